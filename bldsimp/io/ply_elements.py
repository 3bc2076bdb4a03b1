"""Read and write the header and the element tables of PLY files, text or binary."""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .polygons import index_slices
from .text_numbers import parse_numbers

ENCODINGS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}
"""Encodings of the values, and the byte order that NumPy has for each."""

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "int64": "i8", "uint64": "u8", "float32": "f4", "float64": "f8",
}  # fmt: skip
_NAMES = {kind: name for name, kind in reversed(_TYPES.items())}
_LENGTHS = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "i8": "q", "u8": "Q", "f8": "d"}
"""What `struct` calls the types of the lengths of lists."""

_TEXTURE = re.compile(rb"^comment[ \t]+TextureFile[ \t]+(.+?)[ \t\r]*$", re.MULTILINE | re.IGNORECASE)

Column = tuple[str, str, NDArray[Any]]
"""A column to write: name, type, and values; two-dimensional values are lists, a row each."""


@dataclass(frozen=True)
class Property:
    """A column of an element; a list if `count` names the type of its length."""

    name: str
    type: str
    count: str | None = None


@dataclass
class Element:
    """A table of the file.

    Attributes
    ----------
    name : str
    rows : int
    properties : list of Property
    scalars : dict of str to array
        Values by the name of the property.
    lists : dict of str to (array, array)
        Lengths, and values end to end.
    """

    name: str
    rows: int
    properties: list[Property] = field(default_factory=list)
    scalars: dict[str, NDArray[Any]] = field(default_factory=dict)
    lists: dict[str, tuple[NDArray[np.int64], NDArray[Any]]] = field(default_factory=dict)

    @property
    def types(self) -> dict[str, str]:
        """Return the type of each property."""
        return {one.name: one.type for one in self.properties}


@dataclass
class Header:
    """The header of a PLY file.

    Attributes
    ----------
    encoding : str
        A key of `ENCODINGS`.
    elements : list of Element
    start : int
        Where the values start; bytes.
    textures : list of str
        Files that comments name.
    """

    encoding: str
    elements: list[Element]
    start: int
    textures: list[str]


def _read_header(data: bytes) -> Header:
    """Read the header of a PLY file, without values."""
    end = re.search(rb"\bend_header[ \t\r]*\n", data[:1_000_000])
    if not data.startswith(b"ply") or end is None:
        raise InputError("no PLY header: not a PLY file, or one that ends early")
    encoding, elements = "", list[Element]()
    for line in data[: end.start()].decode("ascii", "replace").splitlines():
        words = line.split()
        try:
            if words[:1] == ["format"]:
                encoding = words[1]
            elif words[:1] == ["element"]:
                elements.append(Element(words[1], int(words[2])))
            elif words[:1] == ["property"]:
                elements[-1].properties.append(_parse_property(words))
        except (IndexError, KeyError, ValueError):
            raise InputError(f"the PLY header line '{line.strip()[:60]}' is not understood") from None
    if encoding not in ENCODINGS:
        raise InputError(f"the PLY format '{encoding[:40]}' is not known")
    if any(element.rows < 0 for element in elements):
        raise InputError("the PLY header promises a negative number of rows")
    textures = [name.decode("utf-8", "surrogateescape") for name in _TEXTURE.findall(data[: end.start()])]
    return Header(encoding, elements, end.end(), textures)


def _parse_property(words: list[str]) -> Property:
    """Parse a property line; a list counts its values in whole numbers."""
    if words[1] != "list":
        return Property(words[2], _TYPES[words[1]])
    if _TYPES[words[2]].startswith("f"):
        raise ValueError
    return Property(words[4], _TYPES[words[3]], _TYPES[words[2]])


def read_elements(data: bytes) -> Header:
    """Read the header of a PLY file, and the values of its elements.

    Raises
    ------
    InputError
        If the header is damaged or of a kind that is not known, the file ends early, or a list has an impossible
        length.
    """
    header = _read_header(data)
    place, text = header.start, header.encoding == "ascii"
    if text:
        data, place = parse_numbers(data[place:]).tobytes(), 0
    for element in header.elements:
        props = element.properties
        if text:
            # Text becomes doubles, whatever the header says: the digits are what is stored.
            props = [Property(one.name, "f8", one.count and "f8") for one in props]
        columns, lengths, place = _read_rows(data, place, ENCODINGS[header.encoding], element, props)
        for one, values, length in zip(props, columns, lengths, strict=True):
            if one.count is None:
                element.scalars[one.name] = values
            else:
                element.lists[one.name] = length, values
    return header


