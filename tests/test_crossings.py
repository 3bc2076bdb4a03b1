"""Triangles that pass through one another: found exactly, and never made."""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

Vector = tuple[Fraction, ...]
Polygon = list[Vector]


def minus(a: Vector, b: Vector) -> Vector:
    return tuple(x - y for x, y in zip(a, b, strict=True))


def dot(a: Vector, b: Vector) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def normal(triangle: Polygon) -> Vector:
    a, b, c = triangle
    return cross(minus(b, a), minus(c, a))


def interior_weights(triangle: Polygon, point: Vector) -> bool:
    """Whether a point of the triangle's plane is inside of it, sides not included."""
    n = normal(triangle)
    return all(
        dot(cross(minus(triangle[(i + 1) % 3], triangle[i]), minus(point, triangle[i])), n) > 0 for i in range(3)
    )


def clipped(polygon: Polygon, through: Vector, inward: Vector) -> Polygon:
    """The part of a convex polygon on one side of a plane."""
    kept: Polygon = []
    for p, q in itertools.pairwise([*polygon, polygon[0]]):
        a, b = dot(minus(p, through), inward), dot(minus(q, through), inward)
        if a >= 0:
            kept.append(p)
        if a * b < 0:
            kept.append(tuple(x + a / (a - b) * (y - x) for x, y in zip(p, q, strict=True)))
    return kept


def oracle(f: NDArray[np.float64], g: NDArray[np.float64]) -> bool:
    """Whether two triangles have an inner point in common: what is left of f within g holds one if any does."""
    first, second = ([tuple(map(Fraction, p)) for p in t.tolist()] for t in (f, g))
    n, m = normal(first), normal(second)
    if not any(n) or not any(m) or set(first) == set(second):
        return False
    common = first
    for i in range(3):
        if common:
            common = clipped(common, second[i], cross(m, minus(second[(i + 1) % 3], second[i])))
    above = [dot(minus(p, second[0]), m) for p in common]
    if common and any(above):  # the piece of the line in which the planes meet
        common = [p for p, h in zip(common, above, strict=True) if h == 0] + [
            tuple(x + a / (a - b) * (y - x) for x, y in zip(p, q, strict=True))
            for (p, a), (q, b) in itertools.combinations(zip(common, above, strict=True), 2)
            if a * b < 0
        ]
    if not common:
        return False
    middle = tuple(sum(x, Fraction(0)) / len(common) for x in zip(*common, strict=True))
    return interior_weights(first, middle) and interior_weights(second, middle)
