"""glTF to glTF: the source's own JSON, with new accessors for the primitives that were simplified.

Names, nodes, instances, materials, images, animations, extras and unknown extensions stay as they are.
"""

from __future__ import annotations

import copy
import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InternalError
from ..normals import shaded
from ..options import Options
from ..rows import distinct_rows
from ..scene import Light, Mesh, Scene
from .gltf import Document
from .gltf_body import Body, pack_views, view_json
from .gltf_read import HARMLESS, GltfMesh, Primitive, Rows
from .gltf_references import (
    INSTANCING,
    accessor_slots,
    accessor_view_slots,
    instancing_slots,
    primitive_slots,
    unknown_extensions,
    view_slots,
)
from .gltf_trim import trimmed

_Moved = tuple[NDArray[np.int64], NDArray[np.float64]]


def patched(
    scene: Scene, lights: list[Light], options: Options, warnings: list[str]
) -> tuple[dict[str, Any], bytes, int]:
    """A scene read from glTF with its simplified primitives replaced.

    Returns
    -------
    json : dict
        Names one buffer without a URI, or none.
    binary : bytes
    vertices : int
        Written for the primitives that have triangles.
    """
    document: Document = scene.source
    json_ = copy.deepcopy(document.json)
    body, bare = Body(), _BareMaterials(json_)
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
    binary = _settle(document, json_, body, replaced)
    return json_, binary, vertices


def _replace_mesh(
    document: Document,
    json_: dict[str, Any],
    body: Body,
    mesh: Mesh,
    light: Light,
    options: Options,
    replaced: set[int],
    bare: _BareMaterials,
) -> int:
    """Replace the simplified primitives of one mesh; the number of its vertices."""
    source: GltfMesh = mesh.source
    primitives = json_["meshes"][source.index]["primitives"]
    light, normals = shaded(mesh, light, options)
    made = options.normals == "smooth"
    groups: dict[Rows, list[int]] = {}
    untouched = np.zeros(len(mesh.parts), bool)
    for number, part in enumerate(mesh.parts):
        primitive: Primitive = part.source
        if bool(part.fixed):
            untouched[number] = True
        else:
            groups.setdefault(primitive.rows, []).append(number)
    vertices = len(np.unique(light.faces[untouched[light.part_of_face]]))
    empty: list[int] = []
    for rows, numbers in groups.items():
        faces = [light.faces[light.part_of_face == number] for number in numbers]
        if not sum(map(len, faces)):
            empty += numbers
            continue
        columns = _columns(document, source, rows, _moved(mesh, light), normals, made)
        used, compact = np.unique(np.concatenate(faces), return_inverse=True)
        first, inverse = distinct_rows(
            np.concatenate([values[used].astype(np.float64) for values, _, _ in columns.values()], axis=1)
        )
        attributes = {
            name: body.add_vertices(values[used[first]], normalized=normalized, bounds=bounds)
            for (name, (values, normalized, bounds)) in columns.items()
        }
        vertices += len(first)
        corners = inverse[compact.reshape(-1)].reshape(-1, 3)
        start = 0
        for number, own in zip(numbers, faces, strict=True):
            end = start + len(own)
            if len(own):
                indices = body.add_indices(corners[start:end], len(first))
                primitive = mesh.parts[number].source
                _replace_primitive(bare, primitives[primitive.index], attributes, indices, replaced)
            else:
                empty.append(number)
            start = end
    _remove(primitives, [mesh.parts[number].source.index for number in empty], replaced)
    return vertices


def _moved(mesh: Mesh, light: Light) -> _Moved:
    """Rows of the points that a wide tolerance moved, and where they are now."""
    rows = np.flatnonzero((light.points != mesh.points).any(axis=1))
    return rows, light.points[rows]


def _columns(
    document: Document, source: GltfMesh, rows: Rows, moved: _Moved, normals: NDArray[np.float64] | None, made: bool
) -> dict[str, tuple[NDArray[Any], bool, bool]]:
    """Per attribute the stored values of all rows of the mesh, whether normalized, whether bounded."""
    positions, normalized = _stored(document, source, [group.position for group in source.rows], rows)
    positions[moved[0]] = moved[1]
    columns = {"POSITION": (positions, normalized, True)}
    if made and normals is not None:
        columns["NORMAL"] = (normals.astype(np.float32), False, False)
    elif normals is not None and rows.normal is not None:
        columns["NORMAL"] = (*_stored(document, source, [group.normal for group in source.rows], rows), False)
    return columns


def _stored(
    document: Document, source: GltfMesh, accessors: list[int | None], rows: Rows
) -> tuple[NDArray[Any], bool]:
    """Values as stored, for every row of the mesh; those of another number format, as near as this one has them."""
    own = accessors[source.rows.index(rows)]
    if own is None:
        raise InternalError("a primitive without normals was asked for them")
    entries = document.items("accessors")
    kind = entries[own]["componentType"], bool(entries[own].get("normalized"))
    own_values = document.accessor(own)
    values = np.zeros((sum(group.count for group in source.rows), own_values.shape[1]), own_values.dtype)
    for group, accessor in zip(source.rows, accessors, strict=True):
        if accessor is None:
            continue
        same = (entries[accessor]["componentType"], bool(entries[accessor].get("normalized"))) == kind
        found = document.accessor(accessor) if same else _in_format(document.numbers(accessor), values.dtype, kind[1])
        values[group.start : group.start + group.count] = found
    return values, kind[1]


def _in_format(numbers: NDArray[np.float64], kind: np.dtype[Any], normalized: bool) -> NDArray[Any]:
    """Numbers in a component type; where points are welded, a primitive may name rows of another one's."""
    if kind.kind == "f":
        return numbers.astype(kind)
    range_ = np.iinfo(kind)
    return np.clip(np.rint(numbers * range_.max if normalized else numbers), range_.min, range_.max).astype(kind)


