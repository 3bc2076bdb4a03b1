"""Tiny shapes and files that tests make by name."""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np

FAR = (0.0, 500_000.0, 5_000_000.0)
"""Shifts of map coordinates."""

_SQUARES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))


def box(size: float = 2.0, shift: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Eight points and twelve faces of a closed box, wound outwards."""
    corners = [(x, y, z) for x in (0.0, size) for y in (0.0, size) for z in (0.0, size)]
    faces = [face for a, b, c, d in _SQUARES for face in ((a, c, b), (a, d, c))]
    return np.array(corners) + shift, np.array(faces, np.int32)[:, [0, 2, 1]]


def box_quads(shift: float = 0.0) -> tuple[np.ndarray, list[tuple[int, ...]]]:
    """The same box of six squares."""
    return box(shift=shift)[0], [tuple(square) for square in _SQUARES]


def fine_box(steps: int = 4, size: float = 2.0, shift: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """A closed box whose sides are grids; coordinates are multiples of a half for four steps."""
    index: dict[tuple[float, ...], int] = {}
    faces = []
    for axis in range(3):
        for side in (0, steps):
            for i in range(steps):
                for j in range(steps):
                    corners = []
                    for u, v in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                        place = [0.0, 0.0, 0.0]
                        place[axis], place[(axis + 1) % 3], place[(axis + 2) % 3] = side, u, v
                        corners.append(index.setdefault(tuple(place), len(index)))
                    a, b, c, d = corners if side else corners[::-1]
                    faces += [(a, b, c), (a, c, d)]
    return np.array(list(index)) * (size / steps) + shift, np.array(faces, np.int32)


def open_cone(sides: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """A cone without a floor: one boundary loop."""
    angle = 2 * np.pi * np.arange(sides) / sides
    rim = np.stack([np.cos(angle), np.sin(angle), np.zeros(sides)], axis=1)
    faces = [(i, (i + 1) % sides, sides) for i in range(sides)]
    return np.vstack([rim, [[0.0, 0.0, 1.0]]]), np.array(faces, np.int32)


def concave_polygon_obj() -> str:
    """An arrowhead whose fan from the first corner would cover ground outside of it; area 3."""
    return "v 0 4 0\nv -2 0 0\nv 0 2.5 0\nv 2 0 0\nf 1 2 3 4\n"


def obj_text(points: Any, polygons: Any, *, start: int = 1) -> str:
    """An OBJ file of polygons."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(points, float).tolist()]
    lines += ["f " + " ".join(str(int(i) + start) for i in polygon) for polygon in polygons]
    return "\n".join(lines) + "\n"


def off_text(points: Any, polygons: Any) -> str:
    """An OFF file of polygons."""
    lines = ["OFF", f"{len(points)} {len(polygons)} 0"]
    lines += [f"{x!r} {y!r} {z!r}" for x, y, z in np.asarray(points, float).tolist()]
    lines += [" ".join(map(str, [len(polygon), *map(int, polygon)])) for polygon in polygons]
    return "\n".join(lines) + "\n"


def ply_bytes(points: Any, polygons: Any, *, kind: str = "float", encoding: str = "binary_little_endian") -> bytes:
    """A PLY file of polygons."""
    points = np.asarray(points, float)
    head = f"ply\nformat {encoding} 1.0\ncomment made by a test\nelement vertex {len(points)}\n"
    head += "".join(f"property {kind} {axis}\n" for axis in "xyz")
    head += f"element face {len(polygons)}\nproperty list uchar int vertex_indices\nend_header\n"
    if encoding == "ascii":
        body = "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in points.tolist())
        body += "".join(" ".join(map(str, [len(p), *map(int, p)])) + "\n" for p in polygons)
        return (head + body).encode()
    order = "<" if encoding == "binary_little_endian" else ">"
    data = points.astype(order + ("f4" if kind == "float" else "f8")).tobytes()
    for polygon in polygons:
        data += bytes([len(polygon)]) + np.asarray(polygon, order + "i4").tobytes()
    return head.encode() + data


def stl_text(points: Any, faces: Any, name: str = "solid_a") -> str:
    """An STL file as text."""
    lines = [f"solid {name}"]
    for face in faces:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex " + " ".join(repr(float(v)) for v in points[i]) for i in face]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, f"endsolid {name}", ""])


def stl_bytes(points: Any, faces: Any, *, head: bytes = b"box", count: int | None = None) -> bytes:
    """A binary STL file, of as many faces as its header says, or not."""
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *np.ravel(np.asarray(points)[face]), 0) for face in faces)
    return head.ljust(80) + struct.pack("<I", len(faces) if count is None else count) + body


