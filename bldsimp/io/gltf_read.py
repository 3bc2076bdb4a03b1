"""From a glTF document to meshes: every glTF mesh is one problem, its triangle primitives are the parts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..number_format import number_format
from ..scene import LARGEST_COORDINATE, Mesh, Part, check_finite
from .gltf import Document, refuse_packed
from .gltf_references import INSTANCING
from .surface import Material

TRIANGLES, STRIP, FAN = 4, 5, 6
HARMLESS = {"KHR_materials_variants"}
"""Extensions of a primitive that do not speak of its vertices or faces."""


@dataclass(frozen=True)
class Rows:
    """Vertices that primitives share: the accessors they are read from, and where their rows start."""

    position: int
    normal: int | None
    texture: int | None
    color: int | None
    start: int
    count: int


@dataclass
class Primitive:
    """`Part.source` of a part read from glTF."""

    index: int
    rows: Rows
    material: Material | None


@dataclass
class GltfMesh:
    """`Mesh.source` of a mesh read from glTF."""

    index: int
    rows: list[Rows]
    carried: dict[str, NDArray[np.float64]]


def gltf_meshes(document: Document) -> list[Mesh]:
    """All meshes of a document that have triangles.

    Raises
    ------
    InputError
    """
    for extension in document.json.get("extensionsRequired", []):
        refuse_packed(extension)
    transforms, skinned = _instances(document)
    meshes = []
    for index in range(len(document.items("meshes"))):
        mesh = _mesh(document, index, index in skinned)
        if mesh is not None:
            if transforms.get(index):
                mesh.transforms = np.array(transforms[index])
            meshes.append(mesh)
    if not meshes:
        raise InputError("the glTF file has no triangles: bldsimp simplifies surfaces")
    return meshes


def _mesh(document: Document, index: int, skinned: bool) -> Mesh | None:
    """One mesh, or None where it has no triangles."""
    entry = document.items("meshes")[index]
    name = _name(entry, f"mesh {index}")
    shared: dict[tuple[int | None, ...], Rows] = {}
    parts, faces = [], []
    rows_so_far = 0
    for number, primitive in enumerate(entry.get("primitives", [])):
        for extension in primitive.get("extensions", {}):
            refuse_packed(extension)
        attributes = primitive.get("attributes", {})
        if primitive.get("mode", TRIANGLES) not in (TRIANGLES, STRIP, FAN) or "POSITION" not in attributes:
            continue
        position = attributes["POSITION"]
        key = position, *(attributes.get(name) for name in ("NORMAL", "TEXCOORD_0", "COLOR_0"))
        if key not in shared:
            count = len(document.accessor(position))
            shared[key] = Rows(position, key[1], key[2], key[3], rows_so_far, count)
            rows_so_far += count
        rows = shared[key]
        own = _faces(document, primitive, rows, f"{name}, primitive {number}")
        material = _material(document, primitive)
        parts.append(
            Part(
                _part_name(name, number, material),
                _carried_names(entry, primitive, skinned),
                Primitive(number, rows, material),
            )
        )
        faces.append(own + rows.start)
    if not sum(map(len, faces)):
        return None
    return _joined(document, index, name, list(shared.values()), parts, faces)


def _joined(
    document: Document, index: int, name: str, rows: list[Rows], parts: list[Part], faces: list[NDArray[Any]]
) -> Mesh:
    """One mesh of the vertices and faces of its primitives."""
    points = np.concatenate([document.numbers(group.position) for group in rows])
    if points.shape[1] != 3:
        raise InputError(f"the positions of glTF mesh '{name}' are not three numbers: the file is damaged")
    joined = np.concatenate(faces).astype(np.int32)
    check_finite(points, joined)
    step = max(document.step(group.position) for group in rows)
    mesh = Mesh(
        name=name,
        points=points,
        faces=joined,
        part_of_face=np.repeat(np.arange(len(parts), dtype=np.int32), [len(own) for own in faces]),
        parts=parts,
        source=GltfMesh(index, rows, {}),
    )
    mesh.quantized = bool(step)
    mesh.single, mesh.rounding = (False, step / 2.0) if step else number_format(mesh.used_points)
    if any(group.normal is not None for group in rows):
        mesh.normals = np.concatenate([_normals(document, group) for group in rows])
    mesh.source.carried = _carried(document, index, mesh)
    return mesh


def _faces(document: Document, primitive: dict[str, Any], rows: Rows, name: str) -> NDArray[np.int64]:
    """Faces of a primitive, whatever its mode."""
    if "indices" in primitive:
        corners = document.accessor(primitive["indices"])[:, 0].astype(np.int64)
    else:
        corners = np.arange(rows.count)
    if len(corners) and int(corners.max()) >= rows.count:
        raise InputError(
            f"{name}: index {int(corners.max()):,} names a vertex that does not exist"
            f" (there are {rows.count:,}): the file is damaged"
        )
    mode = primitive.get("mode", TRIANGLES)
    if mode == TRIANGLES:
        triples: NDArray[np.int64] = corners[: len(corners) // 3 * 3].reshape(-1, 3)
        return triples
    if len(corners) < 3:
        return np.zeros((0, 3), np.int64)
    if mode == FAN:
        first = np.full(len(corners) - 2, corners[0])
        return np.stack([corners[1:-1], corners[2:], first], axis=1)
    faces: NDArray[np.int64] = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    faces[1::2] = faces[1::2][:, [0, 2, 1]]
    a, b, c = faces.T
    proper = (a != b) & (b != c) & (a != c)
    return np.asarray(faces[proper])


def _carried_names(entry: dict[str, Any], primitive: dict[str, Any], skinned: bool) -> tuple[str, ...]:
    """What a primitive carries beside positions and normals."""
    names = [name for name in primitive["attributes"] if name not in ("POSITION", "NORMAL")]
    if primitive.get("targets"):
        names.append("morph targets")
    if skinned:
        names.append("skin")
    names += [name for name in primitive.get("extensions", {}) if name not in HARMLESS]
    return tuple(names)


def _carried(document: Document, index: int, mesh: Mesh) -> dict[str, NDArray[np.float64]]:
    """Texture coordinates and colours per row, for writing other formats; NaN where a row has none."""
    carried: dict[str, NDArray[np.float64]] = {}
    primitives = document.items("meshes")[index]["primitives"]
    for part in mesh.parts:
        source: Primitive = part.source
        for name in ("TEXCOORD_0", "COLOR_0"):
            if name not in part.attributes:
                continue
            values = document.numbers(primitives[source.index]["attributes"][name])
            width = 2 if name == "TEXCOORD_0" else 4
            target = carried.setdefault(name, np.full((len(mesh.points), width), np.nan))
            count = min(source.rows.count, len(values))
            block = target[source.rows.start : source.rows.start + count]
            block[:, : values.shape[1]] = values[:count, :width]
            if name == "COLOR_0" and values.shape[1] == 3:
                block[:, 3] = 1.0
            elif name == "TEXCOORD_0":
                block[:, 1] = 1.0 - block[:, 1]
    return carried


def _normals(document: Document, group: Rows) -> NDArray[np.float64]:
    """Normals of a group, zero where it has none."""
    if group.normal is None:
        return np.zeros((group.count, 3))
    found = document.numbers(group.normal)
    if found.shape != (group.count, 3):
        raise InputError("a glTF primitive has not as many normals as positions: the file is damaged")
    return np.nan_to_num(found, posinf=0.0, neginf=0.0)


def _part_name(mesh: str, number: int, material: Material | None) -> str:
    return f"{mesh} / {material.name}" if material and material.name else f"{mesh} / primitive {number}"


def _material(document: Document, primitive: dict[str, Any]) -> Material | None:
    """Name, colour and texture of a primitive's material."""
    number = primitive.get("material")
    materials = document.items("materials")
    if number is None or not 0 <= number < len(materials):
        return None
    entry = materials[number]
    metallic = entry.get("pbrMetallicRoughness", {})
    r, g, b, a = (float(value) for value in metallic.get("baseColorFactor", (1.0, 1.0, 1.0, 1.0)))
    color = r, g, b, a
    texture = metallic.get("baseColorTexture", {}).get("index")
    textures = document.items("textures")
    image = textures[texture].get("source") if texture is not None and 0 <= texture < len(textures) else None
    if image is not None and (not isinstance(image, int) or not 0 <= image < len(document.items("images"))):
        raise InputError(f"glTF texture {texture} names image {image}, which is not there: the file is damaged")
    return Material(_name(entry, f"material {number}"), color, None if image is None else str(image))


