"""Check the polygons of a file and triangulate them into a mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..errors import InputError
from ..model import Faces, Indices, Mesh, Part, Points, cast_indices, check_finite, check_indices
from ..tolerance import find_number_format
from ..unique_rows import find_unique_rows


@dataclass
class Polygons:
    """Faces as the file has them.

    Attributes
    ----------
    sizes : (k,) int64
        Number of corners of each polygon.
    corners : (c,) int32
        Rows of the mesh's points, polygon after polygon.
    part : (k,) int32
        Index into the mesh's parts.
    """

    sizes: NDArray[np.int64]
    corners: Indices
    part: Indices

    @property
    def starts(self) -> NDArray[np.int64]:
        """Return where each polygon starts in `corners`, (k,)."""
        starts: NDArray[np.int64] = np.cumsum(self.sizes) - self.sizes
        return starts

    def select(self, chosen: NDArray[np.int64]) -> Polygons:
        """Return the chosen polygons only."""
        sizes = self.sizes[chosen]
        return Polygons(sizes, self.corners[index_slices(self.starts[chosen], sizes)], self.part[chosen])


def index_slices(starts: NDArray[np.int64], sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the indices of several slices of a flat array, one slice after the other.

    Parameters
    ----------
    starts, sizes : (k,) int
        Where each slice starts, and how many values it has.

    Returns
    -------
    (sum of sizes,) int64

    Examples
    --------
    >>> index_slices(np.array([5, 0]), np.array([2, 3])).tolist()
    [5, 6, 0, 1, 2]
    """
    shift: NDArray[np.int64] = np.repeat(starts - (np.cumsum(sizes) - sizes), sizes)
    return shift + np.arange(len(shift))


def build_mesh(
    name: str, points: Points, polygons: Polygons, parts: list[Part], warnings: list[str]
) -> tuple[Mesh, Indices]:
    """Check polygons, triangulate them, and build a mesh.

    Parameters
    ----------
    name : str
    points : (n, 3) float64
    polygons : Polygons
    parts : list of Part
    warnings : list of str
        Receives a message about polygons that were removed.

    Returns
    -------
    mesh : Mesh
    polygon_of_face : (m,) int32
        The polygon that each face was cut from.

    Raises
    ------
    InputError
        If there is no face, an index is out of range, or a point that a face uses is not finite.
    """
    if not len(points):
        raise InputError("no points: the file is empty of geometry")
    check_indices(polygons.corners, len(points))
    polygons, kept = _remove_slivers(polygons, warnings)
    if not len(polygons.sizes):
        raise InputError(f"{len(points):,} points but no faces: bldsimp simplifies surfaces")
    check_finite(points, polygons.corners)
    faces, polygon = _triangulate(points, polygons)
    mesh = Mesh(name=name, points=points, faces=faces, part_of_face=polygons.part[polygon], parts=parts)
    mesh.single, mesh.rounding = find_number_format(mesh.used_points)
    return mesh, kept[polygon]


def _triangulate(points: Points, polygons: Polygons) -> tuple[Faces, Indices]:
    """Cut polygons of three corners or more into faces, in their order; return also the polygon of each face."""
    sizes, corners = polygons.sizes, polygons.corners
    if np.all(sizes == 3):
        return corners.reshape(-1, 3), cast_indices(np.arange(len(sizes)))
    larger, triangles = np.flatnonzero(sizes > 3), np.flatnonzero(sizes == 3)
    rings = polygons.select(larger)
    cut, ring = _core.triangulate_polygons(points, np.append(rings.starts, len(rings.corners)), rings.corners)
    faces = np.concatenate([polygons.select(triangles).corners.reshape(-1, 3), cut])
    owner = np.concatenate([triangles, larger[ring]])
    order = np.argsort(owner, kind="stable")
    return cast_indices(faces[order]), cast_indices(owner[order])


def _remove_slivers(polygons: Polygons, warnings: list[str]) -> tuple[Polygons, Indices]:
    """Remove repeated neighbors, then polygons of fewer than three distinct corners; return also which are kept."""
    if np.all(polygons.sizes == 3):
        a, b, c = polygons.corners.reshape(-1, 3).T
        good = (a != b) & (b != c) & (a != c)
    else:
        polygons = _remove_repeats(polygons)
        owner = np.repeat(np.arange(len(polygons.sizes)), polygons.sizes)
        first, _ = find_unique_rows(np.stack([owner, polygons.corners], axis=1))
        good = np.bincount(owner[first], minlength=len(polygons.sizes)) >= 3
    kept = np.flatnonzero(good)
    if len(kept) < len(good):
        warnings.append(f"removed {len(good) - len(kept):,} faces with fewer than three distinct corners")
        polygons = polygons.select(kept)
    return polygons, cast_indices(kept)


def _remove_repeats(polygons: Polygons) -> Polygons:
    """Remove corners that equal the next one of their polygon; the first follows the last."""
    sizes, corners = polygons.sizes, polygons.corners
    following = np.arange(1, len(corners) + 1)
    full = sizes > 0
    following[(np.cumsum(sizes) - 1)[full]] = polygons.starts[full]
    keep = corners != corners[following]
    owner = np.repeat(np.arange(len(sizes)), sizes)
    return Polygons(np.bincount(owner[keep], minlength=len(sizes)), corners[keep], polygons.part)
