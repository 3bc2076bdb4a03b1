"""How far writing in single precision moves a point, and the origin that makes it least."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..inspection import count_defects
from ..model import Faces, Points
from ..report import Counts
from ..unique_rows import find_unique_rows

WORTH_MOVING = 4.0
"""The origin is moved only where that makes the rounding so many times less."""


def single_rounding(points: Points, origin: Points | None = None) -> float:
    """Greatest distance between points and what single precision keeps of them about an origin.

    Infinite where single precision does not reach so far. Never below the truth: where the difference
    itself is rounded, that is added.
    """
    if not len(points):
        return 0.0
    origin = np.zeros(3) if origin is None else origin
    local = points - origin
    with np.errstate(over="ignore", under="ignore"):
        kept = local.astype(np.float32).astype(np.float64)
    error = np.abs(kept - local)
    inexact = (local + origin != points) | (points - local != origin)
    error += np.where(inexact, np.spacing(np.abs(points)) + np.spacing(np.abs(local)), 0.0)
    return float(np.sqrt((error**2).sum(axis=1).max())) * (1.0 + 4e-16) if error.any() else 0.0


def fallen_together(points: Points, origin: Points | None = None) -> int:
    """How many distinct points are no longer distinct in single precision about an origin."""
    return len(find_unique_rows(points)[0]) - len(find_unique_rows(_in_single(points, origin))[0])


def counts_in_single(meshes: list[list[tuple[Points, Faces, Points | None]]]) -> Counts:
    """What is left of meshes in single precision.

    Parameters
    ----------
    meshes : list of list of (points, faces, origin)
        Instances of each mesh: it counts once, by the one that came off worst.
    """
    after = Counts(watertight=True)
    for instances in meshes:
        surfaces = [count_defects(_in_single(points, origin), faces) for points, faces, origin in instances]
        worst = max(surfaces, key=lambda one: (one.open_edges + one.nonmanifold_edges, -one.points))
        for name in ("points", "triangles", "open_edges", "nonmanifold_edges"):
            setattr(after, name, getattr(after, name) + getattr(worst, name))
        after.watertight &= worst.watertight
    return after


def _in_single(points: Points, origin: Points | None) -> Points:
    """What single precision keeps of points about an origin, in double again."""
    with np.errstate(over="ignore", under="ignore"):
        return (points if origin is None else points - origin).astype(np.float32).astype(np.float64)


def best_origin(points: Points) -> NDArray[np.float64]:
    """Where to put the origin so that single precision rounds least; zero unless it pays.

    Each coordinate is a multiple of a power of two near the box's size, so that the origin itself is
    a single, and moving to it and back is exact.
    """
    if not len(points):
        return np.zeros(3)
    at_zero = single_rounding(points)
    if at_zero == 0.0:
        return np.zeros(3)
    low, high = points.min(axis=0), points.max(axis=0)
    if max(abs(low).max(), abs(high).max()) > np.finfo(np.float32).max:
        return np.zeros(3)
    origin = np.zeros(3)
    for axis in range(3):
        size = high[axis] - low[axis]
        if size == 0.0:
            origin[axis] = float(np.float32(low[axis]))
            continue
        grid = 2.0 ** (math.frexp(size)[1] - 2)
        origin[axis] = float(np.float32(round((low[axis] + high[axis]) / 2.0 / grid) * grid))
    return origin if WORTH_MOVING * single_rounding(points, origin) <= at_zero else np.zeros(3)
