"""What glTF says is drawn: primitives under their nodes, with materials, textures, all UV sets; y up."""

from __future__ import annotations

import base64
import io
import json
import struct
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from textured.model import CLAMP, MIRROR, REPEAT, Floats, Integers, Material, Surface, Texture

COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
WRAPS = {33071: CLAMP, 33648: MIRROR, 10497: REPEAT}
NEAREST = 9728


def read_gltf(path: Path) -> list[Surface]:
    """All surfaces of the scene that is shown."""
    document = Document(path)
    scenes = document.json.get("scenes", [])
    roots = scenes[document.json.get("scene", 0)].get("nodes", []) if scenes else []
    surfaces: list[Surface] = []
    for root in roots:
        walk_nodes(document, root, np.eye(4), surfaces)
    return surfaces


def walk_nodes(document: Document, number: int, above: Floats, surfaces: list[Surface]) -> None:
    """Add the surfaces of a node and of all below it."""
    node = document.json["nodes"][number]
    here = above @ build_matrix(node)
    if "mesh" in node:
        for place in list_instances(document, node):
            for primitive in document.json["meshes"][node["mesh"]]["primitives"]:
                surfaces.append(read_surface(document, primitive, here @ place))
    for child in node.get("children", []):
        walk_nodes(document, child, here, surfaces)


