"""What users call: a scene, a `trimesh.Trimesh` or plain arrays, made light."""

from __future__ import annotations

import dataclasses
import itertools
import time
from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from .errors import InputError
from .model import MOST_NAMED, Mesh, Part, Points, Scene, SimplifiedMesh, attach_attributes, check_finite
from .options import Options, Tolerance, check_length, parse_tolerance
from .pipeline import counted, simplify_mesh
from .report import DroppedPart, Report, passed_on
from .result import MeshResult
from .stages.assembled import Rung
from .stages.attributes import followed, left
from .stages.removal import Dropped, without_small
from .stages.rings import trace_rings
from .tolerance import blur, diagonal, number_format, resolve_tolerance, scale, transform_points
from .trimesh_adapter import attributes_of, carried_by, corner_values, give, image_of
from .unique_rows import find_unique_rows


@dataclass
class Facet:
    """A maximal connected set of input faces in one plane.

    Attributes
    ----------
    normal : (3,) float64
        Unit normal on the side that the faces face; zero where the facet has no area.
    faces : (k,) int32
        Input faces. Where a wide tolerance parts what was flat, all go with its largest piece.
    rings : list of (n,) int32
        Outline as closed cycles of rows of the result's points, the facet on their left.
    """

    normal: NDArray[np.float64]
    faces: NDArray[np.int32]
    rings: list[NDArray[np.int32]]


@dataclass
class Simplified:
    """A mesh made light.

    Attributes
    ----------
    mesh : same kind as the input
        `trimesh.Trimesh`, with its UV, material, colours and other arrays of vertices and faces, or a tuple of points
        (n, 3) float64 and faces (m, 3) int32.
    report : Report
    """

    mesh: Any
    report: Report
    _outcome: MeshResult

    @cached_property
    def facets(self) -> list[Facet]:
        """Facets that the result still shows, in order of their first face."""
        outcome = self._outcome
        if not len(outcome.triangles):
            return []
        compact = np.unique(outcome.triangles, return_inverse=True)[1]
        triangles = compact.reshape(-1, 3).astype(np.int32)
        order = np.argsort(outcome.facet_of_face, kind="stable")
        start = np.searchsorted(outcome.facet_of_face[order], np.arange(len(outcome.rung)))
        faces = np.split(outcome.source[order], start)[1:]
        order = np.argsort(outcome.facet_of_triangle, kind="stable")
        shown, start = np.unique(outcome.facet_of_triangle[order], return_index=True)
        groups = np.split(triangles[order], start[1:])
        return [
            Facet(outcome.planes[f, :3], np.sort(faces[f]), trace_rings(group))
            for f, group in zip(shown, groups, strict=True)
        ]


def simplify(mesh: Any, tolerance: float | str | Tolerance | None = None) -> Simplified:
    """Make a mesh light: facets keep their corners, and lose every other point.

    Parameters
    ----------
    mesh : trimesh.Trimesh, or (points, faces)
        Points (n, 3), model units; faces (m, 3). Without faces the result is empty.
    tolerance : float, str or Tolerance, optional
        How far any point of the surface may move, model units; as text what the command line takes, such
        as ``"0.1%"`` of the diagonal. Without it, and for ``"auto"``, what the numbers' own rounding blurs;
        0 drops exactly coplanar and collinear points only.

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
    >>> light = simplify((points, [[i, (i + 1) % 8, 8] for i in range(8)]))
    >>> light.report.before.points, light.report.after.points
    (9, 4)
    """
    chosen = _tolerance_of(tolerance)
    # A primitive of trimesh (a box, a sphere) is not made of arrays; the mesh that it stands for is.
    mesh = mesh.to_mesh() if hasattr(mesh, "primitive") and hasattr(mesh, "to_mesh") else mesh
    is_trimesh = hasattr(mesh, "vertices") and hasattr(mesh, "faces")
    scene = _scene_of(*((mesh.vertices, mesh.faces) if is_trimesh else _pair(mesh)))
    if is_trimesh and len(mesh.faces):
        own = scene.meshes[0]
        attach_attributes(own, attributes_of(own, carried_by(mesh), [image_of(mesh)]))
    outcomes, report = simplify_meshes(scene, Options(tolerance=chosen))
    result = _as_trimesh(mesh, scene.meshes[0], outcomes[0]) if is_trimesh else _as_arrays(outcomes[0])
    return Simplified(result, report, outcomes[0])


