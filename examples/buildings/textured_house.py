"""The textured house: body, a wing that is used twice, a sign on the wall, a terrace; what each facet looks like.

Walls read their own piece of one picture (an atlas), plinth and chimney repeat bricks, slopes repeat tiles, and all of
these have a second map into a picture of light. Where plinth and wall meet, the look changes within a plane.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from buildings.facet_model import Frame, Model, Vector, make_rectangle
from buildings.house import DEPTH, LENGTH, PITCH, WALL, add_chimney, add_roof
from buildings.tessellate import Faces, Points, tessellate_facets

PLINTH = 0.45
RIDGE = WALL + DEPTH / 2 * PITCH
DOOR = (5.4, PLINTH + 0.05, 6.6, 2.6)
"""Left, bottom, right and top in the front wall; meters."""

WING_WIDTH, WING_DEPTH, WING_LOW, WING_HIGH = 3.0, 5.0, 2.4, 3.0
TERRACE = ((3.5, -2.8, 0.0), (8.5, 0.0, PLINTH))
SIGN = ((7.7, -0.02, 2.25), (10.5, 2.95))
"""Its lower left corner, and where its right and upper sides are; it hangs before the front wall."""

ATLAS = (512, 392)
"""Columns and rows of the picture of the walls; texels."""

TEXELS = 28.0
"""Texels of the atlas for a meter of wall."""

LIGHT_CELLS, LIGHT_TEXELS = 8, 32
"""Cells of the picture of light along each side, one for each facet, and texels along each."""


LEVEL, SLOPE, HALF = 1e-9, 0.3, 0.5
"""Shares of a normal: less than the first is none, a roof has more than the second upwards."""

EAVES = 2.0
"""Slopes above this are roofs; meters."""

CHIMNEY = ((9.0, 4.5), (11.5, 6.0))
"""Lower left and upper right of its surroundings, seen from above; meters."""


@dataclass(frozen=True)
class Island:
    """The piece of the atlas that shows a wall: where its left end on the ground is, in texels."""

    column: int
    row: int
    width: float
    height: float


ISLANDS = {
    "front": Island(4, 96, LENGTH, WALL),
    "back": Island(4, 191, LENGTH, WALL),
    "west": Island(2, 389, DEPTH, RIDGE),
    "east": Island(258, 389, DEPTH, RIDGE),
    "wing": Island(348, 88, WING_WIDTH, WING_HIGH),
}


@dataclass
class LookSurface:
    """Vertices and triangles of one look; `uv` has v downwards, as glTF does."""

    points: list[Points] = field(default_factory=list)
    normals: list[Points] = field(default_factory=list)
    uv: list[Points] = field(default_factory=list)
    light: list[Points] = field(default_factory=list)
    faces: list[Faces] = field(default_factory=list)

    def join_rows(self, name: str) -> NDArray[np.float64]:
        """Join all rows of one array."""
        return np.concatenate(getattr(self, name))


@dataclass(frozen=True)
class Solid:
    """A model, and the look of each of its facets: a name and a map from points to texture coordinates."""

    model: Model
    look: Callable[[Vector, Points], tuple[str, Points]]
    first_cell: int = 0


def find_axes(normal: Vector) -> tuple[Vector, Vector]:
    """Return right and up on a wall, seen from outside; east and north on what is level."""
    flat = abs(normal[2]) > 1 - LEVEL
    right = np.array([1.0, 0.0, 0.0]) if flat else np.array([-normal[1], normal[0], 0.0])
    right /= (right[0] ** 2 + right[1] ** 2) ** 0.5
    return right, np.cross(normal, right)


def measure_along(points: Points, axis: Vector) -> Points:
    """Measure coordinates along an axis, summed in one fixed order."""
    return points[:, 0] * axis[0] + points[:, 1] * axis[1] + points[:, 2] * axis[2]


def map_repeated(normal: Vector, points: Points, size: float) -> Points:
    """Repeat a picture of `size` meters, far outside 0..1."""
    right, up = find_axes(normal)
    return np.stack([measure_along(points, right), -measure_along(points, up)], axis=1) / size


def map_island(name: str, start: Vector, normal: Vector, points: Points) -> Points:
    """Map to the piece of the atlas for a wall whose left end on the ground is `start`."""
    island = ISLANDS[name]
    right, up = find_axes(normal)
    offset = points - start
    texels = [island.column + TEXELS * measure_along(offset, right), island.row - TEXELS * measure_along(offset, up)]
    return np.stack(texels, axis=1) / ATLAS


def build_body() -> Solid:
    """Build the house: walls in two pieces each, a door, a roof that stands out, a chimney."""
    model = Model(parted=True)
    gable = [(0, PLINTH), (DEPTH, PLINTH), (DEPTH, WALL), (DEPTH / 2, RIDGE), (0, WALL)]
    straight = make_rectangle(0, PLINTH, LENGTH, WALL)
    for origin, right, upper in (
        ((0, 0, 0), (1, 0, 0), straight),
        ((LENGTH, 0, 0), (0, 1, 0), gable),
        ((LENGTH, DEPTH, 0), (-1, 0, 0), straight),
        ((0, DEPTH, 0), (0, -1, 0), gable),
    ):
        frame = Frame.span(origin, right, (0, 0, 1))
        model.add_plate(frame, make_rectangle(0, 0, upper[1][0], PLINTH))
        wall = model.add_plate(frame, upper)
        if origin == (0, 0, 0):
            wall.recess(make_rectangle(*DOOR), 0.2)
    model.add([(0, DEPTH, 0), (LENGTH, DEPTH, 0), (LENGTH, 0, 0), (0, 0, 0)])
    _, back = add_roof(model)
    add_chimney(model, back)
    return Solid(model.finish(), choose_body_look)


def choose_body_look(normal: Vector, points: Points) -> tuple[str, Points]:
    """Choose bricks below and at the chimney, the atlas on walls, tiles on slopes, plain timber elsewhere."""
    low, high = points.min(axis=0), points.max(axis=0)
    within = low[0] >= 0 and high[0] <= LENGTH and low[1] >= 0 and high[1] <= DEPTH and high[2] <= RIDGE
    upright = within and abs(normal[2]) <= LEVEL
    chimney = np.all(low[:2] > CHIMNEY[0]) and np.all(high[:2] < CHIMNEY[1])
    if chimney or (upright and high[2] <= PLINTH):
        return "bricks", map_repeated(normal, points, 1.0)
    if normal[2] > SLOPE and low[2] > EAVES:
        return "tiles", map_repeated(normal, points, 1.5)
    aside = abs(normal[0]) > HALF
    if not upright or (aside and low[1] == 0 and high[1] < 1):
        return "timber", map_repeated(normal, points, 1.0)
    # A wall reads from its left end on the ground, seen from outside.
    name, start = {
        (True, True): ("east", (LENGTH, 0.0, 0.0)),
        (True, False): ("west", (0.0, DEPTH, 0.0)),
        (False, True): ("back", (LENGTH, DEPTH, 0.0)),
        (False, False): ("front", (0.0, 0.0, 0.0)),
    }[aside, bool(normal[0] > 0 if aside else normal[1] >= 0)]
    return "facade", map_island(name, np.array(start), normal, points)


def build_wing(first_cell: int) -> Solid:
    """Build a wing with a slope of its own, at the east of its origin."""
    model = Model(parted=True)
    wide, deep, low, high = WING_WIDTH, WING_DEPTH, WING_LOW, WING_HIGH
    for origin, right, length, left_top, right_top in (
        ((0, 0, 0), (1, 0, 0), wide, high, low),
        ((wide, 0, 0), (0, 1, 0), deep, low, low),
        ((wide, deep, 0), (-1, 0, 0), wide, low, high),
        ((0, deep, 0), (0, -1, 0), deep, high, high),
    ):
        frame = Frame.span(origin, right, (0, 0, 1))
        model.add_plate(frame, make_rectangle(0, 0, length, PLINTH))
        model.add_plate(frame, [(0, PLINTH), (length, PLINTH), (length, right_top), (0, left_top)])
    model.add([(0, 0, high), (wide, 0, low), (wide, deep, low), (0, deep, high)])
    model.add([(0, deep, 0), (wide, deep, 0), (wide, 0, 0), (0, 0, 0)])
    return Solid(model.finish(), choose_wing_look, first_cell)


def choose_wing_look(normal: Vector, points: Points) -> tuple[str, Points]:
    """Choose the atlas in front, bricks on the other walls."""
    if normal[2] > SLOPE:
        return "tiles", map_repeated(normal, points, 1.5)
    if normal[2] < -HALF:
        return "timber", map_repeated(normal, points, 1.0)
    if normal[1] < -HALF and points[:, 2].max() > PLINTH:
        return "facade", map_island("wing", np.zeros(3), normal, points)
    return "bricks", map_repeated(normal, points, 1.0)


def build_terrace() -> Model:
    """Build a slab before the door."""
    model = Model()
    low, high = (np.array(corner) for corner in TERRACE)
    size = high - low
    x, y, z = np.diag(size)
    for start, right, up in (
        (low, x, z), (low + x, y, z), (low + x + y, -x, z), (low + y, -y, z), (low + z, x, y), (low + y, x, -y),
    ):  # fmt: skip
        model.add([start, start + right, start + right + up, start + up])
    return model.finish()


def build_surfaces(solid: Solid, edge: float) -> dict[str, LookSurface]:
    """Over-sample the surfaces of a solid, by the name of their look; each facet has vertices of its own."""
    points, facets = tessellate_facets(solid.model, edge)
    made: dict[str, LookSurface] = {}
    for number, (rings, faces) in enumerate(zip(solid.model.facets, facets, strict=True)):
        normal = solid.model.find_normal(rings[0])
        used, corners = np.unique(faces, return_inverse=True)
        name, uv = solid.look(normal, points[used])
        cell = map_cell(solid.first_cell + number, normal, points[used])
        append_facet(made.setdefault(name, LookSurface()), points[used], normal, (uv, cell), corners.reshape(-1, 3))
    return made


def append_facet(
    surface: LookSurface, points: Points, normal: Vector, maps: tuple[Points, Points], faces: Faces
) -> None:
    """Append a facet."""
    surface.faces.append(faces + sum(map(len, surface.points)))
    surface.points.append(points)
    surface.normals.append(np.tile(normal, (len(points), 1)))
    surface.uv.append(maps[0])
    surface.light.append(maps[1])


def map_cell(cell: int, normal: Vector, points: Points) -> Points:
    """Place a facet in the picture of light: as large as its cell allows, two texels off its rim."""
    if cell >= LIGHT_CELLS**2:
        raise ValueError("the picture of light has too few cells")
    right, up = find_axes(normal)
    flat = np.stack([measure_along(points, right), -measure_along(points, up)], axis=1)
    low = flat.min(axis=0)
    room = LIGHT_TEXELS - 4.0
    share = (flat - low) / (flat.max(axis=0) - low).max()
    row, column = divmod(cell, LIGHT_CELLS)
    return np.asarray((np.array([column, row]) * LIGHT_TEXELS + 2 + room * share) / (LIGHT_CELLS * LIGHT_TEXELS))


def build_sign(edge: float) -> LookSurface:
    """Build a picture on the front wall, a grid of its own."""
    (left, y, bottom), (right, top) = SIGN
    columns, rows = int((right - left) / edge) + 2, int((top - bottom) / edge) + 2
    across, upwards = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    uv = np.stack([across.ravel(), 1 - upwards.ravel()], axis=1)
    points = np.stack([left + (right - left) * uv[:, 0], np.full(len(uv), y), top - (top - bottom) * uv[:, 1]], axis=1)
    start = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    quads = start[:, None] + [0, 1, columns + 1, columns]
    made = LookSurface()
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    append_facet(made, points, np.array([0.0, -1.0, 0.0]), (uv, uv), faces)
    return made


def color_terrace(points: Points) -> Points:
    """Return vertex colors of the terrace: darker towards the wall, redder towards the east; one ramp all over."""
    low, high = (np.array(corner) for corner in TERRACE)
    share = (points - low) / (high - low)
    return np.stack([0.6 + 0.25 * share[:, 0], 0.7 - 0.2 * share[:, 1], 0.42 + 0.15 * share[:, 2]], axis=1)
