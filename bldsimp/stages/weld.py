"""Weld: merge equal points, and near ones with `Options.weld`."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model import Faces, Indices, Mesh, Points, cast_indices


@dataclass(frozen=True)
class WeldedMesh:
    """A mesh whose equal points are one, and the way back to its rows.

    Attributes
    ----------
    points : (n, 3) float64
        Distinct, in lexicographic order.
    faces : (m, 3) int32
        Each with its least point first, in lexicographic order; none repeats a point or copies another.
    source : (m,) int32
        The face of the mesh that each of them was.
    point_of_row : (r,) int32
        The point of each row of the mesh; -1 for rows that no face uses.
    class_of_row : (r,) int32
        Rows of one class are corners of copies of a face; empty where there are none.
    input : (f, 3) int32
        The faces of the mesh.
    moved : float
        How far welding has moved a point at most; model units.
    degenerate, duplicate : int
        Faces left out since they repeat a point, or copy another.
    """

    points: Points
    faces: Faces
    source: Indices
    point_of_row: Indices
    class_of_row: Indices
    input: Faces
    moved: float
    degenerate: int
    duplicate: int

    @cached_property
    def rows(self) -> _core.CornerRows:
        """Which row of the mesh each corner reads."""
        return _core.CornerRows(self.input, self.point_of_row, self.source, self.class_of_row)

    def select_faces(self, chosen: NDArray[np.bool_]) -> WeldedMesh:
        """Return the mesh of some of the faces, over the points that they use."""
        used = np.unique(self.faces[chosen])
        number = np.full(len(self.points) + 1, -1, np.int32)
        number[used] = np.arange(len(used), dtype=np.int32)
        return dataclasses.replace(
            self,
            points=self.points[used],
            faces=number[self.faces[chosen]],
            source=self.source[chosen],
            point_of_row=number[self.point_of_row],
        )


def weld(mesh: Mesh, distance: float, layers: Indices | None = None, chosen: Indices | None = None) -> WeldedMesh:
    """Merge equal or near points of a mesh; points of unchanged parts do not move.

    Parameters
    ----------
    mesh : Mesh
    distance : float
        Points no farther apart than this are one; model units. 0 joins equal points only.
    layers : (f,) int32, optional
        A number for each face of the mesh: copies of a face in other layers are no copies.
    chosen : (c,) int32, optional
        The faces of the mesh to weld; all where left out.

    Notes
    -----
    Nearly linear. The result depends on coordinates alone, not on the order of rows or faces.
    """
    faces = mesh.faces if chosen is None else mesh.faces[chosen]
    layers = layers if layers is None or chosen is None else layers[chosen]
    welded = _core.weld(mesh.points, faces, distance, layers)
    moved = welded.moved
    if moved > 0.0 and mesh.passed_on.any():
        at = _place_rows(mesh, welded)
        used = welded.point_of_row >= 0
        moved = float(np.sqrt(((at - mesh.points)[used] ** 2).sum(axis=1).max()))
        # Rows at their final places are welded exactly, so that points are in lexicographic order again.
        welded = _core.weld(at, faces, 0.0, layers)
    return WeldedMesh(
        welded.points,
        welded.faces,
        welded.source if chosen is None else chosen[welded.source],
        welded.point_of_row,
        welded.class_of_row,
        mesh.faces,
        moved,
        welded.degenerate,
        welded.duplicate,
    )


def _place_rows(mesh: Mesh, welded: _core.WeldResult) -> Points:
    """Return the places of all rows: rows of unchanged parts keep theirs, and near rows move to them."""
    stays = np.zeros(len(mesh.points), bool)
    stays[mesh.faces[mesh.passed_on[mesh.part_of_face]]] = True
    used = welded.point_of_row >= 0
    at = np.where(used[:, None], welded.points[welded.point_of_row], mesh.points)
    rows, targets = _find_nearest_staying(mesh.points, welded.point_of_row, stays)
    at[rows] = mesh.points[targets]
    at[stays] = mesh.points[stays]
    return at


def _find_nearest_staying(points: Points, cluster: Indices, stays: NDArray[np.bool_]) -> tuple[Indices, Indices]:
    """Find rows that share a cluster with rows that stay, and the nearest of those; ties go by coordinates."""
    staying, moving = np.flatnonzero(stays), np.flatnonzero(~stays & (cluster >= 0))
    staying = staying[np.argsort(cluster[staying], kind="stable")]
    first = np.searchsorted(cluster[staying], cluster[moving])
    count = np.searchsorted(cluster[staying], cluster[moving], side="right") - first
    row = np.repeat(moving, count)
    within = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
    target = staying[np.repeat(first, count) + within]
    gap = points[target] - points[row]
    order = np.lexsort((*points[target].T[::-1], (gap**2).sum(axis=1), row))
    nearest = order[np.unique(row[order], return_index=True)[1]]
    return cast_indices(row[nearest]), cast_indices(target[nearest])
