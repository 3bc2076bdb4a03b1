"""Decode compressed glTF documents (Draco, meshopt) with packages of their own."""

from __future__ import annotations

import hashlib
import importlib
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from .buffers import pack_rows
from .document import COMPONENTS, MESHOPT, WIDTHS, Document, Json, copy_json

DRACO = "KHR_draco_mesh_compression"

_PLACE = ("buffer", "byteOffset", "byteLength")


def decode_document(document: Document, warnings: list[str]) -> Document:
    """Return a document without compressed data: the same one if it has none.

    Data that the file has uncompressed too (a fallback) is taken as it is.

    Parameters
    ----------
    document : Document
    warnings : list of str
        Receives a message about the compression, which the result does not have.

    Raises
    ------
    InputError
        If the package that decodes is not installed, or the data is damaged.
    """
    used = [name for name in (*MESHOPT, DRACO) if name in _find_extensions(document)]
    if not used:
        return document
    # Accessors, views and primitives get other entries; all else is shared with the file's own JSON.
    json_ = {**document.json}
    for key in ("accessors", "bufferViews", "meshes"):
        json_[key] = copy_json(document.items(key))
    decoded = replace(document, json=json_, buffers=[*document.buffers], decoded=tuple(used))
    decoder = _Decoder(decoded)
    # Draco's own data may be packed by meshopt.
    for number, view in enumerate(json_["bufferViews"]):
        decoder.decode_view(number, view)
    for mesh in json_["meshes"]:
        for primitive in mesh.get("primitives", []):
            decoder.decode_primitive(primitive)
    for key in ("extensionsUsed", "extensionsRequired"):
        json_[key] = [name for name in json_.get(key, []) if name not in used]
        if not json_[key]:
            del json_[key]
    json_["buffers"] = [
        {k: v for k, v in entry.items() if k != "extensions" or not set(v) & set(MESHOPT)}
        for entry in document.items("buffers")
    ]
    json_["buffers"] += [{"byteLength": len(data)} for data in decoded.buffers[len(document.buffers) :]]
    warnings.append(f"the file is compressed ({', '.join(used)}); glTF output is not")
    return decoded


def _find_extensions(document: Document) -> set[str]:
    """Return the extensions that views and primitives name; the file's own list may be wrong."""
    things = [*document.items("bufferViews")]
    things += [one for mesh in document.items("meshes") for one in mesh.get("primitives", [])]
    listed = [name for key in ("extensionsUsed", "extensionsRequired") for name in document.json.get(key, [])]
    return {*listed, *(name for thing in things for name in thing.get("extensions", {}))}


