"""What stands beside a file: textures, images and material libraries, copied or put inside."""

from __future__ import annotations

import base64
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote

from ..options import Options
from ..scene import Scene
from .folder import beneath
from .gltf import Document, data_uri
from .gltf_body import pack_views
from .sheet import Sheet
from .surface import Material, Stored

_MEDIA = {b"\x89PNG": "image/png", b"\xff\xd8\xff": "image/jpeg", b"RIFF": "image/webp"}


def media_type(data: bytes) -> str:
    """Media type of an image, by its first bytes."""
    return next(
        (kind for magic, kind in _MEDIA.items() if data.startswith(magic)), "application/octet-stream"
    )


def _missing(kind: str, name: str) -> str:
    return f"the {kind} '{name[:80]}' is no file beneath the input's folder"


def copies(
    json_: dict[str, Any], source: Path | None, target: Path, warnings: list[str]
) -> dict[Path, bytes]:
    """Images and buffers that a document names, for the folder that it moves to.

    A reference out of the folder is made relative to the new one instead.
    """
    if source is None or source.parent.resolve() == target.parent.resolve():
        return {}
    found: dict[Path, bytes] = {}
    named = [("image", entry) for entry in json_.get("images", [])]
    for kind, entry in [*named, *(("buffer", entry) for entry in json_.get("buffers", []))]:
        uri = entry.get("uri", "")
        if not uri or uri.startswith("data:") or "://" in uri:
            continue
        name = Path(unquote(uri))
        path = beneath(source.parent, unquote(uri))
        if name.is_absolute() or ".." in name.parts:
            entry["uri"] = quote(Path(os.path.relpath(source.parent / name, target.parent)).as_posix())
        elif path is None:
            warnings.append(_missing(kind, unquote(uri)))
        elif (target.parent / name).parent.is_dir() or name.parent == Path():
            found[target.parent / name] = path.read_bytes()
        else:
            found[target.parent / name.name] = path.read_bytes()
            entry["uri"] = quote(name.name)
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


def obj_pictures(scene: Scene, options: Options, warnings: list[str]) -> dict[str, tuple[str, bytes]]:
    """Media type and bytes of the textures of parts that are passed on."""
    found: dict[str, tuple[str, bytes]] = {}
    for mesh in scene.meshes:
        for part in mesh.parts:
            texture = getattr(getattr(part.source, "material", part.source), "texture", None)
            if not texture or texture in found or not bool(part.fixed):
                continue
            path = beneath(scene.path and scene.path.parent, texture)
            if path is None:
                warnings.append(_missing("texture", texture))
                continue
            data = path.read_bytes()
            found[texture] = media_type(data), data
    return found


class Pictured:
    """The material library of an OBJ file and the textures that it names.

    Attributes
    ----------
    files : dict of Path to bytes
        To be written beside the OBJ file.
    """

    def __init__(self, scene: Scene, main: Path, warnings: list[str]) -> None:
        self.scene = scene
        self.main = main
        self.warnings = warnings
        self.files: dict[Path, bytes] = {}

    def libraries(self, sheets: list[Sheet], text: Callable[[list[Material]], str]) -> list[str]:
        """Names of the libraries to write into the OBJ file; fills `files`."""
        stored = self.scene.meshes[0].source
        if isinstance(stored, Stored) and isinstance(stored.format, list):
            self._copy_libraries(stored.format)
            return [str(name) for name in stored.format]
        materials: dict[str, Material] = {}
        for one in sheets:
            for part, kept in zip(one.parts, one.kept, strict=True):
                material = getattr(part.source, "material", part.source)
                if isinstance(material, Material):
                    name = " ".join(material.name.split())
                    texture = self._texture(material) if kept else None
                    materials.setdefault(name, Material(name, material.color, texture))
        if not materials:
            return []
        library = self.main.with_suffix(".mtl")
        self.files[library] = text(list(materials.values())).encode("utf-8")
        return [library.name]

    def _copy_libraries(self, names: list[str]) -> None:
        """Take libraries and textures along to another folder."""
        source = self.scene.path
        if source is None or source.parent.resolve() == self.main.parent.resolve():
            return
        textures = {
            part.source.material.texture
            for mesh in self.scene.meshes
            for part in mesh.parts
            if part.attributes and part.source.material and part.source.material.texture
        }
        for name in [*names, *sorted(textures)]:
            path, found = Path(name.replace("\\", "/")), beneath(source.parent, name)
            if path.is_absolute() or ".." in path.parts or found is None:
                self.warnings.append(f"'{name}' is named by the input but not found beside it, nor copied")
            elif not (self.main.parent / path).parent.is_dir():
                self.warnings.append(f"'{name}' was not copied: its folder is missing beside the output")
            else:
                self.files[self.main.parent / path] = found.read_bytes()

    def _texture(self, material: Material) -> str | None:
        """Write an image of a glTF document beside the OBJ file."""
        document = self.scene.source
        if material.texture is None or not isinstance(document, Document):
            return None
        image = document.items("images")[int(material.texture)]
        uri = image.get("uri", "")
        if uri and not uri.startswith("data:"):
            path = beneath(self.scene.path and self.scene.path.parent, unquote(uri))
            if path is None:
                self.warnings.append(_missing("image", unquote(uri)))
                return None
            data, name = path.read_bytes(), path.name
        else:
            data = data_uri(uri) if uri else document.view(image["bufferView"])
            suffix = {"image/png": "png", "image/jpeg": "jpg", "image/webp": "webp"}.get(
                media_type(data), "bin"
            )
            name = f"{self.main.stem}_{material.texture}.{suffix}"
        self.files[self.main.with_name(name)] = data
        return name
