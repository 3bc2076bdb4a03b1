"""Where the nodes of a glTF document place its meshes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...model import LARGEST_COORDINATE
from .document import Document
from .references import INSTANCING


def placed_meshes(document: Document) -> tuple[dict[int, list[NDArray[np.float64]]], dict[int, list[str]]]:
    """World transforms of each mesh, over all scenes; and what its nodes do that no simplified mesh can follow."""
    nodes, meshes = document.items("nodes"), document.items("meshes")
    transforms: dict[int, list[NDArray[np.float64]]] = {}
    bent: dict[int, list[str]] = {}
    scaled = _animated(document, "scale")
    stack = [(root, np.eye(4), False) for root in reversed(_roots(document))]
    seen: set[int] = set()
    while stack:
        index, above, grows = stack.pop()
        if not isinstance(index, int) or not 0 <= index < len(nodes) or index in seen:
            raise InputError("the node tree of the glTF file is not a tree: the file is damaged")
        seen.add(index)
        node = nodes[index]
        world = product(above, local_transform(node))
        grows = grows or index in scaled
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
                bent.setdefault(mesh, []).append("skin")
            if grows:
                # The tolerance would grow with it.
                bent.setdefault(mesh, []).append("animated scale")
        stack += [(child, world, grows) for child in reversed(node.get("children", []))]
    return transforms, bent


def _animated(document: Document, path: str) -> set[int]:
    """Nodes of which an animation changes a property."""
    targets = [
        channel.get("target", {}) for animation in document.items("animations") for channel in animation["channels"]
    ]
    return {target["node"] for target in targets if target.get("path") == path and "node" in target}


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
