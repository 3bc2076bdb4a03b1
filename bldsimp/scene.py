"""Simplify every mesh of a scene, and build the report."""

from __future__ import annotations

import dataclasses
import itertools
import time
from collections import Counter
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from . import _core
from .model import Mesh, Scene, SimplifiedMesh
from .options import Options
from .pipeline import simplify_mesh, weld_mesh
from .report import RemovedComponent, RemovedDetail, Report, explain_unchanged
from .result import MeshResult, count_surface
from .stages.fallback import Level
from .stages.removal import DETAIL_KINDS, Dropped, find_small_components
from .stages.weld import WeldedMesh
from .tolerance import measure_blur, measure_diagonal, measure_scale, resolve_tolerance, transform_points


def simplify_scene(
    scene: Scene, options: Options, progress: _core.Progress | None = None
) -> tuple[list[SimplifiedMesh], Report]:
    """Simplify every mesh of a scene.

    Parameters
    ----------
    scene : Scene
    options : Options
    progress : Progress, optional
        See `simplify_mesh`.

    Returns
    -------
    results : list of SimplifiedMesh
        One per mesh.
    report : Report
        Without what writing adds: `rounding`, and `after`'s vertices and bytes.
    """
    results, report = simplify_meshes(scene, options, progress=progress)
    return [result.mesh for result in results], report


def simplify_meshes(
    scene: Scene, options: Options, *, keep_layout: bool = False, progress: _core.Progress | None = None
) -> tuple[list[MeshResult], Report]:
    """Simplify every mesh of a scene, and return the full result of each.

    Parameters
    ----------
    scene : Scene
    options : Options
    keep_layout, progress
        See `simplify_mesh`.

    Returns
    -------
    results : list of MeshResult
        One per mesh.
    report : Report
        As of `simplify_scene`.
    """
    start = time.perf_counter()
    report = Report(
        tolerance=resolve_tolerance(scene, options.tolerance),
        diagonal=measure_diagonal(scene),
        epsilon=measure_blur(scene),
        warnings=list(scene.warnings),
    )
    report.before.bytes = scene.size
    results = []
    for mesh, (welded, chosen, dropped) in zip(scene.meshes, _weld_meshes(scene, options, report), strict=True):
        stretch = measure_scale(mesh) or 1.0
        result = simplify_mesh(
            mesh,
            report.tolerance / stretch,
            _localize(options, mesh),
            welded=chosen,
            keep_layout=keep_layout,
            progress=progress,
        )
        if dropped:
            edges = _core.count_edges(welded.faces, len(welded.points))
            result.before = count_surface(len(welded.points), len(mesh.faces), edges)
            result.dropped = dropped + result.dropped
        results.append(result)
        _add_to_report(report, mesh, result, options, stretch)
        report.unchanged_parts += [explain_unchanged(part) for part in mesh.parts if part.fixed]
    report.before.watertight = all(result.before.watertight for result in results)
    report.after.watertight = all(result.after.watertight for result in results)
    report.seconds = time.perf_counter() - start
    return results, report


def _localize(options: Options, mesh: Mesh) -> Options:
    """Return options whose lengths are those of the mesh's own frame."""
    return dataclasses.replace(options, weld=options.weld / (measure_scale(mesh) or 1.0))


def _weld_meshes(
    scene: Scene, options: Options, report: Report
) -> Iterator[tuple[WeldedMesh, WeldedMesh, list[Dropped]]]:
    """Weld each mesh; yield it whole, without its small components, and those components.

    Warn of components that are as small but stay.
    """
    welded = (weld_mesh(mesh, _localize(options, mesh)) for mesh in scene.meshes)
    if options.min_component == 0.0:
        yield from ((one, one, []) for one in welded)
        return
    every = list(welded)
    small, dropped, staying = find_small_components(scene.meshes, every, options)
    if staying:
        words = "component smaller than {} stays" if staying == 1 else "components smaller than {} stay"
        smaller = words.format(f"{options.min_component:g}")
        report.warnings.append(f"{staying:,} {smaller}, because they belong to unchanged parts")
    for mesh, one, faces, gone in zip(scene.meshes, every, small, dropped, strict=True):
        yield one, _weld_rest(mesh, one, ~faces, options) if gone else one, gone


def _weld_rest(mesh: Mesh, welded: WeldedMesh, chosen: NDArray[np.bool_], options: Options) -> WeldedMesh:
    """Return some faces of a welded mesh; near points are welded anew, since others may have moved them."""
    if welded.moved == 0.0:
        return welded.select_faces(chosen)
    rest = weld_mesh(mesh, _localize(options, mesh), welded.source[chosen])
    return dataclasses.replace(rest, degenerate=welded.degenerate, duplicate=welded.duplicate)


def _add_to_report(report: Report, mesh: Mesh, result: MeshResult, options: Options, stretch: float) -> None:
    """Add one mesh to the report."""
    report.deviation = max(report.deviation, result.deviation * stretch)
    if any(one.kind == "uv" for one in mesh.attributes) and options.keeps("uv"):
        report.texels = max(report.texels or 0.0, result.texels)
    for total, own in ((report.before, result.before), (report.after, result.after)):
        for name in ("points", "triangles", "open_edges", "nonmanifold_edges"):
            setattr(total, name, getattr(total, name) + getattr(own, name))
    report.before.vertices += len(mesh.used_points)
    report.after.vertices += len(np.unique(result.mesh.faces))
    report.facets += len(result.level)
    for level, count in zip(Level, np.bincount(result.level, minlength=len(Level)).tolist(), strict=True):
        name = level.name.lower()
        report.facet_levels[name] = report.facet_levels.get(name, 0) + count
    report.fallback_reasons = dict(Counter(report.fallback_reasons) + Counter(result.reasons))
    for name, count in result.changes.items():
        setattr(report, name, getattr(report, name) + count)
    for one in result.dropped:
        words = mesh.parts[one.part].name, one.triangles, _measure_world_box(one, mesh), one.reason
        if one.reason in DETAIL_KINDS:
            report.removed_details.append(RemovedDetail(*words))
        else:
            report.removed_components.append(RemovedComponent(*words))


def _measure_world_box(dropped: Dropped, mesh: Mesh) -> list[list[float]]:
    """Return the box of what was removed, in world space."""
    corners = np.array(list(itertools.product(*dropped.box.T)))
    world = transform_points(corners, mesh.transforms[0]) if len(mesh.transforms) else corners
    return [world.min(axis=0).tolist(), world.max(axis=0).tolist()]
