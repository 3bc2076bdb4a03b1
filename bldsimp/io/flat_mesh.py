"""Lay a result out the way files store it: rows of points, faces and parts with their values, in one frame."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..material import UvMap
from ..model import FACE, Attribute, Faces, Indices, Mesh, Part, Points, SimplifiedMesh, Values, cast_indices
from ..options import Options
from ..stages.normals import compute_face_normals, resolve_normals
from ..tolerance import transform_points
from ..unique_rows import find_unique_rows


@dataclass
class FlatMesh:
    """One instance of one mesh, or several joined; a face uses every row.

    Attributes
    ----------
    name : str
    points : (n, 3) float64
    normals : (n, 3) float64 or None
        Zero in rows without.
    attributes : list of Attribute
        Values of rows or of faces, as far as they are kept.
    faces : (k, 3) int32
    part : (k,) int32
        Index into `parts`.
    parts : list of Part
    """

    name: str
    points: Points
    normals: Values | None
    attributes: list[Attribute]
    faces: Faces
    part: Indices
    parts: list[Part]

    def values(self, name: str) -> Values | None:
        """Return the values of an attribute, or None if there is none of that name."""
        return next((one.values for one in self.attributes if one.name == name), None)

    def used_parts(self) -> list[Part]:
        """List the parts that have faces."""
        return [self.parts[number] for number in np.unique(self.part)]


def flatten_result(mesh: Mesh, result: SimplifiedMesh, options: Options) -> FlatMesh:
    """Lay a result out in its mesh's own frame.

    Parameters
    ----------
    mesh : Mesh
    result : SimplifiedMesh
    options : Options
        `normals`, `crease_angle` and `delimit`.
    """
    result, normals = resolve_normals(mesh, result, options)
    fixed = mesh.passed_on[result.part_of_face]
    if mesh.normals is not None and normals is None and fixed.any():
        # Unchanged parts keep their own.
        normals = np.zeros_like(result.points)
        normals[result.faces[fixed]] = mesh.normals[result.row][result.faces[fixed]]
    attributes = [replace(one, values=result.values(one)) for one in mesh.attributes if options.keeps(one.kind)]
    flat = FlatMesh(mesh.name, result.points, normals, attributes, result.faces, result.part_of_face, mesh.parts)
    return _select_rows(flat, *drop_unused_rows(result.faces, len(result.points)))


def drop_unused_rows(faces: Faces, count: int) -> tuple[NDArray[np.int64], Faces]:
    """Return the rows, of so many, that faces use, ascending, and the faces in terms of them."""
    used = np.zeros(count, bool)
    used[faces] = True
    return np.flatnonzero(used), (np.cumsum(used, dtype=np.int32) - 1)[faces]


def place_instance(flat: FlatMesh, transform: Values) -> FlatMesh:
    """Move a mesh into world space by a 4 x 4 transform; turn its faces if that mirrors it."""
    if np.array_equal(transform, np.eye(4)):
        return flat
    a, b, c = transform[:3, :3].T
    cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    mirrored = sum((a * np.cross(b, c)).tolist()) < 0.0
    normals = flat.normals
    if normals is not None:
        frame = np.eye(4)
        frame[:3, :3] = -cofactors if mirrored else cofactors
        normals = scale_to_unit(transform_points(normals, frame))
    faces = flat.faces[:, ::-1] if mirrored else flat.faces
    return replace(flat, points=transform_points(flat.points, transform), normals=normals, faces=faces)


def scale_to_unit(vectors: Values) -> Values:
    """Scale vectors, (n, 3), to length 1; leave those of length 0."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0.0))


def apply_uv_maps(flat: FlatMesh) -> FlatMesh:
    """Replace the first UV set by that of the color textures, mapped: other formats have one set and no map."""
    maps = [part.material.uv_map if part.material else UvMap() for part in flat.parts]
    if all(maps[part] == UvMap() for part in np.unique(flat.part)):
        return flat
    flat = _split_corners(flat)
    part = np.repeat(flat.part, 3)
    uv = np.full((len(flat.points), 2), np.nan)
    for number, own in enumerate(maps):
        values = flat.values(f"TEXCOORD_{own.set}")
        if values is not None:
            rows = np.flatnonzero(part == number)
            uv[rows] = values[rows] if own.matrix == UvMap().matrix else _map_uv(values[rows], own.matrix)
    first = Attribute("TEXCOORD_0", "uv", uv, np.ones((len(flat.parts), 2)))
    return replace(flat, attributes=[first, *(a for a in flat.attributes if a.name != "TEXCOORD_0")])


