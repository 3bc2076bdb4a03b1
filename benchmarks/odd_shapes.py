"""Odd shapes at n and at 2n: what grows by more than the size does is not linear.

usage: python benchmarks/odd_shapes.py [--runs R] [--only WORD]

Solids and sheets go through `simplify` from arrays to arrays, plane inputs through `triangulate`. `growth` is
the least time at 2n over that at n; the slowest stage is that of the run at 2n. Printed as Markdown.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from odd_solids import SOLIDS, Solid, close_ring, make_comb_outline, make_spiral_outline, make_square_comb_outline
from stages import time_stages
from table import format_table

import bldsimp

Plane = tuple[NDArray[np.float64], NDArray[np.int32]]


def make_circle(count: int) -> Plane:
    """Make points on one circle."""
    angle = np.arange(count) * (2 * np.pi / count)
    return np.stack([np.cos(angle), np.sin(angle)], axis=1), np.empty((0, 2), np.int32)


def make_line(count: int) -> Plane:
    """Make points on one line, one beside it."""
    x = np.arange(count, dtype=float)
    return np.concatenate([np.stack([x, x / 3], 1), [[0.0, 1.0]]]), np.empty((0, 2), np.int32)


def make_square_grid(count: int) -> Plane:
    """Make points of a grid."""
    side = np.arange(int(np.sqrt(count)), dtype=float)
    return np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2), np.empty((0, 2), np.int32)


def make_parabola(count: int) -> Plane:
    """Make points on a parabola."""
    x = np.linspace(-1, 1, count)
    return np.stack([x, x * x], 1), np.empty((0, 2), np.int32)


def make_two_lines(count: int) -> Plane:
    """Make points on two crossing lines."""
    x = np.linspace(-1, 1, count // 2)
    return np.concatenate([np.stack([x, 0 * x], 1), np.stack([0 * x, x + 1e-7], 1)]), np.empty((0, 2), np.int32)


def make_moment_curve(count: int) -> Plane:
    """Make points on an exponential curve: no cell of a grid suits them all."""
    x = np.linspace(0, 1, count)
    return np.stack([np.exp(40 * (x - 1)), np.exp(-40 * x)], 1), np.empty((0, 2), np.int32)


def make_spiral(count: int) -> Plane:
    """Make a polygon wound up."""
    outline = make_spiral_outline(count)
    return outline, close_ring(len(outline))


def make_comb_polygon(count: int) -> Plane:
    """Make a comb with pointed teeth."""
    outline = make_comb_outline(count // 2)
    return outline, close_ring(len(outline))


def make_square_comb_polygon(count: int) -> Plane:
    """Make a comb with square teeth."""
    outline = make_square_comb_outline(count // 4)
    return outline, close_ring(len(outline))


def make_star_segments(count: int) -> Plane:
    """Make segments that all meet in one point."""
    points, _ = make_circle(count)
    i = np.arange(count, dtype=np.int32)
    return np.concatenate([points, [[0.0, 0.0]]]), np.stack([i, 0 * i + count], 1)


def make_star_across(count: int) -> Plane:
    """Make segments that meet in one point, with random points between: every segment has many triangles to cross."""
    points, segments = make_star_segments(count // 2)
    between = np.random.default_rng(3).random((count // 2, 2)) * 2 - 1
    return np.concatenate([points, between]), segments


def make_long_segments(count: int) -> Plane:
    """Make long parallel segments between random points."""
    rng = np.random.default_rng(4)
    points = rng.random((count, 2))
    few = 40
    y = np.linspace(0, 1, few + 2)[1:-1]
    ends = np.concatenate([np.stack([0 * y - 1, y], 1), np.stack([0 * y + 2, y + 1e-3], 1)])
    i = np.arange(few, dtype=np.int32)
    return np.concatenate([ends, points]), np.stack([i, i + few], 1)


def make_ladder_segments(count: int) -> Plane:
    """Make long parallel segments close to one another, as many as points."""
    y = np.arange(count // 2, dtype=float)
    ends = np.concatenate([np.stack([0 * y, y], 1), np.stack([0 * y + 100.0 * count, y], 1)])
    i = np.arange(count // 2, dtype=np.int32)
    return ends, np.stack([i, i + count // 2], 1)


def make_fan_over_chain(count: int) -> Plane:
    """Make segments from one far point to each point of an arc."""
    x = np.linspace(-1, 1, count)
    arc = np.stack([x, 1 - x * x / 2], 1)
    i = np.arange(count, dtype=np.int32)
    return np.concatenate([arc, [[0.0, -1000.0]]]), np.stack([i, 0 * i + count], 1)


def make_one_long_segment(count: int) -> Plane:
    """Make one segment between two rows of points: its influence domain is the whole net."""
    x = np.linspace(0, 1, count // 2)
    rows = np.concatenate([np.stack([x, 1e-3 + x * (1 - x)], 1), np.stack([x, -1e-3 - x * (1 - x)], 1)])
    ends = np.array([[-1.0, 0.0], [2.0, 0.0]])
    return np.concatenate([rows, ends]), np.array([[len(rows), len(rows) + 1]], np.int32)


def make_zigzag_domain(count: int) -> Plane:
    """Make one segment whose influence domain is bounded by a zigzag."""
    i = np.arange(count)
    y = np.where(i % 2 == 0, 1.0, 2.0) * np.where(i % 4 < 2, 1.0, -1.0) + 1e-3 * np.sin(i)
    ends = np.array([[-10.0, 0.0], [count + 10.0, 0.0]])
    return np.concatenate([np.stack([i.astype(float), y], 1), ends]), np.array([[count, count + 1]], np.int32)


PLANES: list[tuple[Callable[[int], Plane], int]] = [
    (make_circle, 100_000),
    (make_line, 100_000),
    (make_square_grid, 100_000),
    (make_parabola, 100_000),
    (make_two_lines, 100_000),
    (make_moment_curve, 100_000),
    (make_spiral, 50_000),
    (make_comb_polygon, 40_000),
    (make_square_comb_polygon, 40_000),
    (make_star_segments, 50_000),
    (make_star_across, 50_000),
    (make_long_segments, 50_000),
    (make_ladder_segments, 20_000),
    (make_fan_over_chain, 50_000),
    (make_one_long_segment, 100_000),
    (make_zigzag_domain, 50_000),
]


def time_fastest(runs: int, job: Callable[[], object]) -> float:
    """Return the seconds of the fastest of so many runs."""
    seconds = []
    for _ in range(runs):
        start = time.perf_counter()
        job()
        seconds.append(time.perf_counter() - start)
    return min(seconds)


def measure_solid(make: Callable[[int], Solid], size: int, runs: int) -> list[Any]:
    """Measure one row for a mesh that is simplified."""
    small, large = make(size), make(2 * size)
    first = time_fastest(runs, lambda: bldsimp.simplify(small))
    done = []
    second = time_fastest(runs, lambda: done.append(bldsimp.simplify(large)))
    stages = time_stages(lambda: bldsimp.simplify(large))
    slowest = max(stages, key=lambda stage: stages[stage])
    after = done[0].report.after.points
    return format_row(make, len(large[1]), after, first, second, f"{slowest}, {stages[slowest]:.2f} s")


def measure_plane(make: Callable[[int], Plane], size: int, runs: int) -> list[Any]:
    """Measure one row for points and segments that are triangulated."""
    small, large = make(size), make(2 * size)

    def triangles(given: Plane) -> int:
        return len(bldsimp.triangulate(*given, carve=False).triangles)

    first = time_fastest(runs, lambda: triangles(small))
    second = time_fastest(runs, lambda: triangles(large))
    return format_row(make, len(large[0]), triangles(large), first, second, "triangulate")


def format_row(make: Callable[..., Any], size: int, out: int, first: float, second: float, slowest: str) -> list[Any]:
    """Write the cells that all rows have."""
    name = make.__name__.removeprefix("make_").replace("_", " ")
    return [name, size, out, f"{first:.3f} s", f"{second:.3f} s", f"{second / first:.2f}", slowest]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=2)
    parser.add_argument("--only", default="", help="only shapes whose name contains this word")
    args = parser.parse_args()
    header = ["shape", "faces or points at 2n", "out", "n", "2n", "growth", "slowest stage"]
    rows = []
    for kind, cases in ((measure_solid, SOLIDS), (measure_plane, PLANES)):
        for make, size in cases:
            if args.only not in make.__name__:
                continue
            rows.append(kind(make, size, args.runs))
    print(format_table(header, rows))


if __name__ == "__main__":
    main()
