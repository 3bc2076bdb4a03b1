"""The whole path from a scene to what is left of it."""

from __future__ import annotations

import time

from .inspect import counts_of
from .options import Options
from .report import PassedOn, Report
from .scene import Light, Scene
from .tolerance import diagonal, epsilon, resolve_tolerance


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
    lights = [Light(mesh.faces, mesh.part_of_face) for mesh in scene.meshes]
    report = Report(
        tolerance=resolve_tolerance(scene, options.tolerance),
        diagonal=diagonal(scene),
        epsilon=epsilon(scene),
        before=counts_of(scene),
        after=counts_of(scene, [light.faces for light in lights]),
        warnings=list(scene.warnings),
    )
    report.before.bytes = scene.size
    for mesh in scene.meshes:
        for part in mesh.parts:
            if part.passed_on(options):
                names = ", ".join(part.attributes)
                report.passed_on.append(PassedOn(part.name, f"carries {names}"))
    report.seconds = time.perf_counter() - start
    return lights, report
