"""Other formats to glTF: a document made anew, a mesh for each mesh, a primitive for each part."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...model import Faces, Mesh, Points, Scene, SimplifiedMesh
from ...options import Options
from ...report import Counts
from ...tolerance import scale, transform_points
from ...unique_rows import find_unique_rows
from ..flat_mesh import Sheet, sheet, spread
from ..rounding import best_origin, counts_in_single, fallen_together, single_rounding
from ..surface import Material, UvMap, material_of, shown
from .buffers import Body, pack_views, view_json
from .references import TRANSFORM

_CLAMP_TO_EDGE = 33071
_EMISSIVE_STRENGTH = "KHR_materials_emissive_strength"


@dataclass
class Made:
    """What making a document did.

    Attributes
    ----------
    vertices : int
    rounding : float
        Greatest distance by which a point moved, in world space; infinite where one is out of range.
    fallen : int
        Points that are no longer distinct.
    after : Counts or None
        Of what is stored, where there are any.
    """

    vertices: int = 0
    rounding: float = 0.0
    fallen: int = 0
    after: Counts | None = None


def new_document(
    scene: Scene, lights: list[SimplifiedMesh], options: Options, images: dict[str, tuple[str, bytes]]
) -> tuple[dict[str, Any], bytes, Made]:
    """A scene as a glTF document.

    Parameters
    ----------
    scene : Scene
    lights : list of SimplifiedMesh
    options : Options
    images : dict
        Media type and bytes of each texture that a material names.

    Returns
    -------
    json : dict
    binary : bytes
    made : Made
    """
    json_: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": "bldsimp"},
        "scene": 0,
        "scenes": [{"nodes": []}],
        "nodes": [],
        "meshes": [],
    }
    body, pictures = Body(), Pictures(json_, images)
    made = Made()
    stored: list[list[tuple[Points, Faces, Points | None]]] = []
    for mesh, light in zip(scene.meshes, lights, strict=True):
        if not len(light.faces):
            continue
        one = spread(sheet(mesh, light, options))
        origin = best_origin(one.points)
        made.rounding = max(made.rounding, scale(mesh) * single_rounding(one.points, origin))
        if not math.isfinite(made.rounding):
            break
        made.fallen += fallen_together(one.points, origin)
        stored.append([(one.points, one.faces, origin)])
        made.vertices += _add_mesh(json_, body, pictures, one, origin)
        _add_nodes(json_, mesh, origin)
    made.after = counts_in_single(stored) if made.fallen else None
    json_["accessors"] = body.accessors
    json_["bufferViews"] = [view_json(view) for view in body.views] + [{} for _ in pictures.data]
    pieces = [bytes(view.data) for view in body.views] + pictures.data
    for number in range(len(pictures.data)):
        json_["images"][number]["bufferView"] = len(body.views) + number
    binary = pack_views(list(zip(json_["bufferViews"], pieces, strict=True)))
    json_["buffers"] = [{"byteLength": len(binary)}]
    return json_, binary, made


class Pictures:
    """Materials of a new document, and the images that they name."""

    def __init__(self, json_: dict[str, Any], images: dict[str, tuple[str, bytes]]) -> None:
        self.json = json_
        self.images = images
        self.data: list[bytes] = []
        self._numbers: dict[tuple[Any, ...], int] = {}
        self._images: dict[str, int] = {}
        self._textures: dict[tuple[str, bool], int] = {}

    def material(self, material: Material | None, textured: bool, colors: np.ndarray[Any, Any] | None) -> int | None:
        """The number of a material for faces of these colours, added where it is new; those of alpha need one."""
        faded = colors is not None and colors.shape[1] > 3 and bool(np.any(colors[:, 3] < 1.0))
        if material is None and not faded:
            return None
        key = material, textured, colors is not None, faded
        if key not in self._numbers:
            entry = self._entry(material or Material(""), textured, colored=colors is not None)
            if faded or (material and material.color and material.color[3] < 1.0):
                entry["alphaMode"] = "BLEND"
            self.json.setdefault("materials", []).append(entry)
            self._numbers[key] = len(self.json["materials"]) - 1
        return self._numbers[key]

    def _entry(self, material: Material, textured: bool, colored: bool) -> dict[str, Any]:
        """A material as glTF has it; of its colour, colours of vertices take the place, but for alpha."""
        numbers = dict(material.numbers)
        metallic: dict[str, Any] = {"metallicFactor": _unit(*numbers.get("Pm", (0.0,)))}
        if "Pr" in numbers:
            metallic["roughnessFactor"] = _unit(*numbers["Pr"])
        r, g, b, a = map(_unit, material.color or (1.0, 1.0, 1.0, 1.0))
        factor = [1.0, 1.0, 1.0, a] if colored else [r, g, b, a]
        if factor != [1.0, 1.0, 1.0, 1.0]:
            metallic["baseColorFactor"] = factor
        if textured and material.texture in self.images:
            metallic["baseColorTexture"] = self._texture_info(str(material.texture), material)
        named = {"name": shown(material.name)} if material.name else {}
        return {**named, "pbrMetallicRoughness": metallic, **self._glow(numbers.get("Ke", (0.0,)))}

    def _glow(self, color: tuple[float, ...]) -> dict[str, Any]:
        """What a material says of the light that it gives, which has no upper bound."""
        if max(color) <= 0.0:
            return {}
        strength = max(1.0, *color)
        glow: dict[str, Any] = {"emissiveFactor": [_unit(value / strength) for value in color]}
        if strength > 1.0:
            glow["extensions"] = {_EMISSIVE_STRENGTH: {"emissiveStrength": strength}}
            self._use(_EMISSIVE_STRENGTH)
        return glow

    def _texture_info(self, name: str, material: Material) -> dict[str, Any]:
        """A texture as a material names it."""
        info: dict[str, Any] = {"index": self._texture(name, material.clamp)}
        if material.uv_map != UvMap():
            x, _, dx, _, y, dy = material.uv_map.matrix
            # glTF has v downwards: 1 - v' = y (1 - v) + 1 - y - dy.
            info["extensions"] = {TRANSFORM: {"scale": [x, y], "offset": [dx, 1.0 - y - dy]}}
            self._use(TRANSFORM)
        return info

    def _texture(self, name: str, clamp: bool) -> int:
        if name not in self._images:
            media, data = self.images[name]
            self._images[name] = len(self.data)
            self.data.append(data)
            self.json.setdefault("images", []).append({"name": shown(name), "mimeType": media})
        if (name, clamp) not in self._textures:
            entry = {"source": self._images[name]}
            if clamp:
                self.json["samplers"] = [{"wrapS": _CLAMP_TO_EDGE, "wrapT": _CLAMP_TO_EDGE}]
                entry["sampler"] = 0
            self._textures[name, clamp] = len(self._textures)
            self.json.setdefault("textures", []).append(entry)
        return self._textures[name, clamp]

    def _use(self, extension: str) -> None:
        """Name an extension among those that the document uses."""
        used = self.json.setdefault("extensionsUsed", [])
        if extension not in used:
            used.append(extension)


def _unit(value: float) -> float:
    return min(max(float(value), 0.0), 1.0)


def _add_mesh(json_: dict[str, Any], body: Body, pictures: Pictures, one: Sheet, origin: np.ndarray[Any, Any]) -> int:
    """Add a mesh of all parts that have faces; the number of its vertices."""
    entry: dict[str, Any] = {"primitives": []}
    if one.name:
        entry["name"] = one.name
    vertices = 0
    there: dict[tuple[str, ...], list[tuple[int, Faces]]] = {}
    for number in np.unique(one.part).tolist():
        for own in _alike(one, number):
            there.setdefault(_carried(one, own), []).append((number, own))
    for names, group in there.items():
        faces = [own for _, own in group]
        columns = _columns(one, np.concatenate(faces).reshape(-1), origin, names)
        first, inverse = find_unique_rows(np.concatenate([v.astype(np.float64) for v in columns.values()], axis=1))
        vertices += len(first)
        attributes = {
            name: body.add_vertices(values[first], bounds=name == "POSITION") for name, values in columns.items()
        }
        start = 0
        for number, own in group:
            indices = body.add_indices(inverse[start : start + own.size], len(first))
            start += own.size
            entry["primitives"].append(_primitive(pictures, one, number, own, attributes, indices))
    json_["meshes"].append(entry)
    return vertices


def _primitive(
    pictures: Pictures, one: Sheet, number: int, faces: Faces, attributes: dict[str, int], indices: int
) -> dict[str, Any]:
    """A primitive; glTF gives it no name, so the part's goes into its extras."""
    part = one.parts[number]
    primitive: dict[str, Any] = {"attributes": attributes, "indices": indices}
    colors = one.values("COLOR_0") if "COLOR_0" in attributes else None
    own = None if colors is None else colors[faces.reshape(-1)]
    material = pictures.material(material_of(part), "TEXCOORD_0" in attributes, own)
    if material is not None:
        primitive["material"] = material
    if len(one.parts) > 1 or part.name != "mesh":
        primitive["extras"] = {"name": part.name}
    return primitive


