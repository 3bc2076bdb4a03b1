"""Odd shapes at n and at 2n: what grows by more than the size does is not linear.

usage: python benchmarks/odd_shapes.py [--runs R] [--only WORD] [--stages]

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
from stages import stage_seconds
from table import table

import bldsimp

Solid = tuple[NDArray[np.float64], NDArray[np.int32]]
Plane = tuple[NDArray[np.float64], NDArray[np.int32]]


def ring(count: int, first: int = 0) -> NDArray[np.int32]:
    """Segments of a closed ring of so many points."""
    i = np.arange(count, dtype=np.int32)
    return first + np.stack([i, (i + 1) % count], axis=1)


def flat(outline: NDArray[np.float64], segments: NDArray[np.int32]) -> Solid:
    """A sheet in the plane, one facet."""
    cut = bldsimp.triangulate(outline, segments)
    return np.c_[cut.points, np.zeros(len(cut.points))], cut.triangles


def extrude(outline: NDArray[np.float64], segments: NDArray[np.int32]) -> Solid:
    """A closed prism, every wall halved at middle height so that there is something to drop."""
    cut = bldsimp.triangulate(outline, segments)
    count, roof = len(outline), cut.triangles
    a, b = segments.T
    walls = [[a, b, b + count], [a, b + count, a + count], [a + count, b + count, b + 2 * count]]
    walls.append([a + count, b + 2 * count, a + 2 * count])
    faces = [roof[:, ::-1], roof + 2 * count, *(np.stack(w, axis=1) for w in walls)]
    points = np.concatenate([np.c_[outline, np.full(count, h)] for h in (0.0, 1.0, 2.0)])
    return points, np.concatenate(faces).astype(np.int32)


def comb_outline(teeth: int) -> NDArray[np.float64]:
    """A bar with long thin teeth."""
    x = np.arange(2 * teeth, dtype=float)
    zigzag = np.stack([x, np.where(np.arange(2 * teeth) % 2 == 0, 1.0, 100.0)], axis=1)
    bar: NDArray[np.float64] = np.concatenate([zigzag[::-1], [[0.0, 0.0], [x[-1], 0.0]]])
    return bar


def square_comb_outline(teeth: int) -> NDArray[np.float64]:
    """A bar with long thin teeth that end square."""
    x = np.arange(2 * teeth, dtype=float).repeat(2)[1:-1]
    y = np.tile([100.0, 100.0, 1.0, 1.0], teeth)[: len(x)]
    bar: NDArray[np.float64] = np.concatenate(
        [np.stack([x, y], axis=1)[::-1], [[0.0, 100.0], [0.0, 0.0], [x[-1] + 1.0, 0.0], [x[-1] + 1.0, 100.0]]]
    )
    return bar


def spiral_outline(count: int) -> NDArray[np.float64]:
    """A thin band wound up."""
    t = np.linspace(2.0, 2.0 + count / 100, count // 2)
    arm = np.stack([t * np.cos(2 * np.pi * t), t * np.sin(2 * np.pi * t)], axis=1)
    band: NDArray[np.float64] = np.concatenate([arm, (arm * ((t + 0.4) / t)[:, None])[::-1]])
    return band


def comb(teeth: int) -> Solid:
    """A closed prism over a comb."""
    outline = comb_outline(teeth)
    return extrude(outline, ring(len(outline)))


def square_comb(teeth: int) -> Solid:
    """A closed prism over a comb with square teeth."""
    outline = square_comb_outline(teeth)
    return extrude(outline, ring(len(outline)))


def flat_comb(teeth: int) -> Solid:
    """One facet alone, with points to drop."""
    outline = square_comb_outline(teeth)
    middles = (outline + np.roll(outline, -1, axis=0)) / 2
    outline = np.stack([outline, middles], axis=1).reshape(-1, 2)
    return flat(outline, ring(len(outline)))


def fan_of_sheets(count: int) -> Solid:
    """Triangles that all share one edge."""
    angle = np.arange(count) * (2 * np.pi / count)
    rim = np.stack([np.cos(angle), np.sin(angle), np.full(count, 0.5)], axis=1)
    i = np.arange(count, dtype=np.int32)
    return np.concatenate([[[0, 0, 0], [0, 0, 1]], rim]), np.stack([0 * i, 0 * i + 1, i + 2], axis=1)


def book(count: int) -> Solid:
    """Like it, but each page's rows of its own, as soup is stored."""
    points, faces = fan_of_sheets(count)
    return points[faces.ravel()], np.arange(3 * count, dtype=np.int32).reshape(-1, 3)


