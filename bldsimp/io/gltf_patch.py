"""glTF to glTF: the source's own JSON, with new accessors for the primitives that were simplified.

Names, nodes, instances, materials, images, animations, extras and unknown extensions stay as they are.
"""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..normals import shaded
from ..options import Options
from ..rows import distinct_rows
from ..scene import Light, Mesh, Scene
from .gltf import Document
from .gltf_attributes import HARMLESS
from .gltf_body import Body
from .gltf_columns import Column, columns
from .gltf_delimit import BareMaterials, without_lost
from .gltf_references import INSTANCING, instancing_slots, primitive_slots, unknown_extensions
from .gltf_rows import GltfMesh, Rows
from .gltf_settle import settle


def patched(
    scene: Scene, lights: list[Light], options: Options, warnings: list[str], *, whole: bool, first: bool
) -> tuple[dict[str, Any], bytes, int]:
    """A scene read from glTF with its simplified primitives replaced.

    Parameters
    ----------
    scene : Scene
    lights : list of Light
    options : Options
    warnings : list of str
        Added to.
    whole : bool
        All data goes into one buffer; else buffers beside the document that keep all their data stay.
    first : bool
        The buffer that is made comes before all others, as in a GLB.

    Returns
    -------
    json : dict
        Names one buffer without a URI, or none, and those that stay.
    binary : bytes
        Of the one without a URI.
    vertices : int
        Written for the primitives that have triangles.
    """
    document: Document = scene.source
    json_ = copy.deepcopy(document.json)
    body, bare = Body(), BareMaterials(json_)
    replaced: set[int] = set()
    vertices = 0
    # A document must show something: without any triangle it stays as it is.
    if any(len(light.faces) for light in lights):
        for mesh, light in zip(scene.meshes, lights, strict=True):
            vertices += _replace_mesh(document, json_, body, mesh, light, options, replaced, bare)
        _remove_meshes(json_, {mesh.source.index for mesh in scene.meshes}, replaced)
    if replaced and unknown_extensions(json_):
        names = ", ".join(unknown_extensions(json_))
        warnings.append(f"extensions that bldsimp does not know were kept as they are: {names}")
    binary = settle(document, json_, body, replaced, whole=whole or bool(document.unpacked), first=first)
    return json_, binary, vertices


def _replace_mesh(
    document: Document,
    json_: dict[str, Any],
    body: Body,
    mesh: Mesh,
    light: Light,
    options: Options,
    replaced: set[int],
    bare: BareMaterials,
) -> int:
    """Replace the simplified primitives of one mesh; the number of its vertices."""
    source: GltfMesh = mesh.source
    primitives = json_["meshes"][source.index]["primitives"]
    light, normals = shaded(mesh, light, options)
    groups: dict[Rows, list[int]] = {}
    for number, part in enumerate(mesh.parts):
        if not part.fixed:
            groups.setdefault(part.source.rows, []).append(number)
    untouched = np.array([bool(part.fixed) for part in mesh.parts])
    vertices = len(np.unique(light.faces[untouched[light.part_of_face]]))
    empty: list[int] = []
    for rows, numbers in groups.items():
        faces = [light.faces[light.part_of_face == number] for number in numbers]
        empty += [number for number, own in zip(numbers, faces, strict=True) if not len(own)]
        if not sum(map(len, faces)):
            continue
        used, corners = _compact(np.concatenate(faces), len(light.points))
        found = columns(document, mesh, light, rows, used, normals, options)
        first, inverse = distinct_rows(np.concatenate([each.values.astype(np.float64) for each in found], axis=1))
        accessors = {each.name: _add_column(document, body, rows, each, first) for each in found}
        vertices += len(first)
        # Starts of the parts, and the end of the last.
        starts = np.cumsum([0, *map(len, faces)])
        for number, start, end in zip(numbers, starts, starts[1:], strict=False):
            if start < end:
                primitive = primitives[mesh.parts[number].source.index]
                indices = body.add_indices(inverse[corners[start:end]], len(first))
                _replace_primitive(bare, primitive, accessors, indices, replaced, options)
    _remove(primitives, [mesh.parts[number].source.index for number in empty], replaced)
    return vertices


def _compact(faces: NDArray[np.int32], count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows that faces use, ascending, and the faces in terms of them."""
    used = np.zeros(count, bool)
    used[faces] = True
    return np.flatnonzero(used), (np.cumsum(used) - 1)[faces]


def _add_column(document: Document, body: Body, rows: Rows, column: Column, first: NDArray[np.int64]) -> int:
    """Add some rows of a column; the new accessor is called as the one it stands for."""
    number = body.add_vertices(
        column.values[first], normalized=column.normalized, bounds=column.name == "POSITION"
    )
    old = rows.accessor(column.name)
    if old is not None:
        entry = document.items("accessors")[old]
        body.accessors[number].update({key: entry[key] for key in ("name", "extras") if key in entry})
    return number


def _replace_primitive(
    bare: BareMaterials,
    primitive: dict[str, Any],
    accessors: dict[str, int],
    indices: int,
    replaced: set[int],
    options: Options,
) -> None:
    """Point a primitive at new accessors (negative numbers until they are settled)."""
    replaced.update(container[key] for container, key in primitive_slots(primitive))
    if not options.keeps("uv"):
        bare.take(primitive)
    primitive["attributes"] = {name: -1 - number for name, number in accessors.items()}
    primitive["indices"] = -1 - indices
    if primitive.get("mode", 4) != 4:
        primitive["mode"] = 4
    # Morph targets without any entry.
    primitive.pop("targets", None)
    if "extensions" in primitive:
        known = {key: value for key, value in primitive["extensions"].items() if key in HARMLESS}
        left = {key: without_lost(key, value, set(accessors), options) for key, value in known.items()}
        primitive["extensions"] = {key: value for key, value in left.items() if value}
        if not primitive["extensions"]:
            del primitive["extensions"]


def _remove(primitives: list[dict[str, Any]], numbers: list[int], replaced: set[int]) -> None:
    """Take primitives without triangles away."""
    for number in sorted(numbers, reverse=True):
        replaced.update(container[key] for container, key in primitive_slots(primitives[number]))
        del primitives[number]


def _remove_meshes(json_: dict[str, Any], numbers: set[int], replaced: set[int]) -> None:
    """Take meshes without primitives away; nodes that placed them stay, and show nothing."""
    meshes = json_.get("meshes", [])
    left = [i for i, mesh in enumerate(meshes) if i not in numbers or mesh["primitives"]]
    if len(left) == len(meshes):
        return
    json_["meshes"] = [meshes[i] for i in left]
    place = {old: new for new, old in enumerate(left)}
    for node in json_.get("nodes", []):
        if node.get("mesh") in place:
            node["mesh"] = place[node["mesh"]]
        elif "mesh" in node:
            replaced.update(container[key] for container, key in instancing_slots(node))
            for key in ("mesh", "skin", "weights"):
                node.pop(key, None)
            node.get("extensions", {}).pop(INSTANCING, None)
            if not node.get("extensions", True):
                del node["extensions"]