def _alike(one: Sheet, number: int) -> list[Faces]:
    """Faces of a part: those with texture coordinates, and those without, on which no texture is to be seen."""
    faces, uv = one.triangles(number), one.values("TEXCOORD_0")
    if uv is None:
        return [faces]
    bare = np.isnan(uv[faces]).all(axis=(1, 2))
    return [own for own in (faces[~bare], faces[bare]) if len(own)]


def _carried(one: Sheet, faces: Faces) -> tuple[str, ...]:
    """Names of the attributes that any corner of some faces has."""
    rows = faces.reshape(-1)
    return tuple(own.name for own in one.attributes if not np.isnan(own.values[rows]).all())


def _columns(
    one: Sheet, corners: np.ndarray[Any, Any], origin: np.ndarray[Any, Any], names: tuple[str, ...]
) -> dict[str, np.ndarray[Any, Any]]:
    """Attributes of corners."""
    columns = {"POSITION": (one.points[corners] - origin).astype(np.float32)}
    if one.normals is not None and np.any(one.normals[corners]):
        normals = one.normals[corners]
        # glTF knows no missing normal; a part that has some takes this for the others.
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        unit = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0.0)
        columns["NORMAL"] = np.where(length > 0.0, unit, (0.0, 0.0, 1.0)).astype(np.float32)
    for own in one.attributes:
        if own.name not in names:
            continue
        taken = own.values[corners]
        if own.kind == "uv":
            taken = np.stack([taken[:, 0], 1.0 - taken[:, 1]], axis=1)
        missing = 1.0 if own.name == "COLOR_0" else 0.0
        # Of more than four numbers a glTF accessor is no place.
        for start in range(0, taken.shape[1], 4):
            name = own.name if not start else f"{own.name}_{start}"
            piece = taken[:, start : start + 4]
            columns[name] = np.where(np.isnan(piece), missing, piece).astype(np.float32)
    return columns


def _add_nodes(json_: dict[str, Any], mesh: Mesh, origin: np.ndarray[Any, Any]) -> None:
    """Add a node for each instance of the mesh that was added last."""
    for transform in mesh.transforms:
        node: dict[str, Any] = {"mesh": len(json_["meshes"]) - 1}
        if mesh.name:
            node["name"] = mesh.name
        if not np.array_equal(transform, np.eye(4)):
            moved = transform.copy()
            moved[:3, 3] = transform_points(origin[None], transform)[0]
            node["matrix"] = [float(value) for value in moved.T.reshape(-1)]
        elif origin.any():
            node["translation"] = [float(value) for value in origin]
        json_["scenes"][0]["nodes"].append(len(json_["nodes"]))
        json_["nodes"].append(node)
