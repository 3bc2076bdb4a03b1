"""Validate the parts of the document that are copied unchanged."""

from __future__ import annotations

from ...errors import OutputError
from .document import Document, Json
from .references import ACCESSORS, FEATURES, VIEWS, iterate_slots


def check_document(document: Document) -> None:
    """Refuse a document whose references cannot be renumbered, or whose data cannot be laid out anew.

    Raises
    ------
    OutputError
        If a number is out of range or of another type than the format asks.
    """
    try:
        _check_references(document)
        _check_places(document)
        _check_feature_ids(document)
    except (AttributeError, TypeError, ValueError) as error:
        cause = f"{type(error).__name__}: {error}"
        raise OutputError(f"the input's glTF JSON does not follow the format ({cause}): it is damaged") from error


def _check_references(document: Document) -> None:
    """Check all numbers of accessors, buffer views, buffers and meshes."""
    for key, paths in (("accessors", ACCESSORS), ("bufferViews", VIEWS)):
        count = len(document.items(key))
        for container, name in iterate_slots(document.json, paths):
            if not 0 <= container[name] < count:
                raise ValueError(f"{name} {container[name]} is none of the {count} {key}")
    for number, view in enumerate(document.items("bufferViews")):
        if _check_whole(view, "buffer", -1) not in range(len(document.buffers)):
            raise ValueError(f"buffer view {number} names no buffer")
    for node in document.items("nodes"):
        _check_whole(node, "mesh")


def _check_places(document: Document) -> None:
    """Check where the data of accessors and buffer views starts and ends."""
    for view in document.items("bufferViews"):
        for key in ("byteOffset", "byteLength", "byteStride"):
            _check_whole(view, key)
    for accessor in document.items("accessors"):
        if not isinstance(accessor.get("type", ""), str):
            raise TypeError(f"'type' is {accessor['type']!r}")
        sparse = accessor.get("sparse", {})
        for one in (accessor, sparse, sparse.get("indices", {}), sparse.get("values", {})):
            for key in ("bufferView", "byteOffset", "componentType"):
                _check_whole(one, key)
            # Reading takes 24.0 elements for 24.
            if not float(one.get("count", 0)).is_integer():
                raise ValueError(f"'count' is {one['count']}")


def _check_feature_ids(document: Document) -> None:
    """Check the members that name the attributes and textures of feature ids."""
    for mesh in document.items("meshes"):
        for primitive in mesh.get("primitives", []):
            for ids in primitive.get("extensions", {}).get(FEATURES, {}).get("featureIds", []):
                ids.get("texture", {}).get("extensions", {}).values()


def _check_whole(container: Json, key: str, default: int = 0) -> int:
    """Return a member, which must be a whole number."""
    value = container.get(key, default)
    if type(value) is not int:
        raise TypeError(f"'{key}' is {str(value)[:40]!r}")
    return value
