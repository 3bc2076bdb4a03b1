"""List the places where a glTF document's JSON names accessors and buffer views, so that they can be renumbered."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from .document import Json

Slot = tuple[Any, Any]
"""A container, and the key or index in it of a number."""

FEATURES = "EXT_mesh_features"
INSTANCING = "EXT_mesh_gpu_instancing"
METADATA = "EXT_structural_metadata"
TRANSFORM = "KHR_texture_transform"
VARIANTS = "KHR_materials_variants"

_HARMLESS = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "KHR_node_", "KHR_xmp")
_KNOWN = {
    "KHR_mesh_quantization",
    INSTANCING,
    FEATURES,
    METADATA,
    "CESIUM_primitive_outline",
    "CESIUM_RTC",
    "MSFT_texture_dds",
}

PRIMITIVE_ACCESSORS = ("attributes/{}", "indices", "targets/[]/{}", "extensions/CESIUM_primitive_outline/indices")
"""Where a primitive names accessors: keys, with ``{}`` for each member of an object and ``[]`` for each of a list."""

INSTANCE_ACCESSORS = (f"extensions/{INSTANCING}/attributes/{{}}",)
"""Where a node names the accessors of its instances."""

ACCESSORS = (
    *(f"meshes/[]/primitives/[]/{path}" for path in PRIMITIVE_ACCESSORS),
    "skins/[]/inverseBindMatrices",
    "animations/[]/samplers/[]/input",
    "animations/[]/samplers/[]/output",
    *(f"nodes/[]/{path}" for path in INSTANCE_ACCESSORS),
)
"""Where a document names accessors."""

ACCESSOR_VIEWS = ("bufferView", "sparse/indices/bufferView", "sparse/values/bufferView")
"""Where an accessor names buffer views."""

_TABLE_COLUMNS = f"extensions/{METADATA}/propertyTables/[]/properties/{{}}"

VIEWS = (
    *(f"accessors/[]/{path}" for path in ACCESSOR_VIEWS),
    "images/[]/bufferView",
    *(f"{_TABLE_COLUMNS}/{key}" for key in ("values", "arrayOffsets", "stringOffsets")),
)
"""Where a document names buffer views."""


def list_unknown_extensions(json_: Json) -> list[str]:
    """List the extensions that may name accessors or buffer views in ways that bldsimp does not know."""
    return sorted(
        name for name in json_.get("extensionsUsed", []) if name not in _KNOWN and not name.startswith(_HARMLESS)
    )


def list_numbers(json_: Json, paths: Iterable[str]) -> set[int]:
    """List the whole numbers at some paths."""
    return {container[key] for container, key in iterate_slots(json_, paths)}


def iterate_slots(json_: Any, paths: Iterable[str]) -> Iterator[Slot]:
    """Yield every place of a whole number at some paths, such as `ACCESSORS`."""
    for path in paths:
        first, _, rest = path.partition("/")
        if first == "[]":
            members: Iterable[tuple[Any, Any]] = enumerate(json_)
        else:
            members = json_.items() if first == "{}" else [(first, json_.get(first, {}))]
        for key, member in members:
            if rest:
                yield from iterate_slots(member, [rest])
            elif type(member) is int:
                yield json_, key
