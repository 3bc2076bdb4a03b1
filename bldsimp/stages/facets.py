"""Group faces into facets: maximal connected sets of faces in one plane."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .. import _core
from ..model import LARGEST_COORDINATE, Faces, Flags, Indices, Points
from ..options import NEEDLE_DIAGONAL, WIDTH_SHARE
from ..tolerance import measure_frame


@dataclass(frozen=True)
class Limits:
    """How far facets and chains may stray; lengths in model units.

    Attributes
    ----------
    tolerance : float
        What is left of the tolerance once rounding and welding had their share; 0 asks for exact coplanarity.
    width : float
        Greatest extent of a facet along its normal.
    needle : float
        A face no higher than this has no plane of its own.
    fold : float
        How far a needle that is turned over in the plane may reach out of the other faces.
    slack : float
        What rounding may add to a distance.
    center : (x, y, z)
        A place near the mesh.
    """

    tolerance: float
    width: float
    needle: float
    fold: float
    slack: float
    center: tuple[float, float, float]


def derive_limits(box: Points, tolerance: float, moved: float = 0.0) -> Limits:
    """Derive the limits of facets from a tolerance.

    Parameters
    ----------
    box : (2, 3) float64
        Of the points of the surface.
    tolerance : float
        Model units.
    moved : float
        How far welding has moved a point already.
    """
    center, diagonal, slack = measure_frame(box)
    # Squares of it must not leave the range of double precision.
    left = min(tolerance - slack - moved, 1e3 * LARGEST_COORDINATE) if tolerance > 2 * slack + moved else 0.0
    width = WIDTH_SHARE * left
    return Limits(left, width, min(left, NEEDLE_DIAGONAL * diagonal), math.sqrt(left**2 - width**2), slack, center)


@dataclass(frozen=True)
class FacetedSurface:
    """Welded, oriented faces and the facets they form.

    Attributes
    ----------
    points : (n, 3) float64
    faces : (m, 3) int32
    decided : (n,) uint8
        As in `Surface`.
    halfedges : _core.Halfedges
    facets : _core.Facets
    """

    points: Points
    faces: Faces
    decided: Flags
    halfedges: _core.Halfedges
    facets: _core.Facets


def find_facets(
    points: Points, faces: Faces, halfedges: _core.Halfedges, label: Indices, limits: Limits
) -> _core.Facets:
    """Group the faces of a surface into facets.

    Parameters
    ----------
    points : (n, 3) float64
    faces : (m, 3) int32
    halfedges : Halfedges
    label : (m,) int32
        Faces of different labels never share a facet; a face with a negative label is a facet by itself.
    limits : Limits

    Notes
    -----
    The signed distances of all points of a facet to its plane span at most the width: a test of neighboring normals
    alone would drift round a curved wall. Nearly linear.
    """
    return _core.find_facets(points, faces, halfedges, label, limits.center, limits.width, limits.needle, limits.fold)
