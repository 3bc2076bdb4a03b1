"""Simplify a `trimesh.Trimesh` or plain arrays: the public interface."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InputError
from .model import MOST_NAMED, Faces, Mesh, Part, Points, Scene, attach_attributes, cast_indices, check_finite
from .options import Options, Tolerance, check_length, parse_tolerance
from .report import Report
from .result import MeshResult
from .scene import simplify_meshes
from .stages.outlines import trace_rings
from .tolerance import find_number_format
from .trimesh_adapter import build_attributes, collect_columns, find_image, gather_corner_values, restore_attributes
from .unique_rows import find_unique_rows


@dataclass
class Facet:
    """A maximal connected set of input faces in one plane.

    Attributes
    ----------
    normal : (3,) float64
        Unit normal on the side that the faces face; zero where the facet has no area.
    faces : (k,) int32
        Input faces. Where a wide tolerance splits a facet, the largest remaining facet lists all of them.
    rings : list of (n,) int32
        Outline as closed cycles of rows of the result's points, the facet on their left.
    """

    normal: NDArray[np.float64]
    faces: NDArray[np.int32]
    rings: list[NDArray[np.int32]]


@dataclass
class Simplified:
    """A simplified mesh.

    Attributes
    ----------
    mesh : same kind as the input
        `trimesh.Trimesh`, with its UV, material, colors and other arrays of vertices and faces, or a tuple of points
        (n, 3) float64 and faces (m, 3) int32.
    report : Report

    Examples
    --------
    >>> import trimesh
    >>> result = simplify(trimesh.creation.box().subdivide())
    >>> type(result.mesh).__name__, len(result.mesh.vertices), len(result.facets)
    ('Trimesh', 8, 6)
    """

    mesh: Any
    report: Report
    _result: MeshResult

    @cached_property
    def facets(self) -> list[Facet]:
        """Facets that the result still shows, in order of their first face."""
        result = self._result
        if not len(result.triangles):
            return []
        compact = np.unique(result.triangles, return_inverse=True)[1]
        triangles = cast_indices(compact.reshape(-1, 3))
        order = np.argsort(result.facet_of_face, kind="stable")
        start = np.searchsorted(result.facet_of_face[order], np.arange(len(result.level)))
        faces = np.split(result.source[order], start)[1:]
        order = np.argsort(result.facet_of_triangle, kind="stable")
        shown, start = np.unique(result.facet_of_triangle[order], return_index=True)
        groups = np.split(triangles[order], start[1:])
        return [
            Facet(result.planes[f, :3], np.sort(faces[f]), trace_rings(group))
            for f, group in zip(shown, groups, strict=True)
        ]


def simplify(mesh: Any, tolerance: float | str | Tolerance | None = None) -> Simplified:
    """Simplify a mesh: merge its coplanar faces, and keep only the points that their outlines need.

    Parameters
    ----------
    mesh : trimesh.Trimesh, or (points, faces)
        Points (n, 3), model units; faces (m, 3). Without faces the result is empty.
    tolerance : float, str or Tolerance, optional
        How far any point of the surface may move, model units; as text what the command line takes, such
        as ``"0.1%"`` of the diagonal. The default, ``"auto"``, is the precision of the coordinates themselves;
        0 removes only what is exactly coplanar or collinear.

    Returns
    -------
    Simplified

    Raises
    ------
    InputError
        Where `mesh` is something else, arrays have the wrong shape or type, or a face uses a point that is
        not there or not finite.
    UsageError
        Where the tolerance is none of these, or not a finite number from 0 on.

    Notes
    -----
    Nearly linear in the number of faces. The result does not depend on the order of points or faces.

    References
    ----------
    "Morphological recognition optimization of 3D building simplification by Delaunay algorithm",
    section on the simplification model.

    Examples
    --------
    A square of eight triangles round a needless point in the middle:

    >>> points = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0], [2, 2, 0], [1, 2, 0], [0, 2, 0], [0, 1, 0], [1, 1, 0]]
    >>> result = simplify((points, [[i, (i + 1) % 8, 8] for i in range(8)]))
    >>> result.report.before.points, result.report.after.points
    (9, 4)
    """
    chosen = _read_tolerance(tolerance)
    # A primitive of trimesh (a box, a sphere) is not made of arrays; the mesh that it stands for is.
    mesh = mesh.to_mesh() if hasattr(mesh, "primitive") and hasattr(mesh, "to_mesh") else mesh
    is_trimesh = hasattr(mesh, "vertices") and hasattr(mesh, "faces")
    scene = _make_scene(*((mesh.vertices, mesh.faces) if is_trimesh else _split_pair(mesh)))
    if is_trimesh and len(mesh.faces):
        own = scene.meshes[0]
        attach_attributes(own, build_attributes(own, collect_columns(mesh), [find_image(mesh)]))
    results, report = simplify_meshes(scene, Options(tolerance=chosen))
    result = _to_trimesh(mesh, scene.meshes[0], results[0]) if is_trimesh else _to_arrays(results[0])
    return Simplified(result, report, results[0])


def _to_arrays(result: MeshResult) -> tuple[Points, Faces]:
    """Return the points and faces of a result."""
    used, compact = np.unique(result.triangles, return_inverse=True)
    return result.points[used], cast_indices(compact.reshape(-1, 3))


def _to_trimesh(given: Any, mesh: Mesh, result: MeshResult) -> Any:
    """Make a result of the same class as what was given, with its UV, material, colors, other arrays and metadata.

    Points that need several values, as along a seam, are repeated after all others.
    """
    points, faces = _to_arrays(result)
    kind = type(given)
    if not mesh.attributes or not len(faces):
        made = kind(vertices=points, faces=faces, process=False)
        restore_attributes(made, given, mesh, result.mesh, np.empty(0, np.int64))
        return made
    corners = faces.reshape(-1)
    first, inverse = find_unique_rows(np.hstack([corners[:, None], gather_corner_values(mesh, result.mesh)]))
    point = corners[first]
    own = np.unique(point, return_index=True)[1]
    extra = np.setdiff1d(np.arange(len(first)), own)
    order = np.concatenate([own, extra])
    vertex = np.empty(len(order), np.int32)
    vertex[order] = np.arange(len(order))
    made = kind(vertices=points[point[order]], faces=vertex[inverse].reshape(-1, 3), process=False)
    restore_attributes(made, given, mesh, result.mesh, first[order])
    return made


def _read_tolerance(given: Any) -> Tolerance:
    """Read a tolerance as users give it."""
    if given is None or isinstance(given, Tolerance):
        return given or Tolerance()
    if isinstance(given, str):
        return parse_tolerance(given)
    check_length("tolerance", given)
    return Tolerance(float(given), "length")


def _split_pair(mesh: Any) -> tuple[Any, Any]:
    """Split what is no trimesh into points and faces."""
    if isinstance(mesh, (tuple, list)) and len(mesh) == 2:
        return mesh[0], mesh[1]
    raise InputError(f"the mesh is of type {type(mesh).__name__}: give a trimesh.Trimesh or (points, faces)")


def _check_rows(name: str, given: ArrayLike, kinds: str, wanted: str) -> NDArray[Any]:
    """Check rows of three numbers of some kinds; none at all have any shape and kind."""
    try:
        rows = np.asarray(given)
    except (TypeError, ValueError):
        raise InputError(f"{name} are no array, their rows differ in length: give {wanted}") from None
    if rows.size == 0 and rows.shape in ((0,), (0, 3)):
        return np.zeros((0, 3), kinds[0])
    if rows.ndim != 2 or rows.shape[1] != 3 or rows.dtype.kind not in kinds:
        raise InputError(f"{name} have shape {rows.shape} and type {rows.dtype}: give {wanted}")
    return rows


def _make_scene(points: ArrayLike, faces: ArrayLike) -> Scene:
    """Make a scene of one mesh, its arrays checked and cast."""
    own: Points = np.ascontiguousarray(_check_rows("points", points, "fiu", "(n, 3) real numbers"), np.float64)
    corners = _check_rows("faces", faces, "iu", "(m, 3) integers")
    if len(corners) and (corners.min() < 0 or corners.max() >= len(own)):
        outside = np.flatnonzero(((corners < 0) | (corners >= len(own))).any(axis=1))
        raise InputError(f"faces {outside[:MOST_NAMED].tolist()} use points that are not there: there are {len(own)}")
    check_finite(own, corners)
    mesh = Mesh("mesh", own, cast_indices(corners), np.zeros(len(corners), np.int32), [Part("mesh")])
    if len(corners):
        mesh.single, mesh.rounding = find_number_format(mesh.used_points)
    return Scene(path=None, format="arrays", meshes=[mesh], size=own.nbytes + corners.nbytes)
