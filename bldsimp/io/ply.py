"""Polygon file format (PLY): text and binary, single and double, polygons."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..scene import Mesh, Part
from .surface import Polygons, Stored, polygon_mesh
from .text import numbers

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "int64": "i8", "uint64": "u8", "float32": "f4", "float64": "f8",
}  # fmt: skip
_GEOMETRY = {"x", "y", "z", "nx", "ny", "nz"}
_UV = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"))


@dataclass
class Property:
    """A column of an element; a list where `count` names the type of its length."""

    name: str
    type: str
    count: str | None = None


@dataclass
class Element:
    """A table of the file."""

    name: str
    rows: int
    properties: list[Property] = field(default_factory=list)


@dataclass
class PlyFormat:
    """`Stored.format` of a mesh read from PLY: how to write it again."""

    encoding: str
    double: bool


@dataclass
class Columns:
    """An element's values: scalars by name; lists as lengths and values end to end."""

    scalars: dict[str, NDArray[Any]]
    lists: dict[str, tuple[NDArray[np.int64], NDArray[Any]]]


def read_ply(data: bytes, warnings: list[str]) -> list[Mesh]:
    """Read a PLY file into one mesh of one part.

    Raises
    ------
    InputError
    """
    encoding, elements, start = _header(data)
    columns = (
        _text(data[start:], elements) if encoding == "ascii" else _binary(data, start, encoding, elements)
    )
    _name_rest(elements, warnings)
    if "vertex" not in columns or not {"x", "y", "z"} <= columns["vertex"].scalars.keys():
        raise InputError("the PLY file has no points with x, y and z")
    vertex = columns["vertex"].scalars
    points = np.stack([vertex[axis].astype(np.float64) for axis in "xyz"], axis=1)
    sizes, corners, face_extra = _polygons(columns.get("face"))
    part = Part("mesh")
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32)
    mesh = polygon_mesh(
        "", points, Polygons(offsets, corners, np.zeros(len(sizes), np.int32)), [part], warnings
    )
    if {"nx", "ny", "nz"} <= vertex.keys():
        mesh.normals = np.nan_to_num(
            np.stack([vertex[axis].astype(np.float64) for axis in ("nx", "ny", "nz")], axis=1),
            posinf=0.0,
            neginf=0.0,
        )
    types = {p.name: p.type for e in elements if e.name == "vertex" for p in e.properties}
    mesh.source.format = PlyFormat(encoding, types["x"] == "f8")
    _carry(mesh.source, vertex)
    extra = [name for name in vertex if name not in _GEOMETRY]
    part.attributes = tuple(extra) + tuple(f"face {name}" for name in face_extra)
    return [mesh]


def _header(data: bytes) -> tuple[str, list[Element], int]:
    """Encoding, elements, and where the values start."""
    end = re.search(rb"\bend_header[ \t\r]*\n", data[:1_000_000])
    if not data.startswith(b"ply") or end is None:
        raise InputError("no PLY header: not a PLY file, or one that ends early")
    encoding, elements = "", []
    for line in data[: end.start()].decode("ascii", "replace").splitlines():
        words = line.split()
        try:
            if words[:1] == ["format"]:
                encoding = words[1]
            elif words[:1] == ["element"]:
                elements.append(Element(words[1], int(words[2])))
            elif words[:2] == ["property", "list"]:
                count = _TYPES[words[2]]
                if count[0] == "f":
                    raise ValueError
                elements[-1].properties.append(Property(words[4], _TYPES[words[3]], count))
            elif words[:1] == ["property"]:
                elements[-1].properties.append(Property(words[2], _TYPES[words[1]]))
        except (IndexError, KeyError, ValueError):
            raise InputError(f"the PLY header line '{line.strip()[:60]}' is not understood") from None
    if encoding not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise InputError(f"the PLY format '{encoding[:40]}' is not known")
    if any(element.rows < 0 for element in elements):
        raise InputError("the PLY header promises a negative number of rows")
    return encoding, elements, end.end()


def _short(element: Element) -> InputError:
    return InputError(f"the PLY file ends early, within its {element.rows:,} rows of '{element.name}'")


