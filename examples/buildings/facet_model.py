"""A small construction kit for closed models of flat facets.

A model is a list of facets, each an outer ring and inner rings of 3D points, counter-clockwise seen
from outside. Nothing is ever cut out of anything: a window is a ring left open in a wall, four sides
and a back. `Model.finish` then puts every corner into each ring whose edge it lies on, so that
neighbors share all their points, and proves that they do.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Place = Sequence[float] | Vector
Ring = list[int]

ON_EDGE = 1e-7
"""A point nearer to an edge than this lies on it; meters, far below the smallest detail of a model."""

STRAIGHT = 1e-18
"""An outline with a squared cross product of its arms below this does not turn."""


def make_rectangle(left: float, bottom: float, right: float, top: float) -> list[tuple[float, float]]:
    """Return the corners of an upright rectangle, counter-clockwise."""
    return [(left, bottom), (right, bottom), (right, top), (left, top)]


def multiply(a: Vector, b: Vector) -> float:
    """Multiply two vectors to a scalar, summed in one fixed order (a linear-algebra library may choose its own)."""
    return float(sum(x * y for x, y in zip(a, b, strict=True)))


@dataclass(frozen=True)
class Frame:
    """A plane with two axes in it; `right` x `up` points out of the solid."""

    origin: Vector
    right: Vector
    up: Vector

    @classmethod
    def span(cls, origin: Place, right: Place, up: Place) -> Frame:
        """Span a frame by any two perpendicular directions."""
        axes = [np.asarray(axis, dtype=float) for axis in (right, up)]
        return cls(np.asarray(origin, dtype=float), *(axis / multiply(axis, axis) ** 0.5 for axis in axes))

    @property
    def normal(self) -> Vector:
        return np.cross(self.right, self.up)

    def place(self, a: float, b: float, depth: float = 0.0) -> Vector:
        """Return the 3D point at `a` to the right, `b` up and `depth` behind the plane."""
        return self.origin + a * self.right + b * self.up - depth * self.normal

    def locate(self, point: Place) -> tuple[float, float]:
        """Return the coordinates in the plane of a 3D point that lies on it."""
        offset = np.asarray(point, dtype=float) - self.origin
        return multiply(offset, self.right), multiply(offset, self.up)


@dataclass
class Plate:
    """A facet that is still being cut: its frame, its outline and the rings left open in it."""

    model: Model
    frame: Frame
    outline: list[tuple[float, float]]
    openings: list[list[Vector]] = field(default_factory=list)

    def open(self, ring: Iterable[Place]) -> None:
        """Leave open a ring of 3D points, counter-clockwise seen from outside."""
        self.openings.append([np.asarray(point, dtype=float) for point in ring])

    def recess(self, outline: list[tuple[float, float]], depth: float) -> Plate:
        """Sink a part of the plate by `depth` (raise it where negative); returns the sunken plate."""
        place = self.frame.place
        self.open([place(a, b) for a, b in outline])
        for (a, b), (c, d) in zip(outline, outline[1:] + outline[:1], strict=True):
            self.model.add([place(a, b), place(c, d), place(c, d, depth), place(a, b, depth)])
        back = Frame(place(0.0, 0.0, depth), self.frame.right, self.frame.up)
        return self.model.add_plate(back, outline)


@dataclass
class Model:
    """Points and facets of a closed solid in the making."""

    points: list[Vector] = field(default_factory=list)
    facets: list[list[Ring]] = field(default_factory=list)
    plates: list[Plate] = field(default_factory=list)
    ids: dict[tuple[float, ...], int] = field(default_factory=dict)
    parted: bool = False
    """Whether neighbors may lie in one plane: something else than a crease parts them."""

    def add_plate(self, frame: Frame, outline: list[tuple[float, float]]) -> Plate:
        """Begin a facet that may be cut; `finish` adds it."""
        self.plates.append(Plate(self, frame, outline))
        return self.plates[-1]

    def add(self, outer: Iterable[Place], inner: Iterable[Iterable[Place]] = ()) -> None:
        """Add a facet; the outer ring runs counter-clockwise, inner rings clockwise."""
        self.facets.append([[self._id(point) for point in ring] for ring in (outer, *inner)])

    def _id(self, point: Place) -> int:
        key = tuple(round(float(value), 7) + 0.0 for value in point)
        if key not in self.ids:
            self.ids[key] = len(self.points)
            self.points.append(np.asarray(point, dtype=float))
        return self.ids[key]

    def finish(self) -> Model:
        """Add all plates, make the rings share their points, and prove the model closed."""
        for plate in self.plates:
            outer = [plate.frame.place(a, b) for a, b in plate.outline]
            self.add(outer, [ring[::-1] for ring in plate.openings])
        self.plates.clear()
        self._conform()
        self.check_closed()
        return self

    def _conform(self) -> None:
        """Put into each ring the points that lie on its edges."""
        points = np.array(self.points)
        on_edge: dict[tuple[int, int], Ring] = {}
        for rings in self.facets:
            for ring in rings:
                for start, end in pair_edges(ring):
                    key = (min(start, end), max(start, end))
                    if key not in on_edge:
                        on_edge[key] = find_points_between(points, *key)
        for rings in self.facets:
            for k, ring in enumerate(rings):
                longer: Ring = []
                for start, end in pair_edges(ring):
                    between = on_edge[min(start, end), max(start, end)]
                    longer += [start, *(between if start < end else between[::-1])]
                rings[k] = longer

    def map_edges(self) -> dict[tuple[int, int], int]:
        """Map every directed edge to the facet on its left; an edge used twice is an error."""
        owner: dict[tuple[int, int], int] = {}
        for facet, rings in enumerate(self.facets):
            for ring in rings:
                for edge in pair_edges(ring):
                    if edge in owner:
                        raise ValueError(f"edge {self.points[edge[0]]} {self.points[edge[1]]} is used twice")
                    owner[edge] = facet
        return owner

    def check_closed(self) -> None:
        """Raise unless each edge is used once in each direction, by facets that are not one facet, unless `parted`."""
        owner = self.map_edges()
        normals = [self.find_normal(rings[0]) for rings in self.facets]
        for (start, end), facet in owner.items():
            other = owner.get((end, start))
            if other is None:
                raise ValueError(f"edge {self.points[start]} {self.points[end]} is open")
            if not self.parted and multiply(normals[facet], normals[other]) > 1 - 1e-9:
                raise ValueError(f"facets at {self.points[start]} {self.points[end]} are one facet")

    def find_normal(self, ring: Ring) -> Vector:
        """Return the unit normal of a ring, by Newell's sum."""
        corners = [self.points[i] for i in ring]
        total = np.zeros(3)
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
            total += np.cross(a - corners[0], b - corners[0])
        return np.asarray(total / multiply(total, total) ** 0.5)

    def count_corners(self) -> int:
        """Count the fewest points that hold the model: those where three facets meet or an outline turns.

        No mesh of this shape has fewer points, and one with exactly these exists.
        """
        facets_of: dict[int, set[int]] = defaultdict(set)
        turning: set[int] = set()
        for facet, rings in enumerate(self.facets):
            for ring in rings:
                last, following = ring[-1:] + ring[:-1], ring[1:] + ring[:1]
                for before, point, after in zip(last, ring, following, strict=True):
                    facets_of[point].add(facet)
                    arms = [self.points[other] - self.points[point] for other in (before, after)]
                    cross = np.cross(arms[0], arms[1])
                    if multiply(cross, cross) > STRAIGHT:
                        turning.add(point)
        return sum(point in turning or len(facets) > 2 for point, facets in facets_of.items())

    def count_fewest_triangles(self) -> int:
        """Count the triangles of any mesh of the facets without further points: points + 2 holes - 2 for each."""
        return sum(sum(map(len, rings)) + 2 * (len(rings) - 1) - 2 for rings in self.facets)


def pair_edges(ring: Ring) -> Iterator[tuple[int, int]]:
    """Pair the points of a ring to directed edges."""
    return zip(ring, ring[1:] + ring[:1], strict=True)


def find_points_between(points: Vector, start: int, end: int) -> Ring:
    """Find the points strictly between two, in order from the first."""
    along = points[end] - points[start]
    offset = points - points[start]
    length = multiply(along, along) ** 0.5
    share = (offset * along).sum(axis=1) / length
    apart = np.linalg.norm(offset - share[:, None] * along / length, axis=1)
    inside = np.flatnonzero((apart < ON_EDGE) & (share > ON_EDGE) & (share < length - ON_EDGE))
    return [int(i) for i in inside[np.argsort(share[inside], kind="stable")]]
