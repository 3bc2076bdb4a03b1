"""Read a model as it is drawn: glTF and OBJ from what their files say, all else through trimesh."""

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
    """Whether a file is glTF, which stands y up."""
    return path.suffix.lower() in (".glb", ".gltf")


def read(path: Path, *, y_up: bool | None = None) -> Model:
    """A model of any format, turned so that z is up; where not told otherwise, only glTF has to be."""
    if is_gltf(path):
        surfaces = read_gltf(path)
    elif path.suffix.lower() == ".obj":
        surfaces = read_obj(path)
    else:
        surfaces = [surface_of(mesh) for mesh in trimesh.load_scene(path, process=False).geometry.values()]
    if is_gltf(path) if y_up is None else y_up:
        for surface in surfaces:
            surface.points = surface.points @ Y_UP.T
            surface.normals = None if surface.normals is None else surface.normals @ Y_UP.T
    return Model.of(surfaces)


def surface_of(mesh: trimesh.Trimesh) -> Surface:
    """A mesh of trimesh."""
    points, faces = np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int64)
    visual: Any = mesh.visual
    if visual.kind == "vertex":
        return Surface(points, faces, Material(), colours=levels(visual.vertex_colors))
    if visual.kind == "face":
        return Surface(
            points[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3), Material(),
            colours=levels(visual.face_colors).repeat(3, axis=0),
        )  # fmt: skip
    return Surface(points, faces, Material())


def levels(colours: Any) -> Floats:
    """Levels of 255 as shares."""
    return np.asarray(colours, float) / 255.0