class Gltf:
    """A glTF document built by hand."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.json: dict[str, Any] = {
            "asset": {"version": "2.0"}, "accessors": [], "bufferViews": [], "meshes": [],
            "nodes": [], "scenes": [{"nodes": []}], "scene": 0,
        }  # fmt: skip

    def accessor(self, values: Any, kind: str = "f4", **extra: Any) -> int:
        """Add an accessor with a view of its own."""
        array = np.atleast_2d(np.asarray(values).astype("<" + kind))
        array = array.T if np.ndim(values) == 1 else array
        self.data += b"\0" * (-len(self.data) % 4)
        width = array.shape[1] * array.itemsize
        stride = width + (-width % 4 if array.shape[1] > 1 else 0)
        rows = np.zeros((len(array), stride), np.uint8)
        rows[:, :width] = np.ascontiguousarray(array).view(np.uint8).reshape(len(array), width)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": rows.size}
        if stride != width:
            view["byteStride"] = stride
        self.data += rows.tobytes()
        self.json["bufferViews"].append(view)
        codes = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
        types = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
        self.json["accessors"].append(
            {"bufferView": len(self.json["bufferViews"]) - 1, "componentType": codes[kind],
             "count": len(array), "type": types[array.shape[1]], **extra}
        )  # fmt: skip
        return len(self.json["accessors"]) - 1

    def mesh(self, *primitives: dict[str, Any], node: dict[str, Any] | None = None, **extra: Any) -> int:
        """Add a mesh, and a node in the scene that shows it."""
        self.json["meshes"].append({"primitives": list(primitives), **extra})
        number = len(self.json["meshes"]) - 1
        self.json["nodes"].append({"mesh": number, **(node or {})})
        self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]) - 1)
        return number

    def box(self, *, size: float = 2.0, shift: float = 0.0, fine: bool = False, **attributes: int) -> dict[str, Any]:
        """A primitive that is a box."""
        points, faces = fine_box(size=size, shift=shift) if fine else box(size, shift)
        indices = self.accessor(faces.reshape(-1), "u2")
        return {"attributes": {"POSITION": self.accessor(points), **attributes}, "indices": indices}

    def at(self, uri: str) -> None:
        """Say that the buffer of the GLB stands elsewhere."""
        self.json["buffers"] = [{"byteLength": len(self.data), "uri": uri}]

    def glb(self) -> bytes:
        """The document as GLB."""
        json_ = {"buffers": [{"byteLength": len(self.data)}], **self.json}
        text = json.dumps(json_).encode()
        text += b" " * (-len(text) % 4)
        body = bytes(self.data) + b"\0" * (-len(self.data) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(body), 0x004E4942) + body
        return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks

    def gltf(self, uri: str | None = None) -> bytes:
        """The document as text, its buffer at a URI or inside."""
        inside = "data:application/octet-stream;base64," + base64.b64encode(bytes(self.data)).decode()
        return json.dumps({**self.json, "buffers": [{"byteLength": len(self.data), "uri": uri or inside}]}).encode()


def split_glb(data: bytes) -> tuple[dict[str, Any], bytes]:
    """JSON and binary of a GLB file."""
    size = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + size]), data[28 + size :]


def read_values(data: bytes, accessor: int) -> np.ndarray:
    """Values of an accessor of a GLB file, read the plain way, by a reader that is not the program's."""
    json_, binary = split_glb(data)
    entry = json_["accessors"][accessor]
    view = json_["bufferViews"][entry["bufferView"]]
    kind = np.dtype(
        {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}[entry["componentType"]]
    )
    width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[entry["type"]]
    start = view.get("byteOffset", 0) + entry.get("byteOffset", 0)
    stride = view.get("byteStride", kind.itemsize * width)
    rows = [np.frombuffer(binary, kind, width, start + i * stride) for i in range(entry["count"])]
    return np.array(rows)


def collect_triangles(points: Any, faces: Any) -> set[tuple[tuple[float, ...], ...]]:
    """Triangles by their positions, turned so that the least corner is first."""
    found = set()
    for face in np.asarray(faces):
        corners = [tuple(float(v) + 0.0 for v in np.asarray(points)[i]) for i in face]
        least = corners.index(min(corners))
        found.add(tuple(corners[least:] + corners[:least]))
    return found


def write(path: Path, content: str | bytes) -> Path:
    """Put content into a file."""
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path