def _name(entry: dict[str, Any], default: str) -> str:
    """A name that every encoding takes: JSON can name half of a surrogate pair."""
    return str(entry.get("name", default)).encode("utf-8", "replace").decode("utf-8")


def _instances(document: Document) -> tuple[dict[int, list[NDArray[np.float64]]], set[int]]:
    """World transforms of each mesh, over all scenes; and the meshes that a skin bends."""
    nodes, meshes = document.items("nodes"), document.items("meshes")
    transforms: dict[int, list[NDArray[np.float64]]] = {}
    skinned: set[int] = set()
    stack = [(root, np.eye(4)) for root in reversed(_roots(document))]
    seen: set[int] = set()
    while stack:
        index, above = stack.pop()
        if not isinstance(index, int) or not 0 <= index < len(nodes) or index in seen:
            raise InputError("the node tree of the glTF file is not a tree: the file is damaged")
        seen.add(index)
        node = nodes[index]
        world = product(above, local_transform(node))
        if "mesh" in node:
            mesh = node["mesh"]
            if not isinstance(mesh, int) or not 0 <= mesh < len(meshes):
                raise InputError(f"glTF node {index} names mesh {mesh}, which is not there: the file is damaged")
            if not np.all(np.abs(world) <= LARGEST_COORDINATE):
                raise InputError(
                    f"glTF node {index} and those above it scale or move its mesh beyond 1e100: repair their transforms"
                )
            for instance in _gpu_instances(document, node):
                transforms.setdefault(node["mesh"], []).append(product(world, instance))
            if "skin" in node:
                skinned.add(node["mesh"])
        stack += [(child, world) for child in reversed(node.get("children", []))]
    return transforms, skinned


