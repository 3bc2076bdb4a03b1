"""Results as PLY, OFF and STL: formats of one nameless surface."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..rows import distinct_rows
from .ply import PlyFormat
from .sheet import Sheet

_COLORS = ("red", "green", "blue", "alpha")
_STL = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("bytes", "<u2")])


def ply_bytes(sheets: list[Sheet], format_: PlyFormat) -> tuple[bytes, int]:
    """A PLY file, and how many vertices it has.

    Positions are single or double as `format_` says, normals single, colours bytes. Text keeps the
    shortest digits that read back exactly in double.
    """
    columns = [np.concatenate([one.points for one in sheets])]
    kind: list[tuple[str, str]] = [(axis, "f8" if format_.double else "f4") for axis in "xyz"]
    for width, names, values in _extra(sheets):
        columns.append(values)
        kind += [(name, width) for name in names]
    flat = np.concatenate(columns, axis=1)
    first, inverse = distinct_rows(flat)
    sizes, corners = _polygons(sheets)
    corners = inverse[corners]
    vertices = flat[first]
    header = _ply_header(kind, len(first), sizes, format_.encoding)
    if format_.encoding == "ascii":
        body = _ply_text(vertices, kind, sizes, corners)
    else:
        order = "<" if format_.encoding == "binary_little_endian" else ">"
        body = _ply_binary(vertices, kind, sizes, corners, order)
    return header + body, len(first)


def _extra(sheets: list[Sheet]) -> list[tuple[str, list[str], NDArray[np.float64]]]:
    """Normals, texture coordinates and colours, each for all rows, where any sheet has them."""
    extra: list[tuple[str, list[str], NDArray[np.float64]]] = []
    normals = [one.normals for one in sheets]
    if any(values is not None and values.any() for values in normals):
        extra.append(("f4", ["nx", "ny", "nz"], _stacked(sheets, normals, 3, 0.0)))
    textures = [one.carried.get("TEXCOORD_0") for one in sheets]
    if any(values is not None for values in textures):
        extra.append(("f4", ["s", "t"], _stacked(sheets, textures, 2, 0.0)))
    colors = [one.carried.get("COLOR_0") for one in sheets]
    if any(values is not None for values in colors):
        width = max(values.shape[1] for values in colors if values is not None)
        whole = np.rint(_stacked(sheets, colors, width, 1.0) * 255.0)
        extra.append(("u1", list(_COLORS[:width]), np.clip(whole, 0, 255)))
    return extra


def _polygons(sheets: list[Sheet]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Sizes and corners of all polygons, the rows of all sheets end to end."""
    starts = np.cumsum([0, *(len(one.points) for one in sheets)])
    corners = [one.polygons.corners + start for one, start in zip(sheets, starts, strict=False)]
    return np.concatenate([np.diff(one.polygons.offsets) for one in sheets]), np.concatenate(corners)


def _stacked(
    sheets: list[Sheet], columns: list[NDArray[np.float64] | None], width: int, missing: float
) -> NDArray[np.float64]:
    """Values of all rows, with a default where a row has none."""
    stacked = []
    for one, values in zip(sheets, columns, strict=True):
        full = np.full((len(one.points), width), missing)
        if values is not None:
            full[:, : values.shape[1]] = np.where(np.isnan(values), missing, values)
        stacked.append(full)
    return np.concatenate(stacked)


def _ply_header(kind: list[tuple[str, str]], count: int, sizes: NDArray[np.int64], encoding: str) -> bytes:
    names = {"f4": "float", "f8": "double", "u1": "uchar"}
    lines = ["ply", f"format {encoding} 1.0", f"element vertex {count}"]
    lines += [f"property {names[width]} {name}" for name, width in kind]
    length = "uchar" if sizes.max(initial=3) < 256 else "int"
    lines += [f"element face {len(sizes)}", f"property list {length} int vertex_indices", "end_header", ""]
    return "\n".join(lines).encode("ascii")


