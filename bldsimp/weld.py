"""Welding: near points become one, and corners are told where they now lie."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from . import _core
from .scene import Faces, Indices, Light, Mesh, Points


def weld(
    mesh: Mesh, distance: float, layers: Indices | None
) -> tuple[_core.Welded, float]:
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


def at_their_points(mesh: Mesh, light: Light, welded: _core.Welded) -> tuple[Faces, NDArray[np.int64]]:
    """Corners by rows that lie where the welded points are, and which corners got other rows by that.

    Rows of the same part are taken where it has one there.
    """
    point = welded.point_of_row.astype(np.int64)
    there = (point >= 0) & (mesh.points == welded.points[point]).all(axis=1)
    stored = there[mesh.faces]
    rows, key = mesh.faces[stored], mesh.part_of_face.astype(np.int64) * len(welded.points)
    faces, away = light.faces.copy(), ~there[light.faces]
    wanted = point[faces[away]]
    part_key = np.repeat(light.part_of_face.astype(np.int64) * len(welded.points), away.sum(axis=1))
    anywhere, _ = _looked_up(point[rows], rows, wanted)
    own, found = _looked_up(point[rows] + np.repeat(key, stored.sum(axis=1)), rows, wanted + part_key)
    faces[away] = np.where(found, own, anywhere)
    return faces, np.flatnonzero(away)


def _looked_up(
    keys: NDArray[np.int64], values: Indices, wanted: NDArray[np.int64]
) -> tuple[Indices, NDArray[np.bool_]]:
    """The least value of each wanted key, and whether there is one."""
    order = np.lexsort((values, keys))
    place = np.minimum(np.searchsorted(keys[order], wanted), len(keys) - 1)
    return values[order][place], keys[order][place] == wanted
