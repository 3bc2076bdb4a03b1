"""Read a model as it is drawn: glTF from its JSON and buffers, all else through trimesh."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from PIL import Image

from textured.gltf import read_gltf
from textured.model import Floats, Material, Model, Surface, Texture


def read(path: Path) -> Model:
    """A model of any format, z upwards: glTF stands y up, all others are taken as they are."""
    if path.suffix.lower() in (".glb", ".gltf"):
        return Model.of(read_gltf(path))
    scene = trimesh.load_scene(path, process=False)
    return Model.of([surface_of(mesh) for mesh in scene.geometry.values()])


def surface_of(mesh: trimesh.Trimesh) -> Surface:
    """A mesh of trimesh."""
    points, faces = np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int64)
    visual = mesh.visual
    if visual.kind == "vertex":
        return Surface(points, faces, Material(), colours=levels(visual.vertex_colors))
    if visual.kind == "face":
        return Surface(
            points[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3), Material(),
            colours=levels(visual.face_colors).repeat(3, axis=0),
        )  # fmt: skip
    if visual.kind != "texture":
        return Surface(points, faces, Material())
    own = visual.material
    image = getattr(own, "image", None)
    picture = None if image is None else Texture(pixels_of(image))
    colour = levels(own.main_color)
    material = Material(str(own.name), (colour[0], colour[1], colour[2], colour[3]), picture, alpha=alpha_of(picture))
    uv = {} if visual.uv is None else {0: np.asarray(visual.uv, float) * (1, -1) + (0, 1)}
    return Surface(points, faces, material, uv=uv)


def alpha_of(picture: Texture | None) -> str:
    """Formats without a word for it: see-through where the picture is."""
    return "MASK" if picture is not None and picture.pixels[..., 3].min() < 0.5 else "OPAQUE"


def levels(colours: object) -> Floats:
    """Levels of 255 as shares."""
    return np.asarray(colours, float) / 255.0


def pixels_of(image: Image.Image) -> Floats:
    """RGBA of an image."""
    return levels(image.convert("RGBA"))
