"""Corners of triangles with all that colors them, ready to draw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

REPEAT, CLAMP, MIRROR = "repeat", "clamp", "mirror"


@dataclass(frozen=True, eq=False)
class Texture:
    """An image and how it is read.

    Attributes
    ----------
    pixels : (height, width, 4) float64
        In 0..1, the first row on top.
    wrap : tuple of str
        Across and down: `REPEAT`, `CLAMP` or `MIRROR`.
    nearest : bool
        Take the nearest texel, without interpolation.
    uv_set : int
    transform : (2, 3) float64
        Taken of the texture coordinates, v downwards, before they are looked up.
    """

    pixels: Floats
    wrap: tuple[str, str] = (REPEAT, REPEAT)
    nearest: bool = False
    uv_set: int = 0
    transform: Floats = field(default_factory=lambda: np.eye(3)[:2])

    def sample(self, uv: Floats) -> Floats:
        """Sample RGBA at transformed texture coordinates, (n, 2) with v downwards."""
        height, width = self.pixels.shape[:2]
        place = uv * (width, height)
        if self.nearest:
            column, row = np.floor(place).astype(np.int64).T
            return self._texels(row, column)
        place = place - 0.5
        low = np.floor(place).astype(np.int64)
        share = place - low
        found = np.zeros((len(uv), 4))
        for right in (0, 1):
            for down in (0, 1):
                weight = np.abs(1 - right - share[:, 0]) * np.abs(1 - down - share[:, 1])
                found += weight[:, None] * self._texels(low[:, 1] + down, low[:, 0] + right)
        return found

    def _texels(self, row: Integers, column: Integers) -> Floats:
        height, width = self.pixels.shape[:2]
        return self.pixels[wrap_places(row, height, self.wrap[1]), wrap_places(column, width, self.wrap[0])]


def wrap_places(place: Integers, size: int, wrap: str) -> Integers:
    """Wrap rows or columns into an image."""
    if wrap == CLAMP:
        return np.clip(place, 0, size - 1)
    if wrap == MIRROR:
        place = place % (2 * size)
        return np.minimum(place, 2 * size - 1 - place)
    return place % size


@dataclass(frozen=True, eq=False)
class Material:
    """Colors and textures of a surface."""

    name: str = ""
    color: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    picture: Texture | None = None
    occlusion: Texture | None = None
    alpha: str = "OPAQUE"
    cutoff: float = 0.5
    two_sided: bool = True


@dataclass
class Surface:
    """Triangles of one material, in the world, z upwards.

    Attributes
    ----------
    points, normals : (n, 3) float64
        Normals may be None: those of the faces serve.
    faces : (m, 3) int
        Counter-clockwise seen from the front.
    uv : dict of int to (n, 2) float64
        v downwards.
    colors : (n, 4) float64 or None
    material : Material
    """

    points: Floats
    faces: Integers
    material: Material
    normals: Floats | None = None
    uv: dict[int, Floats] = field(default_factory=dict)
    colors: Floats | None = None


@dataclass
class Model:
    """All surfaces of a file, flattened to corners of triangles.

    Attributes
    ----------
    corners, normals : (m, 3, 3) float64
    colors : (m, 3, 4) float64
        Vertex color times the material's.
    uv : dict of str to (m, 3, 2) float64
        For ``picture`` and ``occlusion``, transformed.
    material : (m,) int
        Index into `materials`.
    """

    corners: Floats
    normals: Floats
    colors: Floats
    uv: dict[str, Floats]
    material: Integers
    materials: list[Material]

    @classmethod
    def join(cls, surfaces: Sequence[Surface]) -> Model:
        """Put surfaces together."""
        filled = [surface for surface in surfaces if len(surface.faces)]
        materials = list({id(surface.material): surface.material for surface in filled}.values())
        number = {id(material): k for k, material in enumerate(materials)}
        return cls(
            np.concatenate([surface.points[surface.faces] for surface in filled]),
            np.concatenate([collect_normals(surface) for surface in filled]),
            np.concatenate([collect_colors(surface) for surface in filled]),
            {
                name: np.concatenate([collect_uv(surface, name) for surface in filled])
                for name in ("picture", "occlusion")
            },
            np.repeat([number[id(surface.material)] for surface in filled], [len(each.faces) for each in filled]),
            materials,
        )


def collect_normals(surface: Surface) -> Floats:
    """Collect unit normals at the corners, those of the faces where none are stored."""
    a, b, c = (surface.points[surface.faces[:, k]] for k in range(3))
    flat = np.repeat(np.cross(b - a, c - a)[:, None], 3, axis=1)
    normal = flat if surface.normals is None else surface.normals[surface.faces]
    length = np.linalg.norm(normal, axis=2, keepdims=True)
    flat_length = np.linalg.norm(flat, axis=2, keepdims=True)
    unit = normal / np.where(length > 0, length, 1.0)
    return np.asarray(np.where(length > 0, unit, flat / np.where(flat_length > 0, flat_length, 1.0)))


def collect_colors(surface: Surface) -> Floats:
    """Collect the colors at the corners, times the material's."""
    shape = (len(surface.faces), 3, 4)
    own = np.ones(shape) if surface.colors is None else surface.colors[surface.faces]
    return np.asarray(own * surface.material.color)


def collect_uv(surface: Surface, name: str) -> Floats:
    """Collect the transformed coordinates at the corners for one texture of the material; zero where there is none."""
    texture: Texture | None = getattr(surface.material, name)
    if texture is None or texture.uv_set not in surface.uv:
        return np.zeros((len(surface.faces), 3, 2))
    uv = surface.uv[texture.uv_set]
    return np.asarray((uv @ texture.transform[:, :2].T + texture.transform[:, 2])[surface.faces])
