"""Object File Format, as text: OFF with optional normals, colours and texture coordinates."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..scene import Mesh, Part
from .surface import Polygons, Stored, polygon_mesh
from .text import ragged, table

_HEADER = re.compile(rb"(ST)?(C)?(N)?OFF\b", re.IGNORECASE)


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
    sizes, corners, colored = _faces(lines[1 + vertex_count : 1 + vertex_count + face_count])
    part = Part("mesh")
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32)
    mesh = polygon_mesh(
        "",
        np.ascontiguousarray(values[:, :3]),
        Polygons(offsets, corners, np.zeros(len(sizes), np.int32)),
        [part],
        warnings,
    )
    rest = 3 + 3 * n
    if n:
        mesh.normals = np.nan_to_num(values[:, 3:6], posinf=0.0, neginf=0.0)
    _carry(mesh.source, values[:, rest:], st)
    part.attributes = tuple(
        {"COLOR_0": "colour", "TEXCOORD_0": "texture coordinates"}[key] for key in mesh.source.carried
    ) + (("face colour",) if colored else ())
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


def _faces(lines: list[bytes]) -> tuple[NDArray[np.int64], NDArray[np.int32], bool]:
    """Sizes and corners of the faces, and whether any has a colour behind its corners."""
    if not lines:
        return np.zeros(0, np.int64), np.zeros(0, np.int32), False
    rows, widths = ragged(lines) if len({line.count(b" ") for line in lines[:100]}) > 1 else _even(lines)
    sizes = rows[:, 0].astype(np.int64)
    if np.any(sizes < 0) or np.any(widths < sizes + 1):
        raise InputError("an OFF face has fewer corners than it says: the file is damaged")
    inside = np.arange(1, rows.shape[1]) <= sizes[:, None]
    corners = rows[:, 1:][inside]
    if np.any(corners != np.floor(corners)) or np.any(np.abs(corners) > 2**31 - 1):
        raise InputError("an OFF face has a corner that is no point number: the file is damaged")
    return sizes, corners.astype(np.int32), bool(np.any(widths > sizes + 1))


def _even(lines: list[bytes]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """`ragged` for lines that are likely to be equally long."""
    rows = table(lines)
    if np.isnan(rows).any():
        return ragged(lines)
    return rows, np.full(len(lines), rows.shape[1])


def _carry(stored: Stored, rest: NDArray[np.float64], st: bool) -> None:
    """Keep colours and texture coordinates that follow position and normal."""
    if st and rest.shape[1] >= 2:
        stored.carried["TEXCOORD_0"] = rest[:, -2:]
        rest = rest[:, :-2]
    if rest.shape[1] >= 3:
        colors = rest[:, : min(4, rest.shape[1])]
        stored.carried["COLOR_0"] = colors / 255.0 if np.nanmax(colors) > 1.0 else colors