def _binary(data: bytes, place: int, encoding: str, elements: list[Element]) -> dict[str, Columns]:
    """Values of a binary file."""
    order = "<" if encoding == "binary_little_endian" else ">"
    columns = {}
    for element in elements:
        if not element.rows or not element.properties:
            sizes = [_even_lengths(element, 0)] if element.properties else []
            columns[element.name] = (
                _split(np.zeros(0, np.dtype(sizes[0])), element) if sizes else Columns({}, {})
            )
            continue
        found = _even_rows(data, place, order, element)
        if found is None:
            columns[element.name], place = _uneven_rows(data, place, order, element)
        else:
            columns[element.name] = _split(found, element)
            place += found.nbytes
    return columns


def _even_lengths(element: Element, length: int | list[int], order: str = "<") -> list[Any]:
    """Fields of a row whose lists have these lengths."""
    fields: list[Any] = []
    lengths = iter([length] * len(element.properties) if isinstance(length, int) else length)
    for number, prop in enumerate(element.properties):
        if prop.count is None:
            fields.append((f"v{number}", order + prop.type))
        else:
            fields += [
                (f"n{number}", order + prop.count),
                (f"v{number}", order + prop.type, (next(lengths),)),
            ]
    return fields


def _even_rows(data: bytes, place: int, order: str, element: Element) -> NDArray[Any] | None:
    """All rows at once, if every list is as long as in the first row; else None."""
    lengths: list[int] = []
    at = place
    for prop in element.properties:
        if prop.count is None:
            at += np.dtype(prop.type).itemsize
            continue
        size = np.dtype(prop.count).itemsize
        if at + size > len(data):
            raise _short(element)
        length = int(np.frombuffer(data, order + prop.count, 1, at)[0])
        if length < 0 or length > len(data):
            raise InputError(f"a list of the PLY element '{element.name}' has the length {length}")
        lengths.append(length)
        at += size + length * np.dtype(prop.type).itemsize
    kind = np.dtype(_even_lengths(element, lengths, order))
    if place + kind.itemsize * element.rows > len(data):
        if lengths:
            return None
        raise _short(element)
    rows = np.frombuffer(data, kind, element.rows, place)
    for number, prop in enumerate(element.properties):
        if prop.count is not None and np.any(rows[f"n{number}"] != rows[f"n{number}"][0]):
            return None
    return rows


def _split(rows: NDArray[Any], element: Element) -> Columns:
    """Columns of rows whose lists are equally long."""
    columns = Columns({}, {})
    for number, prop in enumerate(element.properties):
        values = rows[f"v{number}"]
        if prop.count is None:
            columns.scalars[prop.name] = values
        else:
            columns.lists[prop.name] = np.full(len(rows), values.shape[1]), values.reshape(-1)
    return columns


def _uneven_rows(data: bytes, place: int, order: str, element: Element) -> tuple[Columns, int]:
    """Rows one by one, and where they end: only their lengths; the values are then taken at once."""
    counts = [np.dtype(order + p.count) if p.count else None for p in element.properties]
    sizes = [np.dtype(p.type).itemsize for p in element.properties]
    byte_order: Literal["little", "big"] = "little" if order == "<" else "big"
    least = sum(size if count is None else count.itemsize for count, size in zip(counts, sizes, strict=True))
    if place + least * element.rows > len(data):
        raise _short(element)
    starts = np.empty((len(sizes), element.rows), np.int64)
    lengths = np.ones((len(sizes), element.rows), np.int64)
    for row in range(element.rows):
        for number, (count, size) in enumerate(zip(counts, sizes, strict=True)):
            length = 1
            if count is not None:
                head = data[place : place + count.itemsize]
                length = int.from_bytes(head, byte_order, signed=count.kind == "i")
                if length < 0:
                    raise InputError(f"a list of the PLY element '{element.name}' has the length {length}")
                place += count.itemsize
            starts[number, row], lengths[number, row] = place, length
            place += length * size
        if place > len(data):
            raise _short(element)
    raw = np.frombuffer(data, np.uint8)
    columns = Columns({}, {})
    for number, prop in enumerate(element.properties):
        kind = np.dtype(order + prop.type)
        size = kind.itemsize
        first = np.repeat(starts[number], lengths[number])
        ends = np.cumsum(lengths[number])
        within = np.arange(len(first)) - np.repeat(ends - lengths[number], lengths[number])
        values = raw[(first + within * size)[:, None] + np.arange(size)].reshape(-1).view(kind)
        if prop.count is None:
            columns.scalars[prop.name] = values
        else:
            columns.lists[prop.name] = lengths[number], values
    return columns, place


