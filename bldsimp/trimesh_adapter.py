"""Read the attributes of a `trimesh.Trimesh`, and give them back to a result."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .model import FACE, Attribute, Mesh, SimplifiedMesh, make_attribute
from .options import UNKNOWN_TEXELS

_COLOR, _FACE_COLOR, _MATERIAL = "COLOR_0", FACE + "COLOR_0", FACE + "MATERIAL"


def collect_columns(geometry: Any) -> dict[str, NDArray[Any]]:
    """Collect UV, colors, materials and other arrays of a geometry by attribute name: (n, k), of faces (m, k)."""
    found: dict[str, Any] = {}
    visual = geometry.visual
    uv = getattr(visual, "uv", None)
    if uv is not None and np.shape(uv) == (len(geometry.vertices), 2):
        found["TEXCOORD_0"] = np.asarray(uv, np.float64)
    materials = getattr(visual, "face_materials", None)
    if materials is not None and np.shape(materials) == (len(geometry.faces),):
        found[_MATERIAL] = np.asarray(materials)[:, None]
    if visual.kind == "vertex" and visual.defined:
        found[_COLOR] = np.asarray(visual.vertex_colors, np.float64) / 255.0
    elif visual.kind == "face" and visual.defined:
        found[_FACE_COLOR] = np.asarray(visual.face_colors, np.float64) / 255.0
    for front, given, count in (
        ("_", geometry.vertex_attributes, len(geometry.vertices)),
        (FACE + "_", geometry.face_attributes, len(geometry.faces)),
    ):
        for key, values in given.items():
            array = np.asarray(values)
            if array.dtype.kind in "biuf" and array.ndim in (1, 2) and len(array) == count:
                found[f"{front}{key}"] = array.reshape(count, -1)
    return found


def find_image(geometry: Any) -> Any:
    """Find the color texture of a geometry's material, as trimesh has it; None where it has none."""
    material = getattr(geometry.visual, "material", None)
    image = getattr(material, "image", None)
    return getattr(material, "baseColorTexture", None) if image is None else image


def build_attributes(mesh: Mesh, columns: dict[str, NDArray[Any]], images: list[Any]) -> list[Attribute]:
    """Build the attributes of a mesh from the arrays of its geometries.

    Parameters
    ----------
    mesh : Mesh
    columns : dict
        As `collect_columns` names them, in rows and faces of the mesh.
    images : list
        `find_image` each part.
    """
    sizes = [(UNKNOWN_TEXELS, UNKNOWN_TEXELS) if image is None else image.size for image in images]
    found = []
    for name, array in columns.items():
        values, own = array.astype(np.float64), name.removeprefix(FACE)
        if name == "TEXCOORD_0":
            found.append(Attribute(name, "uv", values, np.array(sizes, np.float64)))
        else:
            found.append(make_attribute(own, values, mesh, on_faces=own != name, whole=array.dtype.kind != "f"))
    return found


def gather_corner_values(mesh: Mesh, result: SimplifiedMesh) -> NDArray[np.float64]:
    """Gather the attributes of all corners of a result side by side, (3 k, w)."""
    corners = result.faces.reshape(-1)
    columns = [result.values(one)[corners] for one in mesh.attributes if not one.on_faces]
    return np.hstack([np.empty((len(corners), 0)), *columns])


def restore_attributes(made: Any, given: Any, mesh: Mesh, result: SimplifiedMesh, corner: NDArray[np.int64]) -> None:
    """Restore the attributes that the geometry of a result had.

    Parameters
    ----------
    made, given : trimesh.Trimesh
        The result, changed in place; the input.
    mesh : Mesh
    result : SimplifiedMesh
    corner : (n,) int
        A corner of the result's faces for each of its vertices.
    """
    import trimesh

    made.metadata.update(given.metadata)
    columns = {
        one.name: result.values(one) if one.on_faces else result.values(one)[result.faces.reshape(-1)[corner]]
        for one in mesh.attributes
    }
    material = getattr(given.visual, "material", None)
    if material is not None:
        visuals: Any = trimesh.visual.TextureVisuals
        numbers = None
        if _MATERIAL in columns:
            numbers = np.rint(columns[_MATERIAL][:, 0]).astype(np.asarray(given.visual.face_materials).dtype)
        made.visual = visuals(uv=columns.get("TEXCOORD_0"), material=material, face_materials=numbers)
    elif _COLOR in columns or _FACE_COLOR in columns:
        levels = {
            name: np.rint(255.0 * columns[name]).astype(np.uint8) for name in (_COLOR, _FACE_COLOR) if name in columns
        }
        made.visual = trimesh.visual.ColorVisuals(made, levels.get(_FACE_COLOR), levels.get(_COLOR))
    for front, source, target in (
        ("_", given.vertex_attributes, made.vertex_attributes),
        (FACE + "_", given.face_attributes, made.face_attributes),
    ):
        for key, values in source.items():
            if f"{front}{key}" in columns:
                own, kind = columns[f"{front}{key}"], np.asarray(values).dtype
                whole = np.rint(own) if kind.kind != "f" else own
                target[key] = whole.astype(kind).reshape(len(own), *np.shape(values)[1:])