def _as_arrays(outcome: MeshResult) -> tuple[Points, NDArray[np.int32]]:
    """Points and faces of a result."""
    used, compact = np.unique(outcome.triangles, return_inverse=True)
    return outcome.points[used], compact.reshape(-1, 3).astype(np.int32)


def _as_trimesh(given: Any, mesh: Mesh, outcome: MeshResult) -> Any:
    """A result of the same class as what was given, with its UV, material, colours, other arrays and metadata.

    Points that need several values, as along a seam, are repeated after all others.
    """
    points, faces = _as_arrays(outcome)
    kind = type(given)
    if not mesh.attributes or not len(faces):
        made = kind(vertices=points, faces=faces, process=False)
        give(made, given, mesh, outcome.light, np.empty(0, np.int64))
        return made
    corners = faces.reshape(-1)
    first, inverse = find_unique_rows(np.hstack([corners[:, None], corner_values(mesh, outcome.light)]))
    point = corners[first]
    own = np.unique(point, return_index=True)[1]
    extra = np.setdiff1d(np.arange(len(first)), own)
    order = np.concatenate([own, extra])
    vertex = np.empty(len(order), np.int32)
    vertex[order] = np.arange(len(order))
    made = kind(vertices=points[point[order]], faces=vertex[inverse].reshape(-1, 3), process=False)
    give(made, given, mesh, outcome.light, first[order])
    return made


def simplify_scene(
    scene: Scene, options: Options, progress: _core.Progress | None = None
) -> tuple[list[SimplifiedMesh], Report]:
    """Make every mesh of a scene light.

    Parameters
    ----------
    scene : Scene
    options : Options
    progress : Progress, optional
        See `simplify_mesh`.

    Returns
    -------
    lights : list of SimplifiedMesh
        One per mesh.
    report : Report
        Without what writing adds: `rounding`, and `after`'s vertices and bytes.
    """
    outcomes, report = simplify_meshes(scene, options, progress=progress)
    return [outcome.light for outcome in outcomes], report


def simplify_meshes(
    scene: Scene, options: Options, *, with_layout: bool = False, progress: _core.Progress | None = None
) -> tuple[list[MeshResult], Report]:
    """Make every mesh of a scene light, and tell all that is known of each.

    Parameters
    ----------
    scene : Scene
    options : Options
    with_layout, progress
        See `simplify_mesh`.

    Returns
    -------
    outcomes : list of MeshResult
        One per mesh.
    report : Report
        As of `simplify_scene`.
    """
    start = time.perf_counter()
    report = Report(
        tolerance=resolve_tolerance(scene, options.tolerance),
        diagonal=diagonal(scene),
        epsilon=blur(scene),
        warnings=list(scene.warnings),
    )
    report.before.bytes = scene.size
    outcomes = []
    for mesh, (kept, small) in zip(scene.meshes, _without_small(scene, options, report), strict=True):
        stretch = scale(mesh) or 1.0
        local = dataclasses.replace(options, weld=options.weld / stretch)
        given = mesh if kept is None else left(mesh, kept)
        outcome = simplify_mesh(given, report.tolerance / stretch, local, with_layout=with_layout, progress=progress)
        if kept is not None:
            outcome.light, outcome.source = followed(kept, outcome.light), kept.face[outcome.source]
            outcome.before = counted(mesh, local)
            outcome.dropped = small + outcome.dropped
        outcomes.append(outcome)
        _tell(report, mesh, outcome, options, stretch)
        report.passed_on += [passed_on(part) for part in mesh.parts if part.fixed]
    report.before.watertight = all(outcome.before.watertight for outcome in outcomes)
    report.after.watertight = all(outcome.after.watertight for outcome in outcomes)
    report.seconds = time.perf_counter() - start
    return outcomes, report


def _without_small(scene: Scene, options: Options, report: Report) -> list[tuple[SimplifiedMesh | None, list[Dropped]]]:
    """What is left of meshes without components smaller than `min_part`, and what went.

    Tells of what stays although it is as small.
    """
    if options.min_part == 0.0:
        return [(None, []) for _ in scene.meshes]
    lights, dropped, staying = without_small(scene.meshes, options)
    if staying:
        words = "component smaller than {} stays" if staying == 1 else "components smaller than {} stay"
        smaller = words.format(f"{options.min_part:g}")
        report.warnings.append(f"{staying:,} {smaller}, since parts that are passed on are left alone")
    return list(zip(lights, dropped, strict=True))


