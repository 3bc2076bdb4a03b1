"""Welding: near points become one, and corners are told where they now lie."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model import Faces, Indices, Mesh, Points, SimplifiedMesh


def weld(mesh: Mesh, distance: float, layers: Indices | None) -> tuple[_core.Welded, float]:
    """A mesh with near points joined, and how far that moved one; corners of parts that are passed on stay."""
    welded = _core.weld(mesh.points, mesh.faces, distance, layers)
    if welded.moved == 0.0 or not mesh.passed_on.any():
        return welded, welded.moved
    stays = np.zeros(len(mesh.points), bool)
    stays[mesh.faces[mesh.passed_on[mesh.part_of_face]]] = True
    used = welded.point_of_row >= 0
    at = np.where(used[:, None], welded.points[welded.point_of_row], mesh.points)
    rows, targets = _nearest_staying(mesh.points, welded.point_of_row, stays)
    at[rows] = mesh.points[targets]
    at[stays] = mesh.points[stays]
    moved = float(np.sqrt(((at - mesh.points)[used] ** 2).sum(axis=1).max()))
    # What is where it shall be is welded exactly: points are in lexicographic order again.
    return _core.weld(at, mesh.faces, 0.0, layers), moved


def _nearest_staying(points: Points, cluster: Indices, stays: NDArray[np.bool_]) -> tuple[Indices, Indices]:
    """Rows that share a cluster with rows that stay, and the nearest of those; ties go by coordinates."""
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
    return row[nearest].astype(np.int32), target[nearest].astype(np.int32)


def at_their_points(
    mesh: Mesh, light: SimplifiedMesh, welded: _core.Welded, group: Indices, group_of_light: Indices
) -> tuple[Faces, NDArray[np.int64]]:
    """Corners by rows that lie where the welded points are, and which corners got rows of another group by that.

    Rows of the same group are taken where it has one there, else of the same part.

    Parameters
    ----------
    mesh : Mesh
    light : SimplifiedMesh
    welded : Welded
    group, group_of_light : int32
        What no facet may leave, of each welded face and of each face of the light.
    """
    point = welded.point_of_row.astype(np.int64)
    there = (point >= 0) & (mesh.points == welded.points[point]).all(axis=1)
    stored = there[mesh.faces]
    faces, away = light.faces.copy(), ~there[light.faces]
    rows, wanted = mesh.faces[stored], point[faces[away]]

    def of(kind: Indices, kind_of_light: Indices) -> tuple[Indices, NDArray[np.bool_]]:
        count = len(welded.points)
        keys = point[rows] + count * np.repeat(kind.astype(np.int64), stored.sum(axis=1))
        sought = wanted + count * np.repeat(kind_of_light.astype(np.int64), away.sum(axis=1))
        return _looked_up(keys, rows, sought)

    group_of_input = np.full(len(mesh.faces), -1, np.int32)
    group_of_input[welded.source] = group
    anywhere, _ = _looked_up(point[rows], rows, wanted)
    of_part, in_part = of(mesh.part_of_face, light.part_of_face)
    of_group, in_group = of(group_of_input, group_of_light)
    faces[away] = np.where(in_group, of_group, np.where(in_part, of_part, anywhere))
    return faces, np.flatnonzero(away)[~in_group]


def _looked_up(
    keys: NDArray[np.int64], values: Indices, wanted: NDArray[np.int64]
) -> tuple[Indices, NDArray[np.bool_]]:
    """The least value of each wanted key, and whether there is one."""
    order = np.lexsort((values, keys))
    place = np.minimum(np.searchsorted(keys[order], wanted), len(keys) - 1)
    return values[order][place], keys[order][place] == wanted
