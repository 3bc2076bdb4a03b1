"""Read and write the polygon file format (PLY): text and binary, single and double precision, polygons."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..material import Material
from ..model import FACE, Attribute, Indices, Mesh, Part, Values, attach_attributes, cast_indices, make_attribute
from ..unique_rows import find_unique_rows
from .flat_mesh import FlatMesh, join_flat_meshes
from .input_folder import InputFolder, LoadFile
from .ply_elements import Column, Element, read_elements, write_elements
from .polygons import Polygons, build_mesh
from .textures import make_uv_attribute

_POSITION = ("x", "y", "z")
_NORMAL = ("nx", "ny", "nz")
_COLORS = ("red", "green", "blue", "alpha")
_UV = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"))
_CORNERS = ("vertex_indices", "vertex_index")
_WEDGES = ("texcoord", "texture_coordinates")


@dataclass(frozen=True)
class PlyBundle:
    """Properties of an element that make up one attribute, their types, and the number that is stored for 1."""

    properties: tuple[str, ...]
    types: tuple[str, ...]
    scale: float = 1.0


@dataclass
class PlyStyle:
    """Properties of a PLY file that its result keeps.

    Attributes
    ----------
    encoding : str
    double : bool
        Positions are double.
    bundles : dict of str to PlyBundle
        By name of the attribute; ``NORMAL`` is one of them.
    wedges : bool
        Faces have the texture coordinates of their corners.
    """

    encoding: str = "binary_little_endian"
    double: bool = False
    bundles: dict[str, PlyBundle] = field(default_factory=dict)
    wedges: bool = False


def read_ply(data: bytes, folder: InputFolder, warnings: list[str]) -> tuple[Mesh, PlyStyle]:
    """Read a PLY file; each texture that it names is a part.

    Parameters
    ----------
    data : bytes
    folder : InputFolder
        The folder of the PLY file.
    warnings : list of str
        Receives a message about each kind of data that is ignored.

    Raises
    ------
    InputError
        If the file is damaged, or has no faces.
    """
    header = read_elements(data)
    _warn_of_ignored_data(header.elements, warnings)
    elements = {element.name: element for element in header.elements}
    vertex, face = (elements.get(name, Element(name, 0)) for name in ("vertex", "face"))
    if not set(_POSITION) <= vertex.scalars.keys():
        raise InputError("the PLY file has no points with x, y and z")
    sizes, corners = _read_polygons(face) if "face" in elements else (np.zeros(0, np.int64), np.zeros(0, np.int32))
    corners, wedges = _split_wedges(vertex, face, sizes, corners)
    parts, part = _make_parts(face.scalars, header.textures, len(sizes))
    points = _stack_columns(vertex.scalars, _POSITION)
    mesh, polygon = build_mesh("", points, Polygons(sizes, corners, part), parts, warnings)
    style = PlyStyle(header.encoding, vertex.types["x"] == "f8", wedges=wedges is not None)
    if set(_NORMAL) <= vertex.scalars.keys():
        mesh.normals = np.nan_to_num(_stack_columns(vertex.scalars, _NORMAL), posinf=0.0, neginf=0.0)
        style.bundles["NORMAL"] = PlyBundle(_NORMAL, tuple(vertex.types[name] for name in _NORMAL))
    attributes = [] if wedges is None else [make_uv_attribute(wedges, parts, folder.load_image)]
    # Normals of faces follow from their corners.
    skipped = (*_NORMAL, "texnumber") if header.textures else _NORMAL
    load = folder.load_image if wedges is None else None
    for attribute, bundle in (
        *_read_attributes(mesh, vertex, _POSITION + _NORMAL, load=load),
        *_read_attributes(mesh, face, skipped, polygon=polygon),
    ):
        attributes.append(attribute)
        style.bundles[attribute.name] = bundle
    attach_attributes(mesh, attributes)
    return mesh, style


def _read_attributes(
    mesh: Mesh, table: Element, known: tuple[str, ...], *, load: LoadFile | None = None, polygon: Indices | None = None
) -> Iterator[tuple[Attribute, PlyBundle]]:
    """Yield colors, texture coordinates (with `load`) and all other columns of points, or of each face's polygon."""
    types, columns = table.types, {name: own for name, own in table.scalars.items() if name not in known}
    channels = tuple(name for name in _COLORS if name in columns)
    colors = channels if channels[:3] == _COLORS[:3] else ()
    uv = next((pair for pair in _UV if set(pair) <= columns.keys()), ()) if load else ()
    others = [(name,) for name in columns if name not in colors + uv]
    for names in filter(None, (colors, uv, *others)):
        stored = _stack_columns(columns, names)
        scale = _find_color_scale(np.dtype(types["red"]), stored) if names == colors else 1.0
        values = (stored if polygon is None else stored[polygon]) / scale
        if names == uv and load:
            attribute = make_uv_attribute(values, mesh.parts, load)
        elif names == colors:
            attribute = make_attribute("COLOR_0", values, mesh, on_faces=polygon is not None)
        else:
            whole = types[names[0]][0] != "f"
            attribute = make_attribute(f"_{names[0]}", values, mesh, on_faces=polygon is not None, whole=whole)
        yield attribute, PlyBundle(names, tuple(types[name] for name in names), scale)


