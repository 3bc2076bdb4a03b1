"""Exact distances from points to triangles, well conditioned near zero.

All differences are taken between stored coordinates, and the distance is the length of what is left
between the point and a point of the triangle: no squares are subtracted from each other, so a point on
the surface comes out at the rounding of its own coordinates.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
LEAF = 8
PAIRS = 200_000


class Boxes:
    """A binary tree of boxes over triangles (m, 3, 3): node n has the children 2n + 1 and 2n + 2."""

    def __init__(self, corners: Array) -> None:
        self.corners = corners
        self.depth = max(0, int(np.ceil(np.log2(max(1, len(corners)) / LEAF))))
        middle = corners.mean(axis=1)
        groups = [np.arange(len(corners))]
        self.low: list[Array] = []
        self.high: list[Array] = []
        for level in range(self.depth + 1):
            self.low.append(np.array([corners[g].min(axis=(0, 1)) for g in groups]))
            self.high.append(np.array([corners[g].max(axis=(0, 1)) for g in groups]))
            if level < self.depth:
                groups = [half for g in groups for half in self._halves(g, middle)]
        size = max(len(g) for g in groups)
        self.leaves = np.array([np.resize(g, size) for g in groups])

    @staticmethod
    def _halves(group: NDArray[np.int64], middle: Array) -> list[NDArray[np.int64]]:
        axis = int(np.argmax(np.ptp(middle[group], axis=0)))
        order = group[np.argsort(middle[group, axis], kind="stable")]
        return [order[: len(order) // 2], order[len(order) // 2 :]]

    def gap(self, level: int, node: NDArray[np.int64], points: Array) -> Array:
        """Distance of points to boxes, a little less for rounding."""
        outside = np.maximum(self.low[level][node] - points, points - self.high[level][node])
        return np.linalg.norm(np.maximum(outside, 0), axis=1) * (1 - 1e-12)


def measure_distance(points: Array, tree: Boxes) -> Array:
    """Distance of each point to the nearest triangle of a tree; a triangle may be a line segment."""
    return np.concatenate(
        [_find_nearest(points[i : i + 5000], tree) for i in range(0, len(points), 5000)] or [np.empty(0)]
    )


def _find_nearest(points: Array, tree: Boxes) -> Array:
    best = _descend(points, tree)
    row = np.arange(len(points))
    node = np.zeros(len(points), np.int64)
    for level in range(1, tree.depth + 1):
        row, node = np.repeat(row, 2), (2 * node[:, None] + [0, 1]).reshape(-1)
        near = tree.gap(level, node, points[row]) <= best[row]
        row, node = row[near], node[near]
    width = tree.leaves.shape[1]
    step = max(1, PAIRS // width)
    for i in range(0, len(row), step):
        rows = np.repeat(row[i : i + step], width)
        own = measure_own_distance(points[rows], tree.corners[tree.leaves[node[i : i + step]].reshape(-1)])
        np.minimum.at(best, rows, own)
    return best


def _descend(points: Array, tree: Boxes) -> Array:
    """Distance to the triangles of one near leaf: an upper bound."""
    node = np.zeros(len(points), np.int64)
    for level in range(1, tree.depth + 1):
        first = tree.gap(level, 2 * node, points)
        second = tree.gap(level, 2 * node + 1, points)
        node = 2 * node + (second < first)
    width = tree.leaves.shape[1]
    own = measure_own_distance(np.repeat(points, width, axis=0), tree.corners[tree.leaves[node].reshape(-1)])
    return own.reshape(-1, width).min(axis=1)


def measure_own_distance(p: Array, corners: Array) -> Array:
    """Distance of point i to triangle i: to its sides, and to the inside where the foot lies there.

    From the longest side the height of the triangle is found without loss; all ways are made square to
    that side before they are compared, since a needle's height drowns in the rounding of its length.
    """
    best = np.min([_measure_to_segment(p, corners[:, i], corners[:, (i + 1) % 3]) for i in range(3)], axis=0)
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    first = np.argmax(sides, axis=1)
    rows = np.arange(len(corners))
    a, b, c = (corners[rows, (first + i) % 3] for i in range(3))
    base, side, way = b - a, c - a, p - a
    with np.errstate(divide="ignore", invalid="ignore"):
        height = _take_across(_take_across(side, base), base)
        t = _dot(_take_across(way, base), height) / _dot(height, height)
        s = _dot(way - t[:, None] * side, base) / _dot(base, base)
        inside = (s >= 0) & (t >= 0) & (s + t <= 1)
        foot = way - s[:, None] * base - t[:, None] * side
    return np.where(inside, np.minimum(best, np.linalg.norm(np.where(inside[:, None], foot, 0), axis=1)), best)


def _measure_to_segment(p: Array, a: Array, b: Array) -> Array:
    way, base = p - a, b - a
    square = _dot(base, base)
    t = np.clip(np.divide(_dot(way, base), square, out=np.zeros(len(p)), where=square > 0), 0, 1)
    return np.minimum(np.linalg.norm(way - t[:, None] * base, axis=1), np.linalg.norm(p - b, axis=1))


def _take_across(way: Array, base: Array) -> Array:
    """What of a way is not along `base`."""
    return way - (_dot(way, base) / _dot(base, base))[:, None] * base


def _dot(a: Array, b: Array) -> Array:
    return np.einsum("ij,ij->i", a, b)
