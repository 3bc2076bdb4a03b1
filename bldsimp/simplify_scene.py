"""From a scene to what is left of it, and the report of how."""

from __future__ import annotations

import time

from .inspect import counts_of
from .ladder import Rung
from .options import Options
from .report import PassedOn, Report
from .scene import Light, Mesh, Scene
from .simplify import Outcome, simplify_mesh
from .tolerance import diagonal, resolve_tolerance, rounding_spacing, scale

RUNG_NAMES = {
    Rung.SIMPLIFIED: "simplified",
    Rung.POINTS_PUT_BACK: "points put back",
    Rung.OUTLINE_PUT_BACK: "outline put back",
    Rung.FACES_KEPT: "faces kept",
    Rung.PASSED_ON: "passed on",
}


def simplify_scene(scene: Scene, options: Options) -> tuple[list[Light], Report]:
    """Make every mesh of a scene light.

    Parameters
    ----------
    scene : Scene
    options : Options

    Returns
    -------
    lights : list of Light
        One per mesh.
    report : Report
        Without what writing adds: `rounding`, and `after`'s vertices and bytes.
    """
    start = time.perf_counter()
    report = Report(
        tolerance=resolve_tolerance(scene, options.tolerance),
        diagonal=diagonal(scene),
        epsilon=max((rounding_spacing(mesh) * scale(mesh) for mesh in scene.meshes), default=0.0),
        before=counts_of(scene),
        rungs=dict.fromkeys(RUNG_NAMES.values(), 0),
        warnings=list(scene.warnings),
    )
    report.before.bytes = scene.size
    lights = []
    degenerate = duplicate = 0
    for mesh in scene.meshes:
        outcome = _simplify(mesh, report.tolerance, options)
        _add(report, outcome, scale(mesh))
        degenerate += outcome.degenerate
        duplicate += outcome.duplicate
        lights.append(outcome.light)
    report.after = counts_of(scene, [light.faces for light in lights])
    if degenerate or duplicate:
        report.warnings.append(
            f"left out: {degenerate:,} faces that repeat a point, {duplicate:,} copies of other faces"
        )
    report.passed_on = [
        PassedOn(part.name, "carries " + ", ".join(part.attributes))
        for mesh in scene.meshes
        for part in mesh.parts
        if part.passed_on(options)
    ]
    report.seconds = time.perf_counter() - start
    return lights, report


def _simplify(mesh: Mesh, tolerance: float, options: Options) -> Outcome:
    """One mesh, with lengths in its own frame."""
    stretch = scale(mesh)
    local = tolerance / stretch if stretch > 0.0 else 0.0
    weld = options.weld / stretch if stretch > 0.0 else 0.0
    return simplify_mesh(mesh, local, weld=weld, drop_attributes=options.drop_attributes)


def _add(report: Report, outcome: Outcome, stretch: float) -> None:
    """Add one mesh's outcome to the report."""
    report.deviation = max(report.deviation, outcome.deviation * stretch)
    report.facets += len(outcome.rung)
    for rung, name in RUNG_NAMES.items():
        report.rungs[name] += int((outcome.rung == rung).sum())
    for reason, count in outcome.reasons.items():
        report.reasons[reason] = report.reasons.get(reason, 0) + count
    report.healed += outcome.healed
    report.turned += outcome.turned