def _text(body: bytes, elements: list[Element]) -> dict[str, Columns]:
    """Values of a text file, in double whatever the header says: the digits are what is stored."""
    flat = numbers(body)
    columns, place = {}, 0
    for element in elements:
        columns[element.name], place = _text_rows(flat, place, element)
    return columns


def _text_rows(flat: NDArray[np.float64], place: int, element: Element) -> tuple[Columns, int]:
    """An element's columns out of the file's numbers, and where they end."""
    columns = Columns({}, {})
    props, count = element.properties, element.rows
    if not any(prop.count for prop in props):
        width = len(props)
        if place + width * count > len(flat):
            raise _short(element)
        rows = flat[place : place + width * count].reshape(count, width)
        columns.scalars = {prop.name: rows[:, i] for i, prop in enumerate(props)}
        return columns, place + width * count
    if place + count * len(props) > len(flat):
        raise _short(element)
    starts = np.empty((len(props), count), np.int64)
    lengths = np.ones((len(props), count), np.int64)
    values = flat.tolist()
    for row in range(count):
        for number, prop in enumerate(props):
            length = 1
            if prop.count is not None:
                if place >= len(values):
                    raise _short(element)
                length = int(values[place])
                if length < 0 or length > len(values):
                    raise InputError(f"a list of the PLY element '{element.name}' has the length {length}")
                place += 1
            starts[number, row], lengths[number, row] = place, length
            place += length
    if place > len(values):
        raise _short(element)
    for number, prop in enumerate(props):
        if prop.count is None:
            columns.scalars[prop.name] = flat[starts[number]]
            continue
        ends = np.cumsum(lengths[number])
        shift = np.repeat(starts[number] - (ends - lengths[number]), lengths[number])
        columns.lists[prop.name] = lengths[number], flat[np.arange(len(shift)) + shift]
    return columns, place


def _polygons(face: Columns | None) -> tuple[NDArray[np.int64], NDArray[np.int32], list[str]]:
    """Sizes and corners of the faces, and the names of what else they have."""
    if face is None:
        return np.zeros(0, np.int64), np.zeros(0, np.int32), []
    name = next((name for name in ("vertex_indices", "vertex_index") if name in face.lists), None)
    if name is None:
        raise InputError("the PLY element 'face' has no list 'vertex_indices'")
    sizes, corners = face.lists[name]
    corners = corners.astype(np.int64)
    if len(corners) and (corners.min() < 0 or corners.max() > 2**31 - 1):
        raise InputError("a PLY face names a point that does not exist: the file is damaged")
    return sizes, corners.astype(np.int32), [*face.scalars, *(key for key in face.lists if key != name)]


def _name_rest(elements: list[Element], warnings: list[str]) -> None:
    """Refuse strips; name other elements that are not read."""
    names = {element.name for element in elements if element.rows}
    if "tristrips" in names and "face" not in names:
        raise InputError("PLY triangle strips are not read: export the mesh with faces")
    for name in sorted(names - {"vertex", "face"}):
        warnings.append(f"the PLY element '{name}' was left out")


def _carry(stored: Stored, vertex: dict[str, NDArray[Any]]) -> None:
    """Keep colours and texture coordinates for other formats."""
    channels = [name for name in ("red", "green", "blue", "alpha") if name in vertex]
    if channels[:3] == ["red", "green", "blue"]:
        colors = np.stack([vertex[name].astype(np.float64) for name in channels], axis=1)
        whole = np.issubdtype(vertex["red"].dtype, np.integer) or np.nanmax(colors, initial=0.0) > 1.0
        stored.carried["COLOR_0"] = colors / 255.0 if whole else colors
    for u, v in _UV:
        if u in vertex and v in vertex:
            stored.carried["TEXCOORD_0"] = np.stack(
                [vertex[u].astype(np.float64), vertex[v].astype(np.float64)], axis=1
            )
            break
