"""Collapses: what facets leave at a wide tolerance loses the points that the tolerance does not need."""

from __future__ import annotations

import dataclasses

import numpy as np

from . import _core
from .assembled import Assembled
from .scene import Faces, Flags, Indices, Points


def collapsed(
    assembled: Assembled, points: Points, faces: Faces, part_of_facet: Indices, pinned: Flags, tolerance: float
) -> Assembled:
    """Move points onto neighbours as far as the tolerance allows.

    Parameters
    ----------
    assembled : Assembled
        Within the tolerance of the faces.
    points, faces
        Welded and oriented.
    part_of_facet : (f,) int32
    pinned : (f,) uint8
        Facets whose triangles must stay.
    tolerance : float
        Model units.

    Notes
    -----
    Every triangle stays a triangle of its facet, though it may leave its plane.
    """
    facet = assembled.facet_of_triangle
    found = _core.collapse(points, faces, assembled.triangles, part_of_facet[facet], pinned[facet], tolerance)
    if found.accepted == 0:
        return assembled
    kept = assembled.kept.copy()
    kept[found.triangles] = 1
    return dataclasses.replace(
        assembled,
        triangles=found.triangles,
        facet_of_triangle=facet[found.source],
        kept=kept,
        unchanged=np.zeros_like(assembled.unchanged),
        deviation=np.full_like(assembled.deviation, found.deviation),
    )
