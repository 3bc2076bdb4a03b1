"""STL, and every other mesh format that trimesh reads."""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..model import FACE, Mesh, Part, attach_attributes
from ..trimesh_adapter import build_attributes, collect_columns, find_image
from .stl import whole_stl
from .surface import Material, Polygons, polygon_mesh

STL_BYTES = FACE + "_stl"
"""What an STL file stores behind each face."""


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
    every = list(geometries.values())
    points = np.concatenate([np.asarray(one.vertices, np.float64) for one in every])
    starts = np.cumsum([0, *(len(one.vertices) for one in every)])
    faces = [np.asarray(one.faces, np.int64) + start for one, start in zip(every, starts, strict=False)]
    corners = np.concatenate(faces)
    part = np.repeat(np.arange(len(every)), [len(one.faces) for one in every])
    parts = [Part(key, source=_material(one)) for key, one in geometries.items()]
    polygons = Polygons(
        np.arange(0, corners.size + 1, 3, dtype=np.int32),
        corners.reshape(-1).astype(np.int32),
        part.astype(np.int32),
    )
    mesh, polygon = polygon_mesh(name, points, polygons, parts, warnings)
    columns = _joined(every)
    for key in columns:
        if key.startswith(FACE):
            columns[key] = columns[key][polygon]
    # Bytes that no program has set are no attribute.
    if not columns.get(STL_BYTES, np.ones(1)).any():
        del columns[STL_BYTES]
    attach_attributes(mesh, build_attributes(mesh, columns, [find_image(one) for one in every]))
    return mesh


def _joined(geometries: list[Any]) -> dict[str, Any]:
    """What geometries carry, end to end; NaN, or 0 where numbers are whole, for one that has it not."""
    each = [collect_columns(one) for one in geometries]
    joined = {}
    for key, first in {key: values for own in each for key, values in own.items()}.items():
        blank = np.nan if first.dtype.kind == "f" else 0
        counts = [len(one.faces if key.startswith(FACE) else one.vertices) for one in geometries]
        pieces = [
            own.get(key, np.full((count, first.shape[1]), blank, first.dtype))
            for own, count in zip(each, counts, strict=True)
        ]
        joined[key] = np.concatenate(pieces)
    return joined


def _material(geometry: Any) -> Material | None:
    """Name, colour and texture of a trimesh geometry's material."""
    material = getattr(geometry.visual, "material", None)
    if material is None:
        return None
    r, g, b, a = (float(value) for value in np.asarray(material.main_color, np.float64) / 255.0)
    name, image = str(material.name or "material"), find_image(geometry)
    if image is None:
        return Material(name, (r, g, b, a))
    # trimesh keeps pixels, not files: these are stored without loss.
    stream = io.BytesIO()
    image.save(stream, "PNG")
    own = re.sub(r"[^\w.-]+", "_", name)
    return Material(name, (r, g, b, a), f"{own}.png", image=stream.getvalue())
