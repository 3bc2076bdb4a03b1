"""How finely the textures of a glTF primitive read each of its UV sets."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from ...options import UNKNOWN_TEXELS
from ..image_size import image_size
from .document import Beside, Document, image_bytes
from .references import FEATURES, METADATA, TRANSFORM, VARIANTS

Texels = tuple[float, float]
"""Texels that one unit of u and one of v are worth."""


class Textures:
    """The textures of a document; each image is looked at once.

    Parameters
    ----------
    document : Document
    beside : function of a relative path
        Gives the bytes of an image beneath the document's folder, or None.
    warnings : list of str
        Added to.
    """

    def __init__(self, document: Document, beside: Beside, warnings: list[str]) -> None:
        self.document = document
        self.beside = beside
        self.warnings = warnings
        self._sizes: dict[int, Texels] = {}
        self._materials: dict[int, dict[int, Texels]] = {}

    def texels(self, primitive: dict[str, Any]) -> dict[int, Texels]:
        """For each UV set that something reads, the most texels that a unit of it is worth."""
        found: dict[int, Texels] = {}
        for number in _materials(primitive):
            if number not in self._materials:
                materials = self.document.items("materials")
                infos = texture_infos(materials[number]) if 0 <= number < len(materials) else iter(())
                self._materials[number] = self._finest({}, infos)
            _raise(found, self._materials[number])
        return self._finest(found, self._own_infos(primitive))

    def _own_infos(self, primitive: dict[str, Any]) -> Iterator[dict[str, Any]]:
        """Textures of feature ids and of properties."""
        extensions = primitive.get("extensions", {})
        yield from texture_infos(extensions.get(FEATURES, {}))
        tables = self.document.json.get("extensions", {}).get(METADATA, {}).get("propertyTextures", [])
        for number in extensions.get(METADATA, {}).get("propertyTextures", []):
            yield from tables[number].get("properties", {}).values()

    def _finest(self, found: dict[int, Texels], infos: Iterator[dict[str, Any]]) -> dict[int, Texels]:
        for info in infos:
            transform = info.get("extensions", {}).get(TRANSFORM, {})
            texcoord = int(transform.get("texCoord", info.get("texCoord", 0)))
            _raise(found, {texcoord: _transformed(self._size(info["index"]), transform)})
        return found

    def _size(self, texture: int) -> Texels:
        """Width and height of a texture's largest image."""
        if texture not in self._sizes:
            sizes = [self._image_size(number) for number in _sources(self.document, texture)]
            width, height = zip(*sizes, strict=True) if sizes else ((UNKNOWN_TEXELS,), (UNKNOWN_TEXELS,))
            self._sizes[texture] = float(max(width)), float(max(height))
        return self._sizes[texture]

    def _image_size(self, number: int) -> tuple[int, int]:
        data = image_bytes(self.document, number, self.beside)
        if data is None and self.document.items("images")[number]["uri"].startswith("data:"):
            self.warnings.append(f"the data URI of glTF image {number} cannot be decoded: its size is not known")
        return (data and image_size(data)) or (UNKNOWN_TEXELS, UNKNOWN_TEXELS)


def texture_infos(value: Any) -> Iterator[dict[str, Any]]:
    """Every place in a material, or in an extension of a primitive, that names a texture."""
    # JSON may be nested deeper than functions may call each other.
    waiting = [value]
    while waiting:
        one = waiting.pop()
        items = one.items() if isinstance(one, dict) else enumerate(one) if isinstance(one, list) else ()
        for key, member in items:
            named = str(key).lower().endswith("texture") and isinstance(member, dict)
            if named and isinstance(member.get("index"), int):
                yield member
            elif key != "extras":
                waiting.append(member)


def _materials(primitive: dict[str, Any]) -> set[int]:
    """A primitive's material, and those of its variants."""
    mappings = primitive.get("extensions", {}).get(VARIANTS, {}).get("mappings", [])
    found = {primitive.get("material"), *(mapping.get("material") for mapping in mappings)}
    return {number for number in found if isinstance(number, int)}


def _sources(document: Document, texture: int) -> list[int]:
    """Images of a texture, those that an extension offers instead among them."""
    textures = document.items("textures")
    if not 0 <= texture < len(textures):
        return []
    entry = textures[texture]
    sources = [entry.get("source"), *(each.get("source") for each in entry.get("extensions", {}).values())]
    return [number for number in sources if isinstance(number, int) and 0 <= number < len(document.items("images"))]


def _transformed(size: Texels, transform: dict[str, Any]) -> Texels:
    """Texels that a unit of the stored UV is worth, which a transform scales and then turns."""
    angle = float(transform.get("rotation", 0.0))
    c, s = math.cos(angle), math.sin(angle)
    x, y = (abs(float(value)) for value in transform.get("scale", (1.0, 1.0)))
    return x * math.hypot(c * size[0], s * size[1]), y * math.hypot(s * size[0], c * size[1])


def _raise(found: dict[int, Texels], more: dict[int, Texels]) -> None:
    """Keep the greater of two, for each set."""
    for number, (x, y) in more.items():
        u, v = found.get(number, (0.0, 0.0))
        found[number] = max(u, x), max(v, y)