def _roots(document: Document) -> list[int]:
    """Root nodes of all scenes; of the whole document where it has no scene."""
    scenes = document.items("scenes")
    if scenes:
        return list(dict.fromkeys(root for scene in scenes for root in scene.get("nodes", [])))
    children = {child for node in document.items("nodes") for child in node.get("children", [])}
    return [index for index in range(len(document.items("nodes"))) if index not in children]


def _gpu_instances(document: Document, node: dict[str, Any]) -> list[NDArray[np.float64]]:
    """Transforms that EXT_mesh_gpu_instancing gives a node; the identity where it has none."""
    accessors = node.get("extensions", {}).get(INSTANCING, {}).get("attributes", {})
    known = {
        key.lower(): document.numbers(accessors[key])
        for key in ("TRANSLATION", "ROTATION", "SCALE")
        if key in accessors
    }
    if not known:
        return [np.eye(4)]
    count = min(map(len, known.values()))
    return [local_transform({key: values[i] for key, values in known.items()}) for i in range(count)]


def local_transform(node: dict[str, Any]) -> NDArray[np.float64]:
    """A node's own 4 x 4 transform."""
    transform = _stored_transform(node)
    if not np.isfinite(transform).all():
        raise InputError("a node of the glTF file has a transform that is not finite: the file is damaged")
    return transform


def _stored_transform(node: dict[str, Any]) -> NDArray[np.float64]:
    if "matrix" in node:
        matrix = np.array(node["matrix"], np.float64)
        if matrix.shape != (16,):
            raise InputError("a node of the glTF file has a matrix without 16 numbers: the file is damaged")
        return np.ascontiguousarray(matrix.reshape(4, 4).T)
    x, y, z, w = (float(value) for value in node.get("rotation", (0.0, 0.0, 0.0, 1.0)))
    scale = [float(value) for value in node.get("scale", (1.0, 1.0, 1.0))]
    # A quaternion of single precision is not quite of length one; its matrix must not stretch.
    length = x * x + y * y + z * z + w * w
    s = 2.0 / length if length else 0.0
    rotation = (
        (1.0 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)),
        (s * (x * y + z * w), 1.0 - s * (x * x + z * z), s * (y * z - x * w)),
        (s * (x * z - y * w), s * (y * z + x * w), 1.0 - s * (x * x + y * y)),
    )
    matrix = np.eye(4)
    for row in range(3):
        for column in range(3):
            matrix[row, column] = rotation[row][column] * scale[column]
    matrix[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return matrix


def product(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Matrix product summed in a fixed order; infinite or no number where it leaves the range of double precision."""
    left, right = a.tolist(), b.tolist()
    return np.array([[sum(left[i][k] * right[k][j] for k in range(4)) for j in range(4)] for i in range(4)])
