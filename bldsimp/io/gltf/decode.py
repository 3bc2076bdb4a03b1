"""Compressed glTF documents (Draco, meshopt) to what they stand for; the decoders are packages of their own."""

from __future__ import annotations

import dataclasses
import hashlib
import importlib
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from .document import COMPONENTS, MESHOPT, WIDTHS, Document, copied

DRACO = "KHR_draco_mesh_compression"

_Filter = Callable[[NDArray[np.uint8], int, int], NDArray[np.uint8]]


def unpacked(document: Document, warnings: list[str]) -> Document:
    """A document without compressed data: the same one where it has none.

    Data that the file has uncompressed too (a fallback) is taken as it is.

    Raises
    ------
    InputError
        Where the package that decodes is not installed, or the data is damaged.
    """
    used = [name for name in (*MESHOPT, DRACO) if name in _named(document)]
    if not used:
        return document
    # Accessors, views and primitives get other entries; all else is shared with the file's own JSON.
    json_ = {**document.json}
    for key in ("accessors", "bufferViews", "meshes"):
        json_[key] = copied(document.items(key))
    made = _Made(json_, document)
    for number, view in enumerate(json_["bufferViews"]):
        _unpack_view(made, number, view)
    # Draco's own data may be packed by meshopt.
    whole = dataclasses.replace(document, json=json_, buffers=[*document.buffers, *made.buffers])
    for mesh in json_["meshes"]:
        for primitive in mesh.get("primitives", []):
            _unpack_primitive(made, whole, primitive)
    for key in ("extensionsUsed", "extensionsRequired"):
        left = [name for name in json_.get(key, []) if name not in used]
        json_[key] = left
        if not left:
            del json_[key]
    json_["buffers"] = [
        {k: v for k, v in entry.items() if k != "extensions" or not set(v) & set(MESHOPT)}
        for entry in document.items("buffers")
    ]
    json_["buffers"] += [{"byteLength": len(data)} for data in made.buffers]
    warnings.append(f"the file is compressed ({', '.join(used)}); what is written as glTF is not")
    return dataclasses.replace(document, json=json_, buffers=[*document.buffers, *made.buffers], unpacked=tuple(used))


class _Made:
    """New buffers of a document, one for each piece of unpacked data; equal pieces of Draco's are one."""

    def __init__(self, json_: dict[str, Any], document: Document) -> None:
        self.json = json_
        self.document = document
        self.buffers: list[bytes] = []
        self.decoded: dict[int, Any] = {}
        self._views: dict[tuple[int, bytes], int] = {}

    def add(self, data: bytes) -> dict[str, Any]:
        """The place of new data, as a buffer view tells it."""
        self.buffers.append(data)
        number = len(self.document.buffers) + len(self.buffers) - 1
        return {"buffer": number, "byteOffset": 0, "byteLength": len(data)}

    def fill(self, accessor: dict[str, Any], values: NDArray[Any], *, vertices: bool) -> None:
        """Give an accessor values of its own type, in a view of them alone; vertices start at multiples of four."""
        kind = np.dtype("<" + COMPONENTS[accessor["componentType"]])
        values = np.ascontiguousarray(values).reshape(len(values), -1)
        if values.shape[1] != WIDTHS[accessor["type"]]:
            raise InputError("the Draco data of the glTF file has other attributes than its accessors: it is damaged")
        width = values.shape[1] * kind.itemsize
        rows = np.zeros((len(values), width + (-width % 4 if vertices else 0)), np.uint8)
        rows[:, :width] = values.astype(kind).view(np.uint8).reshape(len(values), width)
        accessor.update(bufferView=self._view(rows, vertices), count=len(values))
        accessor.pop("byteOffset", None)
        if "min" in accessor and len(values):
            accessor["min"], accessor["max"] = values.min(axis=0).tolist(), values.max(axis=0).tolist()

    def _view(self, rows: NDArray[np.uint8], strided: bool) -> int:
        """A view of rows of bytes."""
        data = rows.tobytes()
        key = rows.shape[1] * (1 if strided else -1), hashlib.sha256(data).digest()
        if key not in self._views:
            self._views[key] = len(self.json["bufferViews"])
            self.json["bufferViews"].append(self.add(data))
            if strided:
                self.json["bufferViews"][-1]["byteStride"] = rows.shape[1]
        return self._views[key]


def _named(document: Document) -> set[str]:
    """Extensions that views and primitives name; the file's own list may be wrong."""
    things = [*document.items("bufferViews")]
    things += [one for mesh in document.items("meshes") for one in mesh.get("primitives", [])]
    listed = [name for key in ("extensionsUsed", "extensionsRequired") for name in document.json.get(key, [])]
    return {*listed, *(name for thing in things for name in thing.get("extensions", {}))}