@dataclass
class _Decoder:
    """A document that gets a buffer for each piece of decoded data; equal pieces of Draco's are one."""

    document: Document
    _meshes: dict[int, Any] = field(default_factory=dict)
    _views: dict[tuple[int, bytes], int] = field(default_factory=dict)

    def decode_view(self, number: int, view: Json) -> None:
        """Undo meshopt's compression of a view."""
        name, packed = _pop_extension(view, MESHOPT)
        if packed is None:
            return
        buffers = self.document.buffers
        if 0 <= view["buffer"] < len(self.document.items("buffers")) and buffers[view["buffer"]]:
            return
        module = _import_decoder("meshoptimizer", "meshopt", name)
        place = {key: packed[key] for key in _PLACE if key in packed}
        data = Document({"asset": {}, "bufferViews": [place]}, buffers, []).read_view(0)
        count, stride, mode = int(packed["count"]), int(packed["byteStride"]), packed["mode"]
        try:
            found = _decode_view(module, data, count, stride, mode, packed.get("filter", "NONE"))
        except (RuntimeError, ValueError) as error:
            raise InputError(f"glTF buffer view {number} cannot be decoded ({error}): the file is damaged") from None
        view.update(self._add_buffer(found))
        if mode == "ATTRIBUTES":
            view["byteStride"] = stride

    def decode_primitive(self, primitive: Json) -> None:
        """Undo Draco's compression of a primitive."""
        _, packed = _pop_extension(primitive, (DRACO,))
        if packed is None:
            return
        accessors = self.document.json["accessors"]
        numbers = [primitive["attributes"][name] for name in packed["attributes"]]
        numbers += [primitive["indices"]] if "indices" in primitive else []
        if all("bufferView" in accessors[number] for number in numbers):
            return
        view = packed["bufferView"]
        if view not in self._meshes:
            self._meshes[view] = _decode_draco(self.document.read_view(view))
        mesh = self._meshes[view]
        primitive["mode"] = 4
        if "indices" in primitive:
            faces = np.asarray(mesh.faces).reshape(-1, 1)
            self._fill_accessor(accessors[primitive["indices"]], faces, vertices=False)
        for name, unique in packed["attributes"].items():
            found = mesh.get_attribute_by_unique_id(unique)
            if found is None:
                raise InputError(f"the Draco data of the glTF file has no attribute {unique}, {name}: it is damaged")
            self._fill_accessor(accessors[primitive["attributes"][name]], np.asarray(found["data"]), vertices=True)

    def _add_buffer(self, data: bytes) -> Json:
        """Add a buffer; return the place of its data for a buffer view."""
        self.document.buffers.append(data)
        return {"buffer": len(self.document.buffers) - 1, "byteOffset": 0, "byteLength": len(data)}

    def _fill_accessor(self, accessor: Json, values: NDArray[Any], *, vertices: bool) -> None:
        """Give an accessor values of its own type, in a view of their own."""
        values = np.ascontiguousarray(values).reshape(len(values), -1)
        if values.shape[1] != WIDTHS[accessor["type"]]:
            raise InputError("the Draco data of the glTF file has other attributes than its accessors: it is damaged")
        rows = pack_rows(values, np.dtype("<" + COMPONENTS[accessor["componentType"]]), aligned=vertices)
        key = rows.shape[1] * (1 if vertices else -1), hashlib.sha256(rows.tobytes()).digest()
        if key not in self._views:
            views = self.document.json["bufferViews"]
            self._views[key] = len(views)
            stride = {"byteStride": rows.shape[1]} if vertices else {}
            views.append({**self._add_buffer(rows.tobytes()), **stride})
        accessor.update(bufferView=self._views[key], count=len(values))
        accessor.pop("byteOffset", None)
        if "min" in accessor and len(values):
            accessor["min"], accessor["max"] = values.min(axis=0).tolist(), values.max(axis=0).tolist()


def _pop_extension(thing: Json, names: tuple[str, ...]) -> tuple[str, Json | None]:
    """Remove the first of some extensions that a JSON object has; return its name and value."""
    extensions = thing.get("extensions", {})
    name = next((one for one in names if one in extensions), "")
    packed: Json | None = extensions.pop(name, None)
    if packed is not None and not extensions:
        del thing["extensions"]
    return name, packed


def _decode_view(module: Any, data: bytes, count: int, stride: int, mode: str, filter_: str) -> bytes:
    """Return the bytes of a view that meshopt compressed."""
    if mode != "ATTRIBUTES":
        decode = {"TRIANGLES": module.decode_index_buffer, "INDICES": module.decode_index_sequence}.get(mode)
        if decode is None or stride not in (2, 4):
            raise ValueError(f"mode {mode} of {stride} bytes")
        # The package returns four bytes for each index, whatever size it is given.
        return bytes(decode(count, 4, data).astype(f"<u{stride}").tobytes())
    rows: NDArray[np.uint8] = module.decode_vertex_buffer(count, stride, data, dtype=np.dtype((np.uint8, stride)))
    filters = {
        "NONE": lambda rows, *_: rows,
        "OCTAHEDRAL": module.decode_filter_oct,
        "QUATERNION": module.decode_filter_quat,
        "EXPONENTIAL": module.decode_filter_exp,
    }
    if filter_ not in filters:
        raise ValueError(f"filter {filter_} is not known")
    return bytes(filters[filter_](rows, count, stride).tobytes())


def _decode_draco(data: bytes) -> Any:
    """Return a decoded mesh."""
    module = _import_decoder("DracoPy", "Draco", DRACO)
    try:
        mesh = module.decode(data)
    except Exception as error:  # the package raises its own bare exceptions
        raise InputError(f"the Draco data of the glTF file cannot be decoded ({error}): it is damaged") from None
    if not hasattr(mesh, "faces"):
        raise InputError("the Draco data of the glTF file has points but no faces: it is damaged")
    return mesh


def _import_decoder(package: str, method: str, extension: str) -> Any:
    try:
        return importlib.import_module(package)
    except ImportError:
        raise InputError(
            f"the glTF file is compressed ({method}, {extension}): install the package that reads it with"
            f" 'pip install {package}', or decompress the file with 'gltf-transform copy IN OUT'"
        ) from None
