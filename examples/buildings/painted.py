"""The pictures on the textured house, painted with numbers into small palettes."""

from __future__ import annotations

import numpy as np

from buildings.png import Pixels, encode_png
from buildings.textured_house import (
    ATLAS,
    DOOR,
    ISLANDS,
    LIGHT_CELLS,
    LIGHT_TEXELS,
    PLINTH,
    TEXELS,
    Island,
)

PLASTER, FRAME, GLASS, WOOD, SHUTTER, LINE = 0, 4, 5, 9, 11, 12
WALLS = [
    (226, 205, 160), (222, 200, 154), (230, 210, 167), (217, 195, 149), (248, 246, 240),
    (52, 74, 98), (66, 92, 120), (88, 118, 146), (142, 172, 192), (112, 66, 36), (134, 82, 47),
    (60, 104, 78), (150, 128, 92),
]  # fmt: skip
BRICKS = [(172, 84, 60), (160, 74, 52), (184, 96, 70), (148, 66, 48), (206, 198, 186)]
TILES = [(178, 88, 64), (166, 78, 58), (190, 100, 74), (112, 52, 42), (204, 120, 92)]
SIGNS = [(34, 52, 92), (244, 232, 190), (214, 160, 60), (0, 0, 0, 0)]
LIGHTS = [(17 * level,) * 3 for level in range(16)]

LETTERS = {
    "B": "11110 10001 11110 10001 10001 11110",
    "I": "01110 00100 00100 00100 00100 01110",
    "K": "10001 10010 11100 10010 10001 10001",
    "R": "11110 10001 11110 10010 10001 10001",
    "S": "01111 10000 01110 00001 00001 11110",
    "C": "01110 10001 10000 10000 10001 01110",
}
"""Rows of five dots."""


def make_grain(shape: tuple[int, int], kinds: int, stream: int) -> Pixels:
    """Return a number below `kinds` for each texel, in no visible order."""
    row, column = np.indices(shape, dtype=np.uint64)
    mixed = (row * np.uint64(73856093)) ^ (column * np.uint64(19349663)) ^ np.uint64(stream * 83492791)
    mixed = (mixed ^ (mixed >> np.uint64(13))) * np.uint64(1274126177) % np.uint64(1 << 32)
    return ((mixed ^ (mixed >> np.uint64(16))) % np.uint64(kinds)).astype(np.uint8)


def paint_facade() -> bytes:
    """Paint the atlas: four walls and the front of the wing, plaster all around."""
    pixels = make_grain(ATLAS[::-1], 4, 1)
    for name, lefts in (("front", (0.9, 3.3, 7.5, 9.8)), ("back", (1.0, 3.3, 6.4, 9.4)), ("west", (1.3, 6.1)),
                        ("east", (1.3, 6.1)), ("wing", (0.7,))):  # fmt: skip
        for left in lefts:
            paint_window(pixels, ISLANDS[name], left, 0.9, 1.35, 1.2)
    for name in ("west", "east"):
        paint_window(pixels, ISLANDS[name], 3.8, 3.6, 1.4, 1.3)
    left, bottom, right, top = DOOR
    fill(pixels, ISLANDS["front"], (left, bottom, right, top), WOOD)
    for low in (0.7, 1.6):
        fill(pixels, ISLANDS["front"], (left + 0.15, low, left + 0.55, low + 0.75), WOOD + 1)
        fill(pixels, ISLANDS["front"], (left + 0.65, low, left + 1.05, low + 0.75), WOOD + 1)
    for island in ISLANDS.values():
        fill(pixels, island, (0, PLINTH + 0.05, island.width, PLINTH + 0.12), LINE, over=PLASTER)
    return encode_png(pixels, WALLS)


def fill(
    pixels: Pixels, island: Island, box: tuple[float, float, float, float], color: int, over: int | None = None
) -> None:
    """Paint a rectangle of a wall, in meters from its left end on the ground; with `over`, only plaster."""
    left, bottom, right, top = box
    columns = slice(round(island.column + TEXELS * left), round(island.column + TEXELS * right))
    rows = slice(round(island.row - TEXELS * top), round(island.row - TEXELS * bottom))
    part = pixels[rows, columns]
    part[...] = color if over is None else np.where(part < FRAME, color, part)


