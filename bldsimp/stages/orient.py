"""Orient: pair halfedges, and turn faces so that neighbors agree and closed components face outwards."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model import Faces, Indices, Points


def orient(
    points: Points, faces: Faces, rows: _core.CornerRows, pinned: NDArray[np.bool_], width: float
) -> tuple[Faces, _core.Halfedges, Indices]:
    """Pair the halfedges of faces, and turn those that do not agree with their neighbors.

    Parameters
    ----------
    points : (n, 3) float64
    faces : (m, 3) int32
    rows : CornerRows
        Where more than two faces meet, those that share rows are paired first.
    pinned : (m,) bool
        Faces that are not turned.
    width : float
        Then those are paired that lie in one plane within this width; model units.

    Returns
    -------
    faces : (m, 3) int32
        With consistent, outward winding.
    halfedges : Halfedges
        Of these faces.
    turned : (t,) int32
        Faces whose winding was turned.

    Notes
    -----
    Neighbors agree against the smaller area; a closed component faces outwards unless an odd number of others
    encloses it. Nearly linear.
    """
    halfedges = _core.pair_halfedges(points, faces, rows, width)
    turned = _core.find_misoriented(points, faces, halfedges, rows, pinned.astype(np.uint8))
    if len(turned):
        faces = faces.copy()
        faces[turned] = faces[turned][:, [0, 2, 1]]
        halfedges = _core.pair_halfedges(points, faces, rows, width)
    return faces, halfedges, turned
