"""Vertex normals of a result: the input's at kept points, made anew and smooth but for creases, or none."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..model import Faces, Mesh, Points, SimplifiedMesh
from ..options import FLAT_NORMALS_DEGREES, Options
from ..unique_rows import find_unique_rows

Indices = NDArray[np.int64]
Normals = NDArray[np.float64]


def resolve_normals(mesh: Mesh, light: SimplifiedMesh, options: Options) -> tuple[SimplifiedMesh, Normals | None]:
    """A result with a row for each normal that it needs, and the normals to write with it.

    Parameters
    ----------
    mesh : Mesh
    light : SimplifiedMesh
        Left as it is.
    options : Options
        `Options.normals` and `Options.crease_angle`.

    Returns
    -------
    light : SimplifiedMesh
        The same one where no row has to be told apart; else rows are added at its end.
    normals : (n, 3) float64 or None
        One for each row of the light. None means flat: each face has the normal of its plane, and no file need say
        so. A row is zero where the input has no normal.

    Notes
    -----
    With ``auto`` points keep the normals that are stored for them, turned where their faces were. Where a point has
    moved, what was smooth gets the mean of the faces there, however much they turn; what was hard goes if it is farther
    than the crease angle from the normal of a face there, and is made anew with creases.
    """
    if options.normals not in ("auto", "smooth") or (options.normals == "auto" and mesh.normals is None):
        return light, None
    fixed = mesh.passed_on
    stored = np.zeros_like(light.points) if mesh.normals is None else _turned(mesh, light, mesh.normals)
    made = ~fixed[light.part_of_face]
    if options.normals == "auto":
        assert mesh.normals is not None
        if are_flat(mesh.points, mesh.faces[~fixed[mesh.part_of_face]], mesh.normals):
            return light, None
        smooth = _is_smooth(mesh.points, mesh.normals)[light.row]
        moved = (light.points != mesh.points[light.row]).any(axis=1)
        unfit = moved & (smooth | _unfit(light, stored, options.crease_angle))
        if not np.any(unfit[light.faces] & made[:, None]):
            return light, stored
        corners = (unfit[light.faces] & made[:, None]).reshape(-1)
    else:
        smooth = np.zeros(len(light.points), bool)
        corners = np.repeat(made, 3)
    group, normals = smooth_normals(light.points, light.faces, options.crease_angle)
    if smooth.any():
        whole, means = smooth_normals(light.points, light.faces, 180.0)
        group = np.where(smooth[light.faces.reshape(-1)], whole + len(normals), group)
        normals = np.concatenate([normals, means])
    # Corners that keep what is stored are one group for each row.
    group[~corners] = -1
    pairs = np.stack([light.faces.reshape(-1), group], axis=1)
    first, inverse = find_unique_rows(pairs)
    source, own = pairs[first].T
    light, row = _with_rows(light, source, inverse)
    result = np.zeros_like(light.points)
    result[: len(stored)] = stored
    result[row] = np.where((own >= 0)[:, None], normals[np.maximum(own, 0)], stored[source])
    return light, result


def _turned(mesh: Mesh, light: SimplifiedMesh, normals: Normals) -> Normals:
    """Stored normals of a result's rows, the other way where they agreed with faces that were all turned."""
    stored = normals[light.row]
    before = face_normals(mesh.points, mesh.faces)[light.face]
    turned = (face_normals(light.points, light.faces) * before).sum(axis=1) < 0.0
    if not turned.any():
        return stored
    agrees = ((stored[light.faces] * before[:, None]).sum(axis=2) > 0.0) & turned[:, None]
    both = np.stack([np.bincount(light.faces[chosen], minlength=len(stored)) for chosen in (agrees, ~agrees)])
    return np.where(((both[0] > 0) & (both[1] == 0))[:, None], -stored, stored)


def _is_smooth(points: Points, normals: Normals) -> NDArray[np.bool_]:
    """Rows at whose positions all stored normals are one, within `FLAT_NORMALS_DEGREES`."""
    first, position = find_unique_rows(points)
    # Sums in an order that is not the file's.
    order = np.lexsort((*normals.T, position))
    mean = np.stack([np.bincount(position[order], axis[order], len(first)) for axis in normals.T], axis=1)[position]
    product = (normals * mean).sum(axis=1)
    lengths = np.linalg.norm(normals, axis=1) * np.linalg.norm(mean, axis=1)
    differs = (product < math.cos(math.radians(FLAT_NORMALS_DEGREES)) * lengths) | (lengths == 0.0)
    return np.asarray((np.bincount(position[differs], minlength=len(first)) == 0)[position])


