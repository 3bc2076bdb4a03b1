"""Read a glTF document as a scene to compare: every number of an accessor, view or image is replaced by its value.

This reader follows the rules of the format, and shares nothing with the program that is tested.
"""

from __future__ import annotations

import base64
import copy
import hashlib
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from shapes import split_glb

_KINDS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Contents:
    """A document and its data."""

    def __init__(self, path: Path) -> None:
        data = path.read_bytes()
        self.folder = path.parent
        self.json, binary = split_glb(data) if data[:4] == b"glTF" else (json.loads(data), b"")
        self.buffers = [self.uri(e["uri"]) if "uri" in e else binary for e in self.json.get("buffers", [])]

    def uri(self, uri: str) -> bytes:
        """Return the bytes that a URI names."""
        if uri.startswith("data:"):
            return base64.b64decode(uri.partition(",")[2])
        path = self.folder / unquote(uri)
        return path.read_bytes() if path.exists() else b"not there"

    def view(self, number: int) -> bytes:
        """Return the bytes of a buffer view."""
        view = self.json["bufferViews"][number]
        start = view.get("byteOffset", 0)
        return self.buffers[view["buffer"]][start : start + view["byteLength"]]

    def values(self, number: int) -> np.ndarray:
        """Return the values of an accessor as they are stored."""
        entry = self.json["accessors"][number]
        kind, width = np.dtype(_KINDS[entry["componentType"]]), _WIDTHS[entry["type"]]
        rows = np.zeros((entry["count"], width), kind)
        if "bufferView" in entry:
            stride = self.json["bufferViews"][entry["bufferView"]].get("byteStride", kind.itemsize * width)
            data, start = self.view(entry["bufferView"]), entry.get("byteOffset", 0)
            rows = np.array([np.frombuffer(data, kind, width, start + i * stride) for i in range(entry["count"])])
        if "sparse" in entry:
            where, what = entry["sparse"]["indices"], entry["sparse"]["values"]
            places = np.frombuffer(self.view(where["bufferView"]), _KINDS[where["componentType"]])
            changes = np.frombuffer(self.view(what["bufferView"]), kind).reshape(-1, width)
            rows[places[: entry["sparse"]["count"]]] = changes[: entry["sparse"]["count"]]
        return rows


def read_gltf_scene(path: Path) -> dict[str, Any]:
    """Return all of a document, with primitives as `read_primitive` returns them."""
    found = Contents(path)
    scene = copy.deepcopy(found.json)
    for key in ("accessors", "bufferViews", "buffers"):
        scene.pop(key, None)
    for image in scene.get("images", []):
        data = found.view(image.pop("bufferView")) if "bufferView" in image else found.uri(image.pop("uri"))
        image.pop("mimeType", None)
        image["data"] = hashlib.sha256(data).hexdigest()
    for mesh in scene.get("meshes", []):
        mesh["primitives"] = [read_primitive(found, one) for one in mesh["primitives"]]
    for holder, keys in list_holders(scene):
        replace_numbers(found, holder, keys)
    for table in scene.get("extensions", {}).get("EXT_structural_metadata", {}).get("propertyTables", []):
        for column in table["properties"].values():
            for key in {"values", "arrayOffsets", "stringOffsets"} & set(column):
                column[key] = found.view(column[key]).hex()
    return scene


def list_holders(scene: dict[str, Any]) -> Iterator[tuple[dict[str, Any], list[str]]]:
    """Yield the objects outside meshes that name accessors, and the keys that do."""
    for skin in scene.get("skins", []):
        yield skin, ["inverseBindMatrices"]
    for animation in scene.get("animations", []):
        for sampler in animation["samplers"]:
            yield sampler, ["input", "output"]
    for node in scene.get("nodes", []):
        instances = node.get("extensions", {}).get("EXT_mesh_gpu_instancing", {}).get("attributes", {})
        yield instances, list(instances)


def read_primitive(found: Contents, one: dict[str, Any]) -> dict[str, Any]:
    """Return a primitive with the values that its corners read instead of accessors."""
    one = copy.deepcopy(one)
    entries = found.json["accessors"]
    count = entries[one["attributes"]["POSITION"]]["count"]
    corners = found.values(one.pop("indices"))[:, 0] if "indices" in one else np.arange(count)
    numbers = dict(sorted(one["attributes"].items()))
    one["attributes"] = {name: found.values(number)[corners] for name, number in numbers.items()}
    keys = ("componentType", "normalized", "type")
    one["types"] = {name: [entries[number].get(key) for key in keys] for name, number in numbers.items()}
    for target in one.get("targets", []):
        replace_numbers(found, target, list(target))
    return one


def replace_numbers(found: Contents, holder: dict[str, Any], keys: list[str]) -> None:
    """Replace the numbers of accessors by their values."""
    for key in keys:
        holder[key] = found.values(holder[key]).tolist()
