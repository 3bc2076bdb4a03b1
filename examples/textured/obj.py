"""What an OBJ file and its materials say is drawn; colours of points, and several textures in one file."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from PIL import Image

from textured.model import CLAMP, REPEAT, Floats, Integers, Material, Surface, Texture

PLAIN = Material()


def read_obj(path: Path) -> list[Surface]:
    """A surface for each material; polygons as fans."""
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
            ring = [corner(text, counts) for text in rest.split()]
            for second, third in pairwise(ring[1:]):
                corners.setdefault(name, []).extend((ring[0], second, third))
    numbers = [filled(rows["v"], 6), filled(rows["vt"], 2), filled(rows["vn"], 3)]
    return [surface(np.array(used), library.get(name, PLAIN), numbers) for name, used in corners.items()]


def corner(text: str, counts: list[int]) -> tuple[int, int, int]:
    """Point, texture coordinate and normal of a corner, counted from 0; -1 where it has none."""
    fields = [*text.split("/"), "", ""][:3]
    found = [int(field) if field else 0 for field in fields]
    first, second, third = (n - 1 if n >= 0 else count + n for n, count in zip(found, counts, strict=True))
    return first, second, third


def filled(rows: list[list[float]], width: int) -> Floats:
    """Rows of one width, NaN where a row is shorter, and one more without any number for corners without a row."""
    found = np.full((len(rows) + 1, width), np.nan)
    for k, row in enumerate(rows):
        found[k, : min(len(row), width)] = row[:width]
    return found


def surface(used: Integers, material: Material, numbers: list[Floats]) -> Surface:
    """The faces of one material, each corner a row of its own."""
    places, uv, normals = (values[used[:, k]] for k, values in enumerate(numbers))
    colours = np.column_stack([np.nan_to_num(places[:, 3:], nan=1.0), np.ones(len(places))])
    made = Surface(places[:, :3], np.arange(len(places)).reshape(-1, 3), material, colours=colours)
    made.uv[0] = np.nan_to_num(uv) * (1, -1) + (0, 1)
    if not np.isnan(normals).any():
        made.normals = normals
    return made


def read_mtl(path: Path) -> dict[str, Material]:
    """Materials by name; what is transparent in a picture is so on the wall."""
    found: dict[str, Material] = {}
    name = ""
    for line in path.read_text(encoding="utf-8").splitlines():
        word, _, rest = line.strip().partition(" ")
        if word == "newmtl":
            name = rest.strip()
            found[name] = Material(name)
        elif word == "Kd":
            red, green, blue = (float(number) for number in rest.split()[:3])
            found[name] = replace(found[name], colour=(red, green, blue, 1.0))
        elif word == "map_Kd":
            pixels = np.asarray(Image.open(path.parent / rest.split()[-1]).convert("RGBA"), float) / 255.0
            wrap = CLAMP if "-clamp on" in rest else REPEAT
            alpha = "MASK" if pixels[..., 3].min() < 0.5 else "OPAQUE"
            found[name] = replace(found[name], picture=Texture(pixels, (wrap, wrap)), alpha=alpha)
    return found
