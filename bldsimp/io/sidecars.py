"""Copy textures and material libraries next to a result, or load them to embed them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from urllib.parse import unquote

from ..material import Material
from ..model import Part
from .file_scene import FileScene
from .flat_mesh import FlatMesh
from .gltf.document import load_image
from .input_folder import InputFolder
from .mtl import write_materials
from .textures import find_media_type

_SUFFIXES = {"image/png": "png", "image/jpeg": "jpg", "image/webp": "webp", "image/ktx2": "ktx2"}


class Sidecars:
    """Files to write next to a result.

    Attributes
    ----------
    files : dict of Path to bytes
    """

    def __init__(self, scene: FileScene, main: Path, warnings: list[str]) -> None:
        self.scene = scene
        self.main = main
        self.warnings = warnings
        self.folder = InputFolder(scene.path and scene.path.parent)
        self.files: dict[Path, bytes] = {}

    def load_textures(self) -> dict[str, bytes]:
        """Load the color textures of the scene, to embed them; return their bytes by name."""
        found: dict[str, bytes] = {}
        for material in list_materials(self.scene.parts):
            if material.texture and material.texture not in found:
                image = self._load_texture(material.texture, material)
                if image is not None:
                    found[material.texture] = image[1]
        return found

    def copy_libraries(self) -> list[str]:
        """Copy the material libraries and textures of an OBJ file under their own names; return the libraries."""
        for name in (*self.scene.obj.libraries, *self.scene.obj.textures):
            data = self.folder.load_image(name)
            if data is None:
                self.warnings.append(f"the input names '{name}', which is not next to it, so it was not copied")
            else:
                self.files[self.main.parent / name.replace("\\", "/")] = data
        return self.scene.obj.libraries

    def add_library(self, meshes: list[FlatMesh]) -> tuple[list[str], dict[Material, str]]:
        """Add a material library and its textures; return its name, if any, and the name of each material in it."""
        names: dict[Material, str] = {}
        for material in list_materials(part for one in meshes for part in one.used_parts()):
            # Two materials may have one name in other formats.
            base = " ".join(material.name.split())
            name, count = base, 1
            while name in names.values():
                count += 1
                name = f"{base}_{count}"
            names[material] = name
        if not names:
            return [], {}
        library = self.main.with_suffix(".mtl")
        materials = [self._add_textures_of(material, name) for material, name in names.items()]
        self.files[library] = write_materials(materials).encode("utf-8", "surrogateescape")
        return [library.name], names

    def add_color_textures(self, meshes: list[FlatMesh]) -> dict[str, str]:
        """Add the color textures of meshes with texture coordinates; return the file name of each."""
        found: dict[str, str] = {}
        for one in meshes:
            if one.values("TEXCOORD_0") is not None:
                for material in list_materials(one.used_parts()):
                    name = self._add_texture(material.texture, material) if material.texture not in found else None
                    if material.texture and name:
                        found[material.texture] = name
        return found

    def _add_textures_of(self, material: Material, name: str) -> Material:
        """Return a material under a name of its own, whose textures are files next to the result."""
        texture = self._add_texture(material.texture, material)
        others = [(key, self._add_texture(other, material)) for key, other in material.other_textures]
        return replace(material, name=name, texture=texture, other_textures=tuple((k, v) for k, v in others if v))

    def _add_texture(self, name: str | None, material: Material) -> str | None:
        """Add a texture; return its file name, which differs from those of other textures."""
        found = self._load_texture(name, material) if name else None
        if found is None:
            return None
        own, data = found
        while self.files.get(self.main.parent / own, data) != data:
            own = f"{self.main.stem}_{own}"
        self.files[self.main.parent / own] = data
        return own

    def _load_texture(self, name: str, material: Material) -> tuple[str, bytes] | None:
        """Return a file name for a texture, and its bytes as they are stored; warn if there are none."""
        if material.image is not None and name == material.texture:
            return name, material.image
        document, uri = self.scene.document, name
        if document is not None:
            data = load_image(document, int(name), self.folder.load_image)
            uri = unquote(document.items("images")[int(name)].get("uri", ""))
            if data is not None and (not uri or uri.startswith("data:")):
                return f"{self.main.stem}_{name}.{_SUFFIXES.get(find_media_type(data), 'bin')}", data
            if uri.startswith("data:"):
                self.warnings.append(f"the data URI of glTF image {name} cannot be decoded: it is lost")
                return None
        else:
            data = self.folder.load_image(uri)
        if data is None:
            self.warnings.append(f"the texture '{uri[:80]}' is not a file beneath the input's folder")
            return None
        return uri.replace("\\", "/"), data


def list_materials(parts: Iterable[Part]) -> list[Material]:
    """List the materials of parts, each once."""
    return list(dict.fromkeys(part.material for part in parts if part.material is not None))
