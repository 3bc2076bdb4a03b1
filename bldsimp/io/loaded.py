"""STL, and every other mesh format that trimesh reads."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..scene import Mesh, Part
from .stl import whole_stl
from .surface import Material, Polygons, polygon_mesh


def read_loaded(data: bytes, format_: str, path: Path | None, warnings: list[str]) -> list[Mesh]:
    """Read a file through trimesh: one mesh for an STL, else one for each geometry of the scene.

    Raises
    ------
    InputError
    """
    import trimesh

    if format_ == "stl":
        data = whole_stl(data, warnings)
    source: Any = io.BytesIO(data) if path is None or format_ == "stl" else str(path)
    try:
        # process=False keeps rows as they are stored; True would merge and drop some.
        scene = trimesh.load_scene(source, file_type=format_, process=False)
    except Exception as error:  # trimesh's loaders raise whatever their parsers raise
        first = (str(error).strip() or type(error).__name__).splitlines()[0]
        raise InputError(f"trimesh cannot read this as {format_}: {first[:160]}") from error
    found = {
        name: geometry
        for name, geometry in scene.geometry.items()
        if getattr(geometry, "faces", None) is not None and len(geometry.faces)
    }
    if not found:
        raise InputError("no faces: the file is empty of surfaces, or damaged")
    if format_ == "stl":
        return [_mesh("", found, warnings)]
    meshes = []
    for name, geometry in found.items():
        mesh = _mesh(name, {name: geometry}, warnings)
        places = [scene.graph.get(node) for node in scene.graph.nodes_geometry]
        own = [np.array(matrix, np.float64) for matrix, geometry_name in places if geometry_name == name]
        if own:
            mesh.transforms = np.array(own)
        meshes.append(mesh)
    return meshes


def _mesh(name: str, geometries: dict[str, Any], warnings: list[str]) -> Mesh:
    """One mesh of several geometries."""
    points = np.concatenate([np.asarray(one.vertices, np.float64) for one in geometries.values()])
    starts = np.cumsum([0, *(len(one.vertices) for one in geometries.values())])
    corners = np.concatenate(
        [
            np.asarray(one.faces, np.int64) + start
            for one, start in zip(geometries.values(), starts, strict=False)
        ]
    )
    part = np.repeat(np.arange(len(geometries)), [len(one.faces) for one in geometries.values()])
    parts = [Part(key, _attributes(one), _material(one)) for key, one in geometries.items()]
    polygons = Polygons(
        np.arange(0, corners.size + 1, 3, dtype=np.int32),
        corners.reshape(-1).astype(np.int32),
        part.astype(np.int32),
    )
    mesh = polygon_mesh(name, points, polygons, parts, warnings)
    for one, start in zip(geometries.values(), starts, strict=False):
        for key, values in _carried(one).items():
            target = mesh.source.carried.setdefault(key, np.full((len(points), values.shape[1]), np.nan))
            target[start : start + len(values)] = values
    return mesh


def _attributes(geometry: Any) -> tuple[str, ...]:
    """What a trimesh geometry carries beside its surface."""
    names = []
    visual = geometry.visual
    if getattr(visual, "uv", None) is not None:
        names.append("texture coordinates")
    if visual.kind in ("vertex", "face") and visual.defined:
        names.append({"vertex": "colour", "face": "face colour"}[visual.kind])
    names += list(geometry.vertex_attributes)
    names += [key for key, values in geometry.face_attributes.items() if key != "stl" or np.any(values)]
    return tuple("STL attribute bytes" if name == "stl" else name for name in names)


def _carried(geometry: Any) -> dict[str, Any]:
    """Texture coordinates and colours of a trimesh geometry, per vertex."""
    carried = {}
    uv = getattr(geometry.visual, "uv", None)
    if uv is not None and np.shape(uv) == (len(geometry.vertices), 2):
        carried["TEXCOORD_0"] = np.asarray(uv, np.float64)
    if geometry.visual.kind == "vertex" and geometry.visual.defined:
        carried["COLOR_0"] = np.asarray(geometry.visual.vertex_colors, np.float64) / 255.0
    return carried


def _material(geometry: Any) -> Material | None:
    """Name and colour of a trimesh geometry's material."""
    material = getattr(geometry.visual, "material", None)
    if material is None:
        return None
    color = np.asarray(material.main_color, np.float64) / 255.0
    return Material(str(material.name or "material"), tuple(float(value) for value in color))  # type: ignore[arg-type]
