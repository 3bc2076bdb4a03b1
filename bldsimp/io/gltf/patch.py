"""glTF to glTF: the source's own JSON, with new accessors for the primitives that were simplified.

Names, nodes, instances, materials, images, animations, extras and unknown extensions stay as they are.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...model import Mesh, Scene, SimplifiedMesh
from ...options import Options
from ...stages.normals import resolve_normals
from ...unique_rows import find_unique_rows
from ..unchanged import is_no_lighter
from .attributes import HARMLESS
from .buffers import Body
from .columns import Column, columns
from .delimit import BareMaterials, without_lost
from .document import Document, copied
from .references import INSTANCING, instancing_slots, primitive_slots, unknown_extensions
from .settle import settle
from .vertices import Rows


def patched(
    scene: Scene, lights: list[SimplifiedMesh], options: Options, warnings: list[str], *, whole: bool, first: bool
) -> tuple[dict[str, Any], bytes, int]:
    """A scene read from glTF with its simplified primitives replaced.

    Parameters
    ----------
    scene : Scene
    lights : list of SimplifiedMesh
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
    json_ = copied(document.json)
    patch = _Patch(document, json_, options, Body(), BareMaterials(json_))
    vertices = 0
    # A document must show something: without any triangle it stays as it is.
    if any(len(light.faces) for light in lights):
        for mesh, light in zip(scene.meshes, lights, strict=True):
            vertices += _replace_mesh(patch, mesh, light)
        _remove_meshes(json_, {mesh.source.index for mesh in scene.meshes}, patch.replaced)
    if patch.replaced and unknown_extensions(json_):
        names = ", ".join(unknown_extensions(json_))
        warnings.append(f"extensions that bldsimp does not know were kept as they are: {names}")
    whole |= bool(document.unpacked)
    return json_, settle(document, json_, patch.body, patch.replaced, whole=whole, first=first), vertices


@dataclass
class _Patch:
    """What changes of a document: its JSON, new accessors, and the numbers of those that primitives no longer name."""

    document: Document
    json: dict[str, Any]
    options: Options
    body: Body
    bare: BareMaterials
    replaced: set[int] = field(default_factory=set)


def _replace_mesh(patch: _Patch, mesh: Mesh, light: SimplifiedMesh) -> int:
    """Replace the simplified primitives of one mesh; the number of its vertices."""
    light, normals = resolve_normals(mesh, light, patch.options)
    groups: dict[Rows, list[int]] = {}
    for number, part in enumerate(mesh.parts):
        if not part.fixed:
            groups.setdefault(part.source.rows, []).append(number)
    untouched = mesh.passed_on
    vertices = len(np.unique(light.faces[untouched[light.part_of_face]]))
    empty: list[int] = []
    for rows, numbers in groups.items():
        faces = [light.faces[light.part_of_face == number] for number in numbers]
        empty += [number for number, own in zip(numbers, faces, strict=True) if not len(own)]
        if sum(map(len, faces)):
            vertices += _replace_group(patch, mesh, light, rows, numbers, faces, normals)
    primitives = patch.json["meshes"][mesh.source.index]["primitives"]
    _remove(primitives, [mesh.parts[number].source.index for number in empty], patch.replaced)
    return vertices


def _replace_group(
    patch: _Patch,
    mesh: Mesh,
    light: SimplifiedMesh,
    rows: Rows,
    numbers: list[int],
    faces: list[NDArray[np.int32]],
    normals: NDArray[np.float64] | None,
) -> int:
    """Replace primitives that share vertices; the number of those."""
    used, corners = _compact(np.concatenate(faces), len(light.points))
    found = columns(patch.document, mesh, light, rows, used, normals, patch.options)
    first, inverse = find_unique_rows(np.concatenate([each.values.astype(np.float64) for each in found], axis=1))
    same_names = {each.name for each in found} == {name for name, _ in rows.accessors}
    # What has become no smaller is better left as it is stored.
    if same_names and len(first) == rows.count and is_no_lighter(mesh, light, numbers):
        return len(first)
    accessors = {each.name: _add_column(patch, rows, each, first) for each in found}
    primitives = patch.json["meshes"][mesh.source.index]["primitives"]
    # Starts of the parts, and the end of the last.
    starts = np.cumsum([0, *map(len, faces)])
    for number, start, end in zip(numbers, starts, starts[1:], strict=False):
        if start < end:
            indices = patch.body.add_indices(inverse[corners[start:end]], len(first))
            _replace_primitive(patch, primitives[mesh.parts[number].source.index], accessors, indices)
    return len(first)


def _compact(faces: NDArray[np.int32], count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows that faces use, ascending, and the faces in terms of them."""
    used = np.zeros(count, bool)
    used[faces] = True
    return np.flatnonzero(used), (np.cumsum(used) - 1)[faces]


def _add_column(patch: _Patch, rows: Rows, column: Column, first: NDArray[np.int64]) -> int:
    """Add some rows of a column; the new accessor is called as the one it stands for."""
    old = rows.accessor(column.name)
    entry = {} if old is None else patch.document.items("accessors")[old]
    more = {key: entry[key] for key in ("name", "extras") if key in entry}
    bounds = column.name == "POSITION"
    return patch.body.add_vertices(column.values[first], normalized=column.normalized, bounds=bounds, **more)


def _replace_primitive(patch: _Patch, primitive: dict[str, Any], accessors: dict[str, int], indices: int) -> None:
    """Point a primitive at new accessors (negative numbers until they are settled)."""
    patch.replaced.update(container[key] for container, key in primitive_slots(primitive))
    if not patch.options.keeps("uv"):
        patch.bare.take(primitive)
    primitive["attributes"] = {name: -1 - number for name, number in accessors.items()}
    primitive["indices"] = -1 - indices
    if primitive.get("mode", 4) != 4:
        primitive["mode"] = 4
    # Morph targets without any entry.
    primitive.pop("targets", None)
    if "extensions" in primitive:
        known = {key: value for key, value in primitive["extensions"].items() if key in HARMLESS}
        left = {key: without_lost(key, value, set(accessors), patch.options) for key, value in known.items()}
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