def _find_color_scale(kind: np.dtype[Any], values: Values) -> float:
    """Return the number that is stored for a color of 1."""
    if kind.kind == "f" and np.nanmax(values, initial=0.0) <= 1.0:
        return 1.0
    return float(np.iinfo(kind).max if kind.kind == "u" and kind.itemsize < 4 else 255)


def _stack_columns(columns: dict[str, NDArray[Any]], names: tuple[str, ...]) -> Values:
    return np.stack([columns[name].astype(np.float64) for name in names], axis=1)


def _read_polygons(face: Element) -> tuple[NDArray[np.int64], Indices]:
    """Return sizes and corners of the faces."""
    name = next((name for name in _CORNERS if name in face.lists), None)
    if name is None:
        raise InputError("the PLY element 'face' has no list 'vertex_indices'")
    sizes, corners = face.lists[name]
    corners = corners.astype(np.int64)
    if len(corners) and (corners.min() < 0 or corners.max() > 2**31 - 1):
        raise InputError("a PLY face names a point that does not exist: the file is damaged")
    return sizes, cast_indices(corners)


def _split_wedges(
    vertex: Element, face: Element, sizes: NDArray[np.int64], corners: Indices
) -> tuple[Indices, Values | None]:
    """Repeat points so that each has one texture coordinate; return corners and those, if faces have them."""
    name = next((name for name in _WEDGES if name in face.lists), None)
    if name is None or not len(corners):
        return corners, None
    lengths, values = face.lists[name]
    uv = np.full((len(corners), 2), np.nan)
    full = lengths == 2 * sizes
    uv[np.repeat(full, sizes)] = values[np.repeat(full, lengths)].reshape(-1, 2)
    if not full.any() or corners.min() < 0 or corners.max() >= len(vertex.scalars["x"]):
        return corners, None
    first, inverse = find_unique_rows(np.column_stack([corners, uv]))
    vertex.scalars = {key: column[corners[first]] for key, column in vertex.scalars.items()}
    return cast_indices(inverse), uv[first]


def _make_parts(face: dict[str, NDArray[Any]], textures: list[str], count: int) -> tuple[list[Part], Indices]:
    """Return a part for each texture that faces have, and the part of each face."""
    materials = [Material(PurePosixPath(name.replace("\\", "/")).stem, texture=name) for name in textures]
    if not materials or "texnumber" not in face:
        return [Part("mesh", material=materials[0] if materials else None)], np.zeros(count, np.int32)
    numbers, part = np.unique(face["texnumber"].astype(np.int64), return_inverse=True)
    own = [materials[number] if 0 <= number < len(materials) else None for number in numbers]
    return [Part(one.name if one else "no texture", material=one) for one in own], cast_indices(part.reshape(-1))


def _warn_of_ignored_data(elements: list[Element], warnings: list[str]) -> None:
    """Refuse strips; name other data that is not read."""
    names = {element.name for element in elements if element.rows}
    if "tristrips" in names and "face" not in names:
        raise InputError("bldsimp does not read PLY triangle strips: export the mesh with faces")
    for name in sorted(names - {"vertex", "face"}):
        warnings.append(f"ignored the PLY element '{name}'")
    for element in elements:
        known = {"vertex": (), "face": _CORNERS + _WEDGES}.get(element.name)
        for one in element.properties if known is not None else ():
            if one.count and one.name not in (known or ()):
                warnings.append(f"ignored the PLY list '{one.name}' of each {element.name}")


