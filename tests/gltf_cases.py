"""glTF documents that tests make, and what becomes of them."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

from shapes import Gltf, glb_parts

from bldsimp import Options, Scene, simplify_scene
from bldsimp.io import read
from bldsimp.io import write as write_scene


def png(width: int, height: int) -> bytes:
    """A picture of one colour."""
    from PIL import Image

    stream = io.BytesIO()
    Image.new("RGB", (width, height), (200, 10, 30)).save(stream, "PNG")
    return stream.getvalue()


def add_picture(document: Gltf, data: bytes) -> int:
    """A texture of an embedded image."""
    json_ = document.json
    document.data += b"\0" * (-len(document.data) % 4)
    json_["bufferViews"].append({"buffer": 0, "byteOffset": len(document.data), "byteLength": len(data)})
    document.data += data
    json_.setdefault("images", []).append({"bufferView": len(json_["bufferViews"]) - 1, "mimeType": "image/png"})
    json_.setdefault("textures", []).append({"source": len(json_["images"]) - 1})
    return len(json_["textures"]) - 1


def light_of(data: bytes, path: Path, options: Options = Options()) -> tuple[Scene, bytes]:  # noqa: B008
    """Simplify a GLB and give back what was written."""
    scene = read(data, "glb")
    lights, _ = simplify_scene(scene, options)
    write_scene(scene, lights, path, "glb", options)
    return scene, path.read_bytes()


def new_primitive(data: bytes, number: int = 0) -> dict[str, Any]:
    primitive: dict[str, Any] = glb_parts(data)[0]["meshes"][0]["primitives"][number]
    return primitive
