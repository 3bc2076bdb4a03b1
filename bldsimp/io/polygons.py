"""Polygons to faces, by our own triangulation in each polygon's best plane."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model import Faces, Points

Index = NDArray[np.int32]


def triangulate_polygons(points: Points, offsets: Index, corners: Index) -> tuple[Faces, Index]:
    """Cut polygons into faces.

    Parameters
    ----------
    points : (n, 3) float64
    offsets : (k + 1,) int32
        Where each polygon starts in `corners`; ascending, each polygon has three corners or more.
    corners : (c,) int32
        Rows of `points`.

    Returns
    -------
    faces : (m, 3) int32
        Rows of `points`, wound like their polygon, in the order of the polygons.
    polygon_of_face : (m,) int32
    """
    sizes = np.diff(offsets)
    if np.all(sizes == 3):
        return corners.reshape(-1, 3), np.arange(len(sizes), dtype=np.int32)
    larger = np.flatnonzero(sizes > 3)
    starts, ring = select_polygons(offsets, corners, larger)
    cut, polygon = _core.triangulate_polygons(points, starts.astype(np.int64), ring)
    triangles = np.flatnonzero(sizes == 3)
    first = offsets[triangles]
    faces = np.concatenate([corners[first[:, None] + np.arange(3)], cut])
    owner = np.concatenate([triangles, larger[polygon]]).astype(np.int32)
    order = np.argsort(owner, kind="stable")
    return np.ascontiguousarray(faces[order], np.int32), owner[order]


def select_polygons(offsets: Index, corners: Index, chosen: NDArray[np.int64]) -> tuple[Index, Index]:
    """Offsets and corners of the chosen polygons alone."""
    sizes = np.diff(offsets)[chosen]
    ends = np.concatenate([[0], np.cumsum(sizes)])
    place = np.arange(ends[-1]) - np.repeat(ends[:-1], sizes) + np.repeat(offsets[chosen], sizes)
    return ends.astype(np.int32), corners[place]
