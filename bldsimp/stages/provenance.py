"""Resolve once which row of the mesh each corner reads: of the result, or of what edge collapses have left."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model import Faces, Flags, Indices, Mesh, Points, SimplifiedMesh, cast_indices
from .surface import Surface
from .weld import WeldedMesh


@dataclass(frozen=True)
class ResolvedRows:
    """Which row of the mesh each corner of some triangles reads.

    Attributes
    ----------
    rows : (k, 3) int32
    is_foreign : (k, 3) bool
        The row is one of another label: its values must be made anew.
    """

    rows: Faces
    is_foreign: NDArray[np.bool_]


def resolve_rows(
    mesh: Mesh,
    welded: WeldedMesh,
    triangles: Faces,
    facet: Indices,
    *,
    facet_of_face: Indices,
    label: Indices,
    unchanged: Flags,
) -> ResolvedRows:
    """Find the row of the mesh that each corner reads.

    Parameters
    ----------
    mesh : Mesh
    welded : WeldedMesh
    triangles : (k, 3) int32
        Over its points.
    facet : (k,) int32
        The facet of the welded mesh that each of them was part of.
    facet_of_face, label : (m,) int32
        Of each welded face; all faces of a facet have one label, and are of one part.
    unchanged : (f,) uint8
        Facets whose faces keep the rows that they have.

    Notes
    -----
    At a point where the mesh has several rows the corner gets one that a face of its facet reads there, else one of its
    label, else one of its part. O(faces + triangles).
    """
    kept = np.zeros(len(welded.points), np.uint8)
    kept[triangles] = 1
    label_of_facet, part_of_facet = np.zeros(len(unchanged), np.int32), np.zeros(len(unchanged), np.int32)
    label_of_facet[facet_of_face] = label
    part_of_facet[facet_of_face] = mesh.part_of_face[welded.source]
    found, foreign = _core.assign_rows(
        triangles, facet, welded.faces, welded.rows, facet_of_face, label_of_facet, part_of_facet, unchanged, kept
    )
    is_foreign = np.zeros(3 * len(found), bool)
    is_foreign[foreign] = True
    return ResolvedRows(found, is_foreign.reshape(-1, 3))


def convert_to_rows(
    mesh: Mesh, welded: WeldedMesh, corners: ResolvedRows, source: Indices, label: Indices, welded_label: Indices
) -> tuple[SimplifiedMesh, Indices, Indices]:
    """Convert a result to rows of the mesh; unchanged parts keep exactly their own faces.

    Parameters
    ----------
    mesh : Mesh
    welded : WeldedMesh
    corners : ResolvedRows
    source : (k,) int32
        A face of the mesh that has the face attributes of each triangle.
    label : (k,) int32
        Of each triangle.
    welded_label : (m,) int32
        Of each welded face.

    Returns
    -------
    result : SimplifiedMesh
        Its points are those of the mesh.
    label : (k,) int32
        Of its triangles.
    foreign : (j,) int32
        Corners whose rows are those of another label.
    """
    rows, is_foreign = corners.rows, corners.is_foreign
    part = mesh.part_of_face[source]
    if mesh.passed_on.any():
        fresh, untouched = ~mesh.passed_on[part], np.flatnonzero(mesh.passed_on[mesh.part_of_face])
        rows = np.concatenate([rows[fresh], mesh.faces[untouched]])
        is_foreign = np.concatenate([is_foreign[fresh], np.zeros((len(untouched), 3), bool)])
        source = np.concatenate([source[fresh], cast_indices(untouched)])
        label = np.concatenate([label[fresh], np.full(len(untouched), -1, np.int32)])
        part = mesh.part_of_face[source]
    result = SimplifiedMesh(mesh.points, rows, part, np.arange(len(mesh.points), dtype=np.int32), source)
    foreign = cast_indices(np.flatnonzero(is_foreign))
    if welded.moved > 0:
        label_of_source = np.full(len(mesh.faces), -1, np.int32)
        label_of_source[welded.source] = welded_label
        result.faces, away = _find_rows_at_points(mesh, result, welded, label_of_source, label)
        foreign = cast_indices(np.union1d(foreign, away))
    return result, label, foreign


def place_rows(rows: Points, welded: WeldedMesh, surface: Surface) -> Points:
    """Return the rows of a mesh at the places to which their points have moved, (r, 3)."""
    places = welded.points.copy()
    places[surface.origin] = surface.points
    moved = (places != welded.points).any(axis=1)
    chosen = np.flatnonzero((welded.point_of_row >= 0) & moved[welded.point_of_row])
    placed = rows.copy()
    placed[chosen] = places[welded.point_of_row[chosen]]
    return placed


def _find_rows_at_points(
    mesh: Mesh, result: SimplifiedMesh, welded: WeldedMesh, label_of_source: Indices, label: Indices
) -> tuple[Faces, NDArray[np.int64]]:
    """Find, where welding moved points, rows that lie where those are, and corners that got rows of another label.

    Rows of the same label are taken where it has one there, else of the same part.
    """
    point, count = welded.point_of_row.astype(np.int64), len(welded.points)
    there = (point >= 0) & (mesh.points == welded.points[point]).all(axis=1)
    stored = there[mesh.faces]
    faces, away = result.faces.copy(), ~there[result.faces]
    rows, wanted = mesh.faces[stored], point[faces[away]]

    def find(kind: Indices, kind_of_result: Indices) -> tuple[Indices, NDArray[np.bool_]]:
        keys = point[rows] + count * np.repeat(kind.astype(np.int64), stored.sum(axis=1))
        sought = wanted + count * np.repeat(kind_of_result.astype(np.int64), away.sum(axis=1))
        return _look_up(keys, rows, sought)

    anywhere, _ = _look_up(point[rows], rows, wanted)
    of_part, in_part = find(mesh.part_of_face, result.part_of_face)
    of_label, in_label = find(label_of_source, label)
    faces[away] = np.where(in_label, of_label, np.where(in_part, of_part, anywhere))
    return faces, np.flatnonzero(away)[~in_label]


def _look_up(keys: NDArray[np.int64], values: Indices, wanted: NDArray[np.int64]) -> tuple[Indices, NDArray[np.bool_]]:
    """Return the least value of each wanted key, and whether there is one."""
    order = np.lexsort((values, keys))
    place = np.minimum(np.searchsorted(keys[order], wanted), len(keys) - 1)
    return values[order][place], keys[order][place] == wanted
