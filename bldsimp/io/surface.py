"""From what a polygon file stores to a checked mesh; shared by all formats without a scene graph."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..number_format import number_format
from ..polygons import select_polygons, triangulate_polygons
from ..scene import Mesh, Part, Points, check_finite, check_indices


def shown(name: str) -> str:
    """A name as text that every encoding takes: bytes that were no UTF-8 become question marks."""
    return name.encode("utf-8", "surrogateescape").decode("utf-8", "replace")


@dataclass
class Polygons:
    """Faces as the file has them.

    Attributes
    ----------
    offsets : (k + 1,) int32
        Where each polygon starts in `corners`.
    corners : (c,) int32
        Rows of the mesh's points.
    part : (k,) int32
        Index into the mesh's parts.
    """

    offsets: NDArray[np.int32]
    corners: NDArray[np.int32]
    part: NDArray[np.int32]


@dataclass
class Material:
    """The little of a material that every format knows.

    Attributes
    ----------
    name : str
    color : tuple of float or None
        Red, green, blue, alpha in 0..1, linear as glTF has it or as MTL states it.
    texture : str or None
        Path or URI of the colour texture, relative to the file.
    """

    name: str
    color: tuple[float, float, float, float] | None = None
    texture: str | None = None


@dataclass
class Stored:
    """What a mesh of polygons keeps for the writer (`Mesh.source`).

    Attributes
    ----------
    polygons : Polygons
    carried : dict of str to (n, k) array
        Per row of the points: ``TEXCOORD_0`` (two columns, v upwards), ``COLOR_0`` (three or four, 0..1).
        A row without has NaN.
    format : object
        What only the reader of this format knows.
    """

    polygons: Polygons
    carried: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    format: Any = None


def polygon_mesh(
    name: str,
    points: Points,
    polygons: Polygons,
    parts: list[Part],
    warnings: list[str],
) -> Mesh:
    """Check polygons, triangulate them, and make a mesh.

    Raises
    ------
    InputError
        Where there is no face, an index is out of range, or a point that a face uses is not finite.
    """
    if not len(points):
        raise InputError("no points: the file is empty of geometry")
    check_indices(polygons.corners, len(points))
    polygons = _without_slivers(polygons, warnings)
    if len(polygons.offsets) < 2:
        raise InputError(f"{len(points):,} points but no faces: bldsimp simplifies surfaces")
    check_finite(points, polygons.corners)
    faces, polygon_of_face = triangulate_polygons(points, polygons.offsets, polygons.corners)
    mesh = Mesh(
        name=name,
        points=points,
        faces=faces,
        part_of_face=polygons.part[polygon_of_face],
        parts=parts,
        source=Stored(polygons),
    )
    mesh.single, mesh.rounding = number_format(mesh.used_points)
    return mesh


def _without_slivers(polygons: Polygons, warnings: list[str]) -> Polygons:
    """Polygons without repeated neighbours, and without those of fewer than three distinct corners."""
    offsets, corners = polygons.offsets, polygons.corners
    sizes = np.diff(offsets)
    if not len(sizes):
        return polygons
    if np.all(sizes == 3):
        a, b, c = corners.reshape(-1, 3).T
        good = (a != b) & (b != c) & (a != c)
    else:
        offsets, corners = _without_repeats(offsets, corners)
        good = _distinct_corners(offsets, corners) >= 3
    if not good.all():
        warnings.append(f"{int((~good).sum()):,} faces with fewer than three distinct corners were left out")
    elif corners is polygons.corners:
        return polygons
    kept = np.flatnonzero(good)
    return Polygons(*select_polygons(offsets, corners, kept), polygons.part[kept])


def _without_repeats(
    offsets: NDArray[np.int32], corners: NDArray[np.int32]
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Drop corners that equal the next one of their polygon, round the end too."""
    if not len(corners):
        return offsets, corners
    sizes = np.diff(offsets)
    following = np.arange(1, len(corners) + 1)
    full = sizes > 0
    following[offsets[1:][full] - 1] = offsets[:-1][full]
    keep = corners != corners[following]
    count = np.concatenate([[0], np.cumsum(keep)])
    return count[offsets].astype(np.int32), corners[keep]


def _distinct_corners(offsets: NDArray[np.int32], corners: NDArray[np.int32]) -> NDArray[np.int64]:
    """Number of distinct corners of each polygon."""
    owner = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    order = np.lexsort((corners, owner))
    fresh = np.ones(len(order), bool)
    fresh[1:] = (np.diff(owner[order]) != 0) | (np.diff(corners[order]) != 0)
    return np.bincount(owner[order][fresh], minlength=len(offsets) - 1)
