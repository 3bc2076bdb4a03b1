"""glTF 2.0 documents, text and binary: the JSON as it is, and the numbers its accessors name."""

from __future__ import annotations

import base64
import binascii
import json
import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any
from urllib.parse import unquote, unquote_to_bytes

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError, OutputError

Beside = Callable[[str], bytes | None]

COMPONENTS = {5120: "i1", 5121: "u1", 5122: "i2", 5123: "u2", 5125: "u4", 5126: "f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
FLOAT = 5126

MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")

_MAGIC, _JSON, _BIN = 0x46546C67, 0x4E4F534A, 0x004E4942


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
        Chunks of a GLB beside JSON and BIN.
    embedded : bool
        Every buffer is a data URI.
    unpacked : tuple of str
        Extensions by which the file was compressed; the document is what it stands for.
    data : bytes
        The file itself.
    """

    json: dict[str, Any]
    buffers: list[bytes]
    chunks: list[tuple[int, bytes]]
    embedded: bool = False
    unpacked: tuple[str, ...] = ()
    data: bytes = b""

    def __post_init__(self) -> None:
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
                raise InputError(f"the URI of glTF buffer {number} is no text: the file is damaged")
        for key in ("extensionsUsed", "extensionsRequired"):
            names = self.json.get(key, [])
            if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
                raise InputError(f"the glTF member '{key}' is not a list of names: the file is damaged")

    def items(self, key: str) -> list[dict[str, Any]]:
        """A top-level array, empty where the file has none."""
        found: list[dict[str, Any]] = self.json.get(key, [])
        return found

    @property
    def is_compact(self) -> bool:
        """Whether the file is text on one line."""
        return self.data[:4] != b"glTF" and b"\n" not in self.data.strip()

    def is_same(self, json_: dict[str, Any], binary: bytes) -> bool:
        """Whether a document of this JSON, and of this data where its buffers have no URI, is what the file stores."""
        own = zip(self.items("buffers"), self.buffers, strict=True)
        return not self.unpacked and json_ == self.json and binary == b"".join(b for one, b in own if "uri" not in one)

    def accessor(self, index: int) -> NDArray[Any]:
        """Values of an accessor, (count, width), of its stored type, sparse values put in."""
        accessor = self._item("accessors", index)
        try:
            kind = np.dtype("<" + COMPONENTS[accessor["componentType"]])
            width, count = WIDTHS[accessor["type"]], int(accessor["count"])
        except (KeyError, TypeError, ValueError, OverflowError):
            raise InputError(f"glTF accessor {index} is not understood: the file is damaged") from None
        if count < 0:
            raise InputError(f"glTF accessor {index} has a negative count: the file is damaged")
        if "bufferView" in accessor:
            values = self._strided(accessor["bufferView"], accessor.get("byteOffset", 0), kind, (count, width))
        else:
            values = np.zeros((count, width), kind)
        sparse = accessor.get("sparse")
        if sparse is not None:
            values = values.copy()
            places, changes = self._sparse(sparse, kind, width, index)
            if len(places) and int(places.max()) >= count:
                raise InputError(f"glTF accessor {index} has a sparse index out of range: the file is damaged")
            values[places] = changes
        return values

    def indices(self, index: int) -> NDArray[np.int64]:
        """Values of an accessor that name vertices, (count,)."""
        values = self.accessor(index)
        if values.dtype.kind != "u" or values.shape[1] != 1:
            raise InputError(f"glTF accessor {index} is no list of whole numbers without sign: the file is damaged")
        return values[:, 0].astype(np.int64)

    def numbers(self, index: int) -> NDArray[np.float64]:
        """Values of an accessor in double, integers made fractions where they are normalized."""
        accessor, values = self._item("accessors", index), self.accessor(index)
        numbers = values.astype(np.float64)
        if accessor.get("normalized") and values.dtype.kind != "f":
            numbers = np.maximum(numbers / np.iinfo(values.dtype).max, -1.0)
        return numbers

    def step(self, index: int) -> float:
        """Distance of neighbouring values of an integer accessor; 0 for floating ones."""
        accessor = self._item("accessors", index)
        kind = np.dtype(COMPONENTS[accessor["componentType"]])
        if kind.kind == "f":
            return 0.0
        return 1.0 / np.iinfo(kind).max if accessor.get("normalized") else 1.0

    def view(self, index: int) -> bytes:
        """The bytes of a buffer view."""
        view = self._item("bufferViews", index)
        start, length = view.get("byteOffset", 0), view.get("byteLength", 0)
        return bytes(self._buffer(view, index, start, length)[start : start + length])

    def _sparse(
        self, sparse: dict[str, Any], kind: np.dtype[Any], width: int, index: int
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        try:
            where, what, count = sparse["indices"], sparse["values"], int(sparse["count"])
            place_kind = np.dtype("<" + COMPONENTS[where["componentType"]])
            if place_kind.kind != "u":
                raise ValueError
            places = self._strided(where["bufferView"], where.get("byteOffset", 0), place_kind, (count, 1))
            changes = self._strided(what["bufferView"], what.get("byteOffset", 0), kind, (count, width))
        except (KeyError, TypeError, ValueError):
            raise InputError(f"glTF accessor {index} is sparse in a way that is not understood") from None
        return places[:, 0], changes

    def _strided(self, index: int, offset: int, kind: np.dtype[Any], shape: tuple[int, int]) -> NDArray[Any]:
        view = self._item("bufferViews", index)
        count, width = shape
        element = kind.itemsize * width
        stride = view.get("byteStride", element)
        if not isinstance(stride, int) or stride < element or stride % kind.itemsize:
            raise InputError(
                f"glTF buffer view {index} has a stride of {stride} for elements of {element} bytes"
                f" ({kind.itemsize} each number): the file is damaged"
            )
        needed = offset + (stride * (count - 1) + element if count else 0)
        start, length = view.get("byteOffset", 0), view.get("byteLength", 0)
        buffer = self._buffer(view, index, start, length)
        if needed > length or offset < 0:
            raise InputError(f"a glTF accessor reaches beyond its buffer view {index}: the file is damaged")
        return np.ndarray(shape, kind, buffer, start + offset, (stride, kind.itemsize))

    def _buffer(self, view: dict[str, Any], index: int, start: int, length: int) -> bytes:
        number = view.get("buffer", -1)
        if not 0 <= number < len(self.buffers):
            raise InputError(f"glTF buffer view {index} names no buffer: the file is damaged")
        buffer = self.buffers[number]
        if start < 0 or length < 0 or start + length > len(buffer):
            raise InputError(
                f"glTF buffer view {index} ends at byte {start + length:,}"
                f" of a buffer of {len(buffer):,}: the file is truncated"
            )
        return bytes(buffer)

    def _item(self, key: str, index: int) -> dict[str, Any]:
        items = self.items(key)
        # A truth value is a whole number to Python, but not to JSON.
        if type(index) is not int or not 0 <= index < len(items):
            raise InputError(f"glTF {key} has no entry {index}: the file is damaged")
        return items[index]


def parse_gltf(data: bytes, beside: Beside) -> Document:
    """Read a document, binary or text, with the buffers beside it.

    Parameters
    ----------
    data : bytes
    beside : function of a relative path
        Gives the bytes of a file beneath the document's folder, or None.

    Raises
    ------
    InputError
    """
    text, binary, chunks = _glb_chunks(data) if data[:4] == b"glTF" else (data, None, [])
    try:
        found = json.loads(text.decode("utf-8-sig"), parse_constant=_no_number)
    except (UnicodeDecodeError, ValueError, RecursionError):
        raise InputError("the glTF file's JSON cannot be read: the file is truncated or damaged") from None
    if not isinstance(found, dict) or not isinstance(found.get("asset"), dict):
        raise InputError("the file is JSON but no glTF: it has no 'asset'")
    version = str(found["asset"].get("version", ""))
    if not version.startswith("2"):
        raise InputError(f"the file is glTF {version[:10] or 'without a version'}: convert it to glTF 2.0")
    document = Document(found, [], chunks, data=data)
    entries = document.items("buffers")
    document.buffers = [_buffer(entry, number, binary, beside) for number, entry in enumerate(entries)]
    document.embedded = bool(entries) and all(str(e.get("uri", "")).startswith("data:") for e in entries)
    return document


def _no_number(name: str) -> None:
    raise InputError(f"the glTF JSON holds {name}, which is no JSON number: the file is damaged")


def _glb_chunks(data: bytes) -> tuple[bytes, bytes | None, list[tuple[int, bytes]]]:
    """JSON, BIN, and other chunks of a GLB."""
    if len(data) < 20:
        raise InputError("the GLB file ends within its header: it is truncated")
    _, version, length = struct.unpack_from("<III", data)
    if version != 2:
        raise InputError(f"the GLB file has version {version}: convert it to glTF 2.0")
    if length > len(data):
        raise InputError(f"the GLB file has {len(data):,} of its {length:,} bytes: it is truncated")
    text, binary, chunks, place = None, None, [], 12
    while place + 8 <= length:
        size, kind = struct.unpack_from("<II", data, place)
        body = data[place + 8 : place + 8 + size]
        if len(body) < size:
            raise InputError("a chunk of the GLB file reaches beyond its end: it is truncated")
        if text is None:
            text = body if kind == _JSON else None
            if text is None:
                raise InputError("the first chunk of the GLB file is not JSON: the file is damaged")
        elif kind == _BIN and binary is None:
            binary = body
        else:
            chunks.append((kind, body))
        place += 8 + size
    if text is None:
        raise InputError("the GLB file has no JSON: the file is damaged")
    return text, binary, chunks


def _buffer(entry: dict[str, Any], number: int, binary: bytes | None, beside: Beside) -> bytes:
    """The bytes of a buffer."""
    uri = str(entry.get("uri", ""))
    if not uri:
        if number == 0 and binary is not None:
            found: bytes | None = binary
        elif any(key in MESHOPT for key in entry.get("extensions", {})):
            # A place to unpack to, without data of its own.
            return b""
        else:
            raise InputError(f"glTF buffer {number} has neither a URI nor a binary chunk: the file is damaged")
    else:
        found = data_uri(uri) if uri.startswith("data:") else beside(unquote(uri))
    if found is None and uri.startswith("data:"):
        raise InputError(f"the data URI of glTF buffer {number} cannot be decoded: the file is damaged")
    if found is None:
        raise InputError(f"glTF buffer '{unquote(uri)[:80]}' is no file beneath the input's folder: put it there")
    if len(found) < entry.get("byteLength", 0):
        raise InputError(
            f"glTF buffer {number} has {len(found):,} of its {entry['byteLength']:,} bytes: it is truncated"
        )
    return found


def image_bytes(document: Document, index: int, beside: Beside) -> bytes | None:
    """The bytes of an image, or None where there are none to be had."""
    image = document.items("images")[index]
    uri = image.get("uri", "")
    if "bufferView" in image:
        return document.view(image["bufferView"])
    return data_uri(uri) if uri.startswith("data:") else beside(unquote(uri))


def data_uri(uri: str) -> bytes | None:
    """The bytes that a data URI holds, or None where it cannot be decoded."""
    head, comma, body = uri.partition(",")
    if not comma:
        return None
    try:
        data = unquote_to_bytes(body)
        return base64.b64decode(data, validate=True) if head.endswith(";base64") else data
    except (binascii.Error, UnicodeEncodeError):
        return None


def copied(value: Any) -> Any:
    """A copy of JSON, as deep as it could be read.

    Raises
    ------
    InputError
        Where it could be read only just.
    """
    try:
        return json.loads(json.dumps(value))
    except RecursionError:
        raise InputError("the glTF JSON is nested too deep: the file is damaged") from None


def pack_glb(json_: dict[str, Any], binary: bytes, chunks: list[tuple[int, bytes]]) -> bytes:
    """A GLB file of a document whose only buffer is the binary chunk."""
    text = gltf_text(json_, compact=True)
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    parts = [struct.pack("<II", len(text), _JSON), text]
    if binary:
        parts += [struct.pack("<II", len(binary), _BIN), binary]
    for kind, body in chunks:
        parts += [struct.pack("<II", len(body), kind), body]
    return b"".join([struct.pack("<III", _MAGIC, 2, 12 + sum(map(len, parts))), *parts])


def gltf_text(json_: dict[str, Any], compact: bool) -> bytes:
    """A document's JSON as UTF-8."""
    style: dict[str, Any] = {"separators": (",", ":")} if compact else {"indent": 2}
    try:
        return json.dumps(json_, ensure_ascii=False, allow_nan=False, **style).encode("utf-8")
    except UnicodeEncodeError:
        # Half of a surrogate pair, which JSON can name, but UTF-8 cannot write.
        return json.dumps(json_, allow_nan=False, **style).encode("ascii")
    except RecursionError:
        raise OutputError("the glTF JSON is nested too deep: flatten the input") from None
    except ValueError:
        raise OutputError("the glTF JSON holds a number beyond double precision: repair the input") from None