def write_ply(meshes: list[FlatMesh], style: PlyStyle, textures: dict[str, str]) -> tuple[bytes, int]:
    """Write meshes as a PLY file.

    Parameters
    ----------
    meshes : list of FlatMesh
    style : PlyStyle
        Positions are single or double as it says, and what a PLY file had keeps its types. Otherwise normals and
        texture coordinates have the type of positions, and colors are bytes. Text keeps the shortest digits that read
        back exactly in double.
    textures : dict of str to str
        File names of those that materials name. If not all faces have the same, faces state theirs, and have the
        texture coordinates of their corners.

    Returns
    -------
    data : bytes
    vertices : int
        Distinct vertices.
    """
    real = "f8" if style.double else "f4"
    numbers = np.concatenate([_number_textures(one, list(textures)) for one in meshes])
    several = bool((numbers != numbers[0]).any())
    flat = join_flat_meshes(meshes)
    vertex: list[Column] = [(axis, real, column) for axis, column in zip("xyz", flat.points.T, strict=True)]
    face: list[Column] = []
    if flat.normals is not None:
        bundle = style.bundles.get("NORMAL", PlyBundle(_NORMAL, (real,) * 3))
        vertex += zip(bundle.properties, bundle.types, flat.normals.T, strict=True)
    wedges: list[Column] = []
    for one in flat.attributes:
        if one.on_faces:
            face += _make_columns(one, style, real)
        elif one.name == "TEXCOORD_0" and (style.wedges or several):
            wedges = [("texcoord", real, np.nan_to_num(one.values)[flat.faces].reshape(-1, 6))]
        elif one.kind != "tangent":
            vertex += _make_columns(one, style, real)
    first, inverse = find_unique_rows(np.stack([values for _, _, values in vertex], axis=1))
    numbered: list[Column] = [("texnumber", "i4", numbers)] if several else []
    elements = {
        "vertex": [(name, kind, values[first]) for name, kind, values in vertex],
        "face": [("vertex_indices", "i4", inverse[flat.faces]), *wedges, *numbered, *face],
    }
    return write_elements(style.encoding, list(textures.values()), elements), len(first)


def _number_textures(flat: FlatMesh, textures: list[str]) -> Values:
    """Return the number of each face's texture, -1 for none or where a face has no texture coordinates."""
    names = [part.material.texture if part.material else None for part in flat.parts]
    numbers = np.array([textures.index(name) if name in textures else -1 for name in names], np.float64)[flat.part]
    uv = flat.values("TEXCOORD_0")
    if uv is not None:
        numbers[np.isnan(uv[flat.faces]).all(axis=(1, 2))] = -1
    return numbers


def _make_columns(one: Attribute, style: PlyStyle, real: str) -> list[Column]:
    """Make the columns of an attribute, as they were in a PLY file, or as is common."""
    values, width, name = one.values, one.values.shape[1], one.name.removeprefix(FACE)
    if one.name in style.bundles:
        bundle = style.bundles[one.name]
    elif name == "COLOR_0":
        bundle = PlyBundle(_COLORS[:width], ("u1",) * width, 255.0)
    elif name == "TEXCOORD_0":
        bundle = PlyBundle(("s", "t"), (real, real))
    else:
        label = name.removeprefix("_").lower()
        names = tuple(f"{label}_{i}" for i in range(width)) if width > 1 else (label,)
        large = np.any(np.abs(np.nan_to_num(values)) >= 2**31)
        bundle = PlyBundle(names, (real if one.kind != "feature" else "f8" if large else "i4",) * width)
    if one.kind == "uv" or name.startswith("COLOR_"):
        values = np.where(np.isnan(values), 0.0 if one.kind == "uv" else 1.0, values)
    columns: list[Column] = []
    for label, kind, column in zip(bundle.properties, bundle.types, values.T * bundle.scale, strict=True):
        if kind[0] != "f":
            limits = np.iinfo(kind)
            column = np.clip(np.rint(np.nan_to_num(column)), float(limits.min), float(limits.max))
        columns.append((label, kind, column))
    return columns
