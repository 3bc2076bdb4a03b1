"""A result on its way to a file: rows, faces and parts with all that they carry, in the frame they are written in."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import FACE, Attribute, Faces, Indices, Mesh, Part, Points, SimplifiedMesh
from ..options import Options
from ..stages.normals import resolve_normals
from ..tolerance import transform_points
from .surface import UvMap, material_of


@dataclass
class Sheet:
    """One instance of one mesh; every row is used by a face.

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
    normals: NDArray[np.float64] | None
    attributes: list[Attribute]
    faces: Faces
    part: Indices
    parts: list[Part]

    def triangles(self, part: int) -> Faces:
        """Faces of a part."""
        own: Faces = self.faces[self.part == part]
        return own

    def values(self, name: str) -> NDArray[np.float64] | None:
        """Values of an attribute; None where there is no such one."""
        return next((one.values for one in self.attributes if one.name == name), None)


def sheet(mesh: Mesh, light: SimplifiedMesh, options: Options) -> Sheet:
    """A result in its mesh's own frame."""
    light, normals = resolve_normals(mesh, light, options)
    fixed = mesh.passed_on[light.part_of_face]
    if mesh.normals is not None and normals is None and fixed.any():
        # Parts that are passed on keep their own.
        normals = np.zeros_like(light.points)
        normals[light.faces[fixed]] = mesh.normals[light.row][light.faces[fixed]]
    used = np.zeros(len(light.points), bool)
    used[light.faces] = True
    rows = np.flatnonzero(used)
    compact = np.cumsum(used, dtype=np.int32) - 1
    attributes = []
    for one in mesh.attributes:
        if options.keeps(one.kind):
            values = light.values(one)
            attributes.append(dataclasses.replace(one, values=values if one.on_faces else values[rows]))
    return Sheet(
        name=mesh.name,
        points=light.points[rows],
        normals=None if normals is None else normals[rows],
        attributes=attributes,
        faces=compact[light.faces],
        part=light.part_of_face,
        parts=mesh.parts,
    )


def instance(one: Sheet, transform: NDArray[np.float64]) -> Sheet:
    """A sheet in world space."""
    if np.array_equal(transform, np.eye(4)):
        return one
    a, b, c = transform[:3, :3].T
    cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    mirrored = sum((a * np.cross(b, c)).tolist()) < 0.0
    normals = one.normals
    if normals is not None:
        frame = np.eye(4)
        frame[:3, :3] = -cofactors if mirrored else cofactors
        normals = transform_points(normals, frame)
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0.0)
    faces = one.faces[:, ::-1] if mirrored else one.faces
    return dataclasses.replace(one, points=transform_points(one.points, transform), normals=normals, faces=faces)


def as_shown(one: Sheet) -> Sheet:
    """A sheet whose first UV set is that of colour textures, mapped: other formats have one set, and no map of it."""
    maps = [getattr(material_of(part), "uv_map", UvMap()) for part in one.parts]
    if all(maps[part] == UvMap() for part in np.unique(one.part)):
        return one
    one = _by_corners(one)
    part = np.repeat(one.part, 3)
    uv = np.full((len(one.points), 2), np.nan)
    for number, own in enumerate(maps):
        values = one.values(f"TEXCOORD_{own.set}")
        if values is not None:
            rows = np.flatnonzero(part == number)
            uv[rows] = values[rows] if own.matrix == UvMap().matrix else _mapped(values[rows], own.matrix)
    first = Attribute("TEXCOORD_0", "uv", uv, np.ones((len(one.parts), 2)))
    return dataclasses.replace(one, attributes=[first, *(a for a in one.attributes if a.name != "TEXCOORD_0")])


def _mapped(uv: NDArray[np.float64], matrix: tuple[float, ...]) -> NDArray[np.float64]:
    """UV moved by a 2 x 3 matrix, summed in a fixed order so that no library's blocking shows."""
    u, v = uv.T
    a, b, c, d, e, f = matrix
    return np.stack([a * u + b * v + c, d * u + e * v + f], axis=1)


def spread(one: Sheet) -> Sheet:
    """A sheet whose faces hand what they carry to their corners, each corner a row."""
    handed = [
        dataclasses.replace(
            own, name=own.name.removeprefix(FACE), values=np.repeat(own.values, 3, axis=0), on_faces=False
        )
        for own in one.attributes
        if own.on_faces
    ]
    if not handed:
        return one
    # Where rows carry the same, faces win, as in most viewers: who gives faces a colour wants it seen.
    gone = {own.name for own in handed}
    one = _by_corners(one)
    rows = [own for own in one.attributes if not own.on_faces and own.name not in gone]
    return dataclasses.replace(one, attributes=rows + handed)


def _by_corners(one: Sheet) -> Sheet:
    """A sheet with a row for each corner of each face."""
    corners = one.faces.reshape(-1)
    return dataclasses.replace(
        one,
        points=one.points[corners],
        normals=None if one.normals is None else one.normals[corners],
        attributes=[
            own if own.on_faces else dataclasses.replace(own, values=own.values[corners]) for own in one.attributes
        ],
        faces=np.arange(len(corners), dtype=np.int32).reshape(-1, 3),
    )
