"""What a glTF primitive loses along with attributes that are dropped as asked: textures, and what names them."""

from __future__ import annotations

import json
from typing import Any

from ...options import Options
from .references import FEATURES, METADATA, TRANSFORM, VARIANTS


class BareMaterials:
    """Materials without textures, for primitives that lose their texture coordinates."""

    def __init__(self, json_: dict[str, Any]) -> None:
        self.materials = json_.get("materials", [])
        self._numbers: dict[str, int] = {}
        for number, material in enumerate(self.materials):
            self._numbers.setdefault(json.dumps(material, sort_keys=True), number)

    def take(self, primitive: dict[str, Any]) -> None:
        """Give a primitive, and its variants, the bare forms of their materials, added where there are none yet."""
        for user in (primitive, *primitive.get("extensions", {}).get(VARIANTS, {}).get("mappings", [])):
            number = user.get("material")
            if isinstance(number, int) and 0 <= number < len(self.materials):
                user["material"] = self._bare(number)

    def _bare(self, number: int) -> int:
        bare = _without_textures(self.materials[number])
        if bare == self.materials[number]:
            return number
        key = json.dumps(bare, sort_keys=True)
        if key not in self._numbers:
            self._numbers[key] = len(self.materials)
            self.materials.append(bare)
        return self._numbers[key]


def _without_textures(value: Any) -> Any:
    """JSON without any member that names a texture."""
    # JSON may be nested deeper than functions may call each other.
    return json.loads(json.dumps(value), object_pairs_hook=_untextured)


def _untextured(members: list[tuple[str, Any]]) -> dict[str, Any]:
    return {key: value for key, value in members if not key.lower().endswith("texture")}


def without_lost(extension: str, value: dict[str, Any], left: set[str], options: Options) -> dict[str, Any]:
    """An extension of a primitive without what names attributes that are not left; empty where nothing remains.

    Parameters
    ----------
    extension : str
    value : dict
    left : set of str
        Names of the primitive's attributes.
    options : Options
    """
    if extension == FEATURES:
        ids = [one for one in value.get("featureIds", []) if _is_left(one, left)]
        return {**value, "featureIds": ids} if ids else {}
    if extension == METADATA:
        lost = set() if options.keeps("uv") else {"propertyTextures"}
        lost |= set() if options.keeps("color") and options.keeps("feature") else {"propertyAttributes"}
        return {key: member for key, member in value.items() if key not in lost}
    return value


def _is_left(ids: dict[str, Any], left: set[str]) -> bool:
    """Whether a set of feature ids still has what it is read from."""
    if "attribute" in ids:
        return f"_FEATURE_ID_{ids['attribute']}" in left
    texture = ids.get("texture", {})
    transform = texture.get("extensions", {}).get(TRANSFORM, {})
    return f"TEXCOORD_{transform.get('texCoord', texture.get('texCoord', 0))}" in left
