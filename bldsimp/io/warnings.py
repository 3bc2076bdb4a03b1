"""What a file cannot hold, in words: nothing is lost in silence."""

from __future__ import annotations

import re

from ..model import FACE, Attribute, Scene
from ..options import DELIMITS, Options
from .flat_mesh import Sheet, spread
from .gltf.document import ARRAYS, Document
from .gltf.references import VARIANTS
from .loaded import STL_BYTES
from .obj import ObjFormat
from .surface import Material, material_of

_WORDS = {
    "TEXCOORD_0": "texture coordinates",
    "COLOR_0": "colours",
    FACE + "COLOR_0": "face colours",
    STL_BYTES: "STL attribute bytes",
    "TANGENT": "tangents",
}
_HELD = {
    "obj": r"TEXCOORD_0|COLOR_0",
    "ply": r"(?!TANGENT).*",
    "off": r"COLOR_0|FACE_COLOR_0",
    "stl": STL_BYTES,
    "glb": r".*",
}
"""Names of attributes that a format holds."""


def words(name: str) -> str:
    """The name of an attribute for people."""
    return _WORDS.get(name) or f"'{name.removeprefix(FACE).removeprefix('_')}'"


def dropped(scene: Scene, options: Options) -> list[str]:
    """What goes because the user asked."""
    if all(options.keeps(kind) for kind in DELIMITS):
        return []
    gone = [one for mesh in scene.meshes for one in mesh.attributes if not options.keeps(one.kind)]
    names = {one.name for one in gone}
    count = sum(not names.isdisjoint(part.attributes) for mesh in scene.meshes for part in mesh.parts)
    return [f"dropped as asked, from {_count(count, 'part')}: {_named(gone)}"] if gone else []


def hidden(scene: Scene, options: Options, format_: str) -> list[str]:
    """What vertices and faces carry both, where a format has one place for it, which `sheet.spread` gives to faces."""
    if format_ not in ("glb", "gltf", "obj"):
        return []
    lost = []
    for mesh in scene.meshes:
        there = {own.name for own in mesh.attributes if options.keeps(own.kind)}
        lost += [own for own in mesh.attributes if own.name in there and FACE + own.name in there]
    if format_ == "obj":
        lost = [own for own in lost if re.fullmatch(_HELD["obj"], own.name)]
    upper = "OBJ" if format_ == "obj" else "glTF"
    told = f"{upper} does not hold {_named(lost)} of both vertices and faces: those of vertices are lost"
    return [told] if lost else []


def losses(scene: Scene, sheets: list[Sheet], format_: str) -> list[str]:
    """What OBJ, PLY, OFF or STL does not hold of a result."""
    upper = format_.upper()
    found = []
    held = _HELD[format_] + ("|TEXCOORD_0|FACE__color" if format_ == scene.format == "off" else "")
    lost = [one for own in sheets for one in own.attributes if not re.fullmatch(held, one.name)]
    if lost:
        found.append(f"{upper} does not hold {_named(lost)}: lost")
    if format_ == "obj" and any(_alpha(own) for own in sheets):
        found.append("OBJ colours have no alpha: lost")
    if any(len(mesh.transforms) > 1 for mesh in scene.meshes):
        found.append(f"{upper} holds no instances: each was written out")
    around = _around(scene.source) if isinstance(scene.source, Document) else []
    if around:
        found.append(f"{upper} holds of a glTF document no {', '.join(around)}: lost")
    materials = [material_of(part) for mesh in scene.meshes for part in mesh.parts]
    if format_ == "obj" and isinstance(scene.meshes[0].source, ObjFormat):
        return found
    if format_ == "obj":
        left = dict.fromkeys(key for one in materials if one is not None for key in one.left)
        return found + ([f"MTL does not hold {', '.join(left)} of materials: lost"] if left else [])
    found += _missing(scene) if format_ == "ply" else []
    named = [one for one in materials if one is not None and not (format_ == "ply" and _is_texture(one))]
    if named or (len(materials) > 1 and not (format_ == "ply" and scene.format == "ply")):
        but = " but for colour textures" if format_ == "ply" and any(one and one.texture for one in materials) else ""
        found.append(f"{upper} holds no parts or materials{but}: those of {_count(len(materials), 'part')} are lost")
    shaded = any(one.normals is not None for one in sheets)
    if shaded and (format_ == "stl" or (format_ == "off" and scene.format != "off")):
        found.append(f"{upper} holds no vertex normals: lost")
    return found


def _around(document: Document) -> list[str]:
    """What a glTF document has beside surfaces and materials, in words."""
    meshes, nodes, roots = document.items("meshes"), document.items("nodes"), document.json.get("extensions", {})
    primitives = [one for mesh in meshes for one in mesh.get("primitives", [])]
    extras = [document.json, *(one for key in ARRAYS for one in document.items(key)), *primitives]
    there = {
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
    return [words for words, any_ in there.items() if any_]


def gltf_losses(scene: Scene) -> list[str]:
    """What a glTF document made anew does not take over."""
    materials = [material_of(part) for mesh in scene.meshes for part in mesh.parts]
    others = dict.fromkeys(
        key for one in materials if one is not None for key in (*one.left, *(key for key, _ in one.others))
    )
    told = [f"not carried over to glTF: {', '.join(others)} of materials"] if others else []
    return _missing(scene) + told


def _missing(scene: Scene) -> list[str]:
    """Material libraries of an OBJ file that are not there."""
    stored = scene.meshes[0].source
    names = stored.missing if isinstance(stored, ObjFormat) else []
    return [f"the material library '{name[:80]}' is no file beneath the input's folder: its materials and textures"
            " are lost" for name in names]  # fmt: skip


def _alpha(one: Sheet) -> bool:
    """Whether a colour is not opaque."""
    colors = spread(one).values("COLOR_0")
    return colors is not None and colors.shape[1] > 3 and bool((colors[:, 3] < 1.0).any())


def _is_texture(material: Material) -> bool:
    """Whether a material is no more than a texture that has a file."""
    more = material.others or material.color is not None or material.clamp or material.numbers or material.left
    return material.texture is not None and not more


def _named(attributes: list[Attribute]) -> str:
    """Names of attributes for people, each once."""
    return ", ".join(dict.fromkeys(words(one.name) for one in attributes))


def _count(number: int, noun: str) -> str:
    return f"{number:,} {noun}" + ("" if number == 1 else "s")
