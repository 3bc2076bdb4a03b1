"""Describe materials as far as several file formats know them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class UvMap:
    """The UV set that a texture reads, and the affine map from it to the texture.

    Attributes
    ----------
    set : int
        Number of the set.
    matrix : tuple of 6 float
        Rows of a 2 x 3 matrix; v points up on both sides.
    """

    set: int = 0
    matrix: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0)


@dataclass(frozen=True)
class Material:
    """Name, color and textures of a material.

    Attributes
    ----------
    name : str
    color : tuple of 4 float or None
        Red, green, blue, alpha in 0..1; linear as glTF has it, or as MTL states it.
    texture : str or None
        Path or URI of the color texture, relative to the file; in glTF the number of an image.
    other_textures : tuple of (str, str)
        Each with the MTL statement that would name it.
    repeats : tuple of 2 float
        How many times a texture repeats along u and v, at most.
    image : bytes or None
        Bytes of the color texture, if no file holds it.
    uv_map : UvMap
        How its textures read UV.
    clamp : bool
        The color texture ends where UV leave 0..1.
    numbers : tuple of (str, tuple of float)
        MTL statements that glTF has a counterpart of.
    unsupported : tuple of str
        Names of its other properties, which are not stored here.
    """

    name: str
    color: tuple[float, float, float, float] | None = None
    texture: str | None = None
    other_textures: tuple[tuple[str, str], ...] = ()
    repeats: tuple[float, float] = (1.0, 1.0)
    image: bytes | None = None
    uv_map: UvMap = UvMap()
    clamp: bool = False
    numbers: tuple[tuple[str, tuple[float, ...]], ...] = ()
    unsupported: tuple[str, ...] = ()

    @property
    def textures(self) -> list[str]:
        """List all textures by name."""
        return [name for name in (self.texture, *(name for _, name in self.other_textures)) if name]
