"""Resolve the vertex normals of a result: keep the input's, make smooth ones up to creases, or write none."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from ..model import Faces, Mesh, Points, SimplifiedMesh, cast_indices
from ..options import FLAT_NORMALS_DEGREES, Options
from ..unique_rows import find_unique_rows, join_pairs, place_values

Indices = NDArray[np.int64]
Normals = NDArray[np.float64]


def resolve_normals(mesh: Mesh, result: SimplifiedMesh, options: Options) -> tuple[SimplifiedMesh, Normals | None]:
    """Give a result a row for each normal that it needs, and the normals to write with it.

    Parameters
    ----------
    mesh : Mesh
    result : SimplifiedMesh
        Left as it is.
    options : Options
        `Options.normals` and `Options.crease_angle`.

    Returns
    -------
    result : SimplifiedMesh
        The same one where no row has to be told apart; else rows are added at its end.
    normals : (n, 3) float64 or None
        One for each row of the result. None means flat: each face has the normal of its plane, and no file need say
        so. A row is zero where the input has no normal.

    Notes
    -----
    With ``auto`` points keep the normals that are stored for them, turned where their faces were. Where a point has
    moved, a smooth normal becomes the mean of the faces there, however much they turn. A hard normal that is farther
    than the crease angle from the normal of a face there is computed anew, with creases.
    """
    if options.normals not in ("auto", "smooth") or (options.normals == "auto" and mesh.normals is None):
        return result, None
    made = ~mesh.passed_on[result.part_of_face]
    stored = np.zeros_like(result.points) if mesh.normals is None else _turn_normals(mesh, result, mesh.normals)
    smooth = np.zeros(len(result.points), bool)
    if options.normals == "auto":
        assert mesh.normals is not None
        if are_flat(mesh.points, mesh.faces[~mesh.passed_on[mesh.part_of_face]], mesh.normals):
            return result, None
        smooth = _find_smooth_rows(mesh.points, mesh.normals)[result.row]
        moved = (result.points != mesh.points[result.row]).any(axis=1)
        unfit = moved & (smooth | _find_unfit_rows(result.points, result.faces, stored, options.crease_angle))
        corners = (unfit[result.faces] & made[:, None]).reshape(-1)
        if not corners.any():
            return result, stored
    else:
        corners = np.repeat(made, 3)
    return _make_normals(result, stored, smooth, corners, options.crease_angle)


def _make_normals(
    result: SimplifiedMesh, stored: Normals, smooth: NDArray[np.bool_], corners: NDArray[np.bool_], angle: float
) -> tuple[SimplifiedMesh, Normals]:
    """Make normals for some corners: those of smooth rows across all edges, others up to creases."""
    group, normals = compute_smooth_normals(result.points, result.faces, angle)
    if smooth.any():
        whole, means = compute_smooth_normals(result.points, result.faces, 180.0)
        group = np.where(smooth[result.faces.reshape(-1)], whole + len(normals), group)
        normals = np.concatenate([normals, means])
    # Corners that keep what is stored are one group for each row.
    group[~corners] = -1
    pairs = np.stack([result.faces.reshape(-1), group], axis=1)
    first, inverse = find_unique_rows(pairs)
    source, own = pairs[first].T
    row, added = place_values(source, len(result.points))
    split = dataclasses.replace(result, faces=cast_indices(row[inverse].reshape(-1, 3)))
    split.add_rows(added)
    made = np.concatenate([stored, np.zeros((len(added), 3))])
    made[row] = np.where((own >= 0)[:, None], normals[np.maximum(own, 0)], stored[source])
    return split, made


def _turn_normals(mesh: Mesh, result: SimplifiedMesh, normals: Normals) -> Normals:
    """Return the stored normals of a result's rows, turned where they agreed with faces that were all turned."""
    stored = normals[result.row]
    before = compute_face_normals(mesh.points, mesh.faces)[result.face]
    turned = (compute_face_normals(result.points, result.faces) * before).sum(axis=1) < 0.0
    if not turned.any():
        return stored
    agrees = ((stored[result.faces] * before[:, None]).sum(axis=2) > 0.0) & turned[:, None]
    both = np.stack([np.bincount(result.faces[chosen], minlength=len(stored)) for chosen in (agrees, ~agrees)])
    return np.where(((both[0] > 0) & (both[1] == 0))[:, None], -stored, stored)


