"""Small comparisons for pages."""

from __future__ import annotations

from typing import Any

import numpy as np

from bldsimp.compare.placement import PlacedSurface, weld_surface
from bldsimp.compare.rows import Comparison, MethodRow

EVIL = "</script><img src=x onerror=alert(1)>&amp;\"'<!--.obj"


def make_hill(n: int, height: float = 0.2) -> PlacedSurface:
    """A gentle landscape of n times n squares on a base of 8 by 8."""
    flat = np.mgrid[0 : n + 1, 0 : n + 1].reshape(2, -1).T * (8.0 / n)
    points = np.column_stack([flat, height * np.sin(flat[:, 0]) * np.cos(flat[:, 1] * 1.3)])
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).reshape(-1)
    quads = np.stack([corner, corner + n + 1, corner + n + 2, corner + 1], axis=1)
    return weld_surface(points, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))


def make_box(low: tuple[float, float, float], high: tuple[float, float, float]) -> PlacedSurface:
    """Twelve triangles."""
    corners = np.array([[(low, high)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)])
    quads = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])
    return weld_surface(corners, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))


def make_row(method: str, surface: PlacedSurface | None, deviation: float | None = 0.0, **more: Any) -> MethodRow:
    """A row with the figures of its surface."""
    if surface is None:
        return MethodRow("hill.obj", "0.1%", method, note="cannot be reached", **more)
    points, triangles = len(surface.points), len(surface.faces)
    return MethodRow("hill.obj", "0.1%", method, points, triangles, deviation, surface=surface, watertight=False,
               border_made=0, seconds=0.5, **more)  # fmt: skip


def make_comparison(file: str = "hill.obj", n: int = 24) -> Comparison:
    """A landscape with a coarser one, a flat one, and a method that failed."""
    original, coarse, flat = make_hill(n), make_hill(n // 3), make_hill(1)
    rows = [
        make_row("original", original),
        make_row("improved", coarse, 0.05, bound=0.06),
        make_row("fast-simplification", flat, 0.5),
        make_row("fast-simplification border", None),
    ]
    for each in rows:
        each.file = file
    diagonal = float(np.linalg.norm(np.ptp(original.points, axis=0)))
    return Comparison(file, original, diagonal, {"0.1%": diagonal / 1000}, rows)