def _replace_primitive(
    bare: _BareMaterials,
    primitive: dict[str, Any],
    attributes: dict[str, int],
    indices: int,
    replaced: set[int],
) -> None:
    """Point a primitive at new accessors (negative numbers until they are settled)."""
    replaced.update(container[key] for container, key in primitive_slots(primitive))
    if any(name.startswith("TEXCOORD_") for name in primitive["attributes"]):
        bare.take(primitive)
    primitive["attributes"] = {name: -1 - number for name, number in attributes.items()}
    primitive["indices"] = -1 - indices
    if primitive.get("mode", 4) != 4:
        primitive["mode"] = 4
    primitive.pop("targets", None)
    if "extensions" in primitive:
        primitive["extensions"] = {k: v for k, v in primitive["extensions"].items() if k in HARMLESS}
        if not primitive["extensions"]:
            del primitive["extensions"]


class _BareMaterials:
    """Materials without textures, for primitives that lose their texture coordinates."""

    def __init__(self, json_: dict[str, Any]) -> None:
        self.materials = json_.get("materials", [])
        self._numbers: dict[str, int] = {}
        for number, material in enumerate(self.materials):
            self._numbers.setdefault(json.dumps(material, sort_keys=True), number)

    def take(self, primitive: dict[str, Any]) -> None:
        """Give a primitive the bare form of its material, added where there is none yet."""
        if primitive.get("material") is None:
            return
        bare = _without_textures(self.materials[primitive["material"]])
        key = json.dumps(bare, sort_keys=True)
        if bare == self.materials[primitive["material"]]:
            return
        if key not in self._numbers:
            self._numbers[key] = len(self.materials)
            self.materials.append(bare)
        primitive["material"] = self._numbers[key]


def _without_textures(value: Any) -> Any:
    """JSON without any member that names a texture."""
    if isinstance(value, dict):
        return {k: _without_textures(v) for k, v in value.items() if not k.lower().endswith("texture")}
    return value


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


def _settle(document: Document, json_: dict[str, Any], body: Body, replaced: set[int]) -> bytes:
    """Drop what nothing names any more, number what is left, and lay out the buffer."""
    kept = {container[key] for container, key in accessor_slots(json_) if container[key] >= 0}
    dropped = sorted(replaced - kept)
    old = json_.get("accessors", [])
    freed_views = {
        container[key] for number in dropped for container, key in accessor_view_slots(old[number])
    }
    numbers = _merged(len(old), dropped, len(body.accessors), bool(unknown_extensions(json_)))
    for container, key in list(accessor_slots(json_)):
        container[key] = numbers[container[key]]
    blank = {"componentType": 5126, "count": 1, "type": "VEC3"}
    _place(json_, "accessors", numbers, body.accessors, blank)
    return _settle_views(document, json_, body, freed_views)


def _settle_views(document: Document, json_: dict[str, Any], body: Body, freed: set[int]) -> bytes:
    """The same for buffer views, and their data."""
    for accessor in body.accessors:
        accessor["bufferView"] = -1 - accessor["bufferView"]
    old = json_.get("bufferViews", [])
    kept = {container[key] for container, key in view_slots(json_) if container[key] >= 0}
    dropped = sorted(freed - kept)
    numbers = _merged(len(old), dropped, len(body.views), bool(unknown_extensions(json_)))
    data = {numbers[i]: document.view(i) for i in range(len(old)) if i in numbers}
    if not unknown_extensions(json_):
        short = trimmed(json_, {i: document.view(i) for i in sorted(freed & kept)})
        data |= {numbers[i]: view for i, view in short.items()}
    data |= {numbers[-1 - i]: bytes(view.data) for i, view in enumerate(body.views)}
    for container, key in list(view_slots(json_)):
        container[key] = numbers[container[key]]
    _place(json_, "bufferViews", numbers, [view_json(view) for view in body.views], {})
    views = json_.get("bufferViews", [])
    binary = pack_views([(view, data.get(i, bytes(4))) for i, view in enumerate(views)])
    head = {k: v for k, v in (json_.get("buffers") or [{}])[0].items() if k not in ("uri", "byteLength")}
    json_["buffers"] = [{**head, "byteLength": len(binary)}]
    for key in ("accessors", "bufferViews", "buffers"):
        if not json_[key] or (key == "buffers" and not binary):
            del json_[key]
    return binary


def _merged(old: int, dropped: list[int], new: int, fixed: bool) -> dict[int, int]:
    """Final numbers of old entries (keys 0, 1, ...) and new ones (keys -1, -2, ...).

    New entries take the places of dropped ones. Where `fixed`, places that are left over stay empty,
    since an unknown extension may count on the numbers; else later entries move up.
    """
    free = list(dropped)
    taken = {-1 - i: free[i] if i < len(free) else old + i - len(free) for i in range(new)}
    left = set(free[new:])
    gone = set(dropped)
    final = {i: i for i in range(old) if i not in gone} | taken
    if fixed or not left:
        return final
    shift = np.cumsum([i in left for i in range(old + new)])
    return {key: int(number - shift[number]) for key, number in final.items()}


def _place(
    json_: dict[str, Any],
    key: str,
    numbers: dict[int, int],
    new: list[dict[str, Any]],
    blank: dict[str, Any],
) -> None:
    """Put old and new entries of a top-level array at their final numbers."""
    old = json_.get(key, [])
    count = max([*numbers.values(), -1]) + 1
    placed = [dict(blank) for _ in range(max(count, 0))]
    for source, target in numbers.items():
        placed[target] = old[source] if source >= 0 else new[-1 - source]
    json_[key] = placed
