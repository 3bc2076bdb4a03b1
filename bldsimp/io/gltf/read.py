"""Read the meshes of a glTF document: each mesh is one problem, its triangle primitives are the parts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...model import LARGEST_COORDINATE, Mesh, Part, Values, cast_indices, check_finite, check_indices
from ...tolerance import find_number_format
from ..input_folder import LoadFile
from .attributes import (
    FAN,
    TRIANGLES,
    SharedVertices,
    list_attribute_names,
    list_fixed_names,
    list_primitives,
    read_attributes,
)
from .document import Document, Json
from .materials import TextureSizes, is_one_sided, read_material, read_name
from .references import INSTANCING


def read_meshes(document: Document, load: LoadFile, warnings: list[str]) -> list[Mesh]:
    """Read all meshes of a document that have triangles.

    Parameters
    ----------
    document : Document
    load : function of a relative path
        Returns the bytes of an image beneath the document's folder, or None.
    warnings : list of str
        Receives a message about images that cannot be decoded.

    Raises
    ------
    InputError
        If the document is damaged, or has no triangles.
    """
    transforms, fixed = _place_meshes(document)
    sizes = TextureSizes(document, load, warnings)
    meshes = []
    for number in range(len(document.items("meshes"))):
        mesh = _read_mesh(document, sizes, number, fixed.get(number, []))
        if mesh is not None:
            mesh.transforms = np.array(transforms.get(number, [])).reshape(-1, 4, 4)
            meshes.append(mesh)
    if not meshes:
        raise InputError("the glTF file has no triangles: bldsimp simplifies surfaces")
    if not any(len(mesh.transforms) for mesh in meshes):
        # The file is a mere library of meshes: each shows once.
        for mesh in meshes:
            mesh.transforms = np.eye(4)[None]
    return meshes


def _read_mesh(document: Document, sizes: TextureSizes, number: int, fixed: list[str]) -> Mesh | None:
    """Read one mesh, or return None if it has no triangles; its nodes make all of it `fixed`."""
    name = read_name(document.items("meshes")[number], f"mesh {number}")
    parts, faces, texels = [], [], []
    primitives = list_primitives(document, number)
    for index, primitive, vertices in primitives:
        faces.append(_read_faces(document, primitive, vertices, f"{name}, primitive {index}") + vertices.start)
        material = read_material(document, primitive)
        own = tuple(dict.fromkeys((*fixed, *list_fixed_names(document, primitive, vertices.count))))
        attributes = tuple(dict.fromkeys((*list_attribute_names(primitive), *own)))
        label = material.name if material and material.name else f"primitive {index}"
        parts.append(Part(f"{name} / {label}", attributes, own, is_one_sided(document, primitive), material))
        texels.append(sizes.measure(primitive))
    if not sum(map(len, faces)):
        return None
    groups = list(dict.fromkeys(vertices for _, _, vertices in primitives))
    positions = [group.accessors["POSITION"] for group in groups]
    points = np.concatenate([document.read_numbers(one) for one in positions])
    if points.shape[1] != 3:
        raise InputError(f"the positions of glTF mesh '{name}' are not three numbers: the file is damaged")
    joined = cast_indices(np.concatenate(faces))
    check_finite(points, joined)
    part = np.repeat(cast_indices(np.arange(len(parts))), [len(one) for one in faces])
    mesh = Mesh(name=name, points=points, faces=joined, part_of_face=part, parts=parts, number=number)
    mesh.attributes = read_attributes(document, groups, mesh, texels)
    step = max(document.find_step(one) for one in positions)
    mesh.quantized = bool(step)
    mesh.single, mesh.rounding = (False, step / 2.0) if step else find_number_format(mesh.used_points)
    if any("NORMAL" in group.accessors for group in groups):
        mesh.normals = np.concatenate([_read_normals(document, group) for group in groups])
    return mesh


def _read_faces(document: Document, primitive: Json, vertices: SharedVertices, name: str) -> NDArray[np.int64]:
    """Read the faces of a primitive, whatever its mode."""
    corners = document.read_indices(primitive["indices"]) if "indices" in primitive else np.arange(vertices.count)
    try:
        check_indices(corners, vertices.count)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None
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


def _read_normals(document: Document, group: SharedVertices) -> Values:
    """Read the normals of a group, zero if it has none."""
    if "NORMAL" not in group.accessors:
        return np.zeros((group.count, 3))
    found = document.read_numbers(group.accessors["NORMAL"])
    if found.shape != (group.count, 3):
        raise InputError("a glTF primitive does not have as many normals as positions: the file is damaged")
    return np.asarray(np.nan_to_num(found, posinf=0.0, neginf=0.0))


def _place_meshes(document: Document) -> tuple[dict[int, list[Values]], dict[int, list[str]]]:
    """Return the world transforms of each mesh, over all scenes, and what of its nodes no result can follow."""
    nodes, meshes = document.items("nodes"), document.items("meshes")
    transforms: dict[int, list[Values]] = {}
    fixed: dict[int, list[str]] = {}
    scaled = _list_scaled_nodes(document)
    stack = [(root, np.eye(4), False) for root in reversed(_list_roots(document))]
    seen: set[int] = set()
    while stack:
        index, above, grows = stack.pop()
        if not isinstance(index, int) or not 0 <= index < len(nodes) or index in seen:
            raise InputError("the node tree of the glTF file is not a tree: the file is damaged")
        seen.add(index)
        node = nodes[index]
        world = _multiply_transforms(above, _read_transform(node))
        grows = grows or index in scaled
        if "mesh" in node:
            mesh = node["mesh"]
            if not isinstance(mesh, int) or not 0 <= mesh < len(meshes):
                raise InputError(f"glTF node {index} names mesh {mesh}, which does not exist: the file is damaged")
            if not np.all(np.abs(world) <= LARGEST_COORDINATE):
                raise InputError(
                    f"glTF node {index} and those above it scale or move its mesh beyond 1e100: repair their transforms"
                )
            placed = [_multiply_transforms(world, instance) for instance in _read_instances(document, node)]
            transforms.setdefault(mesh, []).extend(placed)
            # The tolerance would grow with an animated scale.
            reasons = ["skin"] * ("skin" in node) + ["animated scale"] * grows
            fixed.setdefault(mesh, []).extend(reasons)
        stack += [(child, world, grows) for child in reversed(node.get("children", []))]
    return transforms, fixed


def _list_scaled_nodes(document: Document) -> set[int]:
    """List the nodes whose scale an animation changes."""
    targets = [
        channel.get("target", {}) for animation in document.items("animations") for channel in animation["channels"]
    ]
    return {target["node"] for target in targets if target.get("path") == "scale" and "node" in target}


def _list_roots(document: Document) -> list[int]:
    """List the root nodes of all scenes, or of the whole document if it has no scene."""
    scenes = document.items("scenes")
    if scenes:
        return list(dict.fromkeys(root for scene in scenes for root in scene.get("nodes", [])))
    children = {child for node in document.items("nodes") for child in node.get("children", [])}
    return [index for index in range(len(document.items("nodes"))) if index not in children]


def _read_instances(document: Document, node: Json) -> list[Values]:
    """Read the transforms that EXT_mesh_gpu_instancing gives a node; the identity if it has none."""
    accessors = node.get("extensions", {}).get(INSTANCING, {}).get("attributes", {})
    known = {
        key.lower(): document.read_numbers(accessors[key])
        for key in ("TRANSLATION", "ROTATION", "SCALE")
        if key in accessors
    }
    if not known:
        return [np.eye(4)]
    count = min(map(len, known.values()))
    return [_read_transform({key: values[i] for key, values in known.items()}) for i in range(count)]


def _read_transform(node: Json) -> Values:
    """Read a node's own 4 x 4 transform."""
    if "matrix" in node:
        transform = np.array(node["matrix"], np.float64)
        if transform.shape != (16,):
            raise InputError("a node of the glTF file has a matrix without 16 numbers: the file is damaged")
        transform = np.ascontiguousarray(transform.reshape(4, 4).T)
    else:
        scale = node.get("scale", (1.0, 1.0, 1.0))
        transform = np.eye(4)
        transform[:3, :3] = _rotate_axes(*(float(value) for value in node.get("rotation", (0.0, 0.0, 0.0, 1.0))))
        transform[:3, :3] *= [float(scale[0]), float(scale[1]), float(scale[2])]
        transform[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    if not np.isfinite(transform).all():
        raise InputError("a node of the glTF file has a transform that is not finite: the file is damaged")
    return transform


def _rotate_axes(x: float, y: float, z: float, w: float) -> list[list[float]]:
    """Return the 3 x 3 matrix of a quaternion."""
    # A quaternion of single precision is not quite of length one; its matrix must not stretch.
    length = x * x + y * y + z * z + w * w
    s = 2.0 / length if length else 0.0
    return [
        [1.0 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)],
        [s * (x * y + z * w), 1.0 - s * (x * x + z * z), s * (y * z - x * w)],
        [s * (x * z - y * w), s * (y * z + x * w), 1.0 - s * (x * x + y * y)],
    ]


def _multiply_transforms(a: Values, b: Values) -> Values:
    """Multiply 4 x 4 matrices, summed in a fixed order; infinite or no number beyond double precision."""
    left, right = a.tolist(), b.tolist()
    return np.array([[sum(left[i][k] * right[k][j] for k in range(4)) for j in range(4)] for i in range(4)])
