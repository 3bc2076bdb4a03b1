"""Random over-sampled shapes with textures, colors, materials and feature ids that change where walls do, and within.

`textured_shape(seed)` is a mesh and the story of how it was made; the same seed is the same mesh. What a face carries
is told by its plane and by which side of a few lines it lies on; the lines run along edges, so every change is sharp.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from random_shapes import cut_finely, keep, squeeze, turn, turn_and_round
from solids import Points, Shape, staircase, subdivide, voxels

from bldsimp.model import Attribute, Mesh, Part

Random = np.random.Generator
Values = NDArray[np.float64]


def textured_shape(seed: int) -> tuple[Mesh, str]:
    """A random textured mesh, and its story."""
    rng = np.random.default_rng(seed)
    source = SOURCES[int(rng.integers(len(SOURCES)))]
    points, faces = source(rng)
    walls = label_walls(points, faces)
    story = [source.__name__]
    part = choose_regions(points, faces, walls, rng, int(rng.integers(1, 4)))
    columns: dict[str, Values] = {}
    for name in ("TEXCOORD_0", "TEXCOORD_1")[: int(rng.integers(0, 3))]:
        make = MAPS[int(rng.integers(len(MAPS)))]
        story.append(f"{name}:{make.__name__}")
        columns[name] = make(
            points[faces], choose_regions(points, faces, walls, rng, int(rng.integers(1, 5))), walls, rng
        )
    if rng.random() < 0.5:
        make = COLORS[int(rng.integers(len(COLORS)))]
        story.append(f"COLOR_0:{make.__name__}")
        columns["COLOR_0"] = make(points[faces], choose_regions(points, faces, walls, rng, 2), walls, rng)
    if rng.random() < 0.4:
        story.append("_FEATURE_ID_0")
        names = choose_regions(points, faces, walls, rng, int(rng.integers(1, 6)))
        columns["_FEATURE_ID_0"] = np.repeat(names[:, None, None].astype(float), 3, axis=1)
    place = PLACES[int(rng.integers(len(PLACES)))]
    story.append(place.__name__)
    return share_rows(place((points, faces), rng), part, columns, rng), " ".join(story)


# Shapes


def boxes(rng: Random) -> Shape:
    """A union of boxes on a grid, every square cut into a finer grid, and some edges and faces once more."""
    filled = rng.random(tuple(rng.integers(1, 4, 3))) < rng.choice([0.4, 0.9])
    filled.flat[0] = True
    return cut_finely(subdivide(voxels(filled), int(rng.integers(1, 3))), rng)


def steps(rng: Random) -> Shape:
    """An open staircase."""
    return cut_finely(subdivide(staircase(int(rng.integers(1, 4))), int(rng.integers(1, 3))), rng)


SOURCES: list[Callable[[Random], Shape]] = [boxes, boxes, steps]
PLACES = [keep, turn, turn_and_round, squeeze]


# Where things change


def label_walls(points: Points, faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """A number for each plane that faces lie in, facing included."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    height = np.einsum("ij,ij->i", normal, a)
    planes = np.round(np.column_stack([normal, height]) * 1e6)
    return np.unique(planes + 0.0, axis=0, return_inverse=True)[1].reshape(-1)


def choose_regions(
    points: Points, faces: NDArray[np.int64], walls: NDArray[np.int64], rng: Random, count: int
) -> NDArray[np.int64]:
    """At most `count` regions: by walls, or by lines of the grid, which cross walls."""
    if count == 1:
        return np.zeros(len(faces), np.int64)
    if rng.random() < 0.5:
        return np.asarray(rng.integers(0, count, walls.max() + 1)[walls])
    middle = points[faces].mean(axis=1)
    halves = [middle[:, axis] > rng.choice([0.5, 1.0, 1.5]) for axis in rng.permutation(3)[: count - 1]]
    return np.asarray(np.sum([half * 2**k for k, half in enumerate(halves)], axis=0) % count)


