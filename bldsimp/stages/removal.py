"""What goes as a whole: bodies that the rest of a mesh holds, and components smaller than asked for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model import Faces, Flags, Indices, Mesh, Points, SimplifiedMesh
from ..options import SPARE_SHARE, Options
from ..tolerance import scale, transform_points
from ..unique_rows import find_unique_rows

WITHIN_TOLERANCE = "within_tolerance"
SMALLER_THAN_MIN_PART = "smaller_than_min_part"


@dataclass(frozen=True)
class Dropped:
    """What went as a whole.

    Attributes
    ----------
    part : int
        The part of the mesh that most of its triangles belong to.
    triangles : int
        That it had by then.
    box : (2, 3) float64
        Least and greatest coordinates, in the mesh's own frame.
    reason : str
        `WITHIN_TOLERANCE` or `SMALLER_THAN_MIN_PART`.
    """

    part: int
    triangles: int
    box: Points
    reason: str


def spare(
    points: Points, faces: Faces, part_of_face: Indices, pinned: Flags, one_sided: Flags, tolerance: float
) -> tuple[Flags, list[Dropped]]:
    """Bodies of which every point is within a tolerance of what remains.

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
    spare : (m,) uint8
        Faces that can go.
    dropped : list of Dropped

    Notes
    -----
    A body is what of a component can go without opening the rest: solids that touch along an edge are two. The
    smallest goes first; of two that hold one another, one stays.
    """
    body = _core.find_bodies(points, faces)
    pinned = pinned | (_are_sheets(faces, body) & one_sided)
    found = _core.find_spare(points, faces, body, pinned, SPARE_SHARE * tolerance)
    gone = np.flatnonzero(found)
    return found, _listed(points, faces[gone], body[gone], part_of_face[gone], WITHIN_TOLERANCE)


def _are_sheets(faces: Faces, body: Indices) -> Flags:
    """Faces of bodies that have open edges of their own."""
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    edges = np.column_stack([np.repeat(body, 3), ends])
    first, edge = find_unique_rows(edges)
    is_open = np.zeros(len(faces), np.uint8)
    is_open[body[first[np.bincount(edge) == 1] // 3]] = 1
    return is_open[body]


def without_small(meshes: list[Mesh], options: Options) -> tuple[list[SimplifiedMesh | None], list[list[Dropped]], int]:
    """What is left of meshes without the components whose boxes have a smaller diagonal than `min_part` in world space.

    Parameters
    ----------
    meshes : list of Mesh
        Of one scene. The largest component of all that it shows stays, and so do parts that are passed on.
    options : Options

    Returns
    -------
    lights : list of SimplifiedMesh or None
        Of each mesh the faces that stay; None where all do.
    dropped : list of list of Dropped
        Of each mesh.
    staying : int
        Components that are as small, and stay since a part of theirs is passed on.
    """
    found = [_Components(mesh, options) for mesh in meshes]
    largest = max((one.sizes.max(initial=-1.0) for one in found if len(one.mesh.transforms)), default=-1.0)
    least = min(options.min_part, largest)
    staying = sum(int(np.count_nonzero(one.pinned & (one.sizes < least))) for one in found)
    left = [one.without(~one.pinned & (one.sizes < least)) for one in found]
    return [light for light, _ in left], [dropped for _, dropped in left], staying


class _Components:
    """The components of a mesh, by the edges that faces share, in order of their least faces."""

    def __init__(self, mesh: Mesh, options: Options) -> None:
        self.mesh = mesh
        welded = _core.weld(mesh.points, mesh.faces, options.weld / (scale(mesh) or 1.0))
        corners = np.ascontiguousarray(welded.point_of_row[mesh.faces], np.int32)
        component = _core.find_components(corners, len(welded.points))
        roots, order = np.unique(component, return_inverse=True)
        self.of_face = order.astype(np.int32)
        self.pinned = np.zeros(len(roots), bool)
        self.pinned[self.of_face[mesh.passed_on[mesh.part_of_face]]] = True
        self.sizes = np.zeros(len(roots))
        for transform in mesh.transforms if len(mesh.transforms) else np.eye(4)[None]:
            low, high = _boxes(transform_points(mesh.points, transform), mesh.faces, self.of_face)
            self.sizes = np.maximum(self.sizes, np.sqrt(((high - low) ** 2).sum(axis=1)))

    def without(self, small: NDArray[np.bool_]) -> tuple[SimplifiedMesh | None, list[Dropped]]:
        """What stays, and what goes; None where all stays."""
        if not small.any():
            return None, []
        mesh, goes = self.mesh, small[self.of_face]
        stays = np.flatnonzero(~goes).astype(np.int32)
        row = np.arange(len(mesh.points), dtype=np.int32)
        light = SimplifiedMesh(mesh.points, mesh.faces[stays], mesh.part_of_face[stays], row, stays)
        return light, _listed(
            mesh.points, mesh.faces[goes], self.of_face[goes], mesh.part_of_face[goes], SMALLER_THAN_MIN_PART
        )


def _listed(points: Points, faces: Faces, group: Indices, part: Indices, reason: str) -> list[Dropped]:
    """What goes, group by group."""
    if not len(faces):
        return []
    order, start = _runs(group)
    low, high = _boxes(points, faces, group)
    parts = np.split(part[order], start[1:])
    return [
        Dropped(int(np.argmax(np.bincount(own))), len(own), np.stack(box), reason)
        for own, *box in zip(parts, low, high, strict=True)
    ]


def _boxes(points: Points, faces: Faces, group: Indices) -> tuple[Points, Points]:
    """Least and greatest coordinates of each group of faces."""
    if not len(faces):
        return np.empty((0, 3)), np.empty((0, 3))
    order, start = _runs(group)
    corners = points[faces[order]]
    return np.minimum.reduceat(corners.min(axis=1), start), np.maximum.reduceat(corners.max(axis=1), start)


def _runs(group: Indices) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Faces group by group, and where each group starts."""
    order = np.argsort(group, kind="stable")
    return order, np.flatnonzero(np.diff(group[order], prepend=-1))
