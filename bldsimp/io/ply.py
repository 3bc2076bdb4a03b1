"""Polygon file format (PLY): text and binary, single and double, polygons."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..scene import Mesh, Part
from .ply_values import Columns, Element, Property, binary_columns, text_columns
from .surface import Polygons, Stored, polygon_mesh

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "int64": "i8", "uint64": "u8", "float32": "f4", "float64": "f8",
}  # fmt: skip
_GEOMETRY = {"x", "y", "z", "nx", "ny", "nz"}
_UV = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"))


@dataclass
class PlyFormat:
    """`Stored.format` of a mesh read from PLY: how to write it again."""

    encoding: str
    double: bool


def read_ply(data: bytes, warnings: list[str]) -> list[Mesh]:
    """Read a PLY file into one mesh of one part.

    Raises
    ------
    InputError
    """
    encoding, elements, start = _header(data)
    columns = (
        text_columns(data[start:], elements)
        if encoding == "ascii"
        else binary_columns(data, start, encoding, elements)
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
