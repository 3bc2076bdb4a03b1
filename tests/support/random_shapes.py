"""Random shapes that look for trouble: unions of cells, extrusions and soups, then spoilt in random ways.

`random_shape(seed)` is a shape and the story of how it was made; the same seed is the same shape.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from solids import Shape, add_backs, fan_polygons, merge, rotate, shape, unweld, voxels, weld

Random = np.random.Generator


def random_shape(seed: int) -> tuple[Shape, str]:
    """A random shape, and its story."""
    rng = np.random.default_rng(seed)
    make = SOURCES[int(rng.choice(len(SOURCES), p=WEIGHTS))]
    mesh, story = make(rng), make.__name__
    for spoil in SPOILS:
        if rng.random() < 0.3:
            mesh, story = spoil(mesh, rng), f"{story} {spoil.__name__}"
    place = PLACES[int(rng.integers(len(PLACES)))]
    return place(mesh, rng), f"{story} {place.__name__}"


# Sources


def cells(rng: Random) -> Shape:
    """A random union of boxes on a small grid; sides are cut finely."""
    filled = rng.random(tuple(rng.integers(1, 4, 3))) < rng.choice([0.35, 0.6, 0.85])
    filled.flat[0] = True
    return cut_finely(voxels(filled), rng)


def flat_cells(rng: Random) -> Shape:
    """A random set of squares of a grid in one plane: rings, pinches, islands."""
    width, depth = (int(n) for n in rng.integers(2, 6, 2))
    chosen = [(x, y) for x in range(width) for y in range(depth) if rng.random() < 0.65] or [(0, 0)]
    squares = ([(x, y, 0), (x + 1, y, 0), (x + 1, y + 1, 0), (x, y + 1, 0)] for x, y in chosen)
    return cut_finely(fan_polygons(*squares), rng)


def extrusion(rng: Random) -> Shape:
    """A star-shaped polygon on a grid, pulled up; its caps are fans round the middle."""
    sides = int(rng.integers(3, 10))
    angle = np.sort(rng.uniform(0, 2 * np.pi, sides))
    ring = np.round(np.stack([np.cos(angle), np.sin(angle)], axis=1) * rng.uniform(3, 10, sides)[:, None])
    low, high = np.c_[ring, np.zeros(sides)], np.c_[ring, np.full(sides, 4.0)]
    polygons = []
    for i in range(sides):
        polygons.append([low[i - 1], low[i], high[i], high[i - 1]])
        polygons.append([low[i], low[i - 1], (0, 0, 0)])
        polygons.append([high[i - 1], high[i], (0, 0, 4)])
    return cut_finely(fan_polygons(*polygons), rng)


def tangle(rng: Random) -> Shape:
    """Random triangles on a tiny grid: they overlap, repeat points, lie in lines."""
    count = int(rng.integers(1, 14))
    points = np.stack(np.meshgrid(*[np.arange(n) for n in rng.integers(1, 4, 3)]), axis=-1).reshape(-1, 3)
    return shape(points, rng.integers(0, len(points), (count, 3)))


def hills(rng: Random) -> Shape:
    """A grid of squares over heights of few values: flats, steps and ramps."""
    width, depth = (int(n) for n in rng.integers(2, 7, 2))
    height = rng.integers(0, 3, (width + 1, depth + 1)) * rng.choice([0, 1, 0.5], (width + 1, depth + 1))
    rows = np.arange((width + 1) * (depth + 1)).reshape(width + 1, depth + 1)
    points = [(x, y, height[x, y]) for x in range(width + 1) for y in range(depth + 1)]
    faces = []
    for x in range(width):
        for y in range(depth):
            a, b, c, d = rows[x, y], rows[x + 1, y], rows[x + 1, y + 1], rows[x, y + 1]
            faces += [[a, b, c], [a, c, d]] if rng.random() < 0.5 else [[a, b, d], [b, c, d]]
    return shape(points, faces)


def two_solids(rng: Random) -> Shape:
    """Two unions of cells, the second smaller, moved by a fraction: they overlap, touch or nest."""
    first, second = cells(rng), cells(rng)
    return merge(first, (second[0] * rng.choice([0.5, 1, 2]) + rng.integers(-2, 3, 3) * 0.5, second[1]))


SOURCES: list[Callable[[Random], Shape]] = [cells, flat_cells, extrusion, tangle, hills, two_solids]
WEIGHTS = [0.35, 0.2, 0.15, 0.1, 0.1, 0.1]


# Finer


def cut_finely(mesh: Shape, rng: Random) -> Shape:
    """A few times: halve a random edge in all its faces, or put a point into a random face."""
    for _ in range(int(rng.integers(0, 25))):
        if not len(mesh[1]):
            break
        mesh = _split_edge(mesh, rng, all_faces=True) if rng.random() < 0.7 else _split_face(mesh, rng)
    return mesh


def _split_edge(mesh: Shape, rng: Random, *, all_faces: bool) -> Shape:
    points, faces = mesh
    first = int(rng.integers(len(faces)))
    corner = int(rng.integers(3))
    a, b = faces[first, corner], faces[first, (corner + 1) % 3]
    share = rng.choice([0.5, 0.25, 0.75])
    middle = points[a] + (points[b] - points[a]) * share
    new, result = len(points), []
    for i, face in enumerate(faces.tolist()):
        if a not in face or b not in face or a == b or not (all_faces or i == first):
            result.append(face)
            continue
        result += [[new if p == a else p for p in face], [new if p == b else p for p in face]]
    return shape(np.vstack([points, middle]), result)


def _split_face(mesh: Shape, rng: Random) -> Shape:
    points, faces = mesh
    at = int(rng.integers(len(faces)))
    a, b, c = faces[at]
    new = len(points)
    inside = points[a] / 2 + points[b] / 4 + points[c] / 4
    return shape(np.vstack([points, inside]), [*np.delete(faces, at, axis=0), [a, b, new], [b, c, new], [c, a, new]])


# Spoils


def add_t_junctions(mesh: Shape, rng: Random) -> Shape:
    """Edges are cut in one face alone."""
    for _ in range(int(rng.integers(1, 4))):
        mesh = _split_edge(mesh, rng, all_faces=False) if len(mesh[1]) else mesh
    return mesh


def add_closed_t_junctions(mesh: Shape, rng: Random) -> Shape:
    """Edges are cut in one face, and a face without area closes the gap."""
    points, faces = mesh
    for _ in range(int(rng.integers(1, 4))):
        at, corner = int(rng.integers(len(faces))), int(rng.integers(3))
        a, b, c = np.roll(faces[at], -corner)
        points = np.vstack([points, (points[a] + points[b]) / 2])
        m = len(points) - 1
        faces = np.vstack([np.delete(faces, at, axis=0), [[a, m, c], [m, b, c], [a, b, m]]])
    return shape(points, faces)


def cut_openings(mesh: Shape, rng: Random) -> Shape:
    keep = rng.random(len(mesh[1])) > rng.choice([0.05, 0.3])
    keep[0] = True
    return mesh[0], mesh[1][keep]


def add_some_copies(mesh: Shape, rng: Random) -> Shape:
    return mesh[0], np.concatenate([mesh[1], mesh[1][rng.random(len(mesh[1])) < 0.2]])


def add_some_backs(mesh: Shape, rng: Random) -> Shape:
    return mesh[0], np.concatenate([mesh[1], mesh[1][rng.random(len(mesh[1])) < 0.3][:, ::-1]])


def make_two_sided(mesh: Shape, rng: Random) -> Shape:
    return add_backs(mesh) if rng.random() < 0.5 else mesh


def turn_some_faces(mesh: Shape, rng: Random) -> Shape:
    turned = rng.random(len(mesh[1])) < rng.choice([0.1, 0.5, 1])
    return mesh[0], np.where(turned[:, None], mesh[1][:, ::-1], mesh[1])


def make_soup(mesh: Shape, rng: Random) -> Shape:
    return unweld(mesh) if rng.random() < 0.5 else weld(mesh)


def shake(mesh: Shape, rng: Random) -> Shape:
    size = rng.choice([1e-15, 1e-9, 1e-6, 1e-5, 1e-3])
    return mesh[0] + rng.uniform(-size, size, mesh[0].shape), mesh[1]


def fold_a_fan(mesh: Shape, rng: Random) -> Shape:
    """One point is moved along an axis by a lot or by little."""
    points = mesh[0].copy()
    points[rng.integers(len(points)), rng.integers(3)] += rng.choice([-1, -0.5, 0.5, 1, 1e-7, 1e-4])
    return points, mesh[1]


SPOILS: list[Callable[[Shape, Random], Shape]] = [
    add_t_junctions, add_closed_t_junctions, cut_openings, add_some_copies, add_some_backs,
    make_two_sided, turn_some_faces, shake, fold_a_fan, make_soup,
]  # fmt: skip


# Places


def keep(mesh: Shape, rng: Random) -> Shape:
    return mesh


def turn_and_round(mesh: Shape, rng: Random) -> Shape:
    points, faces = rotate(mesh, float(rng.uniform(0, 90)))
    return points.astype(np.float32).astype(float), faces


def turn(mesh: Shape, rng: Random) -> Shape:
    return rotate(mesh, float(rng.uniform(0, 90)))


def squeeze(mesh: Shape, rng: Random) -> Shape:
    return mesh[0] * rng.choice([1, 1e-3, 1e-5, 2.0**-24], 3), mesh[1]


def move_to_the_map(mesh: Shape, rng: Random) -> Shape:
    far = mesh[0] + [500_000, 5_000_000, 100]
    return (far.astype(np.float32).astype(float) if rng.random() < 0.5 else far), mesh[1]


PLACES: list[Callable[[Shape, Random], Shape]] = [keep, turn_and_round, turn, squeeze, move_to_the_map]