def _unpack_view(made: _Made, number: int, view: dict[str, Any]) -> None:
    """Undo meshopt's compression of a view."""
    name = next((one for one in MESHOPT if one in view.get("extensions", {})), None)
    if name is None:
        return
    packed = view["extensions"].pop(name)
    if not view["extensions"]:
        del view["extensions"]
    document = made.document
    if 0 <= view["buffer"] < len(document.buffers) and document.buffers[view["buffer"]]:
        return
    module = _module("meshoptimizer", "meshopt", name)
    source = Document({"asset": {}, "bufferViews": [{key: packed[key] for key in _PLACE if key in packed}]},
                      document.buffers, [])  # fmt: skip
    data, count, stride = source.view(0), int(packed["count"]), int(packed["byteStride"])
    try:
        found = _decoded_view(module, data, count, stride, packed["mode"], packed.get("filter", "NONE"))
    except (RuntimeError, ValueError) as error:
        raise InputError(f"glTF buffer view {number} cannot be decompressed ({error}): the file is damaged") from None
    view.update(made.add(found))
    if packed["mode"] == "ATTRIBUTES":
        view["byteStride"] = stride


_PLACE = ("buffer", "byteOffset", "byteLength")


def _decoded_view(module: Any, data: bytes, count: int, stride: int, mode: str, filter_: str) -> bytes:
    """The bytes that a compressed view stands for."""
    if mode != "ATTRIBUTES":
        decode = {"TRIANGLES": module.decode_index_buffer, "INDICES": module.decode_index_sequence}.get(mode)
        if decode is None or stride not in (2, 4):
            raise ValueError(f"mode {mode} of {stride} bytes")
        # The package gives four bytes for each index, whatever size it is told.
        return bytes(decode(count, 4, data).astype(f"<u{stride}").tobytes())
    rows: NDArray[np.uint8] = module.decode_vertex_buffer(count, stride, data, dtype=np.dtype((np.uint8, stride)))
    filters: dict[str, _Filter] = {
        "OCTAHEDRAL": module.decode_filter_oct,
        "QUATERNION": module.decode_filter_quat,
        "EXPONENTIAL": module.decode_filter_exp,
    }
    if filter_ == "NONE":
        return rows.tobytes()
    if filter_ not in filters:
        raise ValueError(f"filter {filter_} is not known")
    return filters[filter_](rows, count, stride).tobytes()


def _unpack_primitive(made: _Made, document: Document, primitive: dict[str, Any]) -> None:
    """Undo Draco's compression of a primitive."""
    packed = primitive.get("extensions", {}).pop(DRACO, None)
    if packed is None:
        return
    if not primitive["extensions"]:
        del primitive["extensions"]
    accessors = made.json["accessors"]
    names = packed["attributes"]
    numbers = [primitive["attributes"][name] for name in names]
    numbers += [primitive["indices"]] if "indices" in primitive else []
    if all("bufferView" in accessors[number] for number in numbers):
        return
    view = packed["bufferView"]
    if view not in made.decoded:
        made.decoded[view] = _draco(document.view(view))
    mesh = made.decoded[view]
    primitive["mode"] = 4
    if "indices" in primitive:
        made.fill(accessors[primitive["indices"]], np.asarray(mesh.faces).reshape(-1, 1), vertices=False)
    for name, unique in names.items():
        found = mesh.get_attribute_by_unique_id(unique)
        if found is None:
            raise InputError(f"the Draco data of the glTF file has no attribute {unique}, {name}: it is damaged")
        made.fill(accessors[primitive["attributes"][name]], np.asarray(found["data"]), vertices=True)


def _draco(data: bytes) -> Any:
    """A decoded mesh."""
    module = _module("DracoPy", "Draco", DRACO)
    try:
        mesh = module.decode(data)
    except Exception as error:  # the package raises its own bare exceptions
        raise InputError(f"the Draco data of the glTF file cannot be decompressed ({error}): it is damaged") from None
    if not hasattr(mesh, "faces"):
        raise InputError("the Draco data of the glTF file has points but no faces: it is damaged")
    return mesh


def _module(package: str, method: str, extension: str) -> Any:
    try:
        return importlib.import_module(package)
    except ImportError:
        raise InputError(
            f"the glTF file is compressed ({method}, {extension}): install the package that reads it with"
            f" 'pip install {package}', or decompress the file with 'gltf-transform copy IN OUT'"
        ) from None