def _read_rows(
    data: bytes, place: int, order: str, element: Element, props: list[Property]
) -> tuple[list[NDArray[Any]], NDArray[np.int64], int]:
    """Return the values of each property end to end, how many there are in each row, (p, rows), and where all end.

    Rows whose lists are equally long are read all at once.
    """
    count = element.rows if props else 0
    sizes = [np.dtype(one.count or one.type).itemsize for one in props]
    if place + sum(sizes) * count > len(data):
        raise _ends_early(element)
    _, lengths, _ = _find_lists(data, place, order, element, props, min(count, 1))
    kind = _lay_out_row(props, [int(own.sum()) for own in lengths], order)
    if place + kind.itemsize * count <= len(data):
        rows = np.frombuffer(data, kind, count, place) if count else np.zeros(0, kind)
        if all(np.all(rows[f"n{i}"] == lengths[i]) for i, one in enumerate(props) if one.count):
            columns = [rows[f"v{i}"].reshape(-1) for i in range(len(props))]
            return columns, np.repeat(lengths[:, :1], count, axis=1), place + rows.nbytes
    starts, lengths, end = _find_lists(data, place, order, element, props, count)
    raw, columns = np.frombuffer(data, np.uint8), []
    for one, start, length in zip(props, starts, lengths, strict=True):
        own = np.dtype(order + one.type)
        columns.append(raw[index_slices(start, length * own.itemsize)].view(own))
    return columns, lengths, end


def _lay_out_row(props: list[Property], lengths: list[int], order: str) -> np.dtype[Any]:
    """Return the type of a row whose lists have these lengths: fields v0, v1 ..., before lists n0, n1 ..."""
    fields: list[Any] = []
    for number, (one, length) in enumerate(zip(props, lengths, strict=True)):
        if one.count is None:
            fields.append((f"v{number}", order + one.type))
        else:
            fields += [(f"n{number}", order + one.count), (f"v{number}", order + one.type, (length,))]
    return np.dtype(fields)


def _find_lists(
    data: bytes, place: int, order: str, element: Element, props: list[Property], rows: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], int]:
    """Return where the values of each property start in each row, how many there are, (p, rows), and where all end."""
    steps = [
        (np.dtype(one.type).itemsize, struct.Struct(order + _LENGTHS[one.count]) if one.count else None)
        for one in props
    ]
    starts = np.empty((len(steps), rows), np.int64)
    lengths = np.ones((len(steps), rows), np.int64)
    for row in range(rows):
        for number, (size, count) in enumerate(steps):
            length = 1
            if count is not None:
                if place + count.size > len(data):
                    raise _ends_early(element)
                (value,) = count.unpack_from(data, place)
                # No number, as text may have it, is out of any range.
                if not 0 <= value <= len(data):
                    raise InputError(f"a list of the PLY element '{element.name}' has the length {value:g}")
                length = int(value)
                place += count.size
            starts[number, row], lengths[number, row] = place, length
            place += length * size
    if place > len(data):
        raise _ends_early(element)
    return starts, lengths, place


def _ends_early(element: Element) -> InputError:
    return InputError(f"the PLY file ends early, within its {element.rows:,} rows of '{element.name}'")


def write_elements(encoding: str, textures: list[str], elements: dict[str, list[Column]]) -> bytes:
    """Write a PLY file.

    Parameters
    ----------
    encoding : str
        A key of `ENCODINGS`.
    textures : list of str
        Files to name in comments.
    elements : dict of str to list of Column
        By name; text has the shortest digits that read back exactly in double.
    """
    lines = ["ply", f"format {encoding} 1.0", *(f"comment TextureFile {name}" for name in textures)]
    for element, columns in elements.items():
        lines.append(f"element {element} {len(columns[0][2])}")
        for name, kind, values in columns:
            lines.append(f"property {'list uchar ' * (values.ndim - 1)}{_NAMES[kind]} {name}")
    write = _write_text if encoding == "ascii" else _write_binary
    body = [write(columns, ENCODINGS[encoding]) for columns in elements.values()]
    return b"".join(["\n".join([*lines, "end_header", ""]).encode("utf-8", "surrogateescape"), *body])


def _write_text(columns: list[Column], _: str) -> bytes:
    """Write a line for each row."""
    numbers: list[list[Any]] = []
    for _, kind, values in columns:
        if values.ndim > 1:
            numbers.append([values.shape[1]] * len(values))
        numbers += np.atleast_2d((values if kind.startswith("f") else values.astype(int)).T).tolist()
    return "".join(" ".join(map(repr, row)) + "\n" for row in zip(*numbers, strict=True)).encode("ascii")


def _write_binary(columns: list[Column], order: str) -> bytes:
    """Write the rows as they lie in memory."""
    props = [Property(name, kind, "u1" if values.ndim > 1 else None) for name, kind, values in columns]
    rows = np.empty(len(columns[0][2]), _lay_out_row(props, [values.shape[-1] for _, _, values in columns], order))
    for number, (_, _, values) in enumerate(columns):
        if values.ndim > 1:
            rows[f"n{number}"] = values.shape[1]
        rows[f"v{number}"] = values
    return rows.tobytes()
