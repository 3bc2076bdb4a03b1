"""Results as PLY, OFF and STL: formats of one nameless surface."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model import FACE, Attribute
from ..unique_rows import find_unique_rows
from .flat_mesh import Sheet
from .loaded import STL_BYTES
from .off import OffFormat
from .ply import Bundle, PlyFormat
from .surface import material_of

_COLORS = ("red", "green", "blue", "alpha")
_NAMES = {"f4": "float", "f8": "double", "u1": "uchar", "i1": "char", "u2": "ushort", "i2": "short", "u4": "uint",
          "i4": "int", "u8": "uint64", "i8": "int64"}  # fmt: skip
_STL = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("bytes", "<u2")])

_Table = list[tuple[str, str, NDArray[Any]]]
"""Columns, or lists as rows: name, type, values."""


def ply_bytes(sheets: list[Sheet], format_: PlyFormat, textures: dict[str, str]) -> tuple[bytes, int]:
    """A PLY file, and how many vertices it has.

    Parameters
    ----------
    sheets : list of Sheet
    format_ : PlyFormat
        Positions are single or double as it says, and what a PLY file had comes out in its types; else normals and
        texture coordinates are as positions are, and colours bytes. Text keeps the shortest digits that read back
        exactly in double.
    textures : dict of str to str
        File names of those that materials name. Where not all faces have the same, they tell theirs, and have the
        texture coordinates of their corners.
    """
    real = "f8" if format_.double else "f4"
    numbers = np.concatenate([_texture_numbers(one, list(textures)) for one in sheets])
    several = bool((numbers != numbers[0]).any())
    vertex, wedges = _vertex_table(sheets, format_, real, format_.wedges or several)
    first, inverse = find_unique_rows(np.stack([column for _, _, column in vertex], axis=1))
    vertex = [(name, kind, column[first]) for name, kind, column in vertex]
    corners = _corners(sheets)
    lists: _Table = [("vertex_indices", "i4", inverse[corners])]
    if wedges is not None:
        lists.append(("texcoord", real, wedges[corners].reshape(-1, 6)))
    face: _Table = [("texnumber", "i4", numbers)] if several else []
    for one, values in _attributes(sheets, on_faces=True):
        face += _columns(one, values, format_, real)
    header = _ply_header(format_.encoding, list(textures.values()), vertex, lists, face)
    if format_.encoding == "ascii":
        return header + _ply_text(vertex, []) + _ply_text(face, lists), len(first)
    order = ">" if format_.encoding == "binary_big_endian" else "<"
    return header + _ply_binary(vertex, [], order) + _ply_binary(face, lists, order), len(first)


def _vertex_table(
    sheets: list[Sheet], format_: PlyFormat, real: str, wedged: bool
) -> tuple[_Table, NDArray[np.float64] | None]:
    """Columns of all rows, and their texture coordinates, where these belong to the corners of faces."""
    points = np.concatenate([one.points for one in sheets])
    vertex: _Table = [(axis, real, column) for axis, column in zip("xyz", points.T, strict=True)]
    normals, wedges = _normals(sheets), None
    if normals is not None:
        bundle = format_.bundles.get("NORMAL", Bundle(("nx", "ny", "nz"), (real,) * 3))
        vertex += list(zip(bundle.properties, bundle.types, normals.T, strict=True))
    for one, values in _attributes(sheets, on_faces=False):
        if one.name == "TEXCOORD_0" and wedged:
            wedges = np.nan_to_num(values)
        elif one.kind != "tangent":
            vertex += _columns(one, values, format_, real)
    return vertex, wedges


def _texture_numbers(one: Sheet, textures: list[str]) -> NDArray[np.float64]:
    """For each face the number of its texture, -1 for none: nor has one what is without texture coordinates."""
    materials = [material_of(part) for part in one.parts]
    numbers = [textures.index(m.texture) if m is not None and m.texture in textures else -1 for m in materials]
    found, uv = np.array(numbers, np.float64)[one.part], one.values("TEXCOORD_0")
    if uv is not None:
        found[np.isnan(uv[one.faces]).all(axis=(1, 2))] = -1
    return found


def _attributes(sheets: list[Sheet], *, on_faces: bool) -> list[tuple[Attribute, NDArray[np.float64]]]:
    """Each attribute of rows, or of faces, with the values of all sheets end to end; NaN for those without."""
    known = {one.name: one for own in sheets for one in own.attributes if one.on_faces == on_faces}
    found = []
    for name, one in known.items():
        given = [own.values(name) for own in sheets]
        width = max(values.shape[1] for values in given if values is not None)
        pieces = []
        for own, values in zip(sheets, given, strict=True):
            full = np.full((len(own.faces) if on_faces else len(own.points), width), np.nan)
            if values is not None:
                full[:, : values.shape[1]] = values
            pieces.append(full)
        found.append((one, np.concatenate(pieces)))
    return found


def _columns(one: Attribute, values: NDArray[np.float64], format_: PlyFormat, real: str) -> _Table:
    """Columns of an attribute, as they were in a PLY file, or as is common."""
    width, name = values.shape[1], one.name.removeprefix(FACE)
    if one.name in format_.bundles:
        bundle = format_.bundles[one.name]
    elif name == "COLOR_0":
        bundle = Bundle(_COLORS[:width], ("u1",) * width, 255.0)
    elif name == "TEXCOORD_0":
        bundle = Bundle(("s", "t"), (real, real))
    else:
        label = name.removeprefix("_").lower()
        names = tuple(f"{label}_{i}" for i in range(width)) if width > 1 else (label,)
        bundle = Bundle(names, (_whole_type(values) if one.kind == "feature" else real,) * width)
    if one.kind == "uv" or name.startswith("COLOR_"):
        values = np.where(np.isnan(values), 0.0 if one.kind == "uv" else 1.0, values)
    table: _Table = []
    for label, kind, column in zip(bundle.properties, bundle.types, values.T * bundle.scale, strict=True):
        if kind[0] != "f":
            range_ = np.iinfo(kind)
            column = np.clip(np.rint(np.nan_to_num(column)), float(range_.min), float(range_.max))
        table.append((label, kind, column))
    return table


def _whole_type(values: NDArray[np.float64]) -> str:
    """A type that holds numbers that name something."""
    return "f8" if np.any(np.abs(np.nan_to_num(values)) >= 2**31) else "i4"


def _normals(sheets: list[Sheet]) -> NDArray[np.float64] | None:
    """Normals of all rows, zero where one has none; None where none has."""
    if not any(one.normals is not None and one.normals.any() for one in sheets):
        return None
    return np.concatenate([np.zeros_like(one.points) if one.normals is None else one.normals for one in sheets])


def _corners(sheets: list[Sheet]) -> NDArray[np.int64]:
    """Faces of all sheets, whose rows are end to end."""
    starts = np.cumsum([0, *(len(one.points) for one in sheets)])
    return np.concatenate([one.faces + start for one, start in zip(sheets, starts, strict=False)])


def _ply_header(encoding: str, textures: list[str], vertex: _Table, lists: _Table, face: _Table) -> bytes:
    lines = ["ply", f"format {encoding} 1.0", *(f"comment TextureFile {name}" for name in textures)]
    lines.append(f"element vertex {len(vertex[0][2])}")
    lines += [f"property {_NAMES[kind]} {name}" for name, kind, _ in vertex]
    lines.append(f"element face {len(lists[0][2])}")
    lines += [f"property list uchar {_NAMES[kind]} {name}" for name, kind, _ in lists]
    lines += [f"property {_NAMES[kind]} {name}" for name, kind, _ in face]
    return "\n".join([*lines, "end_header", ""]).encode("utf-8", "surrogateescape")


def _ply_text(table: _Table, lists: _Table) -> bytes:
    """Lines of an element: its lists, then its columns."""
    words: list[list[str]] = []
    for _, _, values in lists:
        words.append([str(values.shape[1])] * len(values))
        words += [list(map(repr, column.tolist())) for column in values.T]
    for _, kind, column in table:
        words.append(list(map(repr, (column if kind[0] == "f" else column.astype(int)).tolist())))
    return "".join(" ".join(row) + "\n" for row in zip(*words, strict=True)).encode("ascii")


def _ply_binary(table: _Table, lists: _Table, order: str) -> bytes:
    """Rows of an element: its lists, then its columns."""
    fields: list[Any] = []
    for number, (_, kind, values) in enumerate(lists):
        fields += [(f"n{number}", "u1"), (f"l{number}", order + kind, (values.shape[1],))]
    fields += [(f"c{number}", order + kind) for number, (_, kind, _) in enumerate(table)]
    rows = np.empty(len(lists[0][2]) if lists else len(table[0][2]), fields)
    for number, (_, _, values) in enumerate(lists):
        rows[f"n{number}"], rows[f"l{number}"] = values.shape[1], values
    for number, (_, _, column) in enumerate(table):
        rows[f"c{number}"] = column
    return rows.tobytes()


def off_text(sheets: list[Sheet], format_: OffFormat | None) -> tuple[bytes, int]:
    """An OFF file, and how many vertices it has; numbers are the shortest that read back exactly.

    Normals and texture coordinates are written where they came from OFF: few programs read them.
    """
    points = [np.concatenate([one.points for one in sheets])]
    head, own = "OFF", format_ or OffFormat(255.0, 255.0)
    normals = _normals(sheets) if format_ else None
    if normals is not None:
        points.append(normals)
        head = "N" + head
    rows = {one.name: values for one, values in _attributes(sheets, on_faces=False)}
    if "COLOR_0" in rows:
        points.append(_off_colors(rows["COLOR_0"], own.vertex_scale))
        head = "C" + head
    if format_ and "TEXCOORD_0" in rows:
        points.append(np.nan_to_num(rows["TEXCOORD_0"]))
        head = "ST" + head
    flat = np.concatenate(points, axis=1)
    first, inverse = find_unique_rows(flat)
    lines = [head, f"{len(first)} {sum(len(one.faces) for one in sheets)} 0", *_number_lines(flat[first])]
    corners = inverse[_corners(sheets)].tolist()
    behind = _off_behind(sheets, own.face_scale)
    behind = behind or [""] * len(corners)
    lines += [f"3 {a} {b} {c}{text}" for (a, b, c), text in zip(corners, behind, strict=True)]
    return ("\n".join(lines) + "\n").encode("ascii"), len(first)


def _off_behind(sheets: list[Sheet], scale: float) -> list[str]:
    """What follows the corners of each face."""
    faces = {one.name: values for one, values in _attributes(sheets, on_faces=True)}
    if FACE + "COLOR_0" in faces:
        return [" " + line for line in _number_lines(_off_colors(faces[FACE + "COLOR_0"], scale))]
    numbers = faces.get(FACE + "_color")
    return [] if numbers is None else [f" {int(value)}" if value == value else "" for value in numbers[:, 0].tolist()]


def _off_colors(values: NDArray[np.float64], scale: float) -> NDArray[np.float64]:
    """Colours as OFF stores them: white where there is none."""
    stored = np.where(np.isnan(values), 1.0, values) * scale
    return np.rint(stored) if scale > 1.0 else stored


def _number_lines(values: NDArray[np.float64]) -> list[str]:
    """A line for each row, of the shortest digits that read back exactly; columns of whole numbers without a point."""
    if values.shape[1] == 3 and not np.all(values == np.rint(values)):
        return [f"{x!r} {y!r} {z!r}" for x, y, z in values.tolist()]
    columns = [column.astype(int).tolist() if np.all(np.abs(column) < 2**53) and np.all(column == np.rint(column))
               else column.tolist() for column in values.T]  # fmt: skip
    return [" ".join(map(repr, row)) for row in zip(*columns, strict=True)]


def stl_bytes(sheets: list[Sheet]) -> tuple[bytes, int]:
    """A binary STL file of triangles, and how many vertices it has (three a triangle)."""
    corners = np.concatenate([one.points[one.faces] for one in sheets])
    facets = np.zeros(len(corners), _STL)
    facets["corners"] = corners
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(cross, axis=1, keepdims=True)
    facets["normal"] = np.divide(cross, length, out=np.zeros_like(cross), where=length > 0.0)
    for one, values in _attributes(sheets, on_faces=True):
        if one.name == STL_BYTES:
            facets["bytes"] = np.nan_to_num(values[:, 0])
    header = b"bldsimp".ljust(80, b" ") + len(facets).to_bytes(4, "little")
    return header + facets.tobytes(), 3 * len(facets)