def _unfit(light: SimplifiedMesh, stored: Normals, angle: float) -> NDArray[np.bool_]:
    """Rows whose normals are farther than an angle from that of a face there."""
    cross = face_normals(light.points, light.faces)
    least = math.cos(math.radians(min(angle, 180.0)))
    unfit = np.zeros(len(light.points), bool)
    for corner in light.faces.T:
        product = (stored[corner] * cross).sum(axis=1)
        norms = np.linalg.norm(stored[corner], axis=1) * np.linalg.norm(cross, axis=1)
        unfit[corner[product < least * norms]] = True
    return unfit


def _with_rows(light: SimplifiedMesh, source: Indices, place: Indices) -> tuple[SimplifiedMesh, Indices]:
    """A light whose corners have rows of their own: the first of each row's keeps it, the others get added ones.

    Parameters
    ----------
    light : SimplifiedMesh
    source : (d,) int
        The row that each new one is a copy of.
    place : (3 k,) int
        Which of them each corner reads.

    Returns
    -------
    light : SimplifiedMesh
    row : (d,) int
        Where each is.
    """
    stays = np.zeros(len(source), bool)
    stays[np.unique(source, return_index=True)[1]] = True
    row = source.copy()
    row[~stays] = len(light.points) + np.arange(np.count_nonzero(~stays))
    added = np.concatenate([np.arange(len(light.points)), source[~stays]])
    faces = row[place].reshape(-1, 3).astype(np.int32)
    changed = {name: values[added] for name, values in light.changed.items()}
    return SimplifiedMesh(light.points[added], faces, light.part_of_face, light.row[added], light.face, changed), row


def are_flat(points: Points, faces: Faces, normals: Normals) -> bool:
    """Whether all normals are the normals of their faces, within `FLAT_NORMALS_DEGREES`.

    Rows without a normal and faces without area do not count.
    """
    least = math.cos(math.radians(FLAT_NORMALS_DEGREES))
    cross = face_normals(points, faces)
    length = np.linalg.norm(cross, axis=1)
    for corner in range(3):
        given = normals[faces[:, corner]]
        product = (given * cross).sum(axis=1)
        norms = np.linalg.norm(given, axis=1) * length
        if np.any((norms > 0.0) & (product < least * norms)):
            return False
    return True


def smooth_normals(points: Points, faces: Faces, angle: float) -> tuple[Indices, Normals]:
    """Normals averaged over faces that meet at a position and turn by less than an angle from one to the next.

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
    cross = face_normals(points, faces)
    length = np.linalg.norm(cross, axis=1)
    unit = cross / np.maximum(length, np.finfo(float).tiny)[:, None]
    group = np.unique(_joined(3 * len(faces), *_across(position, unit, length > 0.0, angle)), return_inverse=True)[1]
    total = np.zeros((int(group.max(initial=-1)) + 1, 3))
    for corner in range(3):
        weighted = unit * _angles(points, np.roll(faces, -corner, axis=1))[:, None]
        for axis in range(3):
            total[:, axis] += np.bincount(group[corner::3], weighted[:, axis], len(total))
    size = np.linalg.norm(total, axis=1, keepdims=True)
    return group, np.where(size > 0.0, total / np.maximum(size, np.finfo(float).tiny), (0.0, 0.0, 1.0))


def _across(position: Indices, unit: Normals, wide: NDArray[np.bool_], angle: float) -> tuple[Indices, Indices]:
    """Pairs of corners that share a normal: both ends of each edge that is not hard."""
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


def _joined(count: int, a: Indices, b: Indices) -> Indices:
    """The least of what hangs together by pairs, for each of so many."""
    label = np.arange(count)
    while True:
        before = label.copy()
        least = np.minimum(label[a], label[b])
        for side in (a, b):
            np.minimum.at(label, before[side], least)
            np.minimum.at(label, side, least)
        label = label[label]
        if np.array_equal(label, before):
            return label


def face_normals(points: Points, faces: Faces) -> Normals:
    """Normals of faces, twice as long as the face is large."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    return np.cross(b - a, c - a)


def _angles(points: Points, faces: Faces) -> NDArray[np.float64]:
    """Angle of each face at its first corner, in radians."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    u, v = b - a, c - a
    return np.asarray(np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), (u * v).sum(axis=1)))
