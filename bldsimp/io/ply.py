"""Polygon file format (PLY): text and binary, single and double, polygons."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..model import Attribute, Indices, Mesh, Part, attach_attributes, color_attribute, custom_attribute
from ..unique_rows import find_unique_rows
from .folder import Folder
from .ply_values import Columns, Element, Property, binary_columns, text_columns
from .surface import Material, Polygons, file_stem, polygon_mesh, uv_attribute

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "int64": "i8", "uint64": "u8", "float32": "f4", "float64": "f8",
}  # fmt: skip
_NORMAL = ("nx", "ny", "nz")
_COLORS = ("red", "green", "blue", "alpha")
_UV = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"))
_WEDGES = ("texcoord", "texture_coordinates")
_TEXTURE = re.compile(rb"^comment[ \t]+TextureFile[ \t]+(.+?)[ \t\r]*$", re.MULTILINE | re.IGNORECASE)


@dataclass(frozen=True)
class Bundle:
    """Properties of an element that make up one attribute, their types, and what is stored for a value of 1."""

    properties: tuple[str, ...]
    types: tuple[str, ...]
    scale: float = 1.0


@dataclass
class PlyFormat:
    """`Mesh.source` of a mesh read from PLY: how to write it again.

    Attributes
    ----------
    encoding : str
    double : bool
        Positions are double.
    bundles : dict of str to Bundle
        By name of the attribute; ``NORMAL`` is one of them.
    wedges : bool
        Faces have the texture coordinates of their corners.
    """

    encoding: str
    double: bool
    bundles: dict[str, Bundle] = field(default_factory=dict)
    wedges: bool = False


def read_ply(data: bytes, beside: Folder, warnings: list[str]) -> list[Mesh]:
    """Read a PLY file into one mesh; each texture that it names is a part.

    Parameters
    ----------
    data : bytes
    beside : Folder
        Where the PLY file is.
    warnings : list of str
        Told what is left out.

    Raises
    ------
    InputError
    """
    encoding, elements, start, textures = _header(data)
    columns = (
        text_columns(data[start:], elements) if encoding == "ascii" else binary_columns(data, start, encoding, elements)
    )
    _name_rest(elements, warnings)
    if "vertex" not in columns or not {"x", "y", "z"} <= columns["vertex"].scalars.keys():
        raise InputError("the PLY file has no points with x, y and z")
    types = {element.name: {p.name: p.type for p in element.properties} for element in elements}
    face = columns.get("face", Columns({}, {}))
    sizes, corners = _polygons(columns.get("face"))
    vertex, corners, wedges = _with_wedges(columns["vertex"].scalars, face, sizes, corners)
    parts, part = _parts(face.scalars, textures, len(sizes))
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32)
    mesh, polygon = polygon_mesh(
        "", _stacked(vertex, ("x", "y", "z")), Polygons(offsets, corners, part), parts, warnings
    )
    mesh.source = PlyFormat(encoding, types["vertex"]["x"] == "f8", wedges=wedges is not None)
    if set(_NORMAL) <= vertex.keys():
        mesh.normals = np.nan_to_num(_stacked(vertex, _NORMAL), posinf=0.0, neginf=0.0)
        mesh.source.bundles["NORMAL"] = Bundle(_NORMAL, tuple(types["vertex"][name] for name in _NORMAL))
    attributes = [] if wedges is None else [uv_attribute(wedges, parts, beside.picture)]
    attributes += _vertex_attributes(mesh, vertex, types["vertex"], beside, wedges is None)
    if face.scalars:
        attributes += _face_attributes(mesh, face.scalars, types["face"], polygon, bool(textures))
    attach_attributes(mesh, attributes)
    return [mesh]


def _vertex_attributes(
    mesh: Mesh,
    vertex: dict[str, NDArray[Any]],
    types: dict[str, str],
    beside: Folder,
    textured: bool,
) -> list[Attribute]:
    """Colours, texture coordinates and all other columns of the points."""
    rest = [name for name in vertex if name not in ("x", "y", "z", *_NORMAL)]
    attributes, rest = _colors(mesh, vertex, types, rest, None)
    pair = next((pair for pair in _UV if set(pair) <= set(rest)), None) if textured else None
    if pair is not None:
        attributes.append(uv_attribute(_stacked(vertex, pair), mesh.parts, beside.picture))
        mesh.source.bundles["TEXCOORD_0"] = Bundle(pair, tuple(types[name] for name in pair))
        rest = [name for name in rest if name not in pair]
    return attributes + _customs(mesh, vertex, types, rest, None)


def _face_attributes(
    mesh: Mesh, face: dict[str, NDArray[Any]], types: dict[str, str], polygon: Indices, textured: bool
) -> list[Attribute]:
    """Colours and all other columns of the faces; their normals follow from their corners."""
    rest = [name for name in face if name not in _NORMAL and not (textured and name == "texnumber")]
    attributes, rest = _colors(mesh, face, types, rest, polygon)
    return attributes + _customs(mesh, face, types, rest, polygon)


def _colors(
    mesh: Mesh, columns: dict[str, NDArray[Any]], types: dict[str, str], names: list[str], polygon: Indices | None
) -> tuple[list[Attribute], list[str]]:
    """Colours of points, or of the polygons that faces were cut out of; and the columns that are left."""
    channels = tuple(name for name in _COLORS if name in names)
    if channels[:3] != _COLORS[:3]:
        return [], names
    values = _stacked(columns, channels)
    kind = np.dtype(types["red"])
    scale = float(np.iinfo(kind).max if kind.kind == "u" and kind.itemsize < 4 else 255)
    if kind.kind == "f" and np.nanmax(values, initial=0.0) <= 1.0:
        scale = 1.0
    values = (values if polygon is None else values[polygon]) / scale
    own = color_attribute(values, mesh, on_faces=polygon is not None)
    mesh.source.bundles[own.name] = Bundle(channels, tuple(types[name] for name in channels), scale)
    return [own], [name for name in names if name not in channels]


def _customs(
    mesh: Mesh, columns: dict[str, NDArray[Any]], types: dict[str, str], names: list[str], polygon: Indices | None
) -> list[Attribute]:
    """An attribute for each other column of points, or of the polygons that faces were cut out of."""
    found = []
    for name in names:
        values = _stacked(columns, (name,))
        one = custom_attribute(
            f"_{name}", values if polygon is None else values[polygon], mesh,
            whole=types[name][0] != "f", on_faces=polygon is not None,
        )  # fmt: skip
        mesh.source.bundles[one.name] = Bundle((name,), (types[name],))
        found.append(one)
    return found


def _stacked(columns: dict[str, NDArray[Any]], names: tuple[str, ...]) -> NDArray[np.float64]:
    return np.stack([columns[name].astype(np.float64) for name in names], axis=1)


def _with_wedges(
    vertex: dict[str, NDArray[Any]], face: Columns, sizes: NDArray[np.int64], corners: NDArray[np.int32]
) -> tuple[dict[str, NDArray[Any]], NDArray[np.int32], NDArray[np.float64] | None]:
    """Points and corners such that each point has one texture coordinate, and those, where faces have them."""
    name = next((name for name in _WEDGES if name in face.lists), None)
    if name is None or not len(corners):
        return vertex, corners, None
    lengths, values = face.lists[name]
    uv = np.full((len(corners), 2), np.nan)
    full = lengths == 2 * sizes
    uv[np.repeat(full, sizes)] = values[np.repeat(full, lengths)].reshape(-1, 2)
    if not full.any() or np.any((corners < 0) | (corners >= len(vertex["x"]))):
        return vertex, corners, None
    first, inverse = find_unique_rows(np.column_stack([corners, uv]))
    return {key: column[corners[first]] for key, column in vertex.items()}, inverse.astype(np.int32), uv[first]


def _parts(face: dict[str, NDArray[Any]], textures: list[str], count: int) -> tuple[list[Part], NDArray[np.int32]]:
    """A part for each texture that faces have, and the part of each face."""
    materials = [Material(file_stem(name), texture=name) for name in textures]
    if not materials or "texnumber" not in face:
        return [Part("mesh", source=materials[0] if materials else None)], np.zeros(count, np.int32)
    numbers, part = np.unique(face["texnumber"].astype(np.int64), return_inverse=True)
    own = [materials[number] if 0 <= number < len(materials) else None for number in numbers]
    parts = [Part(one.name if one else "no texture", source=one) for one in own]
    return parts, part.reshape(-1).astype(np.int32)


def _header(data: bytes) -> tuple[str, list[Element], int, list[str]]:
    """Encoding, elements, where the values start, and the textures that comments name."""
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
    textures = [name.decode("utf-8", "surrogateescape") for name in _TEXTURE.findall(data[: end.start()])]
    return encoding, elements, end.end(), textures


def _polygons(face: Columns | None) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """Sizes and corners of the faces."""
    if face is None:
        return np.zeros(0, np.int64), np.zeros(0, np.int32)
    name = next((name for name in ("vertex_indices", "vertex_index") if name in face.lists), None)
    if name is None:
        raise InputError("the PLY element 'face' has no list 'vertex_indices'")
    sizes, corners = face.lists[name]
    corners = corners.astype(np.int64)
    if len(corners) and (corners.min() < 0 or corners.max() > 2**31 - 1):
        raise InputError("a PLY face names a point that does not exist: the file is damaged")
    return sizes, corners.astype(np.int32)


def _name_rest(elements: list[Element], warnings: list[str]) -> None:
    """Refuse strips; name other elements that are not read."""
    names = {element.name for element in elements if element.rows}
    if "tristrips" in names and "face" not in names:
        raise InputError("PLY triangle strips are not read: export the mesh with faces")
    for name in sorted(names - {"vertex", "face"}):
        warnings.append(f"the PLY element '{name}' was left out")
    for element in elements:
        read = ("vertex_indices", "vertex_index", *_WEDGES) if element.name == "face" else ()
        for prop in element.properties if element.name in ("vertex", "face") else ():
            if prop.count and prop.name not in read:
                warnings.append(f"the PLY list '{prop.name}' of each {element.name} was left out")
