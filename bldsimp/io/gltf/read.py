"""From a glTF document to meshes: every glTF mesh is one problem, its triangle primitives are the parts."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...model import Mesh, Part, check_finite, check_indices
from ...tolerance import number_format
from ..surface import Material
from .attributes import attributes, carried_names, fixed_names
from .document import Beside, Document
from .materials import is_one_sided, name_of, read_material
from .nodes import placed_meshes
from .textures import Texels, Textures
from .vertices import GltfMesh, Primitive, Rows

TRIANGLES, STRIP, FAN = 4, 5, 6


def gltf_meshes(document: Document, beside: Beside, warnings: list[str]) -> list[Mesh]:
    """All meshes of a document that have triangles.

    Parameters
    ----------
    document : Document
    beside : function of a relative path
        Gives the bytes of an image beneath the document's folder, or None.
    warnings : list of str
        Added to.

    Raises
    ------
    InputError
    """
    transforms, bent = placed_meshes(document)
    textures = Textures(document, beside, warnings)
    meshes = []
    for index in range(len(document.items("meshes"))):
        mesh = _mesh(document, textures, index, tuple(bent.get(index, ())))
        if mesh is not None:
            mesh.transforms = np.array(transforms.get(index, [])).reshape(-1, 4, 4)
            meshes.append(mesh)
    if not meshes:
        raise InputError("the glTF file has no triangles: bldsimp simplifies surfaces")
    if not any(len(mesh.transforms) for mesh in meshes):
        # A mere library of meshes: each shows once.
        for mesh in meshes:
            mesh.transforms = np.eye(4)[None]
    return meshes


def _mesh(document: Document, textures: Textures, index: int, bent: tuple[str, ...]) -> Mesh | None:
    """One mesh, or None where it has no triangles."""
    entry = document.items("meshes")[index]
    name = name_of(entry, f"mesh {index}")
    shared: dict[tuple[tuple[str, int], ...], Rows] = {}
    parts, faces, texels = [], [], []
    rows_so_far = 0
    for number, primitive in enumerate(entry.get("primitives", [])):
        own = primitive.get("attributes", {})
        if primitive.get("mode", TRIANGLES) not in (TRIANGLES, STRIP, FAN) or "POSITION" not in own:
            continue
        # Two primitives share vertices only where these are the same in everything.
        key = tuple(sorted(own.items()))
        if key not in shared:
            count = len(document.accessor(own["POSITION"]))
            shared[key] = Rows(tuple(own.items()), rows_so_far, count)
            rows_so_far += count
        rows = shared[key]
        faces.append(_faces(document, primitive, rows, f"{name}, primitive {number}") + rows.start)
        material = read_material(document, primitive)
        fixed = tuple(dict.fromkeys((*bent, *fixed_names(document, primitive, rows.count))))
        carried = tuple(dict.fromkeys((*carried_names(primitive), *fixed)))
        one_sided = is_one_sided(document, primitive)
        own = Primitive(number, rows, material)
        parts.append(Part(_part_name(name, number, material), carried, fixed, one_sided, own))
        texels.append(textures.texels(primitive))
    if not sum(map(len, faces)):
        return None
    return _joined(document, GltfMesh(index, list(shared.values())), name, parts, faces, texels)


def _joined(
    document: Document,
    source: GltfMesh,
    name: str,
    parts: list[Part],
    faces: list[NDArray[Any]],
    texels: list[dict[int, Texels]],
) -> Mesh:
    """One mesh of the vertices and faces of its primitives."""
    positions = [group.position for group in source.rows]
    points = np.concatenate([document.numbers(number) for number in positions])
    if points.shape[1] != 3:
        raise InputError(f"the positions of glTF mesh '{name}' are not three numbers: the file is damaged")
    joined = np.concatenate(faces).astype(np.int32)
    check_finite(points, joined)
    step = max(document.step(number) for number in positions)
    mesh = Mesh(
        name=name,
        points=points,
        faces=joined,
        part_of_face=np.repeat(np.arange(len(parts), dtype=np.int32), [len(own) for own in faces]),
        parts=parts,
        source=source,
    )
    mesh.attributes = attributes(document, source.rows, mesh, texels)
    mesh.quantized = bool(step)
    mesh.single, mesh.rounding = (False, step / 2.0) if step else number_format(mesh.used_points)
    if any(group.accessor("NORMAL") is not None for group in source.rows):
        mesh.normals = np.concatenate([_normals(document, group) for group in source.rows])
    return mesh


def _faces(document: Document, primitive: dict[str, Any], rows: Rows, name: str) -> NDArray[np.int64]:
    """Faces of a primitive, whatever its mode."""
    corners = document.indices(primitive["indices"]) if "indices" in primitive else np.arange(rows.count)
    try:
        check_indices(corners, rows.count)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None
    mode = primitive.get("mode", TRIANGLES)
    if mode == TRIANGLES:
        triples: NDArray[np.int64] = corners[: len(corners) // 3 * 3].reshape(-1, 3)
        return triples
    if len(corners) < 3:
        return np.zeros((0, 3), np.int64)
    if mode == FAN:
        first = np.full(len(corners) - 2, corners[0])
        return np.stack([corners[1:-1], corners[2:], first], axis=1)
    faces: NDArray[np.int64] = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    faces[1::2] = faces[1::2][:, [0, 2, 1]]
    a, b, c = faces.T
    proper = (a != b) & (b != c) & (a != c)
    return np.asarray(faces[proper])


def _normals(document: Document, group: Rows) -> NDArray[np.float64]:
    """Normals of a group, zero where it has none."""
    number = group.accessor("NORMAL")
    if number is None:
        return np.zeros((group.count, 3))
    found = document.numbers(number)
    if found.shape != (group.count, 3):
        raise InputError("a glTF primitive has not as many normals as positions: the file is damaged")
    return np.nan_to_num(found, posinf=0.0, neginf=0.0)


def _part_name(mesh: str, number: int, material: Material | None) -> str:
    return f"{mesh} / {material.name}" if material and material.name else f"{mesh} / primitive {number}"
