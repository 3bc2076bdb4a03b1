"""Collapses: what facets leave at a wide tolerance loses the points that the tolerance does not need."""

from __future__ import annotations

import dataclasses

import numpy as np

from . import _core
from .assembled import Assembled
from .scene import Faces, Flags, Indices, Points


def collapsed(
    assembled: Assembled,
    points: Points,
    faces: Faces,
    facet_of_face: Indices,
    part_of_facet: Indices,
    pinned: Flags,
    tolerance: float,
) -> tuple[Assembled, Indices]:
    """Move points onto neighbours as far as the tolerance allows.

    Parameters
    ----------
    assembled : Assembled
        Within the tolerance of the faces.
    points, faces
        Welded and oriented.
    facet_of_face : (m,) int32
    part_of_facet : (f,) int32
    pinned : (f,) uint8
        Facets whose triangles must stay.
    tolerance : float
        Model units.

    Returns
    -------
    assembled : Assembled
    facet_of_face : (m,) int32
        Faces whose facet is gone are with one that covers them.

    Notes
    -----
    Every triangle stays a triangle of its facet, though it may leave its plane.
    """
    facet = assembled.facet_of_triangle
    found = _core.collapse(points, faces, assembled.triangles, part_of_facet[facet], pinned[facet], tolerance)
    if found.accepted == 0:
        return assembled, facet_of_face
    kept = assembled.kept.copy()
    kept[found.triangles] = 1
    shown = np.zeros(len(part_of_facet), bool)
    shown[facet[found.source]] = True
    left = dataclasses.replace(
        assembled,
        triangles=found.triangles,
        facet_of_triangle=facet[found.source],
        kept=kept,
        unchanged=np.zeros_like(assembled.unchanged),
        deviation=np.full_like(assembled.deviation, found.deviation),
    )
    return left, np.where(shown[facet_of_face], facet_of_face, left.facet_of_triangle[found.holder])