# What faces carry: (m, 3, k) for corners (m, 3, 3)


def map_planes(corners: Values, region: NDArray[np.int64], walls: NDArray[np.int64], rng: Random) -> Values:
    """One map of each wall and region: turned, skewed, mirrored or not, far outside 0..1."""
    wall_maps = rng.normal(size=(walls.max() + 1, 3, 2)) * rng.choice([0.1, 1.0, 8.0])
    if rng.random() < 0.3:
        wall_maps[:] = wall_maps[0]
    shift = rng.uniform(-3, 3, (region.max() + 1, 2))
    return np.einsum("ijk,ikl->ijl", corners, wall_maps[walls]) + shift[region][:, None]


def color_regions(corners: Values, region: NDArray[np.int64], walls: NDArray[np.int64], rng: Random) -> Values:
    """One place of a palette for each region."""
    own = rng.random((region.max() + 1, 2))
    return np.repeat(own[region][:, None], 3, axis=1)


def map_each_face(corners: Values, region: NDArray[np.int64], walls: NDArray[np.int64], rng: Random) -> Values:
    """A map of its own for every face of one region, one map for all others."""
    uv = map_planes(corners, region, walls, rng)
    own = region == region.max()
    uv[own] += rng.uniform(0.1, 1.0, (int(own.sum()), 1, 2))
    return uv


def map_curved(corners: Values, region: NDArray[np.int64], walls: NDArray[np.int64], rng: Random) -> Values:
    """No affine map, by little or by a lot."""
    return map_planes(corners, region, walls, rng) + rng.choice([1e-4, 1e-2, 1.0]) * corners[:, :, :2] ** 2


def color_two_ways(corners: Values, region: NDArray[np.int64], walls: NDArray[np.int64], rng: Random) -> Values:
    """One color for each region."""
    own = np.round(rng.random((region.max() + 1, 4)) * 255) / 255
    return np.repeat(own[region][:, None], 3, axis=1)


def ramp_levels(corners: Values, region: NDArray[np.int64], walls: NDArray[np.int64], rng: Random) -> Values:
    """A ramp over all, in levels of 255."""
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    share = (corners - low) / np.maximum(high - low, 1e-9)
    color = np.concatenate([share, np.ones_like(share[:, :, :1])], axis=2)
    return np.round(color * 255) / 255 if rng.random() < 0.5 else color


MAPS = [map_planes, map_planes, map_planes, color_regions, map_each_face, map_curved]
COLORS = [color_two_ways, ramp_levels]


# Rows


def share_rows(mesh: Shape, part: NDArray[np.int64], columns: dict[str, Values], rng: Random) -> Mesh:
    """A mesh whose corners share a row where all that they carry, and their part, is the same."""
    points, faces = mesh
    count = int(part.max()) + 1
    corners = [points[faces], np.repeat(part[:, None, None], 3, axis=1), *columns.values()]
    rows, inverse = np.unique(np.concatenate(corners, axis=2).reshape(-1, sum(c.shape[2] for c in corners)), axis=0,
                              return_inverse=True)  # fmt: skip
    attributes, start = [], 4
    for name, values in columns.items():
        width = values.shape[2]
        kind = {"T": "uv", "C": "color", "_": "feature"}[name[0]]
        texels = {"uv": rng.choice([1, 16, 256, 1024], (count, width)), "color": np.full((count, width), 255.0)}
        steps = texels.get(kind, np.ones((count, width))).astype(float)
        attributes.append(Attribute(name, kind, np.ascontiguousarray(rows[:, start : start + width]), steps))
        start += width
    parts = [Part(f"part {k}", tuple(columns)) for k in range(count)]
    single = bool(np.all(points == points.astype(np.float32)))
    return Mesh(
        "random", np.ascontiguousarray(rows[:, :3]), inverse.reshape(-1, 3).astype(np.int32), part.astype(np.int32),
        parts, attributes=attributes, single=single,
    )  # fmt: skip
