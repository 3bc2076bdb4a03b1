"""Build a glTF document from a scene of another format: a mesh for each mesh, a primitive for each part."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...material import Material, UvMap
from ...model import Faces, Mesh, Points, Scene, SimplifiedMesh, Values
from ...options import Options
from ...tolerance import measure_scale, transform_points
from ...unique_rows import find_unique_rows
from ..file_scene import Written
from ..flat_mesh import FlatMesh, flatten_result, scale_to_unit, spread_face_values
from ..mtl import replace_bad_bytes
from ..single_precision import choose_origin, count_after_rounding, count_merged_points, measure_rounding
from ..textures import find_media_type
from .attributes import to_gltf
from .buffers import NewAccessors, pack_views
from .document import Json
from .references import TRANSFORM

_CLAMP_TO_EDGE = 33071
_EMISSIVE_STRENGTH = "KHR_materials_emissive_strength"
_WHITE = (1.0, 1.0, 1.0, 1.0)


def build_document(
    scene: Scene, results: list[SimplifiedMesh], options: Options, images: dict[str, bytes], written: Written
) -> tuple[Json, bytes]:
    """Build a glTF document.

    Parameters
    ----------
    scene : Scene
    results : list of SimplifiedMesh
    options : Options
    images : dict
        Bytes of each texture that a material names.
    written : Written
        Receives the figures of what is stored; if a point is out of range, the document is not whole.

    Returns
    -------
    json : dict
    binary : bytes
        Data of the only buffer.
    """
    json_: Json = {
        "asset": {"version": "2.0", "generator": "bldsimp"},
        "scene": 0,
        "scenes": [{"nodes": []}],
        "nodes": [],
        "meshes": [],
    }
    builder = _Builder(json_, images)
    stored: list[list[tuple[Points, Faces]]] = []
    for mesh, result in zip(scene.meshes, results, strict=True):
        if not len(result.faces):
            continue
        flat = spread_face_values(flatten_result(mesh, result, options))
        origin = choose_origin(flat.points)
        written.rounding = max(written.rounding, measure_scale(mesh) * measure_rounding(flat.points, origin))
        if not math.isfinite(written.rounding):
            break
        written.merged_points += count_merged_points(flat.points, origin)
        stored.append([(flat.points - origin, flat.faces)])
        written.vertices += builder.add_mesh(flat, origin)
        builder.add_nodes(mesh, origin)
    written.after = count_after_rounding(stored) if written.merged_points else None
    return json_, builder.finish()


@dataclass
class _Builder:
    """A new document that grows: its JSON, its numbers, and the images that its materials name."""

    json: Json
    images: dict[str, bytes]
    new: NewAccessors = field(default_factory=NewAccessors)
    used_images: dict[str, int] = field(default_factory=dict)
    _materials: dict[tuple[Any, ...], int] = field(default_factory=dict)

    def finish(self) -> bytes:
        """Assign numbers to accessors, views and images; return the data of the buffer."""
        views = self.new.list_views()
        for name, number in self.used_images.items():
            self.json["images"][number]["bufferView"] = len(views)
            views.append(({}, self.images[name]))
        self.json["accessors"], self.json["bufferViews"] = self.new.accessors, [entry for entry, _ in views]
        binary = pack_views(views)
        self.json["buffers"] = [{"byteLength": len(binary)}]
        return binary

    def add_mesh(self, flat: FlatMesh, origin: Points) -> int:
        """Add a mesh of all parts that have faces; return the number of its vertices."""
        entry: Json = {"primitives": []}
        if flat.name:
            entry["name"] = flat.name
        vertices = 0
        groups: dict[tuple[str, ...], list[tuple[int, Faces]]] = {}
        for number in np.unique(flat.part).tolist():
            for faces in _split_untextured(flat, number):
                groups.setdefault(_list_present(flat, faces), []).append((number, faces))
        for names, group in groups.items():
            corners = np.concatenate([faces for _, faces in group]).reshape(-1)
            columns = _convert_columns(flat, corners, origin, names)
            first, inverse = find_unique_rows(np.concatenate([v.astype(np.float64) for v in columns.values()], axis=1))
            vertices += len(first)
            attributes = {name: self.new.add_vertices(name, values[first], {}) for name, values in columns.items()}
            ends = np.cumsum([faces.size for _, faces in group])
            for (number, faces), own in zip(group, np.split(inverse, ends[:-1]), strict=True):
                indices = self.new.add_indices(own, len(first))
                entry["primitives"].append(self._make_primitive(flat, number, faces, attributes, indices))
        self.json["meshes"].append(entry)
        return vertices

    def add_nodes(self, mesh: Mesh, origin: Points) -> None:
        """Add a node for each instance of the mesh that was added last."""
        for transform in mesh.transforms:
            node: Json = {"mesh": len(self.json["meshes"]) - 1}
            if mesh.name:
                node["name"] = mesh.name
            if not np.array_equal(transform, np.eye(4)):
                moved = transform.copy()
                moved[:3, 3] = transform_points(origin[None], transform)[0]
                node["matrix"] = moved.T.reshape(-1).tolist()
            elif origin.any():
                node["translation"] = origin.tolist()
            self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]))
            self.json["nodes"].append(node)

    def _make_primitive(
        self, flat: FlatMesh, number: int, faces: Faces, attributes: dict[str, int], indices: int
    ) -> Json:
        """Make a primitive; glTF gives it no name, so the part's goes into its extras."""
        part = flat.parts[number]
        primitive: Json = {"attributes": attributes, "indices": indices}
        colors = flat.values("COLOR_0") if "COLOR_0" in attributes else None
        own = None if colors is None else colors[faces.reshape(-1)]
        material = self._add_material(part.material, "TEXCOORD_0" in attributes, own)
        if material is not None:
            primitive["material"] = material
        if len(flat.parts) > 1 or part.name != "mesh":
            primitive["extras"] = {"name": part.name}
        return primitive

    def _add_material(self, material: Material | None, textured: bool, colors: Values | None) -> int | None:
        """Add a material for faces of these colors, unless it is there; return its number. Those of alpha need one."""
        faded = colors is not None and colors.shape[1] > 3 and bool(np.any(colors[:, 3] < 1.0))
        if material is None and not faded:
            return None
        key = material, textured, colors is not None, faded
        if key not in self._materials:
            entry = self._convert_material(material or Material(""), textured, colored=colors is not None)
            if faded or (material and material.color and material.color[3] < 1.0):
                entry["alphaMode"] = "BLEND"
            self._materials[key] = len(self._materials)
            self.json.setdefault("materials", []).append(entry)
        return self._materials[key]

    def _convert_material(self, material: Material, textured: bool, colored: bool) -> Json:
        """Return a material as glTF has it; colors of vertices replace its color, except for alpha."""
        numbers = dict(material.numbers)
        metallic: Json = {"metallicFactor": _clamp_to_unit(*numbers.get("Pm", (0.0,)))}
        if "Pr" in numbers:
            metallic["roughnessFactor"] = _clamp_to_unit(*numbers["Pr"])
        r, g, b, a = map(_clamp_to_unit, material.color or _WHITE)
        factor = (1.0, 1.0, 1.0, a) if colored else (r, g, b, a)
        if factor != _WHITE:
            metallic["baseColorFactor"] = list(factor)
        if textured and material.texture in self.images:
            metallic["baseColorTexture"] = self._make_texture_info(str(material.texture), material)
        name = {"name": replace_bad_bytes(material.name)} if material.name else {}
        return {**name, "pbrMetallicRoughness": metallic, **self._convert_emission(numbers.get("Ke", (0.0,)))}

    def _convert_emission(self, color: tuple[float, ...]) -> Json:
        """Return the members of a material for the light that it emits, which has no upper bound."""
        if max(color) <= 0.0:
            return {}
        strength = max(1.0, *color)
        emission: Json = {"emissiveFactor": [_clamp_to_unit(value / strength) for value in color]}
        if strength > 1.0:
            emission["extensions"] = {_EMISSIVE_STRENGTH: {"emissiveStrength": strength}}
            self._add("extensionsUsed", _EMISSIVE_STRENGTH)
        return emission

    def _make_texture_info(self, name: str, material: Material) -> Json:
        """Make the member by which a material names a texture."""
        info: Json = {"index": self._add_texture(name, material.clamp)}
        if material.uv_map != UvMap():
            x, _, dx, _, y, dy = material.uv_map.matrix
            # glTF has v downwards: 1 - v' = y (1 - v) + 1 - y - dy.
            info["extensions"] = {TRANSFORM: {"scale": [x, y], "offset": [dx, 1.0 - y - dy]}}
            self._add("extensionsUsed", TRANSFORM)
        return info

    def _add_texture(self, name: str, clamp: bool) -> int:
        """Add a texture and its image, unless they are there; return its number."""
        if name not in self.used_images:
            image = {"name": replace_bad_bytes(name), "mimeType": find_media_type(self.images[name])}
            self.used_images[name] = len(self.used_images)
            self.json.setdefault("images", []).append(image)
        entry = {"source": self.used_images[name]}
        if clamp:
            entry["sampler"] = self._add("samplers", {"wrapS": _CLAMP_TO_EDGE, "wrapT": _CLAMP_TO_EDGE})
        return self._add("textures", entry)

    def _add(self, key: str, entry: Any) -> int:
        """Add an entry to a top-level array, unless it is there; return its number."""
        entries = self.json.setdefault(key, [])
        if entry not in entries:
            entries.append(entry)
        return int(entries.index(entry))


