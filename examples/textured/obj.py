"""Read an OBJ file and its materials to draw them, with colors of points and several textures in one file."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from PIL import Image

from textured.model import CLAMP, REPEAT, Floats, Integers, Material, Surface, Texture

PLAIN = Material()


def read_obj(path: Path) -> list[Surface]:
    """Read a surface for each material; polygons as fans."""
    rows: dict[str, list[list[float]]] = {"v": [], "vt": [], "vn": []}
    library: dict[str, Material] = {}
    corners: dict[str, list[tuple[int, int, int]]] = {}
    name = ""
    for line in path.read_text(encoding="utf-8").splitlines():
        word, _, rest = line.strip().partition(" ")
        if word in rows:
            rows[word].append([float(number) for number in rest.split()])
        elif word == "usemtl":
            name = rest.strip()
        elif word == "mtllib":
            library |= read_mtl(path.parent / rest.strip())
        elif word == "f":
            counts = [len(rows[kind]) for kind in rows]
            ring = [parse_corner(text, counts) for text in rest.split()]
            for second, third in pairwise(ring[1:]):
                corners.setdefault(name, []).extend((ring[0], second, third))
    numbers = [fill_rows(rows["v"], 6), fill_rows(rows["vt"], 2), fill_rows(rows["vn"], 3)]
    return [build_surface(np.array(used), library.get(name, PLAIN), numbers) for name, used in corners.items()]


def parse_corner(text: str, counts: list[int]) -> tuple[int, int, int]:
    """Parse point, texture coordinate and normal of a corner, counted from 0; -1 where it has none."""
    fields = [*text.split("/"), "", ""][:3]
    found = [int(field) if field else 0 for field in fields]
    first, second, third = (n - 1 if n >= 0 else count + n for n, count in zip(found, counts, strict=True))
    return first, second, third


def fill_rows(rows: list[list[float]], width: int) -> Floats:
    """Fill rows to one width, NaN where a row is shorter, and one more without any number for corners without a row."""
    found = np.full((len(rows) + 1, width), np.nan)
    for k, row in enumerate(rows):
        found[k, : min(len(row), width)] = row[:width]
    return found


def build_surface(used: Integers, material: Material, numbers: list[Floats]) -> Surface:
    """Build the faces of one material, each corner a row of its own."""
    places, uv, normals = (values[used[:, k]] for k, values in enumerate(numbers))
    colors = np.column_stack([np.nan_to_num(places[:, 3:], nan=1.0), np.ones(len(places))])
    made = Surface(places[:, :3], np.arange(len(places)).reshape(-1, 3), material, colors=colors)
    made.uv[0] = np.nan_to_num(uv) * (1, -1) + (0, 1)
    if not np.isnan(normals).any():
        made.normals = normals
    return made


def read_mtl(path: Path) -> dict[str, Material]:
    """Read materials by name; transparent texels stay transparent on the wall."""
    found: dict[str, Material] = {}
    name = ""
    for line in path.read_text(encoding="utf-8").splitlines():
        word, _, rest = line.strip().partition(" ")
        if word == "newmtl":
            name = rest.strip()
            found[name] = Material(name)
        elif word == "Kd":
            red, green, blue = (float(number) for number in rest.split()[:3])
            found[name] = replace(found[name], color=(red, green, blue, 1.0))
        elif word == "map_Kd":
            pixels = np.asarray(Image.open(path.parent / rest.split()[-1]).convert("RGBA"), float) / 255.0
            wrap = CLAMP if "-clamp on" in rest else REPEAT
            alpha = "MASK" if pixels[..., 3].min() < Material.cutoff else "OPAQUE"
            found[name] = replace(found[name], picture=Texture(pixels, (wrap, wrap)), alpha=alpha)
    return found