def paint_window(pixels: Pixels, island: Island, left: float, bottom: float, width: float, height: float) -> None:
    """Paint a frame, panes that mirror the sky, a sill, and shutters."""
    right, top = left + width, bottom + height
    for start in (left - 0.4, right + 0.06):
        fill(pixels, island, (start, bottom, start + 0.34, top), SHUTTER)
        for rung in range(6):
            low = bottom + 0.1 + 0.19 * rung
            fill(pixels, island, (start + 0.05, low, start + 0.29, low + 0.05), LINE)
    fill(pixels, island, (left, bottom, right, top), FRAME)
    fill(pixels, island, (left - 0.1, bottom - 0.1, right + 0.1, bottom), LINE)
    for k in range(2):
        start = left + 0.08 + k * width / 2
        for low, high in ((0.08, 0.7), (0.78, height - 0.08)):
            for shade in range(4):
                base = bottom + low + (high - low) * shade / 4
                end = bottom + low + (high - low) * (shade + 1) / 4
                fill(pixels, island, (start, base, start + width / 2 - 0.12, end), GLASS + shade)


def paint_bricks() -> bytes:
    """Paint a square that repeats: eight courses of four bricks."""
    row, column = np.indices((128, 128))
    course = row // 16
    shifted = column + 16 * (course % 2)
    brick = (course * 4 + shifted // 32 % 4).astype(np.uint8)
    joint = (row % 16 < 2) | (shifted % 32 < 2)
    shade = (brick * 7 + brick // 3) % 3
    speck = make_grain((128, 128), 9, 2) == 0
    return encode_png(np.where(joint, 4, np.where(speck, 3, shade)).astype(np.uint8), BRICKS)


def paint_tiles() -> bytes:
    """Paint a square that repeats: six rows of round tiles."""
    row, column = np.indices((96, 96))
    course = row // 16
    across = (column + 8 * (course % 2)) % 16
    edge = row % 16 >= 13 - np.abs(across - 8) // 3
    gap = across < 2
    shade = (course * 5 + (column + 8 * (course % 2)) // 16 % 6 * 3) % 3
    light = (row % 16 == 3) & (across > 4) & (across < 12)
    return encode_png(np.where(edge | gap, 3, np.where(light, 4, shade)).astype(np.uint8), TILES)


def paint_sign() -> bytes:
    """Paint letters on a board with round corners."""
    pixels = np.zeros((64, 256), np.uint8)
    row, column = np.indices(pixels.shape)
    border = np.minimum(np.minimum(row, 63 - row), np.minimum(column, 255 - column))
    pixels[(border >= 4) & (border < 7)] = 2
    corner = np.maximum(14 - np.minimum(column, 255 - column), 0) ** 2
    corner += np.maximum(14 - np.minimum(row, 63 - row), 0) ** 2
    pixels[corner > 14**2] = 3
    for k, letter in enumerate("BRICKS"):
        dots = np.array([[dot == "1" for dot in line] for line in LETTERS[letter].split()])
        shown = dots.repeat(6, axis=0).repeat(6, axis=1)
        pixels[14 : 14 + 36, 20 + 37 * k : 20 + 37 * k + 30][shown] = 1
    return encode_png(pixels, SIGNS)


def paint_light() -> bytes:
    """Paint the picture of light: each facet is darker towards its foot, and no two are the same."""
    size = LIGHT_CELLS * LIGHT_TEXELS
    row, column = np.indices((size, size))
    cell = row // LIGHT_TEXELS * LIGHT_CELLS + column // LIGHT_TEXELS
    level = 15 - (row % LIGHT_TEXELS) // 5 - cell * 5 % 3
    return encode_png(level.astype(np.uint8), LIGHTS)
