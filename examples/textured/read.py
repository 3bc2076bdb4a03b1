"""Read a model to draw it: glTF and OBJ by readers of our own, all else through trimesh."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from textured.gltf import read_gltf
from textured.model import Floats, Material, Model, Surface
from textured.obj import read_obj

Y_UP = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])


def is_gltf(path: Path) -> bool:
    """Return whether a file is glTF, which stands y up."""
    return path.suffix.lower() in (".glb", ".gltf")


def read_model(path: Path, *, y_up: bool | None = None) -> Model:
    """Read a model of any format, turned so that z is up; by default only glTF is turned."""
    if is_gltf(path):
        surfaces = read_gltf(path)
    elif path.suffix.lower() == ".obj":
        surfaces = read_obj(path)
    else:
        surfaces = [convert_mesh(mesh) for mesh in trimesh.load_scene(path, process=False).geometry.values()]
    if is_gltf(path) if y_up is None else y_up:
        for surface in surfaces:
            surface.points = surface.points @ Y_UP.T
            surface.normals = None if surface.normals is None else surface.normals @ Y_UP.T
    return Model.join(surfaces)


def convert_mesh(mesh: trimesh.Trimesh) -> Surface:
    """Convert a mesh of trimesh."""
    points, faces = np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int64)
    visual: Any = mesh.visual
    if visual.kind == "vertex":
        return Surface(points, faces, Material(), colors=scale_levels(visual.vertex_colors))
    if visual.kind == "face":
        return Surface(
            points[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3), Material(),
            colors=scale_levels(visual.face_colors).repeat(3, axis=0),
        )  # fmt: skip
    return Surface(points, faces, Material())


def scale_levels(colors: Any) -> Floats:
    """Scale levels of 255 to shares."""
    return np.asarray(colors, float) / 255.0
