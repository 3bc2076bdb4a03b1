"""Run every file of a folder: points, status of the facets, deviation beside the bound, what a second run removes.

usage: python benchmarks/models.py [FOLDER] [--tolerance auto|LENGTH|PERCENT% ...] [--delimit WORDS]
needs: pip install "bldsimp[bench]"

FOLDER is BLDSIMP_MODELS where left out. Each file is read, simplified and written in its own format as the
program does it; what was written is read again, measured by an independent library against what was read
first, and simplified once more. Everything is printed as Markdown.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from surface import Surface, find_models, measure_deviation, weld_surface
from table import format_percent, format_share, format_table

import bldsimp
from bldsimp.io import SUFFIXES, read, write
from bldsimp.model import Scene
from bldsimp.options import parse_delimit, parse_tolerance
from bldsimp.scene import simplify_scene
from bldsimp.stages.fallback import Level
from bldsimp.tolerance import transform_points

TOLERANCES = ("auto", "0.0001%")

SECOND_RUN = 0.005
"""A second run may remove this share of the points."""

RUNS = 3


@dataclass
class Run:
    """One file at one tolerance; lengths in model units."""

    first: bldsimp.Report
    second: bldsimp.Report
    found: float
    noise: float
    seconds: float

    @property
    def bound(self) -> float:
        """The promised bound, with the rounding of the file."""
        return self.first.deviation + self.first.rounding

    @property
    def kept(self) -> bool:
        """Whether the judge finds no more than the bound and its own noise."""
        return self.found <= self.bound + 4.0 * self.noise

    @property
    def dropped_again(self) -> int:
        """Points that a second run removes."""
        return self.first.after.points - self.second.after.points


def place_scene(scene: Scene) -> Surface:
    """Join all instances of all meshes of a scene to one surface."""
    points, faces, count = [], [], 0
    for mesh in scene.meshes:
        for transform in mesh.transforms:
            points.append(transform_points(mesh.points, transform))
            faces.append(mesh.faces.astype(np.int64) + count)
            count += len(mesh.points)
    return weld_surface(np.concatenate(points), np.concatenate(faces))


def run_file(path: Path, options: bldsimp.Options, folder: Path) -> Run:
    """Simplify a file, and the result once more.

    Raises
    ------
    BldsimpError
        If the program refuses the file.
    """
    format_ = path.suffix.lower().lstrip(".")
    out = folder / f"simplified.{format_}"
    seconds = []
    for _ in range(RUNS):
        start = time.perf_counter()
        scene = read(path, format_)
        results, first = simplify_scene(scene, options)
        first.rounding = write(scene, results, out, format_, options).rounding
        seconds.append(time.perf_counter() - start)
    again = read(out, format_)
    before = place_scene(scene)
    return Run(
        first=first,
        second=simplify_scene(again, options)[1],
        found=measure_deviation(before, place_scene(again)),
        noise=measure_deviation(before, before),
        seconds=min(seconds),
    )


COUNTS = (
    "model", "points", "left", "triangles", "left", "facets",
    *(level.name.lower().replace("_", " ") for level in Level), "second run removes",
)  # fmt: skip
PROMISES = ("model", "tolerance", "bound", "found", "noise", "promise kept", "edges", "healed", "seconds")


def format_counts(name: str, run: Run) -> list[object]:
    """Write the remaining counts, and the status of the facets."""
    report = run.first
    before, after = report.before, report.after
    shares = [format_share(count, report.facets) for count in report.facet_levels.values()]
    return [
        name, before.points, after.points, before.triangles, after.triangles, report.facets, *shares,
        format_percent(run.dropped_again, report.after.points),
    ]  # fmt: skip


def format_promises(name: str, run: Run) -> list[object]:
    """Write how far the surface moved, and whether it stayed closed."""
    report = run.first
    words = {True: "closed", False: "open"}
    edges = f"{words[report.before.watertight]} -> {words[report.after.watertight]}"
    return [
        name, report.tolerance, run.bound, run.found, run.noise, run.kept, edges,
        report.healed_t_junctions, run.seconds,
    ]  # fmt: skip


def run_folder(folder: Path, options: bldsimp.Options) -> tuple[dict[str, Run], list[str]]:
    """Run all files of a folder that the program reads; return the messages of those that it refuses as well."""
    runs, refused = {}, []
    paths = [path for path in sorted(folder.rglob("*")) if path.suffix.lower().lstrip(".") in SUFFIXES]
    for path in paths:
        with tempfile.TemporaryDirectory() as scratch:
            try:
                runs[str(path.relative_to(folder))] = run_file(path, options, Path(scratch))
            except bldsimp.BldsimpError as error:
                refused.append(str(error).replace(f"{folder}/", ""))
    return runs, refused


def list_misses(runs: dict[str, Run]) -> str:
    """List the models that miss a promise, one line for each promise."""
    missed: dict[str, list[str]] = {
        "found above the bound": [name for name, run in runs.items() if not run.kept],
        "closed before and open after": [
            name for name, run in runs.items() if run.first.before.watertight and not run.first.after.watertight
        ],
        f"second run removes more than {SECOND_RUN:.1%}": [
            name for name, run in runs.items() if run.dropped_again > SECOND_RUN * run.first.after.points
        ],
    }
    return "\n".join(f"- {what}: {', '.join(names) or 'none'}" for what, names in missed.items())


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, metavar="FOLDER")
    parser.add_argument("--tolerance", nargs="+", default=TOLERANCES, metavar="TOLERANCE")
    parser.add_argument("--delimit", default="all", help="what facets may not cross")
    args = parser.parse_args()
    folder = args.folder or find_models()
    for tolerance in args.tolerance:
        options = bldsimp.Options(parse_tolerance(tolerance), delimit=parse_delimit(args.delimit))
        runs, refused = run_folder(folder, options)
        print(f"Tolerance {tolerance}{'' if args.delimit == 'all' else f', facets delimited by {args.delimit}'}:\n")
        print(format_table(COUNTS, [format_counts(name, run) for name, run in runs.items()]) + "\n")
        print(format_table(PROMISES, [format_promises(name, run) for name, run in runs.items()]) + "\n")
        print(list_misses(runs))
        print("".join(f"- refused: {message}\n" for message in refused))


if __name__ == "__main__":
    main()
