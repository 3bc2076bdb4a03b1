"""Triangulate points under constraints by morphological recognition: the Python face of the core."""

from __future__ import annotations

import warnings
from dataclasses import astuple, dataclass
from operator import add
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from .errors import InputError, TopologyError
from .model import Faces, Points
from .testing import TriangulationArrays, check_triangulation

MOST_POINTS = 2**28
"""Halfedges are numbered by 32 bits, four to a triangle, two triangles to a point."""

_NAMED_ROWS = 10
"""How many offending rows an error names."""


@dataclass(frozen=True)
class Statistics:
    """What the morphological recognition did.

    Attributes
    ----------
    by_poles : int
        Directions of a triangle that its poles told, by comparisons only.
    by_determinant : int
        Directions that needed an exact predicate, since two vertices held all four poles.
    located : int
        Points located by direction search.
    walked : int
        Triangles that those searches entered.
    flips : int
        Diagonals swapped, in insertions and in influence domains.
    """

    by_poles: int = 0
    by_determinant: int = 0
    located: int = 0
    walked: int = 0
    flips: int = 0

    def __add__(self, other: Statistics) -> Statistics:
        return Statistics(*map(add, astuple(self), astuple(other)))


@dataclass(frozen=True)
class Triangulation(TriangulationArrays):
    """Triangles of points in the plane, Delaunay but for the segments among their edges.

    Attributes
    ----------
    points : (n, 2) float64
        The input's points first, in their order, then those where segments cross.
    triangles : (k, 3) int32
        Rows of `points`, counter-clockwise; of equal points only the lowest row occurs.
    neighbors : (k, 3) int32
        Row of `triangles` across the edge opposite each corner; -1 where there is none.
    point_of_input : (m,) int32
        Lowest row of an equal point, per input point.
    segments : (s, 2) int32
        The input's segments as realized: pieces between points next to each other on them, in the
        order of the input and along each segment. Rows of `points`. Where several segments share a
        piece, it occurs once for each; a segment of no length does not occur.
    input_segment : (s,) int32
        Row of the input's segments that each piece is of.
    constraints : (t, 2) int32
        The input's segments as given.
    carved : bool
        Whether only what the rings enclose was kept.
    statistics : Statistics
    """

    statistics: Statistics

    @property
    def neighbours(self) -> Faces:
        """Deprecated: `neighbors`."""
        warnings.warn("Triangulation.neighbours is now neighbors", DeprecationWarning, stacklevel=2)
        return self.neighbors

    def validate(self) -> None:
        """Check every promise of this triangulation with exact predicates.

        Neighbors agree; triangles are counter-clockwise; edges are Delaunay but for constraints,
        and cocircular ties are broken by coordinates; every constraint is there; Euler's formula
        holds; without carving, the convex hull is covered and every point used.

        Raises
        ------
        InternalError
            Says which promise is broken, where.

        Notes
        -----
        O(n log n) array operations: about 15 seconds for a million triangles.
        """
        check_triangulation(self)


def triangulate(
    points: ArrayLike, segments: ArrayLike, *, carve: bool = True, split_crossings: bool = False
) -> Triangulation:
    """Triangulate points in the plane so that every segment is a chain of edges.

    Parameters
    ----------
    points : (m, 2) array_like of float
        Any finite numbers; equal points count as one.
    segments : (t, 2) array_like of int
        Rows of `points`: rings in any order and direction, open chains, repeated segments. A point
        on a segment splits it.
    carve : bool
        Keep only what the rings enclose: triangles that an odd number of rings surrounds. A piece
        along which an even number of segments runs (a slit, an edge that two rings share) and an
        open end bound nothing, so that without rings nothing is kept. False keeps the convex hull.
    split_crossings : bool
        Let segments cross: they are bent, by a few units in the last place, to a point that joins
        `points`.

    Returns
    -------
    Triangulation
        Without any triangle where all points are collinear.

    Raises
    ------
    InputError
        Wrong shape, a coordinate that is not finite, a segment end out of range; names the rows.
    TopologyError
        Two segments cross and may not be split; their rows are in its `segments`.

    Notes
    -----
    O(n log n) expected. Depends on the coordinates and the segments only, not on their order, nor on
    the machine: predicates are exact, and cocircular ties go to the diagonal that holds the
    lexicographically least of the four points.

    References
    ----------
    "Morphological recognition optimization of 3D building simplification by Delaunay algorithm",
    sections "Delaunay algorithm based on morphological recognition" and "Three dimensional building
    simplification model on the base of improved Delaunay algorithm".

    Examples
    --------
    >>> square = triangulate([(0, 0), (2, 0), (2, 2), (0, 2)], [(0, 1), (1, 2), (2, 3), (3, 0)])
    >>> len(square.triangles)
    2
    >>> square.validate()
    """
    cast_points = _cast_points(points)
    cast_segments = _cast_segments(segments, len(cast_points))
    try:
        result = _core.triangulate(cast_points, cast_segments, carve, split_crossings)
    except (ValueError, IndexError):
        _blame_points(cast_points)
        _blame_segments(cast_segments, len(cast_points))
        raise
    crossing, all_points, triangles, neighbors, point_of_input, pieces, counts = result
    if crossing is not None:
        first, second = crossing
        raise TopologyError(f"segments {first} and {second} cross: move them apart, or allow split_crossings", crossing)
    return Triangulation(
        all_points,
        triangles,
        neighbors,
        point_of_input,
        pieces[:, :2],
        pieces[:, 2],
        cast_segments,
        carve,
        Statistics(*counts),
    )


def _cast_points(points: ArrayLike) -> Points:
    try:
        cast = np.ascontiguousarray(points, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"points are not numbers in rows of two: {error}") from error
    if cast.size == 0:
        return np.empty((0, 2))
    if cast.ndim != 2 or cast.shape[1] != 2:
        raise InputError(f"points have shape {cast.shape}, not (m, 2)")
    if len(cast) >= MOST_POINTS:
        raise InputError(f"{len(cast)} points; at most {MOST_POINTS - 1} can be triangulated at once")
    return cast


def _cast_segments(segments: ArrayLike, point_count: int) -> NDArray[np.int32]:
    try:
        given = np.asarray(segments)
    except ValueError as error:
        raise InputError(f"segments are not rows of two indices: {error}") from error
    if given.size == 0:
        return np.empty((0, 2), np.int32)
    if given.ndim != 2 or given.shape[1] != 2:
        raise InputError(f"segments have shape {given.shape}, not (t, 2)")
    if given.dtype.kind not in "iu":
        raise InputError(f"segments are {given.dtype}, not integers")
    if given.dtype != np.int32:  # int32 is checked by the core; what is wider would wrap in the cast
        _blame_segments(given, point_count)
    return np.ascontiguousarray(given, dtype=np.int32)


def _blame_points(points: Points) -> None:
    """Raise with the rows that are not finite, if any."""
    rows = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(rows):
        raise InputError(f"points not finite: {_name(rows)}")


def _blame_segments(segments: NDArray[np.integer[Any]], point_count: int) -> None:
    """Raise with the rows that have an end out of range, if any."""
    if segments.min(initial=0) < 0 or segments.max(initial=-1) >= point_count:
        rows = np.flatnonzero(((segments < 0) | (segments >= point_count)).any(axis=1))
        raise InputError(f"segments with an end outside the {point_count} points: {_name(rows)}")


def _name(rows: NDArray[np.intp]) -> str:
    named = ", ".join(map(str, rows[:_NAMED_ROWS].tolist()))
    return named if len(rows) <= _NAMED_ROWS else f"{named} and {len(rows) - _NAMED_ROWS} more"
