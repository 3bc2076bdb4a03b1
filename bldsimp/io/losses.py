"""What a file cannot hold, in words: nothing is lost in silence."""

from __future__ import annotations

from ..options import DELIMITS, Options
from ..scene import Part, Scene
from .sheet import Sheet

_TEXTURES = ("vt", "TEXCOORD_0", "texture coordinates", "s", "t", "u", "v", "texture_u", "texture_v")
_COLORS = ("colour", "COLOR_0", "red", "green", "blue", "alpha")
_HELD = {
    "obj": (*_TEXTURES, *_COLORS),
    "ply": (*_TEXTURES, *_COLORS),
    "glb": (*_TEXTURES, *_COLORS),
    "off": (),
    "stl": (),
}


def dropped(scene: Scene, options: Options) -> list[str]:
    """What goes because the user asked."""
    carriers = [part for mesh in scene.meshes for part in mesh.parts if part.attributes]
    if all(options.keeps(kind) for kind in DELIMITS) or not carriers:
        return []
    return [f"dropped as asked, from {_count(len(carriers), 'part')}: {_attributes(carriers, ())}"]


def losses(scene: Scene, sheets: list[Sheet], format_: str) -> list[str]:
    """What OBJ, PLY, OFF or STL does not hold of a result."""
    upper = format_.upper()
    kept = [part for one in sheets for part, stays in zip(one.parts, one.kept, strict=True) if stays]
    found = []
    lost = _attributes(kept, _HELD[format_])
    if lost:
        found.append(f"{upper} does not hold {lost}: lost")
    if any(len(mesh.transforms) > 1 for mesh in scene.meshes):
        found.append(f"{upper} holds no instances: each was written out")
    if format_ == "obj":
        return found
    parts = [part for mesh in scene.meshes for part in mesh.parts]
    if len(parts) > 1 or any(getattr(part.source, "material", None) for part in parts):
        found.append(f"{upper} holds no parts or materials: those of {_count(len(parts), 'part')} are lost")
    shaded = any(one.normals is not None for one in sheets)
    if shaded and (format_ == "stl" or (format_ == "off" and scene.format != "off")):
        found.append(f"{upper} holds no vertex normals: lost")
    return found


def gltf_losses(scene: Scene, options: Options) -> list[str]:
    """What a glTF document made anew does not take over."""
    kept = [part for mesh in scene.meshes for part in mesh.parts if bool(part.fixed)]
    lost = _attributes(kept, _HELD["glb"])
    return [f"not carried over to glTF: {lost}"] if lost else []


def _attributes(parts: list[Part], held: tuple[str, ...]) -> str:
    """Names of what parts carry and a format does not hold."""
    names = [name for part in parts for name in part.attributes if name not in held]
    return ", ".join(dict.fromkeys(names))


def _count(number: int, noun: str) -> str:
    return f"{number:,} {noun}" + ("" if number == 1 else "s")