def _clamp_to_unit(value: float) -> float:
    """Return a number between 0 and 1."""
    return min(max(float(value), 0.0), 1.0)


def _split_untextured(flat: FlatMesh, number: int) -> list[Faces]:
    """Split the faces of a part into those with texture coordinates and those without, which show no texture."""
    faces, uv = flat.faces[flat.part == number], flat.values("TEXCOORD_0")
    if uv is None:
        return [faces]
    bare = np.isnan(uv[faces]).all(axis=(1, 2))
    return [own for own in (faces[~bare], faces[bare]) if len(own)]


def _list_present(flat: FlatMesh, faces: Faces) -> tuple[str, ...]:
    """List the attributes that any corner of some faces has."""
    rows = faces.reshape(-1)
    return tuple(own.name for own in flat.attributes if not np.isnan(own.values[rows]).all())


def _convert_columns(
    flat: FlatMesh, corners: NDArray[Any], origin: Points, names: tuple[str, ...]
) -> dict[str, NDArray[np.float32]]:
    """Return attributes of corners as glTF has them."""
    columns = {"POSITION": (flat.points[corners] - origin).astype(np.float32)}
    if flat.normals is not None and np.any(flat.normals[corners]):
        columns["NORMAL"] = to_gltf("NORMAL", scale_to_unit(flat.normals[corners])).astype(np.float32)
    for own in flat.attributes:
        if own.name in names:
            values = to_gltf(own.name, own.values[corners]).astype(np.float32)
            # A glTF accessor has four numbers at most.
            for start in range(0, values.shape[1], 4):
                columns[f"{own.name}_{start}" if start else own.name] = values[:, start : start + 4]
    return columns
