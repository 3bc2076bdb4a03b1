"""Where a glTF document's JSON names accessors and buffer views, so that they can be renumbered."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

Slot = tuple[Any, Any]
"""A container and the key or index in it that holds a number."""

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


def unknown_extensions(json_: dict[str, Any]) -> list[str]:
    """Extensions that may name accessors or buffer views in ways that are not known here."""
    return sorted(
        name for name in json_.get("extensionsUsed", []) if name not in _KNOWN and not name.startswith(_HARMLESS)
    )


def accessor_slots(json_: dict[str, Any]) -> Iterator[Slot]:
    """Every place that holds the number of an accessor."""
    for mesh in json_.get("meshes", []):
        for primitive in mesh.get("primitives", []):
            yield from primitive_slots(primitive)
    for skin in json_.get("skins", []):
        yield from _one(skin, "inverseBindMatrices")
    for animation in json_.get("animations", []):
        for sampler in animation.get("samplers", []):
            yield from _one(sampler, "input")
            yield from _one(sampler, "output")
    for node in json_.get("nodes", []):
        yield from instancing_slots(node)


def instancing_slots(node: dict[str, Any]) -> Iterator[Slot]:
    """The places of the instances of one node."""
    yield from _all(node.get("extensions", {}).get(INSTANCING, {}).get("attributes", {}))


def primitive_slots(primitive: dict[str, Any]) -> Iterator[Slot]:
    """The places of one primitive."""
    yield from _all(primitive.get("attributes", {}))
    yield from _one(primitive, "indices")
    for target in primitive.get("targets", []):
        yield from _all(target)
    yield from _one(primitive.get("extensions", {}).get("CESIUM_primitive_outline", {}), "indices")


def view_slots(json_: dict[str, Any]) -> Iterator[Slot]:
    """Every place that holds the number of a buffer view."""
    for accessor in json_.get("accessors", []):
        yield from accessor_view_slots(accessor)
    for image in json_.get("images", []):
        yield from _one(image, "bufferView")
    metadata = json_.get("extensions", {}).get(METADATA, {})
    for table in metadata.get("propertyTables", []):
        for column in table.get("properties", {}).values():
            for key in ("values", "arrayOffsets", "stringOffsets"):
                yield from _one(column, key)


def accessor_view_slots(accessor: dict[str, Any]) -> Iterator[Slot]:
    """The places of one accessor."""
    yield from _one(accessor, "bufferView")
    sparse = accessor.get("sparse", {})
    yield from _one(sparse.get("indices", {}), "bufferView")
    yield from _one(sparse.get("values", {}), "bufferView")


def _one(container: Any, key: str) -> Iterator[Slot]:
    if type(container.get(key)) is int:
        yield container, key


def _all(container: dict[str, Any]) -> Iterator[Slot]:
    for key, value in container.items():
        if type(value) is int:
            yield container, key