def cone(count: int) -> Solid:
    """A closed cone with a rim of so many points."""
    angle = np.arange(count) * (2 * np.pi / count)
    rim = np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], axis=1)
    i = np.arange(count, dtype=np.int32)
    j = (i + 1) % count
    faces = np.concatenate([np.stack([i, j, 0 * i + count], 1), np.stack([j, i, 0 * i + count + 1], 1)])
    return np.concatenate([rim, [[0, 0, 1.0], [0, 0, 0.0]]]), faces.astype(np.int32)


def disc(count: int) -> Solid:
    """A flat fan around one point."""
    points, faces = cone(count)
    return np.concatenate([points[:count], points[-1:]]), np.where(faces[count:] > count, count, faces[count:])


def two_cones(count: int) -> Solid:
    """Two cones that touch with their tips."""
    points, faces = cone(count // 2)
    return merged((points, faces), (points * [1, 1, -1] + [0, 0, 2], faces[:, ::-1]))


def merged(*solids: Solid) -> Solid:
    """All of them in one mesh."""
    starts = np.cumsum([0, *(len(points) for points, _ in solids)])
    faces = [faces + start for (_, faces), start in zip(solids, starts[:-1], strict=True)]
    return np.concatenate([points for points, _ in solids]), np.concatenate(faces).astype(np.int32)


def grid(columns: int, rows: int, heights: NDArray[np.float64] | None = None) -> Solid:
    """Quads, halved; `heights` per column of points."""
    x, y = np.meshgrid(np.arange(columns + 1.0), np.arange(rows + 1.0), indexing="ij")
    z = np.zeros_like(x) if heights is None else np.repeat(heights[:, None], rows + 1, axis=1)
    at = np.arange(x.size, dtype=np.int32).reshape(x.shape)
    a, b, c, d = (v.ravel() for v in (at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return np.stack([x.ravel(), y.ravel(), z.ravel()], 1), faces


def strip(quads: int) -> Solid:
    """One row of quads."""
    return grid(quads, 1)


def curved_strip(quads: int) -> Solid:
    """One row of quads on an arc: a facet cannot follow it."""
    t = np.arange(quads + 1.0) / quads
    return grid(quads, 1, t * t)


def stairs(steps: int) -> Solid:
    """Treads and risers, two rows of quads each."""
    x = (np.arange(2 * steps + 1) + 1) // 2
    points, faces = grid(2 * steps, 2, (np.arange(2 * steps + 1) // 2).astype(float))
    points[:, 0] = np.repeat(x, 3)
    return points, faces


CUBE = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
CUBE_FACES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4],
     [1, 5, 7], [1, 7, 3]], np.int32,
)  # fmt: skip


def cubes(count: int) -> Solid:
    """Cubes apart."""
    side = int(np.ceil(np.sqrt(count)))
    at = np.arange(count)
    shift = np.stack([at % side * 2.0, at // side * 2.0, 0.0 * at], axis=1)
    points = (CUBE + shift[:, None]).reshape(-1, 3)
    return points, (CUBE_FACES + 8 * at[:, None, None]).reshape(-1, 3).astype(np.int32)


def turned_cubes(count: int) -> Solid:
    """Cubes apart, all inside out."""
    points, faces = cubes(count)
    return points, faces[:, ::-1].copy()


def nested_cubes(count: int) -> Solid:
    """Cubes inside one another, all facing outwards, but every second inside out."""
    size = 1 + np.arange(count)[:, None, None]
    points = ((CUBE - 0.5) * size).reshape(-1, 3)
    faces = CUBE_FACES + 8 * np.arange(count)[:, None, None]
    faces[::2] = faces[::2, :, ::-1]
    return points, faces.reshape(-1, 3).astype(np.int32)


def holes(count: int) -> Solid:
    """A facet with square holes, each with points to drop."""
    side = int(np.ceil(np.sqrt(count)))
    at = np.arange(count)
    corner = np.array([[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1]]) / 4 + 0.25
    inner = (corner + np.stack([at % side, at // side], 1)[:, None]).reshape(-1, 2)
    outer = np.array([[0, 0], [side, 0], [side, side], [0, side]], float)
    rings = (ring(8) + 8 * at[:, None, None]).reshape(-1, 2)
    return flat(np.concatenate([inner, outer]), np.concatenate([rings, ring(4, 8 * count)]).astype(np.int32))


def round_hole(count: int) -> Solid:
    """A square with one hole of so many points."""
    angle = np.arange(count) * (2 * np.pi / count)
    hole = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    outer = np.array([[-2, -2], [2, -2], [2, 2], [-2, 2]], float)
    return flat(np.concatenate([hole, outer]), np.concatenate([ring(count), ring(4, count)]).astype(np.int32))


def needle_hole(count: int) -> Solid:
    """A square with a slit-like hole of so many points on two lines."""
    x = np.linspace(-1, 1, count // 2)
    hole = np.concatenate([np.stack([x, 1e-3 * (1 - x * x)], 1), np.stack([x, -1e-3 * (1 - x * x)], 1)[-2:0:-1]])
    outer = np.array([[-2, -2], [2, -2], [2, 2], [-2, 2]], float)
    return flat(np.concatenate([hole, outer]), np.concatenate([ring(len(hole)), ring(4, len(hole))]).astype(np.int32))


def straight_slit(count: int) -> Solid:
    """A square with a rectangular hole, all its points but four to be dropped."""
    x = np.linspace(-1, 1, count // 2)
    hole = np.concatenate([np.stack([x, 0 * x + 1e-3], 1), np.stack([x, 0 * x - 1e-3], 1)[::-1]])
    outer = np.array([[-2, -2], [2, -2], [2, 2], [-2, 2]], float)
    return flat(np.concatenate([hole, outer]), np.concatenate([ring(len(hole)), ring(4, len(hole))]).astype(np.int32))


def sphere(count: int) -> Solid:
    """A sphere of about so many faces: nothing to simplify."""
    rows = int(np.sqrt(count / 4))
    u = np.arange(2 * rows) * (np.pi / rows)
    v = np.arange(1, rows) * (np.pi / rows)
    points = np.stack(
        [np.outer(np.sin(v), np.cos(u)), np.outer(np.sin(v), np.sin(u)), np.outer(np.cos(v), 0 * u + 1)], -1
    ).reshape(-1, 3)
    at = np.arange(len(points)).reshape(rows - 1, 2 * rows)
    a, b = at[:-1], np.roll(at[:-1], -1, 1)
    d, c = at[1:], np.roll(at[1:], -1, 1)
    north, south = len(points), len(points) + 1
    quads = [np.stack([x.ravel() for x in t], 1) for t in ((a, d, c), (a, c, b))]
    caps = [
        np.stack([0 * at[0] + north, at[0], np.roll(at[0], -1)], 1),
        np.stack([at[-1], 0 * at[0] + south, np.roll(at[-1], -1)], 1),
    ]
    return np.concatenate([points, [[0, 0, 1], [0, 0, -1]]]), np.concatenate([*quads, *caps]).astype(np.int32)


def soup(count: int) -> Solid:
    """Triangles at random that cross one another."""
    points = np.random.default_rng(1).random((3 * count, 3))
    return points, np.arange(3 * count, dtype=np.int32).reshape(-1, 3)


def flat_soup(count: int) -> Solid:
    """Triangles at random over few points of one plane."""
    rng = np.random.default_rng(2)
    points = np.c_[rng.random((count // 4, 2)), np.zeros(count // 4)]
    return points, rng.integers(0, len(points), (count, 3)).astype(np.int32)


def dense_soup(count: int) -> Solid:
    """Triangles at random over a hundred points."""
    rng = np.random.default_rng(2)
    return rng.random((100, 3)), rng.integers(0, 100, (count, 3)).astype(np.int32)


def copies(count: int) -> Solid:
    """One triangle many times over."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]])
    return np.tile(points, (count, 1)), np.arange(3 * count, dtype=np.int32).reshape(-1, 3)


def copies_both_ways(count: int) -> Solid:
    """The same, every second the other way round."""
    points, faces = copies(count)
    faces[::2] = faces[::2, ::-1]
    return points, faces


def helix(count: int) -> Solid:
    """A ramp that winds up, on few rows."""
    points, faces = grid(count, 2)
    angle = points[:, 0] * (2 * np.pi / 100)
    radius = 5 + points[:, 1]
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), points[:, 0] / 100], 1), faces


def soft_ramp(count: int) -> Solid:
    """A ramp whose slope changes so little that every facet is a guess, within the tolerance for a while."""
    t = np.arange(count + 1.0)
    return grid(count, 2, 1e-6 * t * t / 1000)


def zigzag_border(count: int) -> Solid:
    """A sheet whose border runs to and fro below the tolerance."""
    points, faces = grid(count, 1)
    points[:, 1] += np.where(np.arange(len(points)) // 2 % 2 == 0, 1e-7, 0.0) * count * 1e-2
    return points, faces


def bumpy_outline(count: int) -> Solid:
    """A flat band that bends ever more: thinning cuts its chains at their ends."""
    t = np.arange(count // 2 + 1.0) / count
    lower = np.stack([t, t**8], 1)
    outline = np.concatenate([lower, lower[::-1] + np.array([0, 1.0])])
    return flat(outline, ring(len(outline)))


def circle(count: int) -> Plane:
    """Points on one circle."""
    angle = np.arange(count) * (2 * np.pi / count)
    return np.stack([np.cos(angle), np.sin(angle)], axis=1), np.empty((0, 2), np.int32)


def line(count: int) -> Plane:
    """Points on one line, one beside it."""
    x = np.arange(count, dtype=float)
    return np.concatenate([np.stack([x, x / 3], 1), [[0.0, 1.0]]]), np.empty((0, 2), np.int32)


def square_grid(count: int) -> Plane:
    """Points of a grid."""
    side = np.arange(int(np.sqrt(count)), dtype=float)
    return np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2), np.empty((0, 2), np.int32)


def parabola(count: int) -> Plane:
    """Points on a parabola."""
    x = np.linspace(-1, 1, count)
    return np.stack([x, x * x], 1), np.empty((0, 2), np.int32)


def two_lines(count: int) -> Plane:
    """Points on two crossing lines."""
    x = np.linspace(-1, 1, count // 2)
    return np.concatenate([np.stack([x, 0 * x], 1), np.stack([0 * x, x + 1e-7], 1)]), np.empty((0, 2), np.int32)


def moment_curve(count: int) -> Plane:
    """Points on an exponential curve: no cell of a grid suits them all."""
    x = np.linspace(0, 1, count)
    return np.stack([np.exp(40 * (x - 1)), np.exp(-40 * x)], 1), np.empty((0, 2), np.int32)


def spiral(count: int) -> Plane:
    """A polygon wound up."""
    outline = spiral_outline(count)
    return outline, ring(len(outline))


def comb_polygon(count: int) -> Plane:
    """A comb with pointed teeth."""
    outline = comb_outline(count // 2)
    return outline, ring(len(outline))


def square_comb_polygon(count: int) -> Plane:
    """A comb with square teeth."""
    outline = square_comb_outline(count // 4)
    return outline, ring(len(outline))


def star_segments(count: int) -> Plane:
    """Segments that all meet in one point."""
    points, _ = circle(count)
    i = np.arange(count, dtype=np.int32)
    return np.concatenate([points, [[0.0, 0.0]]]), np.stack([i, 0 * i + count], 1)


def star_across(count: int) -> Plane:
    """The same, with random points between: every segment has many triangles to cross."""
    points, segments = star_segments(count // 2)
    between = np.random.default_rng(3).random((count // 2, 2)) * 2 - 1
    return np.concatenate([points, between]), segments


def long_segments(count: int) -> Plane:
    """Long parallel segments between random points."""
    rng = np.random.default_rng(4)
    points = rng.random((count, 2))
    few = 40
    y = np.linspace(0, 1, few + 2)[1:-1]
    ends = np.concatenate([np.stack([0 * y - 1, y], 1), np.stack([0 * y + 2, y + 1e-3], 1)])
    i = np.arange(few, dtype=np.int32)
    return np.concatenate([ends, points]), np.stack([i, i + few], 1)


def ladder_segments(count: int) -> Plane:
    """Long parallel segments close to one another, as many as points."""
    y = np.arange(count // 2, dtype=float)
    ends = np.concatenate([np.stack([0 * y, y], 1), np.stack([0 * y + 100.0 * count, y], 1)])
    i = np.arange(count // 2, dtype=np.int32)
    return ends, np.stack([i, i + count // 2], 1)


def fan_over_chain(count: int) -> Plane:
    """Segments from one far point to each point of an arc."""
    x = np.linspace(-1, 1, count)
    arc = np.stack([x, 1 - x * x / 2], 1)
    i = np.arange(count, dtype=np.int32)
    return np.concatenate([arc, [[0.0, -1000.0]]]), np.stack([i, 0 * i + count], 1)


def one_long_segment(count: int) -> Plane:
    """One segment between two rows of points: its influence domain is the whole net."""
    x = np.linspace(0, 1, count // 2)
    rows = np.concatenate([np.stack([x, 1e-3 + x * (1 - x)], 1), np.stack([x, -1e-3 - x * (1 - x)], 1)])
    ends = np.array([[-1.0, 0.0], [2.0, 0.0]])
    return np.concatenate([rows, ends]), np.array([[len(rows), len(rows) + 1]], np.int32)


def zigzag_domain(count: int) -> Plane:
    """One segment whose influence domain is bounded by a zigzag."""
    i = np.arange(count)
    y = np.where(i % 2 == 0, 1.0, 2.0) * np.where(i % 4 < 2, 1.0, -1.0) + 1e-3 * np.sin(i)
    ends = np.array([[-10.0, 0.0], [count + 10.0, 0.0]])
    return np.concatenate([np.stack([i.astype(float), y], 1), ends]), np.array([[count, count + 1]], np.int32)


SOLIDS: list[tuple[Callable[[int], Solid], int]] = [
    (comb, 10_000), (square_comb, 10_000), (flat_comb, 10_000), (fan_of_sheets, 20_000), (book, 20_000), (cone, 40_000),
    (disc, 40_000), (two_cones, 40_000), (strip, 200_000), (curved_strip, 50_000), (stairs, 25_000), (cubes, 25_000),
    (turned_cubes, 5_000), (nested_cubes, 2_000), (holes, 5_000), (round_hole, 50_000), (needle_hole, 50_000),
    (straight_slit, 50_000), (sphere, 250_000), (soup, 50_000), (flat_soup, 10_000), (dense_soup, 5_000),
    (copies, 50_000), (copies_both_ways, 50_000), (helix, 50_000), (soft_ramp, 50_000), (zigzag_border, 50_000),
    (bumpy_outline, 50_000),
]  # fmt: skip
PLANES: list[tuple[Callable[[int], Plane], int]] = [
    (circle, 100_000), (line, 100_000), (square_grid, 100_000), (parabola, 100_000), (two_lines, 100_000),
    (moment_curve, 100_000), (spiral, 50_000), (comb_polygon, 40_000), (square_comb_polygon, 40_000),
    (star_segments, 50_000), (star_across, 50_000), (long_segments, 50_000), (ladder_segments, 20_000),
    (fan_over_chain, 50_000), (one_long_segment, 100_000), (zigzag_domain, 50_000),
]  # fmt: skip


def least(runs: int, job: Callable[[], object]) -> float:
    """Seconds of the fastest of so many runs."""
    seconds = []
    for _ in range(runs):
        start = time.perf_counter()
        job()
        seconds.append(time.perf_counter() - start)
    return min(seconds)


def solid_row(make: Callable[[int], Solid], size: int, runs: int) -> list[Any]:
    """One row for a mesh that is simplified."""
    small, large = make(size), make(2 * size)
    first = least(runs, lambda: bldsimp.simplify(small))
    done = []
    second = least(runs, lambda: done.append(bldsimp.simplify(large)))
    stages = stage_seconds(lambda: bldsimp.simplify(large))
    slowest = max(stages, key=lambda stage: stages[stage])
    after = done[0].report.after.points
    return row(make, len(large[1]), after, first, second, f"{slowest}, {stages[slowest]:.2f} s")


def plane_row(make: Callable[[int], Plane], size: int, runs: int) -> list[Any]:
    """One row for points and segments that are triangulated."""
    small, large = make(size), make(2 * size)

    def triangles(given: Plane) -> int:
        return len(bldsimp.triangulate(*given, carve=False).triangles)

    first = least(runs, lambda: triangles(small))
    second = least(runs, lambda: triangles(large))
    return row(make, len(large[0]), triangles(large), first, second, "triangulate")


def row(make: Callable[..., Any], size: int, out: int, first: float, second: float, slowest: str) -> list[Any]:
    """What all rows show."""
    name = make.__name__.replace("_", " ")
    return [name, size, out, f"{first:.3f} s", f"{second:.3f} s", f"{second / first:.2f}", slowest]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=2)
    parser.add_argument("--only", default="", help="shapes whose name holds this word")
    args = parser.parse_args()
    header = ["shape", "faces or points at 2n", "out", "n", "2n", "growth", "slowest stage"]
    rows = []
    for kind, cases in ((solid_row, SOLIDS), (plane_row, PLANES)):
        for make, size in cases:
            if args.only not in make.__name__:
                continue
            rows.append(kind(make, size, args.runs))
    print(table(header, rows))


if __name__ == "__main__":
    main()
