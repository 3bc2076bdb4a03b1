"""Make glTF documents for tests, and simplify them."""

from __future__ import annotations

import importlib
import io
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapes import Gltf, fine_box, split_glb

from bldsimp import Options
from bldsimp.io import read
from bldsimp.io import write as write_scene
from bldsimp.model import Scene
from bldsimp.options import DEFAULTS
from bldsimp.scene import simplify_scene


def import_decoder(package: str) -> Any:
    """Import a package that packs and decodes glTF; skip the test if it is missing and not required."""
    if os.environ.get("BLDSIMP_NEED_DECODERS") == "1":
        return importlib.import_module(package)
    return pytest.importorskip(package)


def png(width: int, height: int) -> bytes:
    """Return an image of one color."""
    from PIL import Image

    stream = io.BytesIO()
    Image.new("RGB", (width, height), (200, 10, 30)).save(stream, "PNG")
    return stream.getvalue()


def add_picture(document: Gltf, data: bytes) -> int:
    """Add a texture of an embedded image; return its number."""
    json_ = document.json
    document.data += b"\0" * (-len(document.data) % 4)
    json_["bufferViews"].append({"buffer": 0, "byteOffset": len(document.data), "byteLength": len(data)})
    document.data += data
    json_.setdefault("images", []).append({"bufferView": len(json_["bufferViews"]) - 1, "mimeType": "image/png"})
    json_.setdefault("textures", []).append({"source": len(json_["images"]) - 1})
    return len(json_["textures"]) - 1


def simplify_glb(data: bytes, path: Path, options: Options = DEFAULTS) -> tuple[Scene, bytes]:
    """Simplify a GLB; return the scene as read, and what was written."""
    scene = read(data, "glb")
    results, _ = simplify_scene(scene, options)
    write_scene(scene, results, path, "glb", options)
    return scene, path.read_bytes()


def new_primitive(data: bytes, number: int = 0) -> dict[str, Any]:
    primitive: dict[str, Any] = split_glb(data)[0]["meshes"][0]["primitives"][number]
    return primitive


def bounded(document: Gltf, points: np.ndarray, kind: str = "f4", **extra: Any) -> int:
    """Add an accessor of positions, with the bounds that the format asks for."""
    bounds = {"min": points.min(axis=0).tolist(), "max": points.max(axis=0).tolist()}
    return document.accessor(points, kind, **bounds, **extra)


def flat_map(points: np.ndarray) -> np.ndarray:
    """Return texture coordinates that are one affine map everywhere."""
    return points @ np.array([[0.25, 0.0], [0.125, 0.25], [0.0, 0.125]])


def fine(document: Gltf, *, shift: float = 0.0, **attributes: int) -> dict[str, Any]:
    """Make a primitive that is a fine box, valid in every respect."""
    points, faces = fine_box(shift=shift)
    indices = document.accessor(faces.reshape(-1), "u2")
    return {"attributes": {"POSITION": bounded(document, points), **attributes}, "indices": indices}


def textured(document: Gltf, count: int = 1, *, shift: float = 0.0, **more: Any) -> dict[str, Any]:
    """Make a fine box with UV sets, in a material whose textures read all of them."""
    picture = add_picture(document, png(32, 16))
    uv = document.accessor(flat_map(fine_box()[0]))
    slots = ("emissiveTexture", "occlusionTexture")[: count - 1]
    material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": picture}}, "name": "brick", **more}
    material |= {slot: {"index": picture, "texCoord": number} for number, slot in enumerate(slots, 1)}
    document.json.setdefault("materials", []).append(material)
    names = {f"TEXCOORD_{number}": uv for number in range(count)}
    return {**fine(document, shift=shift, **names), "material": len(document.json["materials"]) - 1}


def used(document: Gltf, *names: str, **root: Any) -> None:
    """Declare extensions as used, with their members at the root."""
    document.json["extensionsUsed"] = [*document.json.get("extensionsUsed", []), *names]
    if root:
        document.json["extensions"] = root