def _map_uv(uv: Values, matrix: tuple[float, ...]) -> Values:
    """Map UV by a 2 x 3 matrix, summed in a fixed order so that no library's blocking shows."""
    u, v = uv.T
    a, b, c, d, e, f = matrix
    return np.stack([a * u + b * v + c, d * u + e * v + f], axis=1)


def spread_face_values(flat: FlatMesh) -> FlatMesh:
    """Give the values of faces to their corners, each corner a row."""
    spread = [
        replace(one, name=one.name.removeprefix(FACE), values=np.repeat(one.values, 3, axis=0), on_faces=False)
        for one in flat.attributes
        if one.on_faces
    ]
    if not spread:
        return flat
    # Where rows have the same attribute, faces win, as in most viewers: who colors faces wants to see it.
    hidden = {one.name for one in spread}
    flat = _split_corners(flat)
    rows = [one for one in flat.attributes if not one.on_faces and one.name not in hidden]
    return replace(flat, attributes=rows + spread)


def _split_corners(flat: FlatMesh) -> FlatMesh:
    """Give each corner of each face a row of its own."""
    corners = flat.faces.reshape(-1)
    return _select_rows(flat, corners, cast_indices(np.arange(len(corners))).reshape(-1, 3))


def _select_rows(flat: FlatMesh, rows: NDArray[Any], faces: Faces) -> FlatMesh:
    """Take some rows of a mesh, and faces in terms of them."""
    normals = None if flat.normals is None else flat.normals[rows]
    attributes = [one if one.on_faces else replace(one, values=one.values[rows]) for one in flat.attributes]
    return replace(flat, points=flat.points[rows], normals=normals, attributes=attributes, faces=faces)


def join_flat_meshes(meshes: list[FlatMesh]) -> FlatMesh:
    """Join meshes end to end, for formats of one surface; values are NaN where a mesh has no such attribute.

    Normals are zero in rows without, and None if no row has one.
    """
    starts = np.cumsum([0, *(len(one.points) for one in meshes)])
    first_parts = np.cumsum([0, *(len(one.parts) for one in meshes)])
    normals = None
    if any(one.normals is not None and one.normals.any() for one in meshes):
        normals = np.concatenate([np.zeros_like(one.points) if one.normals is None else one.normals for one in meshes])
    attributes = []
    for name, one in {one.name: one for flat in meshes for one in flat.attributes}.items():
        given = [flat.values(name) for flat in meshes]
        width = max(values.shape[1] for values in given if values is not None)
        blocks = [np.full((len(flat.faces if one.on_faces else flat.points), width), np.nan) for flat in meshes]
        for block, values in zip(blocks, given, strict=True):
            if values is not None:
                block[:, : values.shape[1]] = values
        attributes.append(replace(one, values=np.concatenate(blocks)))
    points = np.concatenate([one.points for one in meshes])
    faces = cast_indices(np.concatenate([one.faces + start for one, start in zip(meshes, starts, strict=False)]))
    part = cast_indices(np.concatenate([one.part + at for one, at in zip(meshes, first_parts, strict=False)]))
    return FlatMesh("", points, normals, attributes, faces, part, [part for one in meshes for part in one.parts])


def has_same_surface(mesh: Mesh, result: SimplifiedMesh, parts: list[int]) -> bool:
    """Tell whether parts have as many faces as before, on the same points, of the same area and outside.

    Then the file is better left as it is stored. Which diagonals cut a flat piece does not matter, but no face may be
    without area.
    """
    if result.changed or any(
        np.count_nonzero(mesh.part_of_face == part) != np.count_nonzero(result.part_of_face == part) for part in parts
    ):
        return False
    chosen = np.isin(result.part_of_face, parts)
    old, new = mesh.faces[np.isin(mesh.part_of_face, parts)], result.faces[chosen]
    if (result.points[new] != mesh.points[result.row[new]]).any():
        return False
    if _count_points(mesh.points, old) != _count_points(result.points, new):
        return False
    # So that no product of coordinates leaves the range of double precision.
    unit = float(np.abs(mesh.points[old]).max()) or 1.0
    before, after = compute_face_normals(mesh.points / unit, old), compute_face_normals(result.points / unit, new)
    areas = np.linalg.norm(before, axis=1)
    sides = (after * compute_face_normals(mesh.points / unit, mesh.faces[result.face[chosen]])).sum(axis=1)
    same = np.isclose(areas.sum(), np.linalg.norm(after, axis=1).sum(), rtol=1e-9, atol=0.0)
    return bool(same and (areas > 0.0).all() and (sides > 0.0).all())


def _count_points(points: Points, faces: Faces) -> int:
    """Count the distinct positions that faces use."""
    return len(find_unique_rows(points[np.unique(faces)])[0])