def build_matrix(node: dict[str, Any]) -> Floats:
    """Build the transform of a node, or of an instance."""
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    made = np.eye(4)
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    made[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    made[:3, :3] *= node.get("scale", (1, 1, 1))
    made[:3, 3] = node.get("translation", (0, 0, 0))
    return made


def list_instances(document: Document, node: dict[str, Any]) -> list[Floats]:
    """List the transforms of a mesh within its node: one, or those of EXT_mesh_gpu_instancing."""
    entry = node.get("extensions", {}).get("EXT_mesh_gpu_instancing")
    if entry is None:
        return [np.eye(4)]
    values = {name.lower(): document.read_accessor(number) for name, number in entry["attributes"].items()}
    count = len(next(iter(values.values())))
    return [build_matrix({name: rows[k] for name, rows in values.items()}) for k in range(count)]


def read_surface(document: Document, primitive: dict[str, Any], place: Floats) -> Surface:
    """Read a primitive in the world; a mirrored one keeps its front outside."""
    attributes = {name: document.read_accessor(number) for name, number in primitive["attributes"].items()}
    points = attributes["POSITION"] @ place[:3, :3].T + place[:3, 3]
    mirrored = float(np.linalg.det(place[:3, :3])) < 0
    order = document.read_accessor(primitive["indices"])[:, 0] if "indices" in primitive else np.arange(len(points))
    faces = list_triangles(order.astype(np.int64), primitive.get("mode", 4))
    normals = attributes.get("NORMAL")
    if normals is not None:
        normals = normals @ np.linalg.inv(place[:3, :3])
    colors = attributes.get("COLOR_0")
    if colors is not None and colors.shape[1] == 3:
        colors = np.column_stack([colors, np.ones(len(colors))])
    return Surface(
        points, faces[:, ::-1] if mirrored else faces, document.find_material(primitive.get("material")), normals,
        {int(name[9:]): values for name, values in attributes.items() if name.startswith("TEXCOORD_")}, colors,
    )  # fmt: skip


def list_triangles(order: Integers, mode: int) -> Integers:
    """List the faces of triangles, strips and fans."""
    if mode == 4:
        return order[: len(order) // 3 * 3].reshape(-1, 3)
    if mode == 6:
        return np.stack([np.full(len(order) - 2, order[0]), order[1:-1], order[2:]], axis=1)
    if mode != 5:
        return np.empty((0, 3), np.int64)
    faces = np.stack([order[:-2], order[1:-1], order[2:]], axis=1)
    faces[1::2] = faces[1::2, [1, 0, 2]]
    return faces


class Document:
    """The JSON of a file, and what it points to."""

    def __init__(self, path: Path) -> None:
        data = path.read_bytes()
        self.folder = path.parent
        self.binary = b""
        if data[:4] == b"glTF":
            size = struct.unpack_from("<I", data, 12)[0]
            self.binary = data[28 + size :]
            data = data[20 : 20 + size]
        self.json: dict[str, Any] = json.loads(data)
        self.buffers = [self.load_resource(buffer.get("uri")) for buffer in self.json.get("buffers", [])]
        self.textures: dict[str, Texture] = {}
        self.materials: dict[int | None, Material] = {}

    def load_resource(self, uri: str | None) -> bytes:
        """Load bytes beside the file, within it, or in the URI itself."""
        if uri is None:
            return self.binary
        if uri.startswith("data:"):
            return base64.b64decode(uri.partition(",")[2])
        return (self.folder / unquote(uri)).read_bytes()

    def read_rows(self, view: int, kind: str, width: int, count: int, offset: int) -> NDArray[Any]:
        """Read numbers in a view of a buffer."""
        entry = self.json["bufferViews"][view]
        item = np.dtype(kind)
        start = entry.get("byteOffset", 0) + offset
        stride = entry.get("byteStride", item.itemsize * width)
        data = np.frombuffer(self.buffers[entry["buffer"]], np.uint8)
        places = start + np.arange(count)[:, None] * stride + np.arange(width * item.itemsize)
        return np.ascontiguousarray(data[places]).view(item).reshape(count, width)

    def read_accessor(self, number: int) -> Floats:
        """Read the values of an accessor, (n, k); normalized integers as shares."""
        entry = self.json["accessors"][number]
        kind, width, count = COMPONENTS[entry["componentType"]], WIDTHS[entry["type"]], entry["count"]
        values = np.zeros((count, width), kind)
        if "bufferView" in entry:
            values = self.read_rows(entry["bufferView"], kind, width, count, entry.get("byteOffset", 0)).copy()
        if "sparse" in entry:
            some = entry["sparse"]
            where, what = some["indices"], some["values"]
            codes = COMPONENTS[where["componentType"]]
            own = self.read_rows(where["bufferView"], codes, 1, some["count"], where.get("byteOffset", 0))[:, 0]
            values[own] = self.read_rows(what["bufferView"], kind, width, some["count"], what.get("byteOffset", 0))
        if entry.get("normalized"):
            return np.maximum(values / float(np.iinfo(kind).max), -1.0)
        return values.astype(np.float64)

    def find_material(self, number: int | None) -> Material:
        """Find a material, the plain one where none is named; the same object each time."""
        if number not in self.materials:
            self.materials[number] = self.read_material({} if number is None else self.json["materials"][number])
        return self.materials[number]

    def read_material(self, entry: dict[str, Any]) -> Material:
        """Read the drawn properties of a material."""
        base = entry.get("pbrMetallicRoughness", {})
        red, green, blue, opacity = base.get("baseColorFactor", (1.0, 1.0, 1.0, 1.0))
        return Material(
            entry.get("name", ""), (red, green, blue, opacity),
            self.read_texture(base.get("baseColorTexture")), self.read_texture(entry.get("occlusionTexture")),
            entry.get("alphaMode", "OPAQUE"), entry.get("alphaCutoff", 0.5), entry.get("doubleSided", False),
        )  # fmt: skip

    def read_texture(self, entry: dict[str, Any] | None) -> Texture | None:
        """Read a texture as a material refers to it."""
        if entry is None:
            return None
        texture = self.json["textures"][entry["index"]]
        sampler = self.json["samplers"][texture["sampler"]] if "sampler" in texture else {}
        moved = entry.get("extensions", {}).get("KHR_texture_transform", {})
        (across, down), turn = moved.get("scale", (1.0, 1.0)), moved.get("rotation", 0.0)
        cos, sin = np.cos(turn), np.sin(turn)
        x, y = moved.get("offset", (0.0, 0.0))
        return Texture(
            self.load_image(texture["source"]),
            (WRAPS[sampler.get("wrapS", 10497)], WRAPS[sampler.get("wrapT", 10497)]),
            sampler.get("magFilter") == NEAREST,
            moved.get("texCoord", entry.get("texCoord", 0)),
            np.array([[cos * across, sin * down, x], [-sin * across, cos * down, y]]),
        )

    def load_image(self, number: int) -> Floats:
        """Load RGBA of an image."""
        entry = self.json["images"][number]
        if "bufferView" in entry:
            view = self.json["bufferViews"][entry["bufferView"]]
            start = view.get("byteOffset", 0)
            data = self.buffers[view["buffer"]][start : start + view["byteLength"]]
        else:
            data = self.load_resource(entry["uri"])
        return np.asarray(Image.open(io.BytesIO(data)).convert("RGBA"), float) / 255.0
