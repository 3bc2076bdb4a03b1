"""Vertex normals of a result: the input's at kept points, smooth ones made anew, or none."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .options import FLAT_NORMALS_DEGREES, Options
from .rows import distinct_rows
from .scene import Faces, Light, Mesh, Points

Normals = NDArray[np.float64]


def shading(mesh: Mesh, light: Light, options: Options) -> Normals | None:
    """Normals to write with a result, one per row of the mesh's points.

    Parameters
    ----------
    mesh : Mesh
    light : Light
    options : Options
        `Options.normals`.

    Returns
    -------
    (n, 3) float64 or None
        None means flat: each face has the normal of its plane, and no file need say so. A row is zero
        where the input has no normal.
    """
    if options.normals == "smooth":
        return smooth_normals(light.points, light.faces)
    if options.normals != "auto" or mesh.normals is None:
        return None
    passed = np.array([bool(part.fixed) for part in mesh.parts])
    own = mesh.faces[~passed[mesh.part_of_face]]
    return None if are_flat(mesh.points, own, mesh.normals) else mesh.normals


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


def smooth_normals(points: Points, faces: Faces) -> Normals:
    """Normals averaged over the faces that meet at a position, weighted by their angle there.

    Returns
    -------
    (n, 3) float64
        Unit vectors; zero in rows that no face uses.
    """
    used, compact = np.unique(faces, return_inverse=True)
    corners = compact.reshape(-1, 3).astype(np.int32)
    own = points[used]
    first, position = distinct_rows(own)
    cross = face_normals(own, corners)
    unit = cross / np.maximum(np.linalg.norm(cross, axis=1), np.finfo(float).tiny)[:, None]
    total = np.zeros((len(first), 3))
    for corner in range(3):
        weighted = unit * _angles(own, np.roll(corners, -corner, axis=1))[:, None]
        for axis in range(3):
            total[:, axis] += np.bincount(position[corners[:, corner]], weighted[:, axis], len(first))
    length = np.linalg.norm(total, axis=1)
    total = np.where(
        length[:, None] > 0.0, total / np.maximum(length, np.finfo(float).tiny)[:, None], (0.0, 0.0, 1.0)
    )
    normals = np.zeros_like(points)
    normals[used] = total[position]
    return normals


def face_normals(points: Points, faces: Faces) -> Normals:
    """Normals of faces, twice as long as the face is large."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    return np.cross(b - a, c - a)


def _angles(points: Points, faces: Faces) -> NDArray[np.float64]:
    """Angle of each face at its first corner, in radians."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    u, v = b - a, c - a
    return np.asarray(np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), (u * v).sum(axis=1)))
