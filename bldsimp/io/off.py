"""Read and write the Object File Format as text: OFF with optional normals, colors and texture coordinates."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..model import FACE, Attribute, Indices, Mesh, Part, Values, attach_attributes, cast_indices, make_attribute
from ..unique_rows import find_unique_rows
from .flat_mesh import FlatMesh, join_flat_meshes
from .polygons import Polygons, build_mesh
from .text_numbers import parse_rows
from .textures import make_uv_attribute

_HEADER = re.compile(rb"(ST)?(C)?(N)?OFF\b", re.IGNORECASE)


@dataclass
class OffStyle:
    """Properties of an OFF file that its result keeps.

    Attributes
    ----------
    vertex_scale, face_scale : float
        The number that is stored for a color of 1, in points and in faces.
    decorated : bool
        Normals and texture coordinates are written: few programs read them, so only where they came from OFF.
    """

    vertex_scale: float = 255.0
    face_scale: float = 255.0
    decorated: bool = False


def read_off(data: bytes, warnings: list[str]) -> tuple[Mesh, OffStyle]:
    """Read an OFF file into a mesh of one part.

    Parameters
    ----------
    data : bytes
    warnings : list of str
        Receives a message about faces that are removed.

    Raises
    ------
    InputError
        If the file is damaged, binary, or has no faces.
    """
    header, lines = _split_lines(data)
    st, _, n = (bool(group) for group in header.groups())
    try:
        vertex_count, face_count = (int(word) for word in lines[0].split()[:2])
    except (ValueError, IndexError):
        raise InputError("the OFF header does not tell how many points and faces there are") from None
    if len(lines) < 1 + vertex_count + face_count:
        raise InputError(
            f"the OFF file ends early: {vertex_count:,} points and {face_count:,} faces are promised,"
            f" {len(lines) - 1:,} lines follow"
        )
    values, _ = parse_rows(lines[1 : 1 + vertex_count])
    if vertex_count and (values.shape[1] < 3 or (values.shape[1] == 3 and n)):
        raise InputError("an OFF point has too few numbers: the file is damaged")
    sizes, corners, extra = _read_off_faces(lines[1 + vertex_count : 1 + vertex_count + face_count])
    polygons = Polygons(sizes, corners, np.zeros(len(sizes), np.int32))
    mesh, polygon = build_mesh("", np.ascontiguousarray(values[:, :3]), polygons, [Part("mesh")], warnings)
    if n:
        mesh.normals = np.nan_to_num(values[:, 3:6], posinf=0.0, neginf=0.0)
    style = OffStyle(1.0, 1.0, decorated=True)
    attach_attributes(mesh, _read_extra_numbers(mesh, style, values[:, 3 + 3 * n :], extra[polygon], st))
    return mesh, style


def _split_lines(data: bytes) -> tuple[re.Match[bytes], list[bytes]]:
    """Return the header word, and all lines that are not blank from the counts on, without comments."""
    if b"#" in data:
        data = re.sub(rb"#[^\n]*", b"", data)
    lines = [line for line in (raw.strip() for raw in data.split(b"\n")) if line]
    header = _HEADER.match(lines[0]) if lines else None
    if header is None:
        raise InputError("no OFF header: not an OFF file, or one of a kind that bldsimp does not read")
    rest = lines[0][header.end() :].strip()
    if rest.upper().startswith(b"BINARY"):
        raise InputError("bldsimp does not read binary OFF: convert it to text OFF or to PLY")
    return header, [rest, *lines[1:]] if rest else lines[1:]


def _read_off_faces(lines: list[bytes]) -> tuple[NDArray[np.int64], Indices, Values]:
    """Return sizes and corners of the faces, and the numbers after their corners, at most four, NaN for none."""
    if not lines:
        return np.zeros(0, np.int64), np.zeros(0, np.int32), np.empty((0, 0))
    rows, widths = parse_rows(lines)
    sizes = rows[:, 0].astype(np.int64)
    if np.any(sizes < 0) or np.any(widths < sizes + 1):
        raise InputError("an OFF face has fewer corners than it says: the file is damaged")
    corners = rows[:, 1:][np.arange(1, rows.shape[1]) <= sizes[:, None]]
    if np.any(corners != np.floor(corners)) or np.any(np.abs(corners) > 2**31 - 1):
        raise InputError("an OFF face has a corner that is no point number: the file is damaged")
    wide = np.pad(rows, ((0, 0), (0, 4)), constant_values=np.nan)
    extra = np.take_along_axis(wide, sizes[:, None] + 1 + np.arange(4), axis=1)
    return sizes, cast_indices(corners), extra[:, : int(np.clip((widths - sizes - 1).max(), 0, 4))]


def _read_extra_numbers(mesh: Mesh, style: OffStyle, of_points: Values, of_faces: Values, st: bool) -> list[Attribute]:
    """Read the numbers after position and normal, and after the corners; a single one is a color of a list."""
    attributes = []
    if st and of_points.shape[1] >= 2:
        attributes.append(make_uv_attribute(of_points[:, -2:], mesh.parts, lambda _: None))
        of_points = of_points[:, :-2]
    if of_points.shape[1] >= 3:
        style.vertex_scale = _find_off_scale(of_points)
        attributes.append(make_attribute("COLOR_0", of_points[:, :4] / style.vertex_scale, mesh))
    if of_faces.shape[1] >= 3:
        style.face_scale = _find_off_scale(of_faces)
        attributes.append(make_attribute("COLOR_0", of_faces / style.face_scale, mesh, on_faces=True))
    elif of_faces.shape[1]:
        attributes.append(make_attribute("_color", of_faces[:, :1], mesh, on_faces=True, whole=True))
    return attributes


def _find_off_scale(colors: Values) -> float:
    """Return the number that is stored for a color of 1."""
    return 255.0 if np.nanmax(colors, initial=0.0) > 1.0 else 1.0


def write_off(meshes: list[FlatMesh], style: OffStyle) -> tuple[bytes, int]:
    """Write meshes as an OFF file.

    Parameters
    ----------
    meshes : list of FlatMesh
    style : OffStyle

    Returns
    -------
    text : bytes
        Numbers are the shortest that read back exactly in double precision.
    vertices : int
        Distinct vertices.
    """
    flat = join_flat_meshes(meshes)
    values = {one.name: one.values for one in flat.attributes}
    head, columns = "OFF", [flat.points]
    if flat.normals is not None and style.decorated:
        head, columns = "N" + head, [*columns, flat.normals]
    if "COLOR_0" in values:
        head, columns = "C" + head, [*columns, _scale_colors(values["COLOR_0"], style.vertex_scale)]
    if "TEXCOORD_0" in values and style.decorated:
        head, columns = "ST" + head, [*columns, np.nan_to_num(values["TEXCOORD_0"])]
    rows = np.concatenate(columns, axis=1)
    first, inverse = find_unique_rows(rows)
    lines = [head, f"{len(first)} {len(flat.faces)} 0", *_write_number_lines(rows[first])]
    extra = [""] * len(flat.faces)
    if FACE + "COLOR_0" in values:
        extra = [" " + line for line in _write_number_lines(_scale_colors(values[FACE + "COLOR_0"], style.face_scale))]
    elif FACE + "_color" in values:
        numbers = values[FACE + "_color"][:, 0]
        extra = [f" {int(one)}" if known else "" for one, known in zip(numbers, ~np.isnan(numbers), strict=True)]
    lines += [f"3 {a} {b} {c}{text}" for (a, b, c), text in zip(inverse[flat.faces].tolist(), extra, strict=True)]
    return ("\n".join(lines) + "\n").encode("ascii"), len(first)


def _scale_colors(values: Values, scale: float) -> Values:
    """Return colors as OFF stores them, white where there is none."""
    stored = np.where(np.isnan(values), 1.0, values) * scale
    return np.rint(stored) if scale > 1.0 else stored


def _write_number_lines(values: Values) -> list[str]:
    """Write a line for each row, in the shortest digits that read back exactly; columns of whole numbers as such."""
    rounded = np.all(values == np.rint(values), axis=0)
    whole = rounded & np.all(np.abs(values) < 2**53, axis=0)
    if values.shape[1] == 3 and not rounded.all():
        # Positions alone look alike in all columns.
        whole[:] = False
    columns = [(column.astype(int) if own else column).tolist() for column, own in zip(values.T, whole, strict=True)]
    return [" ".join(map(repr, row)) for row in zip(*columns, strict=True)]
