"""Parse and write glTF 2.0 documents, text and binary: the JSON as it is, and the numbers that its accessors name."""

from __future__ import annotations

import base64
import binascii
import json
import struct
from dataclasses import dataclass
from typing import Any
from urllib.parse import unquote, unquote_to_bytes

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError, OutputError
from ...model import Values
from ..input_folder import LoadFile

COMPONENTS = {5120: "i1", 5121: "u1", 5122: "i2", 5123: "u2", 5125: "u4", 5126: "f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}

MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")

_MAGIC, _JSON, _BIN = 0x46546C67, 0x4E4F534A, 0x004E4942

Json = dict[str, Any]
"""An object of the JSON."""

ARRAYS = (
    "accessors", "animations", "bufferViews", "buffers", "cameras", "images", "materials", "meshes", "nodes",
    "samplers", "scenes", "skins", "textures",
)  # fmt: skip
"""Top-level arrays of objects."""


@dataclass
class Document:
    """A glTF file in memory.

    Attributes
    ----------
    json : dict
        As the file has it; never changed.
    buffers : list of bytes
        One per entry of ``json["buffers"]``.
    chunks : list of (int, bytes)
        Chunks of a GLB other than JSON and BIN.
    embedded : bool
        Every buffer is a data URI.
    decoded : tuple of str
        Extensions by which the file was compressed; the document is uncompressed.
    """

    json: Json
    buffers: list[bytes]
    chunks: list[tuple[int, bytes]]
    embedded: bool = False
    decoded: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse a document whose top-level members, images or buffers are not of the types that the format asks."""
        for key in ARRAYS:
            found = self.items(key)
            if not isinstance(found, list) or not all(isinstance(item, dict) for item in found):
                raise InputError(f"the glTF member '{key}' is not a list of objects: the file is damaged")
        for number, image in enumerate(self.items("images")):
            if not isinstance(image.get("uri", ""), str) or not ("uri" in image or "bufferView" in image):
                raise InputError(f"glTF image {number} has neither a URI nor a buffer view: the file is damaged")
            if "bufferView" in image:
                self._item("bufferViews", image["bufferView"])
        for number, buffer in enumerate(self.items("buffers")):
            if not isinstance(buffer.get("uri", ""), str):
                raise InputError(f"the URI of glTF buffer {number} is not text: the file is damaged")
        for key in ("extensionsUsed", "extensionsRequired"):
            names = self.json.get(key, [])
            if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
                raise InputError(f"the glTF member '{key}' is not a list of names: the file is damaged")

    def items(self, key: str) -> list[Json]:
        """Return a top-level array, empty if the file has none."""
        found: list[Json] = self.json.get(key, [])
        return found

    def join_own_buffers(self) -> bytes:
        """Return the data of the buffers without a URI."""
        own = zip(self.items("buffers"), self.buffers, strict=True)
        return b"".join(data for entry, data in own if "uri" not in entry)

    def read_accessor(self, index: int) -> NDArray[Any]:
        """Return the values of an accessor, (count, width), of its stored type, with its sparse values."""
        accessor = self._item("accessors", index)
        try:
            kind = np.dtype("<" + COMPONENTS[accessor["componentType"]])
            width, count = WIDTHS[accessor["type"]], int(accessor["count"])
        except (KeyError, TypeError, ValueError, OverflowError):
            raise InputError(f"glTF accessor {index} is not understood: the file is damaged") from None
        if count < 0:
            raise InputError(f"glTF accessor {index} has a negative count: the file is damaged")
        if "bufferView" in accessor:
            values = self._read_strided(accessor["bufferView"], accessor.get("byteOffset", 0), kind, (count, width))
        else:
            values = np.zeros((count, width), kind)
        sparse = accessor.get("sparse")
        return values if sparse is None else self._replace_sparse(values, sparse, index)

    def read_indices(self, index: int) -> NDArray[np.int64]:
        """Return the values of an accessor that name vertices, (count,)."""
        values = self.read_accessor(index)
        if values.dtype.kind != "u" or values.shape[1] != 1:
            raise InputError(f"glTF accessor {index} is not a list of unsigned whole numbers: the file is damaged")
        return values[:, 0].astype(np.int64)

    def read_numbers(self, index: int) -> Values:
        """Return the values of an accessor in double; normalized integers become fractions."""
        accessor, values = self._item("accessors", index), self.read_accessor(index)
        numbers = values.astype(np.float64)
        if accessor.get("normalized") and values.dtype.kind != "f":
            numbers = np.maximum(numbers / np.iinfo(values.dtype).max, -1.0)
        return numbers

    def find_step(self, index: int) -> float:
        """Return the distance of neighboring values of an integer accessor, 0 for floating ones."""
        accessor = self._item("accessors", index)
        kind = np.dtype(COMPONENTS[accessor["componentType"]])
        if kind.kind == "f":
            return 0.0
        return 1.0 / np.iinfo(kind).max if accessor.get("normalized") else 1.0

    def read_view(self, index: int) -> bytes:
        """Return the bytes of a buffer view."""
        buffer, start, length = self._find_view(index)
        return bytes(buffer[start : start + length])

    def _replace_sparse(self, values: NDArray[Any], sparse: Json, index: int) -> NDArray[Any]:
        """Return the values of an accessor with those that sparse ones replace."""
        try:
            where, what, shape = sparse["indices"], sparse["values"], (int(sparse["count"]), values.shape[1])
            place_kind = np.dtype("<" + COMPONENTS[where["componentType"]])
            if place_kind.kind != "u":
                raise ValueError
            places = self._read_strided(where["bufferView"], where.get("byteOffset", 0), place_kind, (shape[0], 1))
            changes = self._read_strided(what["bufferView"], what.get("byteOffset", 0), values.dtype, shape)
        except (KeyError, TypeError, ValueError):
            raise InputError(f"glTF accessor {index} is sparse in a way that is not understood") from None
        if len(places) and int(places.max()) >= len(values):
            raise InputError(f"glTF accessor {index} has a sparse index out of range: the file is damaged")
        values = values.copy()
        values[places[:, 0]] = changes
        return values

    def _read_strided(self, index: int, offset: int, kind: np.dtype[Any], shape: tuple[int, int]) -> NDArray[Any]:
        """Return rows of a buffer view, without a copy."""
        count, width = shape
        element = kind.itemsize * width
        stride = self._item("bufferViews", index).get("byteStride", element)
        if not isinstance(stride, int) or stride < element or stride % kind.itemsize:
            raise InputError(
                f"glTF buffer view {index} has a stride of {stride} for elements of {element} bytes"
                f" ({kind.itemsize} each number): the file is damaged"
            )
        needed = offset + (stride * (count - 1) + element if count else 0)
        buffer, start, length = self._find_view(index)
        if needed > length or offset < 0:
            raise InputError(f"a glTF accessor reaches beyond its buffer view {index}: the file is damaged")
        return np.ndarray(shape, kind, buffer, start + offset, (stride, kind.itemsize))

    def _find_view(self, index: int) -> tuple[bytes, int, int]:
        """Return the buffer of a view, where the view starts in it, and its length."""
        view = self._item("bufferViews", index)
        start, length, number = view.get("byteOffset", 0), view.get("byteLength", 0), view.get("buffer", -1)
        if not 0 <= number < len(self.buffers):
            raise InputError(f"glTF buffer view {index} names no buffer: the file is damaged")
        buffer = self.buffers[number]
        if start < 0 or length < 0 or start + length > len(buffer):
            raise InputError(
                f"glTF buffer view {index} ends at byte {start + length:,}"
                f" of a buffer of {len(buffer):,}: the file is truncated"
            )
        return buffer, start, length

    def _item(self, key: str, index: int) -> Json:
        """Return an entry of a top-level array."""
        items = self.items(key)
        # A truth value is a whole number to Python, but not to JSON.
        if type(index) is not int or not 0 <= index < len(items):
            raise InputError(f"glTF {key} has no entry {index}: the file is damaged")
        return items[index]


def parse_gltf(data: bytes, load: LoadFile) -> Document:
    """Parse a document, binary or text, and load the buffers next to it.

    Parameters
    ----------
    data : bytes
    load : function of a relative path
        Returns the bytes of a file beneath the document's folder, or None.

    Raises
    ------
    InputError
        If the document or a buffer is missing, damaged, or of another version.
    """
    text, binary, chunks = _split_chunks(data) if data[:4] == b"glTF" else (data, None, [])
    try:
        found = json.loads(text.decode("utf-8-sig"), parse_constant=_refuse_constant)
    except (UnicodeDecodeError, ValueError, RecursionError):
        raise InputError("the glTF file's JSON cannot be read: the file is truncated or damaged") from None
    if not isinstance(found, dict) or not isinstance(found.get("asset"), dict):
        raise InputError("the file is JSON but no glTF: it has no 'asset'")
    version = str(found["asset"].get("version", ""))
    if not version.startswith("2"):
        raise InputError(f"the file is glTF {version[:10] or 'without a version'}: convert it to glTF 2.0")
    document = Document(found, [], chunks)
    entries = document.items("buffers")
    document.buffers = [_load_buffer(entry, number, binary, load) for number, entry in enumerate(entries)]
    document.embedded = bool(entries) and all(str(e.get("uri", "")).startswith("data:") for e in entries)
    return document


def _refuse_constant(name: str) -> None:
    raise InputError(f"the glTF JSON contains {name}, which is no JSON number: the file is damaged")


def _split_chunks(data: bytes) -> tuple[bytes, bytes | None, list[tuple[int, bytes]]]:
    """Return JSON, BIN, and the other chunks of a GLB."""
    if len(data) < 20:
        raise InputError("the GLB file ends within its header: it is truncated")
    _, version, length = struct.unpack_from("<III", data)
    if version != 2:
        raise InputError(f"the GLB file has version {version}: convert it to glTF 2.0")
    if length > len(data):
        raise InputError(f"the GLB file has {len(data):,} of its {length:,} bytes: it is truncated")
    chunks, place = [], 12
    while place + 8 <= length:
        size, kind = struct.unpack_from("<II", data, place)
        body = data[place + 8 : place + 8 + size]
        if len(body) < size:
            raise InputError("a chunk of the GLB file reaches beyond its end: it is truncated")
        chunks.append((kind, body))
        place += 8 + size
    if not chunks:
        raise InputError("the GLB file has no JSON: the file is damaged")
    (first, text), *rest = chunks
    if first != _JSON:
        raise InputError("the first chunk of the GLB file is not JSON: the file is damaged")
    place = next((number for number, (kind, _) in enumerate(rest) if kind == _BIN), -1)
    return text, rest.pop(place)[1] if place >= 0 else None, rest


def _load_buffer(entry: Json, number: int, binary: bytes | None, load: LoadFile) -> bytes:
    """Return the bytes of a buffer."""
    uri = str(entry.get("uri", ""))
    if uri:
        found = load_uri(uri, load)
        if found is None and uri.startswith("data:"):
            raise InputError(f"the data URI of glTF buffer {number} cannot be decoded: the file is damaged")
        if found is None:
            raise InputError(
                f"glTF buffer '{unquote(uri)[:80]}' is not a file beneath the input's folder: put it there"
            )
    elif number == 0 and binary is not None:
        found = binary
    elif any(key in MESHOPT for key in entry.get("extensions", {})):
        # A place to decode to, without data of its own.
        return b""
    else:
        raise InputError(f"glTF buffer {number} has neither a URI nor a binary chunk: the file is damaged")
    if len(found) < entry.get("byteLength", 0):
        raise InputError(
            f"glTF buffer {number} has {len(found):,} of its {entry['byteLength']:,} bytes: it is truncated"
        )
    return found


def load_image(document: Document, index: int, load: LoadFile) -> bytes | None:
    """Return the bytes of an image, or None if they cannot be read."""
    image = document.items("images")[index]
    if "bufferView" in image:
        return document.read_view(image["bufferView"])
    return load_uri(image.get("uri", ""), load)


def load_uri(uri: str, load: LoadFile) -> bytes | None:
    """Return the bytes that a URI names or contains, or None if they cannot be read."""
    return _parse_data_uri(uri) if uri.startswith("data:") else load(unquote(uri))


def _parse_data_uri(uri: str) -> bytes | None:
    """Return the bytes that a data URI contains, or None if it cannot be decoded."""
    head, comma, body = uri.partition(",")
    if not comma:
        return None
    try:
        data = unquote_to_bytes(body)
        return base64.b64decode(data, validate=True) if head.endswith(";base64") else data
    except (binascii.Error, UnicodeEncodeError):
        return None


def copy_json(value: Any) -> Any:
    """Copy JSON as deep as it could be read.

    Raises
    ------
    InputError
        If the JSON is so deep that it could be read only just.
    """
    try:
        return json.loads(json.dumps(value))
    except RecursionError:
        raise InputError("the glTF JSON is nested too deep: the file is damaged") from None


def pack_glb(json_: Json, binary: bytes, chunks: list[tuple[int, bytes]]) -> bytes:
    """Return the GLB file of a document whose only buffer is the binary chunk."""
    text = write_json(json_, compact=True)
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    written = [(_JSON, text), *([(_BIN, binary)] if binary else []), *chunks]
    parts = [part for kind, data in written for part in (struct.pack("<II", len(data), kind), data)]
    return b"".join([struct.pack("<III", _MAGIC, 2, 12 + sum(map(len, parts))), *parts])


def write_json(json_: Json, compact: bool) -> bytes:
    """Return a document's JSON as UTF-8.

    Raises
    ------
    OutputError
        If it is nested too deep, or holds a number beyond double precision.
    """
    style: Json = {"separators": (",", ":")} if compact else {"indent": 2}
    try:
        return json.dumps(json_, ensure_ascii=False, allow_nan=False, **style).encode("utf-8")
    except UnicodeEncodeError:
        # Half of a surrogate pair, which JSON can name, but UTF-8 cannot write.
        return json.dumps(json_, allow_nan=False, **style).encode("ascii")
    except RecursionError:
        raise OutputError("the glTF JSON is nested too deep: flatten the input") from None
    except ValueError:
        raise OutputError("the glTF JSON contains a number beyond double precision: repair the input") from None