def _find_smooth_rows(points: Points, normals: Normals) -> NDArray[np.bool_]:
    """Find rows at whose positions all stored normals are one, within `FLAT_NORMALS_DEGREES`."""
    first, position = find_unique_rows(points)
    # Sums in an order that is not the file's.
    order = np.lexsort((*normals.T, position))
    mean = np.stack([np.bincount(position[order], axis[order], len(first)) for axis in normals.T], axis=1)[position]
    product = (normals * mean).sum(axis=1)
    lengths = np.linalg.norm(normals, axis=1) * np.linalg.norm(mean, axis=1)
    differs = (product < math.cos(math.radians(FLAT_NORMALS_DEGREES)) * lengths) | (lengths == 0.0)
    return np.asarray((np.bincount(position[differs], minlength=len(first)) == 0)[position])


def _find_unfit_rows(points: Points, faces: Faces, normals: Normals, angle: float) -> NDArray[np.bool_]:
    """Find rows whose normals are farther than an angle from that of a face there; none and no area fit."""
    cross = compute_face_normals(points, faces)
    length = np.linalg.norm(cross, axis=1)
    least = math.cos(math.radians(min(angle, 180.0)))
    unfit = np.zeros(len(points), bool)
    for corner in faces.T:
        product = (normals[corner] * cross).sum(axis=1)
        unfit[corner[product < least * (np.linalg.norm(normals[corner], axis=1) * length)]] = True
    return unfit


def are_flat(points: Points, faces: Faces, normals: Normals) -> bool:
    """Tell whether all normals are the normals of their faces, within `FLAT_NORMALS_DEGREES`.

    Rows without a normal and faces without area do not count.
    """
    return not _find_unfit_rows(points, faces, normals, FLAT_NORMALS_DEGREES).any()


def compute_smooth_normals(points: Points, faces: Faces, angle: float) -> tuple[Indices, Normals]:
    """Average normals over faces that meet at a position and turn by less than an angle from one to the next.

    Parameters
    ----------
    points : (n, 3) float64
    faces : (k, 3) int32
    angle : float
        Edges that turn by more are hard, and so are those of one face or of more than two; degrees.

    Returns
    -------
    group : (3 k,) int64
        Which normal each corner has.
    normals : (g, 3) float64
        Unit vectors, averaged by the angle of the faces at the position.
    """
    used, compact = np.unique(faces, return_inverse=True)
    own = points[used]
    position = find_unique_rows(own)[1][compact.reshape(-1)].reshape(-1, 3)
    cross = compute_face_normals(points, faces)
    length = np.linalg.norm(cross, axis=1)
    unit = cross / np.maximum(length, np.finfo(float).tiny)[:, None]
    group = np.unique(
        join_pairs(3 * len(faces), *_pair_corners(position, unit, length > 0.0, angle)), return_inverse=True
    )[1]
    total = np.zeros((int(group.max(initial=-1)) + 1, 3))
    for corner in range(3):
        weighted = unit * _measure_angles(points, np.roll(faces, -corner, axis=1))[:, None]
        for axis in range(3):
            total[:, axis] += np.bincount(group[corner::3], weighted[:, axis], len(total))
    size = np.linalg.norm(total, axis=1, keepdims=True)
    return group, np.where(size > 0.0, total / np.maximum(size, np.finfo(float).tiny), (0.0, 0.0, 1.0))


def _pair_corners(position: Indices, unit: Normals, wide: NDArray[np.bool_], angle: float) -> tuple[Indices, Indices]:
    """Find pairs of corners that share a normal: both ends of each edge that is not hard."""
    following = np.roll(position, -1, axis=1).reshape(-1)
    start = position.reshape(-1)
    low, high = np.minimum(start, following), np.maximum(start, following)
    order = np.lexsort((high, low))
    fresh = np.ones(len(order), bool)
    fresh[1:] = (np.diff(low[order]) != 0) | (np.diff(high[order]) != 0)
    begin = np.flatnonzero(fresh)
    pair = begin[np.diff(np.append(begin, len(order))) == 2]
    a, b = order[pair], order[pair + 1]
    cosine = (unit[a // 3] * unit[b // 3]).sum(axis=1)
    # A face without area turns nowhere.
    soft = (cosine >= math.cos(math.radians(min(angle, 180.0)))) | ~wide[a // 3] | ~wide[b // 3]
    a, b = a[soft & (start[a] == following[b])], b[soft & (start[a] == following[b])]
    after_a, after_b = a - a % 3 + (a + 1) % 3, b - b % 3 + (b + 1) % 3
    return np.concatenate([a, after_a]), np.concatenate([after_b, b])


def compute_face_normals(points: Points, faces: Faces) -> Normals:
    """Return the normals of faces, twice as long as the face is large."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    return np.cross(b - a, c - a)


def _measure_angles(points: Points, faces: Faces) -> NDArray[np.float64]:
    """Return the angle of each face at its first corner, in radians."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    u, v = b - a, c - a
    return np.asarray(np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), (u * v).sum(axis=1)))
