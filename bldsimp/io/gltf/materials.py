"""The little of a glTF material that other formats know."""

from __future__ import annotations

import math
from typing import Any

from ...errors import InputError
from ..surface import Material, UvMap
from .document import Document
from .references import TRANSFORM
from .textures import texture_infos

_MAPS = {"normalTexture": "norm", "emissiveTexture": "map_Ke"}
"""Textures that have a statement in MTL."""

_TOLD = ("name", "extras", "pbrMetallicRoughness", *_MAPS)
_PLAIN = ("baseColorFactor", "baseColorTexture")


def read_material(document: Document, primitive: dict[str, Any]) -> Material | None:
    """Name, colour and textures of a primitive's material.

    Raises
    ------
    InputError
        Where a texture names an image that is not there.
    """
    number = primitive.get("material")
    materials = document.items("materials")
    if number is None or not 0 <= number < len(materials):
        return None
    entry = materials[number]
    metallic = entry.get("pbrMetallicRoughness", {})
    r, g, b, a = (float(value) for value in metallic.get("baseColorFactor", (1.0, 1.0, 1.0, 1.0)))
    base = metallic.get("baseColorTexture")
    left = [key for key in metallic if key not in _PLAIN] + [key for key in entry if key not in _TOLD]
    others = []
    for key, statement in _MAPS.items():
        image = _image(document, entry.get(key))
        if image is not None and (base is None or _uv_map(entry[key]) == _uv_map(base)):
            others.append((statement, image))
        elif key in entry:
            left.append(key)
    first = base or next(texture_infos(entry), None)
    return Material(
        name_of(entry, f"material {number}"),
        (r, g, b, a),
        _image(document, base),
        tuple(others),
        uv_map=UvMap() if first is None else _uv_map(first),
        left=tuple(left),
    )


def name_of(entry: dict[str, Any], default: str) -> str:
    """A name that every encoding takes: JSON can name half of a surrogate pair."""
    return str(entry.get("name", default)).encode("utf-8", "replace").decode("utf-8")


def _image(document: Document, info: dict[str, Any] | None) -> str | None:
    """The number of the image that a texture reads, as text."""
    textures = document.items("textures")
    number = None if info is None else info.get("index")
    if number is None or not 0 <= number < len(textures):
        return None
    entry = textures[number]
    sources = [entry.get("source"), *(each.get("source") for each in entry.get("extensions", {}).values())]
    image = next((source for source in sources if source is not None), None)
    if image is not None and (not isinstance(image, int) or not 0 <= image < len(document.items("images"))):
        raise InputError(f"glTF texture {number} names image {image}, which is not there: the file is damaged")
    return None if image is None else str(image)


def _uv_map(info: dict[str, Any]) -> UvMap:
    """The UV set that a texture reads, and what it does to it, with v upwards as other formats have it."""
    transform = info.get("extensions", {}).get(TRANSFORM, {})
    number = int(transform.get("texCoord", info.get("texCoord", 0)))
    x, y = (float(value) for value in transform.get("scale", (1.0, 1.0)))
    dx, dy = (float(value) for value in transform.get("offset", (0.0, 0.0)))
    angle = float(transform.get("rotation", 0.0))
    if (x, y, dx, dy, angle) == (1.0, 1.0, 0.0, 0.0, 0.0):
        return UvMap(number)
    c, s = math.cos(angle), math.sin(angle)
    # With v = 1 - w: u' = c x u + s y (1 - w) + dx, and w' = 1 + s x u - c y (1 - w) - dy.
    return UvMap(number, (c * x, -s * y, s * y + dx, s * x, c * y, 1.0 - c * y - dy))


def is_one_sided(document: Document, primitive: dict[str, Any]) -> bool:
    """Whether back faces of a primitive are not drawn; the default where it names no material."""
    number, materials = primitive.get("material"), document.items("materials")
    return number is None or not 0 <= number < len(materials) or not materials[number].get("doubleSided", False)
