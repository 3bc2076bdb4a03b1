"""What stands beside a file: textures, images and material libraries, copied or put inside."""

from __future__ import annotations

import base64
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote

import numpy as np

from ..model import Part, Scene
from .flat_mesh import Sheet
from .folder import beneath
from .gltf.buffers import pack_views
from .gltf.document import Document, data_uri
from .obj import ObjFormat
from .surface import Material, material_of

_MEDIA = {b"\x89PNG": "image/png", b"\xff\xd8\xff": "image/jpeg", b"RIFF": "image/webp", b"\xabKTX 20": "image/ktx2"}
_SUFFIXES = {"image/png": "png", "image/jpeg": "jpg", "image/webp": "webp", "image/ktx2": "ktx2"}


def media_type(data: bytes) -> str:
    """Media type of an image, by its first bytes."""
    return next((kind for magic, kind in _MEDIA.items() if data.startswith(magic)), "application/octet-stream")


def _missing(kind: str, name: str) -> str:
    return f"the {kind} '{name[:80]}' is no file beneath the input's folder"


def copies(json_: dict[str, Any], source: Path | None, target: Path, warnings: list[str]) -> dict[Path, bytes]:
    """Images and buffers that a document names, for the folder that it moves to.

    Each keeps its name and its folder there. A reference out of the folder is made relative to the new one instead.
    """
    if source is None or source.parent.resolve() == target.parent.resolve():
        return {}
    found: dict[Path, bytes] = {}
    named = [("image", entry) for entry in json_.get("images", [])]
    for kind, entry in [*named, *(("buffer", entry) for entry in json_.get("buffers", []))]:
        uri = entry.get("uri", "")
        if not uri or uri.startswith("data:") or "://" in uri:
            continue
        name = Path(unquote(uri).replace("\\", "/"))
        path = beneath(source.parent, unquote(uri))
        if name.is_absolute() or ".." in name.parts:
            entry["uri"] = quote(Path(os.path.relpath(source.parent / name, target.parent)).as_posix())
        elif path is None:
            warnings.append(_missing(kind, unquote(uri)))
        else:
            found[target.parent / name] = path.read_bytes()
    return found


def embedded_images(
    json_: dict[str, Any], binary: bytes, source: Path | None, format_: str, warnings: list[str]
) -> bytes:
    """Put the images that stand beside a document into it; the new buffer."""
    extra: list[tuple[dict[str, Any], bytes]] = []
    for image in json_.get("images", []):
        uri = image.get("uri", "")
        if not uri or "://" in uri:
            continue
        if uri.startswith("data:"):
            data = data_uri(uri)
            if data is None:
                # It was told on reading; an image that is damaged stays as it is.
                continue
        else:
            path = beneath(source and source.parent, unquote(uri))
            if path is None:
                warnings.append(_missing("image", unquote(uri)))
                continue
            data = path.read_bytes()
        media = image.get("mimeType", media_type(data))
        if format_ == "gltf":
            image["uri"] = f"data:{media};base64," + base64.b64encode(data).decode()
            continue
        image.pop("uri")
        image["mimeType"] = media
        views = json_.setdefault("bufferViews", [])
        image["bufferView"] = len(views)
        views.append({})
        extra.append((views[-1], data))
    if not extra:
        return binary
    start = len(binary) + -len(binary) % 8
    tail = pack_views(extra)
    for view, _ in extra:
        view["byteOffset"] += start
    joined = binary.ljust(start, b"\0") + tail
    json_.setdefault("buffers", [{}])[0]["byteLength"] = len(joined)
    return joined


