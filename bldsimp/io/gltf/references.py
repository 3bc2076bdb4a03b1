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


def list_unknown_extensions(json_: Json) -> list[str]:
    """List the extensions that may name accessors or buffer views in ways that bldsimp does not know."""
    return sorted(
        name for name in json_.get("extensionsUsed", []) if name not in _KNOWN and not name.startswith(_HARMLESS)
    )


def iterate_accessor_slots(json_: Json) -> Iterator[Slot]:
    """Yield every place of an accessor's number."""
    for mesh in json_.get("meshes", []):
        for primitive in mesh.get("primitives", []):
            yield from iterate_primitive_slots(primitive)
    for skin in json_.get("skins", []):
        yield from _iterate_slots(skin, ["inverseBindMatrices"])
    for animation in json_.get("animations", []):
        for sampler in animation.get("samplers", []):
            yield from _iterate_slots(sampler, ["input", "output"])
    for node in json_.get("nodes", []):
        yield from iterate_instance_slots(node)


def iterate_instance_slots(node: Json) -> Iterator[Slot]:
    """Yield every place of an accessor's number in the instances of one node."""
    yield from _iterate_slots(node.get("extensions", {}).get(INSTANCING, {}).get("attributes", {}))


def iterate_primitive_slots(primitive: Json) -> Iterator[Slot]:
    """Yield every place of an accessor's number in one primitive."""
    yield from _iterate_slots(primitive.get("attributes", {}))
    yield from _iterate_slots(primitive, ["indices"])
    for target in primitive.get("targets", []):
        yield from _iterate_slots(target)
    yield from _iterate_slots(primitive.get("extensions", {}).get("CESIUM_primitive_outline", {}), ["indices"])


def iterate_view_slots(json_: Json) -> Iterator[Slot]:
    """Yield every place of a buffer view's number."""
    for accessor in json_.get("accessors", []):
        yield from iterate_accessor_view_slots(accessor)
    for image in json_.get("images", []):
        yield from _iterate_slots(image, ["bufferView"])
    metadata = json_.get("extensions", {}).get(METADATA, {})
    for table in metadata.get("propertyTables", []):
        for column in table.get("properties", {}).values():
            yield from _iterate_slots(column, ["values", "arrayOffsets", "stringOffsets"])


def iterate_accessor_view_slots(accessor: Json) -> Iterator[Slot]:
    """Yield every place of a buffer view's number in one accessor."""
    sparse = accessor.get("sparse", {})
    for container in (accessor, sparse.get("indices", {}), sparse.get("values", {})):
        yield from _iterate_slots(container, ["bufferView"])


def _iterate_slots(container: Json, keys: Iterable[str] | None = None) -> Iterator[Slot]:
    """Yield the places of whole numbers, of all keys or of those given."""
    for key in container.keys() if keys is None else keys:
        if type(container.get(key)) is int:
            yield container, key