def _ply_text(
    vertices: NDArray[np.float64],
    kind: list[tuple[str, str]],
    sizes: NDArray[np.int64],
    corners: NDArray[np.int64],
) -> bytes:
    whole = [width == "u1" for _, width in kind]
    lines = [
        " ".join(
            str(int(value)) if integer else repr(value) for value, integer in zip(row, whole, strict=True)
        )
        for row in vertices.tolist()
    ]
    lines += _polygon_lines(sizes, corners)
    return ("\n".join(lines) + "\n").encode("ascii")


def _ply_binary(
    vertices: NDArray[np.float64],
    kind: list[tuple[str, str]],
    sizes: NDArray[np.int64],
    corners: NDArray[np.int64],
    order: str,
) -> bytes:
    table = np.empty(len(vertices), [(name, order + width) for name, width in kind])
    for column, (name, _) in enumerate(kind):
        table[name] = vertices[:, column]
    length = "u1" if sizes.max(initial=3) < 256 else order + "i4"
    if len(np.unique(sizes)) == 1:
        faces = np.empty(len(sizes), [("n", length), ("v", order + "i4", (int(sizes[0]),))])
        faces["n"], faces["v"] = sizes, corners.reshape(len(sizes), -1)
        return table.tobytes() + faces.tobytes()
    ends = np.cumsum(sizes)
    ids = corners.astype(order + "i4")
    heads = sizes.astype(length)
    chunks = [
        heads[i : i + 1].tobytes() + ids[end - size : end].tobytes()
        for i, (size, end) in enumerate(zip(sizes.tolist(), ends.tolist(), strict=True))
    ]
    return table.tobytes() + b"".join(chunks)


def _number_lines(values: NDArray[np.float64]) -> list[str]:
    """A line for each row, of the shortest digits that read back exactly."""
    if values.shape[1] == 3:
        return [f"{x!r} {y!r} {z!r}" for x, y, z in values.tolist()]
    return [" ".join(map(repr, row)) for row in values.tolist()]


def _polygon_lines(sizes: NDArray[np.int64], corners: NDArray[np.int64]) -> list[str]:
    """A line for each polygon: how many corners it has, and which."""
    if np.all(sizes == 3):
        return [f"3 {a} {b} {c}" for a, b, c in corners.reshape(-1, 3).tolist()]
    ids, ends = corners.tolist(), np.cumsum(sizes).tolist()
    return [
        " ".join(map(str, [size, *ids[end - size : end]]))
        for size, end in zip(sizes.tolist(), ends, strict=True)
    ]


def off_text(sheets: list[Sheet], with_normals: bool) -> tuple[bytes, int]:
    """An OFF file, and how many vertices it has; numbers are the shortest that read back exactly."""
    columns = [np.concatenate([one.points for one in sheets])]
    extra = {names[0]: values for _, names, values in _extra(sheets)}
    head = "OFF"
    if with_normals and "nx" in extra:
        columns.append(extra["nx"])
        head = "N" + head
    flat = np.concatenate(columns, axis=1)
    first, inverse = distinct_rows(flat)
    sizes, corners = _polygons(sheets)
    corners = inverse[corners]
    lines = [head, f"{len(first)} {len(sizes)} 0"]
    lines += _number_lines(flat[first])
    lines += _polygon_lines(sizes, corners)
    return ("\n".join(lines) + "\n").encode("ascii"), len(first)


def stl_bytes(sheets: list[Sheet]) -> tuple[bytes, int]:
    """A binary STL file of triangles, and how many vertices it has (three a triangle)."""
    corners = np.concatenate([one.points[one.polygons.corners] for one in sheets]).reshape(-1, 3, 3)
    facets = np.zeros(len(corners), _STL)
    facets["corners"] = corners
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(cross, axis=1, keepdims=True)
    facets["normal"] = np.divide(cross, length, out=np.zeros_like(cross), where=length > 0.0)
    header = b"bldsimp".ljust(80, b" ") + len(facets).to_bytes(4, "little")
    return header + facets.tobytes(), 3 * len(facets)