class Pictured:
    """Textures and material libraries of a result, to be written beside it or put inside.

    Attributes
    ----------
    files : dict of Path to bytes
        To be written beside the main file; what is there already is the same.
    """

    def __init__(self, scene: Scene, main: Path, warnings: list[str]) -> None:
        self.scene = scene
        self.main = main
        self.warnings = warnings
        self.files: dict[Path, bytes] = {}

    def inside(self) -> dict[str, tuple[str, bytes]]:
        """Media type and bytes of each colour texture of the scene."""
        found: dict[str, tuple[str, bytes]] = {}
        for material in _materials([part for mesh in self.scene.meshes for part in mesh.parts]):
            if material.texture and material.texture not in found:
                image = self._image(material.texture, material)
                if image is not None:
                    found[material.texture] = media_type(image[1]), image[1]
        return found

    def libraries(
        self, sheets: list[Sheet], text: Callable[[list[Material]], str]
    ) -> tuple[list[str], dict[Material, str]]:
        """Material libraries to name in an OBJ file, and what they call each material; fills `files`."""
        stored = self.scene.meshes[0].source
        if isinstance(stored, ObjFormat):
            for name in [*stored.libraries, *stored.textures]:
                self._copy(name)
            return list(stored.libraries), {}
        names: dict[Material, str] = {}
        for material in _materials(_shown(sheets)):
            # Two materials may have one name in other formats.
            own, count = " ".join(material.name.split()), 1
            while own in names.values():
                count += 1
                own = f"{' '.join(material.name.split())}_{count}"
            names[material] = own
        if not names:
            return [], {}
        library = self.main.with_suffix(".mtl")
        written = [self._beside(material, name) for material, name in names.items()]
        self.files[library] = text(written).encode("utf-8", "surrogateescape")
        return [library.name], names

    def textures(self, sheets: list[Sheet]) -> dict[str, str]:
        """File names of the colour textures of a result; fills `files`."""
        found: dict[str, str] = {}
        for one in sheets:
            if one.values("TEXCOORD_0") is not None:
                for material in _materials(_shown([one])):
                    name = self._put(material.texture, material) if material.texture not in found else None
                    if material.texture and name:
                        found[material.texture] = name
        return found

    def _copy(self, name: str) -> None:
        """Take a file along under its own name."""
        path = Path(name.replace("\\", "/"))
        found = beneath(self.scene.path and self.scene.path.parent, name)
        if found is None:
            self.warnings.append(f"'{name}' is named by the input but not found beside it, nor copied")
        else:
            self.files[self.main.parent / path] = found.read_bytes()

    def _image(self, name: str, material: Material) -> tuple[str, bytes] | None:
        """A name for the file of a texture, and its bytes as they are stored; tells where there is none."""
        if material.image is not None and name == material.texture:
            return name, material.image
        folder = self.scene.path and self.scene.path.parent
        uri = name
        if isinstance(self.scene.source, Document):
            image = self.scene.source.items("images")[int(name)]
            uri = unquote(image.get("uri", ""))
            if not uri or uri.startswith("data:"):
                data = data_uri(image["uri"]) if uri else self.scene.source.view(image["bufferView"])
                if data is None:
                    self.warnings.append(f"the data URI of glTF image {name} cannot be decoded: it is lost")
                    return None
                return f"{self.main.stem}_{name}.{_SUFFIXES.get(media_type(data), 'bin')}", data
        path = beneath(folder, uri)
        if path is None:
            self.warnings.append(_missing("texture", uri))
            return None
        return uri.replace("\\", "/"), path.read_bytes()

    def _put(self, name: str | None, material: Material) -> str | None:
        """Write a texture beside the result; its name there."""
        found = self._image(name, material) if name else None
        if found is None:
            return None
        own, data = found
        while self.files.get(self.main.parent / own, data) != data:
            own = f"{self.main.stem}_{own}"
        self.files[self.main.parent / own] = data
        return own

    def _beside(self, material: Material, name: str) -> Material:
        """A material whose textures are files beside the result."""
        texture = self._put(material.texture, material)
        others = [(key, self._put(other, material)) for key, other in material.others]
        return replace(material, name=name, texture=texture, others=tuple((k, v) for k, v in others if v))


def _shown(sheets: list[Sheet]) -> list[Part]:
    """Parts that have faces."""
    return [one.parts[number] for one in sheets for number in np.unique(one.part)]


def _materials(parts: list[Part]) -> list[Material]:
    """Materials of parts, each once."""
    return list(dict.fromkeys(one for one in map(material_of, parts) if one is not None))
