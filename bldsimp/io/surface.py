"""From what a polygon file stores to a checked mesh; shared by all formats without a scene graph."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import PurePosixPath

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..model import Attribute, Indices, Mesh, Part, Points, check_finite, check_indices
from ..options import UNKNOWN_TEXELS
from ..tolerance import number_format
from .image_size import image_size
from .polygons import select_polygons, triangulate_polygons


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


@dataclass(frozen=True)
class UvMap:
    """Which UV set a texture reads, and the affine map that leads from it to the texture, v upwards: by rows."""

    set: int = 0
    matrix: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0)


@dataclass(frozen=True)
class Material:
    """The little of a material that every format knows.

    Attributes
    ----------
    name : str
    color : tuple of float or None
        Red, green, blue, alpha in 0..1, linear as glTF has it or as MTL states it.
    texture : str or None
        Path or URI of the colour texture, relative to the file; the number of an image, in glTF.
    others : tuple of (str, str)
        Its other textures, each with the MTL statement that would name it.
    stretch : tuple of float
        How many times a texture is repeated along u and v, at most.
    image : bytes or None
        The colour texture, where no file holds it.
    uv_map : UvMap
        How its textures read UV.
    clamp : bool
        Its colour texture ends where UV leave 0..1.
    numbers : tuple of (str, tuple of float)
        Statements of MTL that glTF has a like of.
    left : tuple of str
        What else it has, which is not here.
    """

    name: str
    color: tuple[float, float, float, float] | None = None
    texture: str | None = None
    others: tuple[tuple[str, str], ...] = ()
    stretch: tuple[float, float] = (1.0, 1.0)
    image: bytes | None = None
    uv_map: UvMap = UvMap()
    clamp: bool = False
    numbers: tuple[tuple[str, tuple[float, ...]], ...] = ()
    left: tuple[str, ...] = ()

    @property
    def textures(self) -> list[str]:
        """All textures by name."""
        return [name for name in (self.texture, *(name for _, name in self.others)) if name]


def material_of(part: Part) -> Material | None:
    """The material of a part of any format."""
    found = getattr(part.source, "material", part.source)
    return found if isinstance(found, Material) else None


def texels(parts: list[Part], beside: Callable[[str], bytes | None]) -> NDArray[np.float64]:
    """Width and height, for each part, of the largest image that its material reads, (p, 2); texels.

    Parameters
    ----------
    parts : list of Part
    beside : function of a relative path
        Gives the bytes of a file next to the model, or None.
    """
    sizes: dict[str, tuple[int, int]] = {}
    found = np.full((len(parts), 2), float(UNKNOWN_TEXELS))
    for row, material in enumerate(map(material_of, parts)):
        if material is None or not material.textures:
            continue
        for name in material.textures:
            if name not in sizes:
                data = material.image if material.image is not None and name == material.texture else beside(name)
                sizes[name] = image_size(data or b"") or (UNKNOWN_TEXELS, UNKNOWN_TEXELS)
        found[row] = np.max([sizes[name] for name in material.textures], axis=0) * material.stretch
    return found


def uv_attribute(values: NDArray[np.float64], parts: list[Part], beside: Callable[[str], bytes | None]) -> Attribute:
    """Texture coordinates of rows, NaN where one has none."""
    return Attribute("TEXCOORD_0", "uv", values, texels(parts, beside))


def file_stem(name: str) -> str:
    """The name of a file without folder and suffix."""
    return PurePosixPath(name.replace("\\", "/")).stem


def polygon_mesh(
    name: str,
    points: Points,
    polygons: Polygons,
    parts: list[Part],
    warnings: list[str],
) -> tuple[Mesh, Indices]:
    """Check polygons, triangulate them, and make a mesh.

    Returns
    -------
    mesh : Mesh
    polygon_of_face : (m,) int32
        The polygon that each face was cut out of.

    Raises
    ------
    InputError
        Where there is no face, an index is out of range, or a point that a face uses is not finite.
    """
    if not len(points):
        raise InputError("no points: the file is empty of geometry")
    check_indices(polygons.corners, len(points))
    polygons, given = _without_slivers(polygons, warnings)
    if len(polygons.offsets) < 2:
        raise InputError(f"{len(points):,} points but no faces: bldsimp simplifies surfaces")
    check_finite(points, polygons.corners)
    faces, polygon_of_face = triangulate_polygons(points, polygons.offsets, polygons.corners)
    mesh = Mesh(name=name, points=points, faces=faces, part_of_face=polygons.part[polygon_of_face], parts=parts)
    mesh.single, mesh.rounding = number_format(mesh.used_points)
    return mesh, given[polygon_of_face]


def _without_slivers(polygons: Polygons, warnings: list[str]) -> tuple[Polygons, Indices]:
    """Polygons without repeated neighbours, and without those of fewer than three distinct corners; which are left."""
    offsets, corners = polygons.offsets, polygons.corners
    sizes = np.diff(offsets)
    if np.all(sizes == 3):
        a, b, c = corners.reshape(-1, 3).T
        good = (a != b) & (b != c) & (a != c)
    else:
        offsets, corners = _without_repeats(offsets, corners)
        good = _distinct_corners(offsets, corners) >= 3
    kept = np.flatnonzero(good)
    if len(kept) < len(good):
        warnings.append(f"{len(good) - len(kept):,} faces with fewer than three distinct corners were left out")
    elif corners is polygons.corners:
        return polygons, kept.astype(np.int32)
    return Polygons(*select_polygons(offsets, corners, kept), polygons.part[kept]), kept.astype(np.int32)


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
