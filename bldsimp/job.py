"""One file made light: read, simplified, written, and told."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, TypeAlias

from . import _core
from .io import read, write
from .model import Scene, SimplifiedMesh
from .options import Options
from .report import Report
from .scene import simplify_scene

Work: TypeAlias = Callable[["_core.Progress | None"], tuple[list[SimplifiedMesh], Report]]


@dataclass
class FileResult:
    """What became of a file.

    Attributes
    ----------
    scene : Scene
        As it was read.
    report : Report
    seconds : dict of str to float
        Of ``read``, ``simplify`` and ``write``.
    """

    scene: Scene
    report: Report
    seconds: dict[str, float]


def _unwatched(work: Work, points: int) -> tuple[list[SimplifiedMesh], Report]:
    return work(None)


def simplify_file(
    source: Path | bytes,
    from_: str,
    target: Path | BinaryIO,
    to: str,
    options: Options,
    *,
    overwrite: bool = True,
    watch: Callable[[Work, int], tuple[list[SimplifiedMesh], Report]] = _unwatched,
) -> FileResult:
    """Read a file, simplify it, and write what is left.

    Parameters
    ----------
    source : Path or bytes
    from_ : str
        Format of the source: a suffix without the dot, in lower case.
    target : Path or binary stream
        A file appears whole or not at all; one that exists is replaced.
    to : str
        Format of the target.
    options : Options
    overwrite : bool
        Whether files beside the target that differ may be replaced.
    watch : callable
        Does the work that it is given, which takes a `Progress` or None; how many points there are is its second
        argument.

    Returns
    -------
    FileResult

    Raises
    ------
    InputError
        Where the source is missing, damaged or no surface.
    OutputError
        Where the target cannot be written.
    """
    start = time.perf_counter()
    scene = read(source, from_)
    if to not in ("glb", "gltf"):
        _leave_out_unshown(scene)
    after_read = time.perf_counter()
    points = sum(len(mesh.used_points) for mesh in scene.meshes)
    lights, report = watch(lambda progress: _simplified(scene, options, progress), points)
    after_simplify = time.perf_counter()
    written = write(scene, lights, target, to, options, overwrite=overwrite)
    report.rounding = written.rounding
    report.deviation += written.rounding
    report.after = dataclasses.replace(written.after or report.after, bytes=written.bytes, vertices=written.vertices)
    report.warnings += written.warnings
    end = time.perf_counter()
    report.seconds = end - start
    seconds = {"read": after_read - start, "simplify": after_simplify - after_read, "write": end - after_simplify}
    return FileResult(scene, report, seconds)


def _leave_out_unshown(scene: Scene) -> None:
    """Take meshes away that no node of a scene graph shows, since formats without one have no place for them."""
    shown = [mesh for mesh in scene.meshes if len(mesh.transforms)]
    if len(shown) < len(scene.meshes):
        scene.warnings.append(f"meshes that no node shows are left out: {len(scene.meshes) - len(shown):,}")
        scene.meshes = shown


def _simplified(scene: Scene, options: Options, progress: _core.Progress | None) -> tuple[list[SimplifiedMesh], Report]:
    lights, report = simplify_scene(scene, options, progress)
    if options.baseline:
        from .compare.decimate import count_baseline_points

        report.baseline = count_baseline_points(scene, report.deviation, report.warnings)
    return lights, report
