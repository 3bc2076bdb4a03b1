"""A result on its way to a file: rows, polygons and parts, in the frame they are written in."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..normals import shading
from ..options import Options
from ..polygons import select_polygons
from ..scene import Faces, Light, Mesh, Part, Points
from ..tolerance import placed
from .surface import Polygons, Stored


@dataclass
class Sheet:
    """One instance of one mesh; every row is used by a polygon.

    Attributes
    ----------
    name : str
    points : (n, 3) float64
    normals : (n, 3) float64 or None
        Zero in rows without.
    carried : dict of str to (n, k) float64
        Of the parts that are passed on, NaN elsewhere; see `Stored.carried`. Never all NaN.
    polygons : Polygons
    parts : list of Part
    kept : (p,) bool
        Which parts are passed on with what they carry.
    """

    name: str
    points: Points
    normals: NDArray[np.float64] | None
    carried: dict[str, NDArray[np.float64]]
    polygons: Polygons
    parts: list[Part]
    kept: NDArray[np.bool_]

    @property
    def faces(self) -> Faces:
        """Rows of each polygon, where every polygon is a triangle."""
        faces: Faces = self.polygons.corners.reshape(-1, 3)
        return faces

    def triangles(self, part: int) -> Faces:
        """Faces of a part, where every polygon is a triangle."""
        own: Faces = self.faces[self.polygons.part == part]
        return own


def sheet(mesh: Mesh, light: Light, options: Options, *, polygonal: bool) -> Sheet:
    """A result in its mesh's own frame.

    Parameters
    ----------
    mesh : Mesh
    light : Light
    options : Options
    polygonal : bool
        Parts that are passed on keep their polygons; else all are triangles.
    """
    kept = np.array([bool(part.fixed) for part in mesh.parts])
    normals = shading(mesh, light, options)
    if mesh.normals is not None and kept.any():
        normals = _with_kept(mesh, light, kept, normals)
    polygons = Polygons(
        np.arange(0, light.faces.size + 1, 3, dtype=np.int32), light.faces.reshape(-1), light.part_of_face
    )
    if polygonal and kept.any() and isinstance(mesh.source, Stored):
        polygons = _joined(
            _chosen(polygons, ~kept[polygons.part]),
            _chosen(mesh.source.polygons, kept[mesh.source.polygons.part]),
        )
    used = np.zeros(len(mesh.points), bool)
    used[polygons.corners] = True
    rows = np.flatnonzero(used)
    compact = np.cumsum(used, dtype=np.int32) - 1
    polygons.corners = compact[polygons.corners]
    return Sheet(
        name=mesh.name,
        points=light.points[rows],
        normals=None if normals is None else normals[rows],
        carried=_kept_values(mesh, polygons, kept, rows),
        polygons=polygons,
        parts=mesh.parts,
        kept=kept,
    )


def instance(one: Sheet, transform: NDArray[np.float64]) -> Sheet:
    """A sheet in world space."""
    if np.array_equal(transform, np.eye(4)):
        return one
    a, b, c = transform[:3, :3].T
    cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    mirrored = float(np.dot(a, np.cross(b, c))) < 0.0
    normals = one.normals
    if normals is not None:
        frame = np.eye(4)
        frame[:3, :3] = -cofactors if mirrored else cofactors
        normals = placed(normals, frame)
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0.0)
    polygons = _turned(one.polygons) if mirrored else one.polygons
    return Sheet(one.name, placed(one.points, transform), normals, one.carried, polygons, one.parts, one.kept)


def _kept_values(
    mesh: Mesh, polygons: Polygons, kept: NDArray[np.bool_], rows: NDArray[np.int64]
) -> dict[str, NDArray[np.float64]]:
    """What rows of the parts that are passed on carry."""
    carried: dict[str, NDArray[np.float64]] = {}
    if not kept.any():
        return carried
    inside = np.zeros(len(rows), bool)
    inside[polygons.corners[np.repeat(kept[polygons.part], np.diff(polygons.offsets))]] = True
    for name, values in mesh.source.carried.items():
        taken = np.where(inside[:, None], values[rows], np.nan)
        if not np.isnan(taken).all():
            carried[name] = taken
    return carried


def _with_kept(
    mesh: Mesh, light: Light, kept: NDArray[np.bool_], normals: NDArray[np.float64] | None
) -> NDArray[np.float64]:
    """Normals of the parts passed on, which keep their own, among the others'."""
    assert mesh.normals is not None
    joined = np.zeros_like(mesh.points) if normals is None else normals.copy()
    rows = np.unique(light.faces[kept[light.part_of_face]])
    joined[rows] = mesh.normals[rows]
    return joined


def _chosen(polygons: Polygons, mask: NDArray[np.bool_]) -> Polygons:
    chosen = np.flatnonzero(mask)
    return Polygons(*select_polygons(polygons.offsets, polygons.corners, chosen), polygons.part[chosen])


def _joined(a: Polygons, b: Polygons) -> Polygons:
    return Polygons(
        np.concatenate([a.offsets, b.offsets[1:] + a.offsets[-1]]),
        np.concatenate([a.corners, b.corners]),
        np.concatenate([a.part, b.part]),
    )


def _turned(polygons: Polygons) -> Polygons:
    """Polygons wound the other way."""
    sizes = np.diff(polygons.offsets)
    ends = np.repeat(polygons.offsets[1:], sizes) - 1
    within = np.arange(len(polygons.corners)) - np.repeat(polygons.offsets[:-1], sizes)
    return Polygons(polygons.offsets, polygons.corners[ends - within], polygons.part)
