"""Read STL, and every other mesh format that bldsimp has no reader for, through trimesh."""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..material import Material
from ..model import FACE, Mesh, Part, attach_attributes, cast_indices
from ..trimesh_adapter import build_attributes, collect_columns, find_image
from .polygons import Polygons, build_mesh
from .stl import STL_BYTES, check_stl


def read_by_trimesh(data: bytes, format_: str, path: Path | None, warnings: list[str]) -> list[Mesh]:
    """Read a file through trimesh.

    Parameters
    ----------
    data : bytes
    format_ : str
    path : Path or None
        Formats other than STL are read from here, if given, since they may name other files.
    warnings : list of str
        Receives a message about each kind of data that is ignored.

    Returns
    -------
    list of Mesh
        One for an STL file, whose solids are parts; else one for each geometry of the scene.

    Raises
    ------
    InputError
        If the file is damaged, or has no faces.
    """
    import trimesh

    if format_ == "stl":
        data = check_stl(data, warnings)
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
        return [_build_mesh("", found, warnings)]
    meshes = []
    for name, geometry in found.items():
        mesh = _build_mesh(name, {name: geometry}, warnings)
        places = [scene.graph.get(node) for node in scene.graph.nodes_geometry]
        own = [np.array(matrix, np.float64) for matrix, geometry_name in places if geometry_name == name]
        if own:
            mesh.transforms = np.array(own)
        meshes.append(mesh)
    return meshes


def _build_mesh(name: str, geometries: dict[str, Any], warnings: list[str]) -> Mesh:
    """Build one mesh of several geometries, a part each."""
    every = list(geometries.values())
    points = np.concatenate([np.asarray(one.vertices, np.float64) for one in every])
    starts = np.cumsum([0, *(len(one.vertices) for one in every)])
    faces = np.concatenate([np.asarray(one.faces, np.int64) + start for one, start in zip(every, starts, strict=False)])
    part = np.repeat(np.arange(len(every)), [len(one.faces) for one in every])
    parts = [Part(key, material=_read_material(one)) for key, one in geometries.items()]
    polygons = Polygons(np.full(len(faces), 3), cast_indices(faces.reshape(-1)), cast_indices(part))
    mesh, polygon = build_mesh(name, points, polygons, parts, warnings)
    # Several solids are those of an STL text, which has nothing but corners.
    given = collect_columns(every[0]) if len(every) == 1 else {}
    columns = {key: values[polygon] if key.startswith(FACE) else values for key, values in given.items()}
    # Bytes that no program has set are no attribute.
    if not columns.get(STL_BYTES, np.ones(1)).any():
        del columns[STL_BYTES]
    attach_attributes(mesh, build_attributes(mesh, columns, [find_image(one) for one in every]))
    return mesh


def _read_material(geometry: Any) -> Material | None:
    """Read name, color and texture of a trimesh geometry's material."""
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
