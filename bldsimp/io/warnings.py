"""Describe in words what a format cannot store, so that nothing is lost silently."""

from __future__ import annotations

import re

from ..material import Material
from ..model import FACE, Attribute
from ..options import DELIMITS, Options
from .file_scene import FileScene
from .flat_mesh import FlatMesh, spread_face_values
from .gltf.document import ARRAYS, Document
from .gltf.references import VARIANTS
from .sidecars import list_materials
from .stl import STL_BYTES

_WORDS = {
    "TEXCOORD_0": "texture coordinates",
    "COLOR_0": "colors",
    FACE + "COLOR_0": "face colors",
    STL_BYTES: "STL attribute bytes",
    "TANGENT": "tangents",
}
_STORED = {
    "obj": r"TEXCOORD_0|COLOR_0",
    "ply": r"(?!TANGENT).*",
    "off": r"COLOR_0|FACE_COLOR_0",
    "stl": STL_BYTES,
    "glb": r".*",
}
"""Names of attributes that a format stores."""


def describe_attribute(name: str) -> str:
    """Return the name of an attribute for people."""
    return _WORDS.get(name) or f"'{name.removeprefix(FACE).removeprefix('_')}'"


def list_removed_attributes(scene: FileScene, options: Options) -> list[str]:
    """Describe the attributes that the user asked to remove."""
    if all(options.keeps(kind) for kind in DELIMITS):
        return []
    gone = [one for mesh in scene.meshes for one in mesh.attributes if not options.keeps(one.kind)]
    names = {one.name for one in gone}
    count = sum(not names.isdisjoint(part.attributes) for part in scene.parts)
    return [f"removed as requested, from {_count_parts(count)}: {_name_attributes(gone)}"] if gone else []


def list_hidden_values(scene: FileScene, options: Options, format_: str) -> list[str]:
    """Describe values of vertices that those of faces replace, if the format has one place for both."""
    if format_ not in ("glb", "gltf", "obj"):
        return []
    format_name, stored = ("OBJ", _STORED["obj"]) if format_ == "obj" else ("glTF", _STORED["glb"])
    lost = []
    for mesh in scene.meshes:
        present = {own.name: own for own in mesh.attributes if options.keeps(own.kind)}
        both = [own for name, own in present.items() if FACE + name in present]
        lost += [own for own in both if re.fullmatch(stored, own.name)]
    what = f"{_name_attributes(lost)} of both vertices and faces"
    return [f"{format_name} cannot store {what}: those of vertices are lost"] if lost else []


def list_losses(scene: FileScene, meshes: list[FlatMesh], format_: str) -> list[str]:
    """Describe what OBJ, PLY, OFF or STL cannot store of a result."""
    cannot = f"{format_.upper()} cannot store"
    found = []
    stored = _STORED[format_] + ("|TEXCOORD_0|FACE__color" if format_ == scene.format == "off" else "")
    lost = [one for own in meshes for one in own.attributes if not re.fullmatch(stored, one.name)]
    if lost:
        found.append(f"{cannot} {_name_attributes(lost)}: lost")
    if format_ == "obj" and any(_has_alpha(own) for own in meshes):
        found.append(f"{cannot} the alpha of colors: lost")
    if any(len(mesh.transforms) > 1 for mesh in scene.meshes):
        found.append(f"{cannot} instances: each was written out")
    other = _list_document_contents(scene.document) if scene.document else []
    if other:
        found.append(f"{cannot} {', '.join(other)} of the glTF document: lost")
    materials, count = list_materials(scene.parts), len(scene.parts)
    if format_ == "obj":
        unsupported = dict.fromkeys(key for one in materials for key in one.unsupported)
        if unsupported and scene.format != "obj":
            found.append(f"MTL cannot store {', '.join(unsupported)} of materials: lost")
        return found
    found += _list_missing_libraries(scene) if format_ == "ply" else []
    named = [one for one in materials if not (format_ == "ply" and _is_texture_only(one))]
    if named or (count > 1 and not (format_ == "ply" and scene.format == "ply")):
        but = " except color textures" if format_ == "ply" and any(one.texture for one in materials) else ""
        found.append(f"{cannot} parts or materials{but}: those of {_count_parts(count)} are lost")
    shaded = any(one.normals is not None for one in meshes)
    if shaded and (format_ == "stl" or (format_ == "off" and scene.format != "off")):
        found.append(f"{cannot} vertex normals: lost")
    return found


def _list_document_contents(document: Document) -> list[str]:
    """List what a glTF document has besides surfaces and materials, in words."""
    meshes, nodes, roots = document.items("meshes"), document.items("nodes"), document.json.get("extensions", {})
    primitives = [one for mesh in meshes for one in mesh.get("primitives", [])]
    extras = [document.json, *(one for key in ARRAYS for one in document.items(key)), *primitives]
    present = {
        "points and lines": any(one.get("mode") in (0, 1, 2, 3) for one in primitives),
        "cameras": document.items("cameras"),
        "lights": "KHR_lights_punctual" in roots,
        "animations": document.items("animations"),
        "skins": document.items("skins"),
        "morph targets": any("targets" in one for one in primitives),
        "variants of materials": VARIANTS in roots,
        "wrap and filter of textures": any(one.keys() - {"name", "extras"} for one in document.items("samplers")),
        "tree of nodes": any("children" in one for one in nodes),
        "names of nodes": any("name" in one for one in nodes),
        "extras": any("extras" in one for one in extras),
    }
    return [words for words, any_ in present.items() if any_]


def list_gltf_losses(scene: FileScene) -> list[str]:
    """Describe what a new glTF document cannot store."""
    lost = [[*one.unsupported, *dict(one.other_textures)] for one in list_materials(scene.parts)]
    others = dict.fromkeys(key for keys in lost for key in keys)
    found = [f"glTF cannot store {', '.join(others)} of materials: lost"] if others else []
    return _list_missing_libraries(scene) + found


def _list_missing_libraries(scene: FileScene) -> list[str]:
    """Describe the material libraries of an OBJ file that do not exist."""
    return [f"the material library '{name[:80]}' is not a file beneath the input's folder: its materials and textures"
            " are lost" for name in scene.obj.missing]  # fmt: skip


def _has_alpha(flat: FlatMesh) -> bool:
    """Tell whether a color is not opaque."""
    colors = spread_face_values(flat).values("COLOR_0")
    return colors is not None and colors.shape[1] > 3 and bool((colors[:, 3] < 1.0).any())


def _is_texture_only(material: Material) -> bool:
    """Tell whether a material is no more than a texture."""
    more = material.other_textures, material.color, material.clamp, material.numbers, material.unsupported
    return material.texture is not None and not any(more)


def _name_attributes(attributes: list[Attribute]) -> str:
    """Name attributes for people, each once."""
    return ", ".join(dict.fromkeys(describe_attribute(one.name) for one in attributes))


def _count_parts(number: int) -> str:
    return f"{number:,} part" + ("" if number == 1 else "s")
