"""Remove redundant bodies, details and small components as wholes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model import Faces, Flags, Indices, Mesh, Points, cast_indices, measure_box
from ..options import AUTO_DIAGONAL, FLAT_SHARE, MOVED_SHARE, SPARE_SHARE, Options
from ..tolerance import measure_frame, transform_points
from ..unique_rows import find_unique_rows
from .surface import Surface
from .weld import WeldedMesh

WITHIN_TOLERANCE = "within_tolerance"
SMALLER_THAN_MIN_COMPONENT = "smaller_than_min_component"

DETAIL_KINDS = ("detail", "passage", "boundary_loop", "step")
"""What went, in the order of the kernel's `FeatureKind`: what one cap closes (a recess, a sill, a chimney), what
several do, open edges, and a small step between two planes."""


@dataclass(frozen=True)
class Dropped:
    """A component, a body or a detail that was removed as a whole.

    Attributes
    ----------
    part : int
        The part of the mesh that most of its triangles belong to.
    triangles : int
        How many it had when it was removed.
    box : (2, 3) float64
        Least and greatest coordinates, in the mesh's own frame.
    reason : str
        `WITHIN_TOLERANCE`, `SMALLER_THAN_MIN_COMPONENT` or one of `DETAIL_KINDS`.
    """

    part: int
    triangles: int
    box: Points
    reason: str


@dataclass(frozen=True)
class Details:
    """What a wide tolerance removes as wholes before edges collapse.

    Attributes
    ----------
    left_out : (m,) uint8
        Faces that are removed: what remains must stay within the tolerance of them.
    dropped : list of Dropped
    caps : (k, 3) int32
        Faces that take the place of those left out.
    parent : (k,) int32
        A face of the surface whose label and attributes each cap has.
    points : (n, 3) float64
        Where the points of the surface have moved to.
    kept_by_label : int
        Details that stay since the facets around them have several labels.
    """

    left_out: Flags
    dropped: list[Dropped]
    caps: Faces
    parent: Indices
    points: Points
    kept_by_label: int

    @property
    def change_anything(self) -> bool:
        """Whether anything is removed."""
        return len(self.dropped) > 0


def remove_details(
    mesh: Mesh,
    welded: WeldedMesh,
    surface: Surface,
    textured: NDArray[np.bool_],
    tolerance: float,
    options: Options,
) -> Details:
    """Find bodies that the rest of a surface holds within a tolerance, and details that can go as wholes.

    Parameters
    ----------
    mesh : Mesh
    welded : WeldedMesh
    surface : Surface
        What is left of it.
    textured : (p,) bool
        Parts that stay because they show pictures, however near the rest is.
    tolerance : float
        Model units.
    options : Options
        `keep_topology`.

    Notes
    -----
    About O(n log n). A detail goes where each border loop of some facets can be closed in the planes of the facets
    around it, within the tolerance both ways; or where a small facet slides into the plane beside it.
    """
    size = measure_frame(measure_box(surface.points))
    within = SPARE_SHARE * (tolerance - size[2])
    part = mesh.part_of_face[surface.source]
    pinned = (surface.label < 0).astype(np.uint8)
    one_sided = np.array([one.one_sided for one in mesh.parts], np.uint8)[part]
    stays = pinned | textured[part]
    bodies, dropped = find_redundant_bodies(surface.points, surface.faces, part, stays, one_sided, tolerance - size[2])
    found = _core.remove_features(
        surface.points,
        surface.faces,
        surface.label,
        part,
        (_count_rows(welded)[surface.origin] > 1).astype(np.uint8),
        pinned,
        bodies,
        within,
        max(AUTO_DIAGONAL * size[1], FLAT_SHARE * within),
        count_decimals(mesh, tolerance),
        mesh.single,
        options.keep_topology,
        len(mesh.faces),
    )
    dropped += [
        Dropped(int(part[place]), int(triangles), box, DETAIL_KINDS[kind])
        for place, kind, triangles, box in zip(
            found.places, found.kinds, found.triangles, found.boxes.reshape(-1, 2, 3), strict=True
        )
    ]
    return Details(found.left_out, dropped, found.faces, found.parent, found.points, found.kept_by_label)


def _count_rows(welded: WeldedMesh) -> Indices:
    """Count the rows of the file at each welded point."""
    points = welded.point_of_row[welded.point_of_row >= 0]
    return cast_indices(np.bincount(points, minlength=len(welded.points)))


def count_decimals(mesh: Mesh, tolerance: float) -> int:
    """Count the decimals of a moved coordinate that are worth storing at a tolerance; -1 where none may move."""
    return -1 if mesh.quantized else max(0, math.ceil(-math.log10(MOVED_SHARE * tolerance)))


def find_redundant_bodies(
    points: Points, faces: Faces, part_of_face: Indices, pinned: Flags, one_sided: Flags, tolerance: float
) -> tuple[Flags, list[Dropped]]:
    """Find bodies of which every point is within a tolerance of what remains.

    Parameters
    ----------
    points, faces
        Welded and oriented.
    part_of_face : (m,) int32
    pinned : (m,) uint8
        Faces that stay.
    one_sided : (m,) uint8
        Faces that are seen from the front only: a sheet with any stays, since what holds it may face the other way.
    tolerance : float
        Model units.

    Returns
    -------
    redundant : (m,) uint8
        Faces that can be removed.
    dropped : list of Dropped

    Notes
    -----
    A body can be removed from its component without opening the rest: solids that touch along an edge are two.
    The smallest is tried first; of two that hold one another, one stays.
    """
    body = _core.find_bodies(points, faces)
    pinned = pinned | (_find_sheets(faces, body) & one_sided)
    found = _core.find_redundant_bodies(points, faces, body, pinned, SPARE_SHARE * tolerance)
    gone = np.flatnonzero(found)
    return found, _list_dropped(points, faces[gone], body[gone], part_of_face[gone], WITHIN_TOLERANCE)


def _find_sheets(faces: Faces, body: Indices) -> Flags:
    """Find faces of bodies that have open edges of their own."""
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    edges = np.column_stack([np.repeat(body, 3), ends])
    first, edge = find_unique_rows(edges)
    is_open = np.zeros(len(faces), np.uint8)
    is_open[body[first[np.bincount(edge) == 1] // 3]] = 1
    return is_open[body]


def find_small_components(
    meshes: list[Mesh], welded: list[WeldedMesh], options: Options
) -> tuple[list[NDArray[np.bool_]], list[list[Dropped]], int]:
    """Find the components whose boxes have a smaller diagonal than `min_component` in world space.

    Parameters
    ----------
    meshes, welded : list
        Of one scene. The largest component that it shows stays, and so do unchanged parts.
    options : Options
        `min_component`, model units.

    Returns
    -------
    small : list of (m,) bool
        For each mesh the welded faces to remove.
    dropped : list of list of Dropped
        Of each mesh.
    staying : int
        Number of components that are as small but stay, because they belong to an unchanged part.
    """
    found = [_Components(mesh, own) for mesh, own in zip(meshes, welded, strict=True)]
    largest = max((one.sizes.max(initial=-1.0) for one in found if len(one.mesh.transforms)), default=-1.0)
    least = min(options.min_component, largest)
    staying = sum(int(np.count_nonzero(one.pinned & (one.sizes < least))) for one in found)
    small = [(~one.pinned & (one.sizes < least))[one.of_face] for one in found]
    return small, [one.list_dropped(faces) for one, faces in zip(found, small, strict=True)], staying


class _Components:
    """The components of a mesh, by the edges that faces share, in order of their least faces."""

    def __init__(self, mesh: Mesh, welded: WeldedMesh) -> None:
        self.mesh, self.welded = mesh, welded
        component = _core.find_components(welded.faces, len(welded.points))
        roots, order = np.unique(component, return_inverse=True)
        self.of_face = cast_indices(order)
        self.pinned = np.zeros(len(roots), bool)
        # By their points: of copies of a face the one that stays may be of another part.
        unchanged = np.zeros(len(welded.points), bool)
        unchanged[welded.point_of_row[mesh.faces[mesh.passed_on[mesh.part_of_face]]]] = True
        self.pinned[self.of_face[unchanged[welded.faces].all(axis=1)]] = True
        self.sizes = np.zeros(len(roots))
        for transform in mesh.transforms if len(mesh.transforms) else np.eye(4)[None]:
            low, high = _measure_boxes(transform_points(welded.points, transform), welded.faces, self.of_face)
            self.sizes = np.maximum(self.sizes, np.sqrt(((high - low) ** 2).sum(axis=1)))

    def list_dropped(self, small: NDArray[np.bool_]) -> list[Dropped]:
        """List the components of some faces."""
        part = self.mesh.part_of_face[self.welded.source[small]]
        return _list_dropped(
            self.welded.points, self.welded.faces[small], self.of_face[small], part, SMALLER_THAN_MIN_COMPONENT
        )


def _list_dropped(points: Points, faces: Faces, group: Indices, part: Indices, reason: str) -> list[Dropped]:
    """List what is removed, group by group."""
    if not len(faces):
        return []
    order, start = _sort_groups(group)
    low, high = _measure_boxes(points, faces, group)
    parts = np.split(part[order], start[1:])
    return [
        Dropped(int(np.argmax(np.bincount(own))), len(own), np.stack(box), reason)
        for own, *box in zip(parts, low, high, strict=True)
    ]


def _measure_boxes(points: Points, faces: Faces, group: Indices) -> tuple[Points, Points]:
    """Return the least and greatest coordinates of each group of faces."""
    if not len(faces):
        return np.empty((0, 3)), np.empty((0, 3))
    order, start = _sort_groups(group)
    corners = points[faces[order]]
    return np.minimum.reduceat(corners.min(axis=1), start), np.maximum.reduceat(corners.max(axis=1), start)


def _sort_groups(group: Indices) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Sort faces group by group; return their order, and where each group starts."""
    order = np.argsort(group, kind="stable")
    return order, np.flatnonzero(np.diff(group[order], prepend=-1))
