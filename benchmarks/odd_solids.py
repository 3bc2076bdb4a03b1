"""Odd solids and sheets, each of a size n."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

import bldsimp

Solid = tuple[NDArray[np.float64], NDArray[np.int32]]


def close_ring(count: int, first: int = 0) -> NDArray[np.int32]:
    """Return the segments of a closed ring of so many points."""
    i = np.arange(count, dtype=np.int32)
    return first + np.stack([i, (i + 1) % count], axis=1)


def fill_outline(outline: NDArray[np.float64], segments: NDArray[np.int32]) -> Solid:
    """Fill an outline: a sheet in the plane, one facet."""
    cut = bldsimp.triangulate(outline, segments)
    return np.c_[cut.points, np.zeros(len(cut.points))], cut.triangles


def extrude(outline: NDArray[np.float64], segments: NDArray[np.int32]) -> Solid:
    """Extrude an outline to a closed prism, with each wall halved at middle height by needless points."""
    cut = bldsimp.triangulate(outline, segments)
    count, roof = len(outline), cut.triangles
    a, b = segments.T
    walls = [[a, b, b + count], [a, b + count, a + count], [a + count, b + count, b + 2 * count]]
    walls.append([a + count, b + 2 * count, a + 2 * count])
    faces = [roof[:, ::-1], roof + 2 * count, *(np.stack(w, axis=1) for w in walls)]
    points = np.concatenate([np.c_[outline, np.full(count, h)] for h in (0.0, 1.0, 2.0)])
    return points, np.concatenate(faces).astype(np.int32)


def make_comb_outline(teeth: int) -> NDArray[np.float64]:
    """Make a bar with long thin teeth."""
    x = np.arange(2 * teeth, dtype=float)
    zigzag = np.stack([x, np.where(np.arange(2 * teeth) % 2 == 0, 1.0, 100.0)], axis=1)
    bar: NDArray[np.float64] = np.concatenate([zigzag[::-1], [[0.0, 0.0], [x[-1], 0.0]]])
    return bar


def make_square_comb_outline(teeth: int) -> NDArray[np.float64]:
    """Make a bar with long thin teeth that end square."""
    x = np.arange(2 * teeth, dtype=float).repeat(2)[1:-1]
    y = np.tile([100.0, 100.0, 1.0, 1.0], teeth)[: len(x)]
    bar: NDArray[np.float64] = np.concatenate(
        [np.stack([x, y], axis=1)[::-1], [[0.0, 100.0], [0.0, 0.0], [x[-1] + 1.0, 0.0], [x[-1] + 1.0, 100.0]]]
    )
    return bar


def make_spiral_outline(count: int) -> NDArray[np.float64]:
    """Make a thin band wound up."""
    t = np.linspace(2.0, 2.0 + count / 100, count // 2)
    arm = np.stack([t * np.cos(2 * np.pi * t), t * np.sin(2 * np.pi * t)], axis=1)
    band: NDArray[np.float64] = np.concatenate([arm, (arm * ((t + 0.4) / t)[:, None])[::-1]])
    return band


def make_comb(teeth: int) -> Solid:
    """Make a closed prism over a comb."""
    outline = make_comb_outline(teeth)
    return extrude(outline, close_ring(len(outline)))


def make_square_comb(teeth: int) -> Solid:
    """Make a closed prism over a comb with square teeth."""
    outline = make_square_comb_outline(teeth)
    return extrude(outline, close_ring(len(outline)))


def make_flat_comb(teeth: int) -> Solid:
    """Make one facet alone, with points to remove."""
    outline = make_square_comb_outline(teeth)
    middles = (outline + np.roll(outline, -1, axis=0)) / 2
    outline = np.stack([outline, middles], axis=1).reshape(-1, 2)
    return fill_outline(outline, close_ring(len(outline)))


def make_fan_of_sheets(count: int) -> Solid:
    """Make triangles that all share one edge."""
    angle = np.arange(count) * (2 * np.pi / count)
    rim = np.stack([np.cos(angle), np.sin(angle), np.full(count, 0.5)], axis=1)
    i = np.arange(count, dtype=np.int32)
    return np.concatenate([[[0, 0, 0], [0, 0, 1]], rim]), np.stack([0 * i, 0 * i + 1, i + 2], axis=1)


def make_book(count: int) -> Solid:
    """Make like it, but each page's rows of its own, as soup is stored."""
    points, faces = make_fan_of_sheets(count)
    return points[faces.ravel()], np.arange(3 * count, dtype=np.int32).reshape(-1, 3)