def everything_around() -> Gltf:
    """Names, extras, a tree, cameras, lights and an animation around a textured box."""
    document = Gltf()
    document.mesh({**textured(document), "extras": {"part": "walls"}}, name="house", extras={"id": 7},
                  node={"name": "at home", "translation": [1, 2, 3], "extras": {"floor": 2}})  # fmt: skip
    json_ = document.json
    light = {"KHR_lights_punctual": {"light": 0}}
    json_["nodes"] += [
        {"name": "garden", "children": [0, 2], "rotation": [0, 0.6, 0, 0.8]},
        {"name": "eye", "camera": 0, "extensions": light, "matrix": [*np.eye(4).reshape(-1).tolist()]},
    ]
    json_["scenes"] = [{"nodes": [1], "name": "all", "extras": [1, 2]}]
    json_["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}, "name": "front"}]
    json_["extras"] = {"author": "us"}
    json_["asset"]["copyright"] = "ours"
    json_["samplers"] = [{"wrapS": 33071, "magFilter": 9728}]
    json_["textures"][0]["sampler"] = 0
    time = document.accessor([0.0, 1.0], min=[0.0], max=[1.0])
    move = document.accessor(np.eye(3)[:2])
    channel = {"sampler": 0, "target": {"node": 0, "path": "translation"}}
    json_["animations"] = [{"name": "lift", "channels": [channel], "samplers": [{"input": time, "output": move}]}]
    used(document, "KHR_lights_punctual", KHR_lights_punctual={"lights": [{"type": "point", "name": "lamp"}]})
    return document


def several_primitives() -> Gltf:
    document = Gltf()
    plain = fine(document, shift=5.0)
    painted = fine(document, shift=9.0, COLOR_0=document.accessor(np.full((98, 3), 0.5)))
    first, second = textured(document), textured(document, 3, shift=13.0, name="plaster", doubleSided=True)
    document.mesh(first, second, plain, painted)
    return document


def mirrored() -> Gltf:
    document = Gltf()
    number = document.mesh(textured(document), node={"scale": [-1, 1, 1], "name": "left wing"})
    document.json["nodes"].append({"mesh": number, "name": "right wing", "translation": [3, 0, 0]})
    document.json["scenes"][0]["nodes"].append(1)
    return document


def without_indices() -> Gltf:
    document, (points, faces) = Gltf(), fine_box()
    primitive = textured(document)
    corners = points[faces].reshape(-1, 3)
    names = {"POSITION": bounded(document, corners), "TEXCOORD_0": document.accessor(flat_map(corners))}
    document.mesh({"attributes": names, "material": primitive["material"]})
    return document


def instances() -> Gltf:
    document = Gltf()
    places = document.accessor(np.random.default_rng(0).random((500, 3)) * 100.0)
    turns = document.accessor(np.tile([0.0, 0.0, 0.0, 1.0], (500, 1)))
    placed = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places, "ROTATION": turns}}}
    document.mesh(textured(document), node={"extensions": placed, "name": "windows"})
    used(document, "EXT_mesh_gpu_instancing")
    document.json["extensionsRequired"] = ["EXT_mesh_gpu_instancing"]
    return document


def nodes() -> Gltf:
    document = Gltf()
    number = document.mesh(textured(document), name="window")
    more = [{"mesh": number, "name": f"window {i}", "translation": [3.0 * i, 0, 0]} for i in range(1, 500)]
    document.json["nodes"] += more
    document.json["scenes"][0]["nodes"] += list(range(1, 500))
    return document


def sparse() -> Gltf:
    document = Gltf()
    points = fine_box()[0]
    primitive = textured(document)
    base = document.json["accessors"][primitive["attributes"]["POSITION"]]
    where, what = document.accessor([3, 5], "u2"), document.accessor(points[[3, 5]])
    views = [document.json["accessors"].pop()["bufferView"] for _ in (what, where)]
    base["sparse"] = {"count": 2, "indices": {"bufferView": views[1], "componentType": 5123},
                      "values": {"bufferView": views[0]}}  # fmt: skip
    document.mesh(primitive)
    return document


def quantized() -> Gltf:
    document, (points, faces) = Gltf(), fine_box()
    material = textured(document)["material"]
    names = {"POSITION": bounded(document, points * 100 - 50, "i2")}
    names["TEXCOORD_0"] = document.accessor(np.rint(flat_map(points * 2) * 65528 / 4), "u2", normalized=True)
    names["COLOR_0"] = document.accessor(np.full((98, 3), 77), "u1", normalized=True)
    document.mesh({"attributes": names, "indices": document.accessor(faces.reshape(-1), "u2"), "material": material})
    used(document, "KHR_mesh_quantization")
    document.json["extensionsRequired"] = ["KHR_mesh_quantization"]
    return document


def variants() -> Gltf:
    document = Gltf()
    first, second = textured(document), textured(document, shift=5.0, name="by night")
    mappings = [{"material": first["material"], "variants": [0]}, {"material": second["material"], "variants": [1]}]
    document.mesh({**first, "extensions": {"KHR_materials_variants": {"mappings": mappings}}}, second)
    names = {"variants": [{"name": "day"}, {"name": "night"}]}
    used(document, "KHR_materials_variants", KHR_materials_variants=names)
    return document


