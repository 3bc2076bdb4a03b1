"""Patch a glTF document: the source's own JSON, with new accessors for the primitives that were simplified.

Names, nodes, instances, materials, images, animations, extras and unknown extensions stay as they are.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...model import Mesh, Scene, SimplifiedMesh, Values
from ...options import Options
from ...stages.normals import resolve_normals
from ...unique_rows import find_unique_rows
from ..flat_mesh import drop_unused_rows, has_same_surface
from . import references
from .attributes import HARMLESS, SharedVertices, list_primitives, store_column
from .buffers import NewAccessors, replace_accessors
from .document import Document, Json, copy_json
from .materials import BareMaterials, find_uv_set


def patch_document(
    document: Document,
    scene: Scene,
    results: list[SimplifiedMesh],
    options: Options,
    warnings: list[str],
    *,
    whole: bool,
    first: bool,
) -> tuple[Json, bytes, int]:
    """Replace the simplified primitives of a document.

    Parameters
    ----------
    document : Document
    scene : Scene
        As it was read from the document.
    results : list of SimplifiedMesh
    options : Options
    warnings : list of str
        Receives a message about unknown extensions.
    whole : bool
        All data goes into one buffer; else buffers next to the document that keep all their data stay.
    first : bool
        The new buffer comes before all others, as in a GLB.

    Returns
    -------
    json : dict
        Names one buffer without a URI, or none, and those that stay.
    binary : bytes
        Data of the buffer without a URI.
    vertices : int
        Written for the primitives that have triangles.
    """
    json_ = copy_json(document.json)
    patch = _Patch(document, json_, options, BareMaterials(json_))
    vertices = 0
    # A document must show something: without any triangle it stays as it is.
    if any(len(result.faces) for result in results):
        for mesh, result in zip(scene.meshes, results, strict=True):
            vertices += patch.replace_mesh(mesh, result)
        patch.remove_meshes({mesh.number for mesh in scene.meshes})
    if patch.replaced and references.list_unknown_extensions(json_):
        names = ", ".join(references.list_unknown_extensions(json_))
        warnings.append(f"kept extensions that bldsimp does not know as they are: {names}")
    whole |= bool(document.decoded)
    return json_, replace_accessors(document, json_, patch.new, patch.replaced, whole=whole, first=first), vertices


@dataclass
class _Patch:
    """Changes of a document: its JSON, new accessors, and the numbers of those that primitives named before."""

    document: Document
    json: Json
    options: Options
    bare: BareMaterials
    new: NewAccessors = field(default_factory=NewAccessors)
    replaced: set[int] = field(default_factory=set)

    def replace_mesh(self, mesh: Mesh, result: SimplifiedMesh) -> int:
        """Replace the simplified primitives of one mesh; return the number of its vertices."""
        result, normals = resolve_normals(mesh, result, self.options)
        vertices = len(np.unique(result.faces[mesh.passed_on[result.part_of_face]]))
        primitives = self.json["meshes"][mesh.number]["primitives"]
        empty: list[int] = []
        groups: dict[SharedVertices, dict[int, int]] = {}
        for number, (index, _, group) in enumerate(list_primitives(self.document, mesh.number)):
            if not mesh.parts[number].fixed:
                groups.setdefault(group, {})[number] = index
                empty += [] if np.any(result.part_of_face == number) else [index]
        for group, indices in groups.items():
            vertices += self._replace_group(mesh, result, normals, group, indices)
        for index in reversed(empty):
            self.replaced |= references.list_numbers(primitives[index], references.PRIMITIVE_ACCESSORS)
            del primitives[index]
        return vertices

    def _replace_group(
        self, mesh: Mesh, result: SimplifiedMesh, normals: Values | None, group: SharedVertices, indices: dict[int, int]
    ) -> int:
        """Replace primitives that share vertices, given by the numbers of their parts; return how many are left."""
        faces = [result.faces[result.part_of_face == number] for number in indices]
        if not sum(map(len, faces)):
            return 0
        used, corners = drop_unused_rows(np.concatenate(faces), len(result.points))
        columns = self._store_columns(mesh, result, normals, group, used)
        first, inverse = find_unique_rows(np.concatenate([one.astype(np.float64) for one in columns.values()], axis=1))
        same_names = columns.keys() == group.accessors.keys()
        # A result that is no smaller is better left as it is stored.
        if same_names and len(first) == group.count and has_same_surface(mesh, result, list(indices)):
            return len(first)
        accessors = {name: self._add_column(group, name, values[first]) for name, values in columns.items()}
        primitives = self.json["meshes"][mesh.number]["primitives"]
        ends = np.cumsum([len(own) for own in faces])
        for index, own in zip(indices.values(), np.split(inverse[corners], ends[:-1]), strict=True):
            if len(own):
                self._replace_primitive(primitives[index], accessors, self.new.add_indices(own, len(first)))
        return len(first)

    def _store_columns(
        self, mesh: Mesh, result: SimplifiedMesh, normals: Values | None, group: SharedVertices, used: NDArray[np.int64]
    ) -> dict[str, NDArray[Any]]:
        """Return all attributes of the rows that primitives with shared vertices use, in the types of the file."""
        row = result.row[used]
        kinds = {attribute.name: attribute.kind for attribute in mesh.attributes}
        names = [name for name in group.accessors if name not in kinds or self.options.keeps(kinds[name])]
        if normals is None and "TANGENT" in names and mesh.normals is not None and self.options.normals == "auto":
            # Tangents mean nothing without normals.
            normals = mesh.normals[result.row]
        # Values as they shall be, and as they were read.
        wanted = {"POSITION": (result.points[used], mesh.points[row])}
        if normals is not None and normals[used].any():
            own = normals[used]
            wanted["NORMAL"] = own, np.zeros_like(own) if mesh.normals is None else mesh.normals[row]
        for attribute in mesh.attributes:
            wanted[attribute.name] = result.values(attribute)[used], attribute.values[row]
        if "NORMAL" not in wanted:
            names = [name for name in names if name not in ("NORMAL", "TANGENT")]
        elif "NORMAL" not in names:
            names.append("NORMAL")
        return {name: store_column(self.document, name, group, row, *wanted[name]) for name in names}

    def _add_column(self, group: SharedVertices, name: str, values: NDArray[Any]) -> int:
        """Add values of an attribute; the new accessor has the name of the one it replaces."""
        old = group.accessors.get(name)
        entry = {} if old is None else self.document.items("accessors")[old]
        more: Json = {key: entry[key] for key in ("name", "extras") if key in entry}
        if entry.get("normalized"):
            more["normalized"] = True
        return self.new.add_vertices(name, values, more)

    def _replace_primitive(self, primitive: Json, accessors: dict[str, int], indices: int) -> None:
        """Point a primitive at new accessors, by negative numbers until `replace_accessors` assigns them."""
        self.replaced |= references.list_numbers(primitive, references.PRIMITIVE_ACCESSORS)
        if not self.options.keeps("uv"):
            self.bare.apply(primitive)
        primitive["attributes"] = {name: -1 - number for name, number in accessors.items()}
        primitive["indices"] = -1 - indices
        if primitive.get("mode", 4) != 4:
            primitive["mode"] = 4
        # Morph targets without any entry.
        primitive.pop("targets", None)
        if "extensions" in primitive:
            kept = {
                key: _drop_lost_names(key, value, set(accessors), self.options)
                for key, value in primitive["extensions"].items()
                if key in HARMLESS
            }
            primitive["extensions"] = {key: value for key, value in kept.items() if value}
            if not primitive["extensions"]:
                del primitive["extensions"]

    def remove_meshes(self, numbers: set[int]) -> None:
        """Remove meshes without primitives; the nodes that placed them stay, and show nothing."""
        meshes = self.json.get("meshes", [])
        kept = [i for i, mesh in enumerate(meshes) if i not in numbers or mesh["primitives"]]
        if len(kept) == len(meshes):
            return
        self.json["meshes"] = [meshes[i] for i in kept]
        place = {old: new for new, old in enumerate(kept)}
        for node in self.json.get("nodes", []):
            if node.get("mesh") in place:
                node["mesh"] = place[node["mesh"]]
            elif "mesh" in node:
                self.replaced |= references.list_numbers(node, references.INSTANCE_ACCESSORS)
                for key in ("mesh", "skin", "weights"):
                    node.pop(key, None)
                node.get("extensions", {}).pop(references.INSTANCING, None)
                if not node.get("extensions", True):
                    del node["extensions"]


def _drop_lost_names(extension: str, value: Json, kept: set[str], options: Options) -> Json:
    """Return an extension of a primitive without members that name attributes other than those kept."""
    if extension == references.FEATURES:
        ids = [one for one in value.get("featureIds", []) if _has_source(one, kept)]
        return {**value, "featureIds": ids} if ids else {}
    if extension == references.METADATA:
        lost = set() if options.keeps("uv") else {"propertyTextures"}
        lost |= set() if options.keeps("color") and options.keeps("feature") else {"propertyAttributes"}
        return {key: member for key, member in value.items() if key not in lost}
    return value


def _has_source(ids: Json, kept: set[str]) -> bool:
    """Tell whether the attribute or UV set that feature ids are read from is kept."""
    if "attribute" in ids:
        return f"_FEATURE_ID_{ids['attribute']}" in kept
    return f"TEXCOORD_{find_uv_set(ids.get('texture', {}))}" in kept