def make_cone(count: int) -> Solid:
    """Make a closed cone with a rim of so many points."""
    angle = np.arange(count) * (2 * np.pi / count)
    rim = np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], axis=1)
    i = np.arange(count, dtype=np.int32)
    j = (i + 1) % count
    faces = np.concatenate([np.stack([i, j, 0 * i + count], 1), np.stack([j, i, 0 * i + count + 1], 1)])
    return np.concatenate([rim, [[0, 0, 1.0], [0, 0, 0.0]]]), faces.astype(np.int32)


def make_disc(count: int) -> Solid:
    """Make a flat fan around one point."""
    points, faces = make_cone(count)
    return np.concatenate([points[:count], points[-1:]]), np.where(faces[count:] > count, count, faces[count:])


def make_two_cones(count: int) -> Solid:
    """Make two cones that touch with their tips."""
    points, faces = make_cone(count // 2)
    return merge((points, faces), (points * [1, 1, -1] + [0, 0, 2], faces[:, ::-1]))


def merge(*solids: Solid) -> Solid:
    """All of them in one mesh."""
    starts = np.cumsum([0, *(len(points) for points, _ in solids)])
    faces = [faces + start for (_, faces), start in zip(solids, starts[:-1], strict=True)]
    return np.concatenate([points for points, _ in solids]), np.concatenate(faces).astype(np.int32)


def make_grid(columns: int, rows: int, heights: NDArray[np.float64] | None = None) -> Solid:
    """Make quads, halved; `heights` per column of points."""
    x, y = np.meshgrid(np.arange(columns + 1.0), np.arange(rows + 1.0), indexing="ij")
    z = np.zeros_like(x) if heights is None else np.repeat(heights[:, None], rows + 1, axis=1)
    at = np.arange(x.size, dtype=np.int32).reshape(x.shape)
    a, b, c, d = (v.ravel() for v in (at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return np.stack([x.ravel(), y.ravel(), z.ravel()], 1), faces


def make_strip(quads: int) -> Solid:
    """Make one row of quads."""
    return make_grid(quads, 1)


def make_curved_strip(quads: int) -> Solid:
    """Make one row of quads on an arc: a facet cannot follow it."""
    t = np.arange(quads + 1.0) / quads
    return make_grid(quads, 1, t * t)


def make_stairs(steps: int) -> Solid:
    """Make treads and risers, two rows of quads each."""
    x = (np.arange(2 * steps + 1) + 1) // 2
    points, faces = make_grid(2 * steps, 2, (np.arange(2 * steps + 1) // 2).astype(float))
    points[:, 0] = np.repeat(x, 3)
    return points, faces


CUBE = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
CUBE_FACES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4],
     [1, 5, 7], [1, 7, 3]], np.int32,
)  # fmt: skip


def make_cubes(count: int) -> Solid:
    """Make cubes apart."""
    side = int(np.ceil(np.sqrt(count)))
    at = np.arange(count)
    shift = np.stack([at % side * 2.0, at // side * 2.0, 0.0 * at], axis=1)
    points = (CUBE + shift[:, None]).reshape(-1, 3)
    return points, (CUBE_FACES + 8 * at[:, None, None]).reshape(-1, 3).astype(np.int32)


def make_turned_cubes(count: int) -> Solid:
    """Make cubes apart, all inside out."""
    points, faces = make_cubes(count)
    return points, faces[:, ::-1].copy()


def make_nested_cubes(count: int) -> Solid:
    """Make cubes inside one another, all facing outwards, but every second inside out."""
    size = 1 + np.arange(count)[:, None, None]
    points = ((CUBE - 0.5) * size).reshape(-1, 3)
    faces = CUBE_FACES + 8 * np.arange(count)[:, None, None]
    faces[::2] = faces[::2, :, ::-1]
    return points, faces.reshape(-1, 3).astype(np.int32)


def make_holes(count: int) -> Solid:
    """Make a facet with square holes, each with points to remove."""
    side = int(np.ceil(np.sqrt(count)))
    at = np.arange(count)
    corner = np.array([[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1]]) / 4 + 0.25
    inner = (corner + np.stack([at % side, at // side], 1)[:, None]).reshape(-1, 2)
    outer = np.array([[0, 0], [side, 0], [side, side], [0, side]], float)
    rings = (close_ring(8) + 8 * at[:, None, None]).reshape(-1, 2)
    return fill_outline(
        np.concatenate([inner, outer]), np.concatenate([rings, close_ring(4, 8 * count)]).astype(np.int32)
    )


def make_round_hole(count: int) -> Solid:
    """Make a square with one hole of so many points."""
    angle = np.arange(count) * (2 * np.pi / count)
    hole = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    outer = np.array([[-2, -2], [2, -2], [2, 2], [-2, 2]], float)
    return fill_outline(
        np.concatenate([hole, outer]), np.concatenate([close_ring(count), close_ring(4, count)]).astype(np.int32)
    )


def make_needle_hole(count: int) -> Solid:
    """Make a square with a slit-like hole of so many points on two lines."""
    x = np.linspace(-1, 1, count // 2)
    hole = np.concatenate([np.stack([x, 1e-3 * (1 - x * x)], 1), np.stack([x, -1e-3 * (1 - x * x)], 1)[-2:0:-1]])
    outer = np.array([[-2, -2], [2, -2], [2, 2], [-2, 2]], float)
    return fill_outline(
        np.concatenate([hole, outer]),
        np.concatenate([close_ring(len(hole)), close_ring(4, len(hole))]).astype(np.int32),
    )


def make_straight_slit(count: int) -> Solid:
    """Make a square with a rectangular hole, all its points but four to be removed."""
    x = np.linspace(-1, 1, count // 2)
    hole = np.concatenate([np.stack([x, 0 * x + 1e-3], 1), np.stack([x, 0 * x - 1e-3], 1)[::-1]])
    outer = np.array([[-2, -2], [2, -2], [2, 2], [-2, 2]], float)
    return fill_outline(
        np.concatenate([hole, outer]),
        np.concatenate([close_ring(len(hole)), close_ring(4, len(hole))]).astype(np.int32),
    )


def make_sphere(count: int) -> Solid:
    """Make a sphere of about so many faces: nothing to simplify."""
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


def make_soup(count: int) -> Solid:
    """Make triangles at random that cross one another."""
    points = np.random.default_rng(1).random((3 * count, 3))
    return points, np.arange(3 * count, dtype=np.int32).reshape(-1, 3)


def make_flat_soup(count: int) -> Solid:
    """Make triangles at random over few points of one plane."""
    rng = np.random.default_rng(2)
    points = np.c_[rng.random((count // 4, 2)), np.zeros(count // 4)]
    return points, rng.integers(0, len(points), (count, 3)).astype(np.int32)


def make_dense_soup(count: int) -> Solid:
    """Make triangles at random over a hundred points."""
    rng = np.random.default_rng(2)
    return rng.random((100, 3)), rng.integers(0, 100, (count, 3)).astype(np.int32)


def make_copies(count: int) -> Solid:
    """Make one triangle many times over."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]])
    return np.tile(points, (count, 1)), np.arange(3 * count, dtype=np.int32).reshape(-1, 3)


def make_copies_both_ways(count: int) -> Solid:
    """Make copies of a triangle, every second the other way round."""
    points, faces = make_copies(count)
    faces[::2] = faces[::2, ::-1]
    return points, faces


def make_helix(count: int) -> Solid:
    """Make a ramp that winds up, on few rows."""
    points, faces = make_grid(count, 2)
    angle = points[:, 0] * (2 * np.pi / 100)
    radius = 5 + points[:, 1]
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), points[:, 0] / 100], 1), faces


def make_soft_ramp(count: int) -> Solid:
    """Make a ramp whose slope changes so little that every facet is a guess, within the tolerance for a while."""
    t = np.arange(count + 1.0)
    return make_grid(count, 2, 1e-6 * t * t / 1000)


def make_zigzag_border(count: int) -> Solid:
    """Make a sheet whose border runs to and fro below the tolerance."""
    points, faces = make_grid(count, 1)
    points[:, 1] += np.where(np.arange(len(points)) // 2 % 2 == 0, 1e-7, 0.0) * count * 1e-2
    return points, faces


def make_bumpy_outline(count: int) -> Solid:
    """Make a flat band that bends ever more: thinning cuts its chains at their ends."""
    t = np.arange(count // 2 + 1.0) / count
    lower = np.stack([t, t**8], 1)
    outline = np.concatenate([lower, lower[::-1] + np.array([0, 1.0])])
    return fill_outline(outline, close_ring(len(outline)))


SOLIDS: list[tuple[Callable[[int], Solid], int]] = [
    (make_comb, 10_000),
    (make_square_comb, 10_000),
    (make_flat_comb, 10_000),
    (make_fan_of_sheets, 20_000),
    (make_book, 20_000),
    (make_cone, 40_000),
    (make_disc, 40_000),
    (make_two_cones, 40_000),
    (make_strip, 200_000),
    (make_curved_strip, 50_000),
    (make_stairs, 25_000),
    (make_cubes, 25_000),
    (make_turned_cubes, 5_000),
    (make_nested_cubes, 2_000),
    (make_holes, 5_000),
    (make_round_hole, 50_000),
    (make_needle_hole, 50_000),
    (make_straight_slit, 50_000),
    (make_sphere, 250_000),
    (make_soup, 50_000),
    (make_flat_soup, 10_000),
    (make_dense_soup, 5_000),
    (make_copies, 50_000),
    (make_copies_both_ways, 50_000),
    (make_helix, 50_000),
    (make_soft_ramp, 50_000),
    (make_zigzag_border, 50_000),
    (make_bumpy_outline, 50_000),
]
