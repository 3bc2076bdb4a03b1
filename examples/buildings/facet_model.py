"""A small construction kit for closed models of flat facets.

A model is a list of facets, each an outer ring and inner rings of 3D points, counter-clockwise seen
from outside. Nothing is ever cut out of anything: a window is a ring left open in a wall, four sides
and a back. `Model.finish` then puts every corner into each ring whose edge it lies on, so that
neighbours share all their points, and proves that they do.
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
"""A point nearer to an edge than this lies on it; metres, far below the smallest detail of a model."""


def rectangle(left: float, bottom: float, right: float, top: float) -> list[tuple[float, float]]:
    """Corners of an upright rectangle, counter-clockwise."""
    return [(left, bottom), (right, bottom), (right, top), (left, top)]


def dot(a: Vector, b: Vector) -> float:
    """Scalar product, summed in one fixed order (a linear-algebra library may choose its own)."""
    return float(sum(x * y for x, y in zip(a, b, strict=True)))


@dataclass(frozen=True)
class Frame:
    """A plane with two axes in it; `right` x `up` points out of the solid."""

    origin: Vector
    right: Vector
    up: Vector

    @classmethod
    def through(cls, origin: Place, right: Place, up: Place) -> Frame:
        """A frame whose axes are given by any two perpendicular directions."""
        axes = [np.asarray(axis, dtype=float) for axis in (right, up)]
        return cls(np.asarray(origin, dtype=float), *(axis / dot(axis, axis) ** 0.5 for axis in axes))

    @property
    def normal(self) -> Vector:
        return np.cross(self.right, self.up)

    def at(self, a: float, b: float, depth: float = 0.0) -> Vector:
        """The 3D point at `a` to the right, `b` up and `depth` behind the plane."""
        return self.origin + a * self.right + b * self.up - depth * self.normal

    def local(self, point: Place) -> tuple[float, float]:
        """Coordinates in the plane of a 3D point that lies on it."""
        offset = np.asarray(point, dtype=float) - self.origin
        return dot(offset, self.right), dot(offset, self.up)


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
        at = self.frame.at
        self.open([at(a, b) for a, b in outline])
        for (a, b), (c, d) in zip(outline, outline[1:] + outline[:1], strict=True):
            self.model.add([at(a, b), at(c, d), at(c, d, depth), at(a, b, depth)])
        back = Frame(at(0.0, 0.0, depth), self.frame.right, self.frame.up)
        return self.model.plate(back, outline)


@dataclass
class Model:
    """Points and facets of a closed solid in the making."""

    points: list[Vector] = field(default_factory=list)
    facets: list[list[Ring]] = field(default_factory=list)
    plates: list[Plate] = field(default_factory=list)
    ids: dict[tuple[float, ...], int] = field(default_factory=dict)
    parted: bool = False
    """Whether neighbours may lie in one plane: something else than a crease parts them."""

    def plate(self, frame: Frame, outline: list[tuple[float, float]]) -> Plate:
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
            outer = [plate.frame.at(a, b) for a, b in plate.outline]
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
                for start, end in edges_of(ring):
                    key = (min(start, end), max(start, end))
                    if key not in on_edge:
                        on_edge[key] = points_between(points, *key)
        for rings in self.facets:
            for k, ring in enumerate(rings):
                longer: Ring = []
                for start, end in edges_of(ring):
                    between = on_edge[min(start, end), max(start, end)]
                    longer += [start, *(between if start < end else between[::-1])]
                rings[k] = longer

    def facets_at_edges(self) -> dict[tuple[int, int], int]:
        """The facet on the left of every directed edge; an edge used twice is an error."""
        owner: dict[tuple[int, int], int] = {}
        for facet, rings in enumerate(self.facets):
            for ring in rings:
                for edge in edges_of(ring):
                    if edge in owner:
                        raise ValueError(f"edge {self.points[edge[0]]} {self.points[edge[1]]} is used twice")
                    owner[edge] = facet
        return owner

    def check_closed(self) -> None:
        """Raise unless each edge is used once in each direction, by facets that are not one facet, unless `parted`."""
        owner = self.facets_at_edges()
        normals = [self.normal(rings[0]) for rings in self.facets]
        for (start, end), facet in owner.items():
            other = owner.get((end, start))
            if other is None:
                raise ValueError(f"edge {self.points[start]} {self.points[end]} is open")
            if not self.parted and dot(normals[facet], normals[other]) > 1 - 1e-9:
                raise ValueError(f"facets at {self.points[start]} {self.points[end]} are one facet")

    def normal(self, ring: Ring) -> Vector:
        """Unit normal of a ring, by Newell's sum."""
        corners = [self.points[i] for i in ring]
        total = np.zeros(3)
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
            total += np.cross(a - corners[0], b - corners[0])
        return np.asarray(total / dot(total, total) ** 0.5)

    def corners(self) -> int:
        """The fewest points that hold the model: those where three facets meet or an outline turns.

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
                    if dot(cross, cross) > 1e-18:
                        turning.add(point)
        return sum(point in turning or len(facets) > 2 for point, facets in facets_of.items())

    def fewest_triangles(self) -> int:
        """Triangles of any mesh of the facets without further points: points + 2 holes - 2 for each."""
        return sum(sum(map(len, rings)) + 2 * (len(rings) - 1) - 2 for rings in self.facets)


def edges_of(ring: Ring) -> Iterator[tuple[int, int]]:
    """Directed edges of a ring."""
    return zip(ring, ring[1:] + ring[:1], strict=True)


def points_between(points: Vector, start: int, end: int) -> Ring:
    """Ids of the points strictly between two, in order from the first."""
    along = points[end] - points[start]
    offset = points - points[start]
    length = dot(along, along) ** 0.5
    share = (offset * along).sum(axis=1) / length
    apart = np.linalg.norm(offset - share[:, None] * along / length, axis=1)
    inside = np.flatnonzero((apart < ON_EDGE) & (share > ON_EDGE) & (share < length - ON_EDGE))
    return [int(i) for i in inside[np.argsort(share[inside], kind="stable")]]
