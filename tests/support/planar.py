"""What tests of the triangulation share: points and segments of rings, and what is true of a result."""

from __future__ import annotations

import numpy as np
import oracle

from bldsimp import triangulate
from bldsimp.triangulation import Triangulation

SQUARE = [(0, 0), (4, 0), (4, 4), (0, 4)]


def ring(first: int, count: int) -> list[tuple[int, int]]:
    """Segments of a closed ring of consecutive points."""
    return [(first + i, first + (i + 1) % count) for i in range(count)]


def rings(*outlines) -> tuple[np.ndarray, list[tuple[int, int]]]:
    """Points and segments of several rings."""
    points = np.concatenate([np.reshape(np.array(outline, float), (-1, 2)) for outline in outlines])
    segments, first = [], 0
    for outline in outlines:
        segments += ring(first, len(outline)) if len(outline) else []
        first += len(outline)
    return points, segments


def check(points, segments, **options) -> Triangulation:
    result = triangulate(points, segments, **options)
    result.validate()
    return result


def compute_area(result: Triangulation) -> float:
    a, b, c = np.moveaxis(result.points[result.triangles], 1, 0)
    return 0.5 * float(np.sum((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]))


def collect_shapes(result: Triangulation) -> set[frozenset[tuple[float, float]]]:
    """Triangles by coordinates, whatever the numbers of their points."""
    return {frozenset(map(tuple, result.points[t].tolist())) for t in result.triangles}


def cross(points, first, second) -> bool:
    """Whether two segments cross at a point that is none of the input's."""
    exact = oracle.make_exact(points)
    a, b, c, d = (exact[i] for i in (*first, *second))
    return (
        oracle.orient2d(a, b, c) * oracle.orient2d(a, b, d) < 0
        and oracle.orient2d(c, d, a) * oracle.orient2d(c, d, b) < 0
        and not any(oracle.orient2d(a, b, p) == oracle.orient2d(c, d, p) == 0 for p in exact)
    )
