"""Read one file, simplify it, write it, and report."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
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
    """The result of a file.

    Attributes
    ----------
    scene : Scene
        As it was read.
    report : Report
    seconds : dict of str to float
        Time for ``read``, ``simplify`` and ``write``.
    """

    scene: Scene
    report: Report
    seconds: dict[str, float]


def simplify_file(
    source: Path | bytes,
    from_: str,
    target: Path | BinaryIO,
    to: str,
    options: Options,
    *,
    overwrite: bool = True,
    watch: Callable[[Work, int], tuple[list[SimplifiedMesh], Report]] | None = None,
) -> FileResult:
    """Read a file, simplify it, and write the result.

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
        Whether files next to the target that differ may be replaced.
    watch : callable, optional
        Runs the work that it gets, which takes a `Progress` or None. Its second argument is the number of points.

    Returns
    -------
    FileResult

    Raises
    ------
    InputError
        Where the source is missing, damaged or not a surface.
    OutputError
        Where the target cannot be written.
    """
    start = time.perf_counter()
    scene = read(source, from_)
    if to not in ("glb", "gltf"):
        _remove_hidden_meshes(scene)
    after_read = time.perf_counter()
    work = partial(_simplify, scene, options)
    results, report = watch(work, sum(len(mesh.used_points) for mesh in scene.meshes)) if watch else work(None)
    after_simplify = time.perf_counter()
    written = write(scene, results, target, to, options, overwrite=overwrite)
    report.rounding = written.rounding
    report.deviation += written.rounding
    report.after = dataclasses.replace(written.after or report.after, bytes=written.bytes, vertices=written.vertices)
    report.warnings += written.warnings
    end = time.perf_counter()
    report.seconds = end - start
    seconds = {"read": after_read - start, "simplify": after_simplify - after_read, "write": end - after_simplify}
    return FileResult(scene, report, seconds)


def _remove_hidden_meshes(scene: Scene) -> None:
    """Remove meshes that no node of a scene graph shows: formats without one have no place for them."""
    shown = [mesh for mesh in scene.meshes if len(mesh.transforms)]
    if len(shown) < len(scene.meshes):
        scene.warnings.append(f"meshes that no node shows are left out: {len(scene.meshes) - len(shown):,}")
        scene.meshes = shown


def _simplify(scene: Scene, options: Options, progress: _core.Progress | None) -> tuple[list[SimplifiedMesh], Report]:
    results, report = simplify_scene(scene, options, progress)
    if options.baseline:
        from .compare.decimate import count_baseline_points

        report.baseline = count_baseline_points(scene, report.deviation, report.warnings)
    return results, report