def _tell(report: Report, mesh: Mesh, outcome: MeshResult, options: Options, stretch: float) -> None:
    """Add one mesh to the report."""
    report.deviation = max(report.deviation, outcome.deviation * stretch)
    if any(one.kind == "uv" for one in mesh.attributes) and options.keeps("uv"):
        report.texels = max(report.texels or 0.0, outcome.texels)
    for total, own in ((report.before, outcome.before), (report.after, outcome.after)):
        for name in ("points", "triangles", "open_edges", "nonmanifold_edges"):
            setattr(total, name, getattr(total, name) + getattr(own, name))
    report.before.vertices += len(mesh.used_points)
    report.after.vertices += len(np.unique(outcome.light.faces))
    report.facets += len(outcome.rung)
    rungs = np.bincount(outcome.rung, minlength=len(Rung))
    for rung in Rung:
        name = rung.name.lower()
        report.rungs[name] = report.rungs.get(name, 0) + int(rungs[rung])
    report.reasons = dict(Counter(report.reasons) + Counter(outcome.reasons))
    report.healed += outcome.healed
    report.touching += outcome.touching
    report.closed += outcome.closed
    report.dropped += [_in_words(one, mesh) for one in outcome.dropped]
    report.turned += outcome.turned
    report.degenerate += outcome.degenerate
    report.duplicate += outcome.duplicate


def _in_words(dropped: Dropped, mesh: Mesh) -> DroppedPart:
    """What went, by the name of its part and in world space."""
    corners = np.array(list(itertools.product(*dropped.box.T)))
    world = transform_points(corners, mesh.transforms[0]) if len(mesh.transforms) else corners
    box = [world.min(axis=0).tolist(), world.max(axis=0).tolist()]
    return DroppedPart(mesh.parts[dropped.part].name, dropped.triangles, box, dropped.reason)


def _tolerance_of(given: Any) -> Tolerance:
    """A tolerance as users give it."""
    if given is None or isinstance(given, Tolerance):
        return given or Tolerance()
    if isinstance(given, str):
        return parse_tolerance(given)
    check_length("tolerance", given)
    return Tolerance(float(given), "length")


def _pair(mesh: Any) -> tuple[Any, Any]:
    """Points and faces of what is no trimesh."""
    if isinstance(mesh, (tuple, list)) and len(mesh) == 2:
        return mesh[0], mesh[1]
    raise InputError(f"the mesh is of type {type(mesh).__name__}: give a trimesh.Trimesh or (points, faces)")


def _rows(name: str, given: ArrayLike, kinds: str, wanted: str) -> NDArray[Any]:
    """Rows of three numbers of some kinds; none at all have any shape and kind."""
    try:
        rows = np.asarray(given)
    except (TypeError, ValueError):
        raise InputError(f"{name} are no array, their rows differ in length: give {wanted}") from None
    if rows.size == 0 and rows.shape in ((0,), (0, 3)):
        return np.zeros((0, 3), kinds[0])
    if rows.ndim != 2 or rows.shape[1] != 3 or rows.dtype.kind not in kinds:
        raise InputError(f"{name} have shape {rows.shape} and type {rows.dtype}: give {wanted}")
    return rows


def _scene_of(points: ArrayLike, faces: ArrayLike) -> Scene:
    """A scene of one mesh, its arrays checked and cast."""
    own: Points = np.ascontiguousarray(_rows("points", points, "fiu", "(n, 3) real numbers"), np.float64)
    corners = _rows("faces", faces, "iu", "(m, 3) integers")
    if len(corners) and (corners.min() < 0 or corners.max() >= len(own)):
        outside = np.flatnonzero(((corners < 0) | (corners >= len(own))).any(axis=1))
        raise InputError(f"faces {outside[:MOST_NAMED].tolist()} use points that are not there: there are {len(own)}")
    check_finite(own, corners)
    mesh = Mesh(
        name="mesh",
        points=own,
        faces=np.ascontiguousarray(corners, np.int32),
        part_of_face=np.zeros(len(corners), np.int32),
        parts=[Part("mesh")],
    )
    if len(corners):
        mesh.single, mesh.rounding = number_format(mesh.used_points)
    return Scene(path=None, format="arrays", meshes=[mesh], size=own.nbytes + corners.nbytes)
