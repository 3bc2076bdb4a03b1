"""What a general decimator needs for the same deviation: the figure that shows what flat facets save."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from . import _core
from .rows import distinct_rows
from .scene import Faces, Points, Scene
from .tolerance import placed

STEPS = 14
"""So often the number of triangles is bisected, geometrically."""

LEAST_TRIANGLES = 12
"""Where the bisection starts: a box."""

SAMPLES = 20_000
"""So many points are spread over a surface by area, beside its own points, to measure a distance."""

SEED = 1


def baseline_points(scene: Scene, deviation: float, warnings: list[str]) -> int | None:
    """Points that fast-simplification needs to stay within a deviation.

    Parameters
    ----------
    scene : Scene
    deviation : float
        Model units, in world space.
    warnings : list of str
        Told where the deviation cannot be reached.

    Returns
    -------
    int or None
        None where fast-simplification cannot drop a triangle without going beyond the deviation.

    Notes
    -----
    The target number of triangles is bisected geometrically. A result counts if no point and no sample
    of either surface lies farther than the deviation, and what single precision blurs, from the other: so
    the figure favours the baseline.
    """
    from fast_simplification import simplify

    points, faces = _surface(scene)
    # It stores single precision; about its middle a model loses the least by that.
    points = points - (points.min(axis=0) + points.max(axis=0)) / 2.0
    # What it cannot store is not held against it.
    limit = deviation + 2.0 * float(np.spacing(np.float32(np.abs(points).max())))
    low, high, best = LEAST_TRIANGLES, len(faces), None
    for _ in range(STEPS):
        if high - low <= 1:
            break
        target = int(np.sqrt(float(low) * high))
        found, cells = simplify(points.astype(np.float32), faces, target_count=target)
        result = found.astype(np.float64), cells.astype(np.int32)
        if len(cells) and within((points, faces), result, limit):
            high, best = target, len(np.unique(cells))
        else:
            low = target
    if best is None:
        warnings.append("fast-simplification drops nothing within the same deviation")
    return best


def within(a: tuple[Points, Faces], b: tuple[Points, Faces], limit: float) -> bool:
    """Whether the points and samples of two surfaces lie within a limit of each other."""
    for one, other in ((a, b), (b, a)):
        queries = np.concatenate([one[0][np.unique(one[1])], samples(*one)])
        if _core.farthest(queries, np.ascontiguousarray(other[0]), other[1], limit) > limit:
            return False
    return True


def samples(points: Points, faces: Faces) -> NDArray[np.float64]:
    """Points spread over a surface by area, the same every time."""
    random = np.random.default_rng(SEED)
    a, b, c = (points[faces[:, i]] for i in range(3))
    area = np.cumsum(np.linalg.norm(np.cross(b - a, c - a), axis=1))
    if not len(area) or area[-1] == 0.0:
        return np.empty((0, 3))
    face = np.searchsorted(area, np.sort(random.random(SAMPLES)) * area[-1], side="right")
    face = np.minimum(face, len(faces) - 1)
    root, share = np.sqrt(random.random(SAMPLES))[:, None], random.random(SAMPLES)[:, None]
    return np.asarray((1 - root) * a[face] + root * (1 - share) * b[face] + root * share * c[face])


def _surface(scene: Scene) -> tuple[Points, Faces]:
    """All meshes in world space, once each, welded, without faces that repeat a point."""
    points, faces, count = [], [], 0
    for mesh in scene.meshes:
        points.append(placed(mesh.points, mesh.transforms[0]))
        faces.append(mesh.faces.astype(np.int64) + count)
        count += len(mesh.points)
    joined = np.concatenate(faces)
    used, compact = np.unique(joined, return_inverse=True)
    own = np.concatenate(points)[used]
    first, position = distinct_rows(own)
    welded = position[compact.reshape(-1)].reshape(-1, 3)
    a, b, c = welded.T
    proper = (a != b) & (b != c) & (a != c)
    return np.ascontiguousarray(own[first]), np.ascontiguousarray(welded[proper], np.int32)
