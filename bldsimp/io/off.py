"""Object File Format, as text: OFF with optional normals, colours and texture coordinates."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..model import Mesh, Part, attach_attributes, color_attribute, custom_attribute
from .surface import Polygons, polygon_mesh, uv_attribute
from .text import ragged, table

_HEADER = re.compile(rb"(ST)?(C)?(N)?OFF\b", re.IGNORECASE)


@dataclass
class OffFormat:
    """`Mesh.source` of a mesh read from OFF: what is stored for a colour of 1, in points and in faces."""

    vertex_scale: float = 1.0
    face_scale: float = 1.0


def read_off(data: bytes, warnings: list[str]) -> list[Mesh]:
    """Read an OFF file into one mesh of one part.

    Raises
    ------
    InputError
    """
    header, lines = _content(data)
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
    values = table(lines[1 : 1 + vertex_count])
    if vertex_count and (values.shape[1] < 3 or (values.shape[1] == 3 and n)):
        raise InputError("an OFF point has too few numbers: the file is damaged")
    sizes, corners, behind = _faces(lines[1 + vertex_count : 1 + vertex_count + face_count])
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32)
    mesh, polygon = polygon_mesh(
        "",
        np.ascontiguousarray(values[:, :3]),
        Polygons(offsets, corners, np.zeros(len(sizes), np.int32)),
        [Part("mesh")],
        warnings,
    )
    if n:
        mesh.normals = np.nan_to_num(values[:, 3:6], posinf=0.0, neginf=0.0)
    _carry(mesh, values[:, 3 + 3 * n :], st, behind[polygon])
    return [mesh]


def _content(data: bytes) -> tuple[re.Match[bytes], list[bytes]]:
    """The header word, and all lines that say something, from the counts on."""
    if b"#" in data:
        data = re.sub(rb"#[^\n]*", b"", data)
    lines = [line for line in (raw.strip() for raw in data.split(b"\n")) if line]
    header = _HEADER.match(lines[0]) if lines else None
    if header is None:
        raise InputError("no OFF header: not an OFF file, or one of a kind that bldsimp does not read")
    rest = lines[0][header.end() :].strip()
    if rest.upper().startswith(b"BINARY"):
        raise InputError("binary OFF is not read: convert it to text OFF or to PLY")
    return header, [rest, *lines[1:]] if rest else lines[1:]


def _faces(lines: list[bytes]) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float64]]:
    """Sizes and corners of the faces, and the numbers behind their corners, at most four, NaN for none."""
    if not lines:
        return np.zeros(0, np.int64), np.zeros(0, np.int32), np.empty((0, 0))
    rows, widths = ragged(lines) if len({line.count(b" ") for line in lines[:100]}) > 1 else _even(lines)
    sizes = rows[:, 0].astype(np.int64)
    if np.any(sizes < 0) or np.any(widths < sizes + 1):
        raise InputError("an OFF face has fewer corners than it says: the file is damaged")
    inside = np.arange(1, rows.shape[1]) <= sizes[:, None]
    corners = rows[:, 1:][inside]
    if np.any(corners != np.floor(corners)) or np.any(np.abs(corners) > 2**31 - 1):
        raise InputError("an OFF face has a corner that is no point number: the file is damaged")
    wide = np.pad(rows, ((0, 0), (0, 4)), constant_values=np.nan)
    behind = np.take_along_axis(wide, sizes[:, None] + 1 + np.arange(4), axis=1)
    return sizes, corners.astype(np.int32), behind[:, : int(np.clip((widths - sizes - 1).max(), 0, 4))]


def _even(lines: list[bytes]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """`ragged` for lines that are likely to be equally long."""
    rows = table(lines)
    if np.isnan(rows).any():
        return ragged(lines)
    return rows, np.full(len(lines), rows.shape[1])


def _carry(mesh: Mesh, rest: NDArray[np.float64], st: bool, behind: NDArray[np.float64]) -> None:
    """Take what follows position and normal of points, and the corners of faces; one number is a colour of a list."""
    mesh.source, attributes = OffFormat(), []
    if st and rest.shape[1] >= 2:
        attributes.append(uv_attribute(rest[:, -2:], mesh.parts, lambda _: None))
        rest = rest[:, :-2]
    if rest.shape[1] >= 3:
        mesh.source.vertex_scale = _scale(rest)
        attributes.append(color_attribute(rest[:, :4] / mesh.source.vertex_scale, mesh))
    if behind.shape[1] >= 3:
        mesh.source.face_scale = _scale(behind)
        attributes.append(color_attribute(behind / mesh.source.face_scale, mesh, on_faces=True))
    elif behind.shape[1]:
        attributes.append(custom_attribute("_color", behind[:, :1], mesh, whole=True, on_faces=True))
    attach_attributes(mesh, attributes)


def _scale(colors: NDArray[np.float64]) -> float:
    """What is stored for a colour of 1."""
    return 255.0 if np.nanmax(colors, initial=0.0) > 1.0 else 1.0
