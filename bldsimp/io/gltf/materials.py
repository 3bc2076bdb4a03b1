"""Read glTF materials as far as other formats know them, and measure how finely textures read each UV set."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

from ...errors import InputError
from ...material import Material, UvMap
from ...options import UNKNOWN_TEXELS
from ..input_folder import LoadFile
from ..textures import read_image_size
from .document import Document, Json, load_image
from .references import FEATURES, METADATA, TRANSFORM, VARIANTS

_MAPS = {"normalTexture": "norm", "emissiveTexture": "map_Ke"}
"""Textures that have a statement in MTL."""

_READ = ("name", "extras", "pbrMetallicRoughness", *_MAPS)
_PLAIN = ("baseColorFactor", "baseColorTexture")

Texels = tuple[float, float]
"""Texels that one unit of u and one of v are worth."""


def read_material(document: Document, primitive: Json) -> Material | None:
    """Read name, color and textures of a primitive's material.

    Raises
    ------
    InputError
        If a texture names an image that does not exist.
    """
    number, entry = primitive.get("material"), _find_material(document, primitive)
    if entry is None:
        return None
    metallic = entry.get("pbrMetallicRoughness", {})
    r, g, b, a = (float(value) for value in metallic.get("baseColorFactor", (1.0, 1.0, 1.0, 1.0)))
    base = metallic.get("baseColorTexture")
    unsupported = [key for key in metallic if key not in _PLAIN] + [key for key in entry if key not in _READ]
    others = []
    for key, statement in _MAPS.items():
        image = _find_image(document, entry.get(key))
        if image is not None and (base is None or _read_uv_map(entry[key]) == _read_uv_map(base)):
            others.append((statement, image))
        elif key in entry:
            unsupported.append(key)
    first = base or next(iterate_texture_infos(entry), None)
    return Material(
        read_name(entry, f"material {number}"),
        (r, g, b, a),
        _find_image(document, base),
        tuple(others),
        uv_map=UvMap() if first is None else _read_uv_map(first),
        unsupported=tuple(unsupported),
    )


def is_one_sided(document: Document, primitive: Json) -> bool:
    """Tell whether back faces of a primitive are not drawn, as by default."""
    entry = _find_material(document, primitive)
    return entry is None or not entry.get("doubleSided", False)


def read_name(entry: Json, default: str) -> str:
    """Return a name that every encoding takes: JSON can name half of a surrogate pair."""
    return str(entry.get("name", default)).encode("utf-8", "replace").decode("utf-8")


def _find_material(document: Document, primitive: Json) -> Json | None:
    """Return the material of a primitive, or None if it names none that exists."""
    number, materials = primitive.get("material"), document.items("materials")
    return None if number is None or not 0 <= number < len(materials) else materials[number]


def _list_sources(entry: Json) -> list[Any]:
    """List the images of a texture, and those that extensions offer instead."""
    sources = [entry.get("source"), *(each.get("source") for each in entry.get("extensions", {}).values())]
    return [source for source in sources if source is not None]


def _find_image(document: Document, info: Json | None) -> str | None:
    """Return the number of the image that a texture reads, as text."""
    textures = document.items("textures")
    number = None if info is None else info.get("index")
    if number is None or not 0 <= number < len(textures):
        return None
    image = next(iter(_list_sources(textures[number])), None)
    if image is not None and (not isinstance(image, int) or not 0 <= image < len(document.items("images"))):
        raise InputError(f"glTF texture {number} names image {image}, which does not exist: the file is damaged")
    return None if image is None else str(image)


def find_uv_set(info: Json) -> int:
    """Return the number of the UV set that a texture reads."""
    return int(info.get("extensions", {}).get(TRANSFORM, {}).get("texCoord", info.get("texCoord", 0)))


def _read_uv_map(info: Json) -> UvMap:
    """Read the UV set of a texture and its transform, with v upwards as other formats have it."""
    transform, number = info.get("extensions", {}).get(TRANSFORM, {}), find_uv_set(info)
    x, y = (float(value) for value in transform.get("scale", (1.0, 1.0)))
    dx, dy = (float(value) for value in transform.get("offset", (0.0, 0.0)))
    angle = float(transform.get("rotation", 0.0))
    if (x, y, dx, dy, angle) == (1.0, 1.0, 0.0, 0.0, 0.0):
        return UvMap(number)
    c, s = math.cos(angle), math.sin(angle)
    # With v = 1 - w: u' = c x u + s y (1 - w) + dx, and w' = 1 + s x u - c y (1 - w) - dy.
    return UvMap(number, (c * x, -s * y, s * y + dx, s * x, c * y, 1.0 - c * y - dy))


def iterate_texture_infos(value: Any) -> Iterator[Json]:
    """Yield every place in a material, or in an extension of a primitive, that names a texture."""
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


class TextureSizes:
    """Sizes of the textures of a document; each image is read once.

    Parameters
    ----------
    document : Document
    load : function of a relative path
        Returns the bytes of an image beneath the document's folder, or None.
    warnings : list of str
        Receives a message about images that cannot be decoded.
    """

    def __init__(self, document: Document, load: LoadFile, warnings: list[str]) -> None:
        self.document = document
        self.load = load
        self.warnings = warnings
        self._sizes: dict[int, Texels] = {}

    def measure(self, primitive: Json) -> dict[int, Texels]:
        """Return for each UV set that something reads the most texels that a unit of it is worth."""
        found: dict[int, Texels] = {}
        for info in self._iterate_infos(primitive):
            transform, uv_set = info.get("extensions", {}).get(TRANSFORM, {}), find_uv_set(info)
            texels = _transform_texels(self._find_size(info["index"]), transform)
            u, v = found.get(uv_set, (0.0, 0.0))
            found[uv_set] = max(u, texels[0]), max(v, texels[1])
        return found

    def _iterate_infos(self, primitive: Json) -> Iterator[Json]:
        """Yield the textures of a primitive's material and its variants, of feature ids and of properties."""
        extensions, materials = primitive.get("extensions", {}), self.document.items("materials")
        mappings = extensions.get(VARIANTS, {}).get("mappings", [])
        for number in {primitive.get("material"), *(mapping.get("material") for mapping in mappings)}:
            if isinstance(number, int) and 0 <= number < len(materials):
                yield from iterate_texture_infos(materials[number])
        yield from iterate_texture_infos(extensions.get(FEATURES, {}))
        tables = self.document.json.get("extensions", {}).get(METADATA, {}).get("propertyTextures", [])
        for number in extensions.get(METADATA, {}).get("propertyTextures", []):
            yield from tables[number].get("properties", {}).values()

    def _find_size(self, number: int) -> Texels:
        """Return width and height of a texture's largest image."""
        if number not in self._sizes:
            textures, images = self.document.items("textures"), range(len(self.document.items("images")))
            sources = _list_sources(textures[number]) if 0 <= number < len(textures) else []
            sizes = [self._read_size(image) for image in sources if isinstance(image, int) and image in images]
            width, height = zip(*sizes, strict=True) if sizes else ((UNKNOWN_TEXELS,), (UNKNOWN_TEXELS,))
            self._sizes[number] = float(max(width)), float(max(height))
        return self._sizes[number]

    def _read_size(self, number: int) -> tuple[int, int]:
        """Return width and height of an image."""
        data = load_image(self.document, number, self.load)
        if data is None and self.document.items("images")[number]["uri"].startswith("data:"):
            self.warnings.append(f"the data URI of glTF image {number} cannot be decoded: its size is unknown")
        return (data and read_image_size(data)) or (UNKNOWN_TEXELS, UNKNOWN_TEXELS)


