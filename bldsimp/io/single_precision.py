"""Measure how far storing points in single precision moves them, and choose the origin that makes it least."""

from __future__ import annotations

import numpy as np

from ..inspection import count_defects
from ..model import Faces, Points, Values
from ..report import Counts
from ..unique_rows import find_unique_rows

WORTH_MOVING = 4.0
"""Move the origin only if that makes the rounding so many times smaller."""


def measure_rounding(points: Points, origin: Points | float = 0.0) -> float:
    """Return the greatest distance between points and their single-precision copies about an origin.

    Infinite beyond the range of single precision. Never below the truth: if the difference itself is rounded, that is
    added.
    """
    if not len(points):
        return 0.0
    local = points - origin
    error = np.abs(_round_points(points, origin) - local)
    inexact = (local + origin != points) | (points - local != origin)
    error += np.where(inexact, np.spacing(np.abs(points)) + np.spacing(np.abs(local)), 0.0)
    return float(np.sqrt((error**2).sum(axis=1).max())) * (1.0 + 4e-16) if error.any() else 0.0


def count_merged_points(points: Points, origin: Points | float = 0.0) -> int:
    """Count the distinct points that are no longer distinct in single precision about an origin."""
    return len(find_unique_rows(points)[0]) - len(find_unique_rows(_round_points(points, origin))[0])


def count_after_rounding(meshes: list[list[tuple[Points, Faces]]]) -> Counts:
    """Count points and edges of meshes in single precision.

    Parameters
    ----------
    meshes : list of list of (points, faces)
        Instances of each mesh: it counts once, by the instance with the most defects.
    """
    after = Counts(watertight=True)
    for instances in meshes:
        surfaces = [count_defects(_round_points(points, 0.0), faces) for points, faces in instances]
        worst = max(surfaces, key=lambda one: (one.open_edges + one.nonmanifold_edges, -one.points))
        for name in ("points", "triangles", "open_edges", "nonmanifold_edges"):
            setattr(after, name, getattr(after, name) + getattr(worst, name))
        after.watertight &= worst.watertight
    return after


def _round_points(points: Points, origin: Points | float) -> Points:
    """Round points about an origin to single precision, as double again."""
    with np.errstate(over="ignore", under="ignore"):
        return (points - origin).astype(np.float32).astype(np.float64)


def choose_origin(points: Points) -> Values:
    """Return the origin about which single precision rounds least, or zero if moving does not pay.

    Each coordinate is a multiple of a power of two near the box's size. So the origin itself is a single, and moving to
    it and back is exact.
    """
    at_zero = measure_rounding(points)
    if at_zero == 0.0 or np.abs(points).max() > np.finfo(np.float32).max:
        return np.zeros(3)
    low, high = points.min(axis=0), points.max(axis=0)
    grid = np.ldexp(1.0, np.frexp(high - low)[1] - 2)
    # Adding zero turns -0.0 into 0.0.
    middle = np.where(high == low, low, np.rint((low + high) / 2.0 / grid) * grid + 0.0)
    origin = middle.astype(np.float32).astype(np.float64)
    return origin if WORTH_MOVING * measure_rounding(points, origin) <= at_zero else np.zeros(3)
