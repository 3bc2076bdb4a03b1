"""Orient: pair halfedges, and turn faces so that neighbors agree and closed components face outwards."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .weld import WeldedMesh


def orient(welded: WeldedMesh, pinned: NDArray[np.bool_], width: float) -> tuple[WeldedMesh, _core.Halfedges]:
    """Pair the halfedges of a welded mesh, with consistent, outward winding.

    Parameters
    ----------
    welded : WeldedMesh
    pinned : (m,) bool
        Faces that are not turned.
    width : float
        Where more than two faces meet, those that lie in one plane within this width may be paired; model units.

    Returns
    -------
    welded : WeldedMesh
        With some faces turned.
    halfedges : Halfedges
    """
    points, faces, rows = welded.points, welded.faces, welded.rows
    halfedges = _core.pair_halfedges(points, faces, rows, width)
    turned = _core.find_turned(points, faces, halfedges, rows, pinned.astype(np.uint8))
    if not len(turned):
        return welded, halfedges
    faces = faces.copy()
    faces[turned] = faces[turned][:, [0, 2, 1]]
    return dataclasses.replace(welded, faces=faces, turned=len(turned)), _core.pair_halfedges(
        points, faces, rows, width
    )