def _transform_texels(size: Texels, transform: Json) -> Texels:
    """Return the texels that a unit of the stored UV is worth, which a transform scales and then turns."""
    angle = float(transform.get("rotation", 0.0))
    c, s = math.cos(angle), math.sin(angle)
    x, y = (abs(float(value)) for value in transform.get("scale", (1.0, 1.0)))
    return x * math.hypot(c * size[0], s * size[1]), y * math.hypot(s * size[0], c * size[1])


class BareMaterials:
    """Materials without textures, for primitives that lose their texture coordinates."""

    def __init__(self, json_: Json) -> None:
        self.materials = json_.get("materials", [])
        self._numbers: dict[str, int] = {}
        for number, material in enumerate(self.materials):
            self._numbers.setdefault(json.dumps(material, sort_keys=True), number)

    def apply(self, primitive: Json) -> None:
        """Give a primitive and its variants the bare forms of their materials; add those that are new."""
        for user in (primitive, *primitive.get("extensions", {}).get(VARIANTS, {}).get("mappings", [])):
            number = user.get("material")
            if isinstance(number, int) and 0 <= number < len(self.materials):
                user["material"] = self._find_bare(number)

    def _find_bare(self, number: int) -> int:
        """Return the number of a material's bare form."""
        # JSON may be nested deeper than functions may call each other.
        bare = json.loads(json.dumps(self.materials[number]), object_pairs_hook=_drop_textures)
        if bare == self.materials[number]:
            return number
        key = json.dumps(bare, sort_keys=True)
        if key not in self._numbers:
            self._numbers[key] = len(self.materials)
            self.materials.append(bare)
        return self._numbers[key]


def _drop_textures(members: list[tuple[str, Any]]) -> Json:
    """Return the members of a JSON object that name no texture."""
    return {key: value for key, value in members if not key.lower().endswith("texture")}
