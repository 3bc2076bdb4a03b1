"""The values of a PLY file's elements, column by column, from text or binary."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .text import numbers


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
class Columns:
    """An element's values: scalars by name; lists as lengths and values end to end."""

    scalars: dict[str, NDArray[Any]]
    lists: dict[str, tuple[NDArray[np.int64], NDArray[Any]]]


def _short(element: Element) -> InputError:
    return InputError(f"the PLY file ends early, within its {element.rows:,} rows of '{element.name}'")


def binary_columns(data: bytes, place: int, encoding: str, elements: list[Element]) -> dict[str, Columns]:
    """Values of a binary file."""
    order = "<" if encoding == "binary_little_endian" else ">"
    columns = {}
    for element in elements:
        if not element.rows or not element.properties:
            sizes = [_even_lengths(element, 0)] if element.properties else []
            columns[element.name] = _split(np.zeros(0, np.dtype(sizes[0])), element) if sizes else Columns({}, {})
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


def text_columns(body: bytes, elements: list[Element]) -> dict[str, Columns]:
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