def features() -> Gltf:
    """Feature ids by attribute and by texture, a property table, a property texture and a property attribute."""
    document = Gltf()
    primitive = textured(document)
    primitive["attributes"]["_FEATURE_ID_0"] = document.accessor(np.full(98, 1), "u2")
    primitive["attributes"]["_HEAT"] = document.accessor(fine_box()[0][:, :1])
    by_texture = {"featureCount": 2, "texture": {"index": 0, "texCoord": 0, "channels": [0]}}
    ids = [{"featureCount": 2, "attribute": 0, "propertyTable": 0}, by_texture]
    primitive["extensions"] = {
        "EXT_mesh_features": {"featureIds": ids},
        "EXT_structural_metadata": {"propertyTextures": [0], "propertyAttributes": [0]},
    }
    table = document.json["accessors"].pop(document.accessor([11, 22], "u4"))["bufferView"]
    number = {"type": "SCALAR", "componentType": "UINT32"}
    level = {"type": "SCALAR", "componentType": "UINT8"}
    heat = {"type": "SCALAR", "componentType": "FLOAT32"}
    classes = {"room": {"properties": {"area": number}}, "wall": {"properties": {"damp": level}},
               "point": {"properties": {"heat": heat}}}  # fmt: skip
    metadata = {
        "schema": {"id": "house", "classes": classes},
        "propertyTables": [{"class": "room", "count": 2, "properties": {"area": {"values": table}}}],
        "propertyTextures": [{"class": "wall", "properties": {"damp": {"index": 0, "texCoord": 0, "channels": [0]}}}],
        "propertyAttributes": [{"class": "point", "properties": {"heat": {"attribute": "_HEAT"}}}],
    }
    document.mesh(primitive)
    used(document, "EXT_mesh_features", "EXT_structural_metadata", EXT_structural_metadata=metadata)
    return document


def tangents() -> Gltf:
    document = Gltf()
    square = np.array([[x, y, 0.0] for x in range(4) for y in range(4)])
    cells = [4 * x + y for x in range(3) for y in range(3)]
    faces = np.array([face for a in cells for face in ((a, a + 4, a + 5), (a, a + 5, a + 1))])
    primitive = textured(document, normalTexture={"index": 0})
    names = {"POSITION": bounded(document, square), "TEXCOORD_0": document.accessor(square[:, :2] / 3.0)}
    names |= {"NORMAL": document.accessor(np.tile([0.0, 0.0, 1.0], (16, 1)))}
    names |= {"TANGENT": document.accessor(np.tile([1.0, 0.0, 0.0, 1.0], (16, 1)))}
    document.mesh({**primitive, "attributes": names, "indices": document.accessor(faces.reshape(-1), "u2")})
    return document


def transformed() -> Gltf:
    """Tiles whose texture a material scales and turns, in another set than the texture names."""
    document = Gltf()
    primitive = textured(document, 2)
    transform = {"KHR_texture_transform": {"scale": [20, 10], "rotation": 0.3, "texCoord": 1}}
    document.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] = transform
    document.mesh(primitive)
    used(document, "KHR_texture_transform")
    return document


def bent() -> Gltf:
    """A skinned mesh and one with morph targets and animated weights, beside one that can be simplified."""
    document = Gltf()
    joints = {"JOINTS_0": document.accessor(np.zeros((98, 4)), "u1")}
    joints |= {"WEIGHTS_0": document.accessor(np.tile([1.0, 0, 0, 0], (98, 1)))}
    document.mesh(fine(document, **joints), node={"skin": 0, "name": "flag"}, name="flag")
    target = bounded(document, fine_box()[0])
    document.mesh({**fine(document), "targets": [{"POSITION": target}]}, weights=[0.5], name="door")
    document.mesh(textured(document), name="house")
    json_ = document.json
    json_["nodes"].append({"name": "joint"})
    json_["scenes"][0]["nodes"].append(3)
    matrices = document.accessor(np.eye(4), type="MAT4")
    json_["accessors"][matrices]["count"] = 1
    json_["skins"] = [{"joints": [3], "inverseBindMatrices": matrices, "name": "pole"}]
    time = document.accessor([0.0, 1.0], min=[0.0], max=[1.0])
    weights = document.accessor([0.0, 1.0])
    channel = {"sampler": 0, "target": {"node": 1, "path": "weights"}}
    json_["animations"] = [{"channels": [channel], "samplers": [{"input": time, "output": weights}]}]
    return document


CASES: dict[str, Callable[[], Gltf]] = {
    one.__name__.replace("_", " "): one
    for one in (
        everything_around, several_primitives, mirrored, without_indices, instances, nodes, sparse, quantized,
        variants, features, tangents, transformed, bent,
    )
}  # fmt: skip
"""A document for each feature that must stay unchanged."""
