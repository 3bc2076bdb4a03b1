"""Measure what the certificate of wide tolerances costs: processor time of whole runs, and cells of fixed pairs.

usage: python benchmarks/certificate.py [--runs R]
needs: pip install bldsimp; third-party models and small cases beside them, where they are: other rows are left out

Runs are in one process, without the first, which loads modules: reading, simplifying and writing one
file, or `simplify` of a mesh made here. Seconds are processor time of the fastest run. Cells are those that certify the
distance of an original and of a result made once, both ways, at a precision of a tenth of each tolerance: they do not
grow as the tolerance shrinks. Everything is printed as Markdown.
"""

from __future__ import annotations

import argparse
import math
import os
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from surface import ROOT, Surface, read_surface
from table import format_table

import bldsimp
from bldsimp import _core
from bldsimp.job import simplify_file
from bldsimp.options import parse_tolerance

MODELS = Path(os.environ.get("BLDSIMP_MODELS") or ROOT.parent / "shared" / "models")
CASES = MODELS.parent / "cases"

FILES = (
    (CASES / "mm_house.obj", ("0.001",), 0.02),
    (CASES / "slow_box.obj", ("0.0012%",), 0.02),
    (MODELS / "city" / "derived_val3dity_fzk_haus.obj", ("0.001%", "0.005%", "0.02%", "0.1%"), 0.1),
)
"""Files, their tolerances, and the most processor seconds of a run."""

SLABS, SLAB_RELATIVE, SLAB_SECONDS = (80, 200, 400), (1.01e-5, 1e-4), 0.2
"""Segments of the curved slabs; their tolerances, as shares of the diagonal. Up to 1e-5 nothing is collapsed."""

SCAN, SCAN_TOLERANCE = MODELS / "noisy" / "easy3d_building.off", "2%"
"""A scan whose result, of few long faces, is simplified once more."""

SCAN_RELATIVE, SCAN_SECONDS = (1.01e-5, 1e-4, 1e-3, 1e-2), 0.05

RELATIVE = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
"""Tolerances at which the cells of fixed pairs are counted, as shares of the diagonal."""


@dataclass(frozen=True)
class Row:
    """One row of the table of runs; seconds of processor time."""

    name: str
    tolerance: str
    before: int
    after: int
    bound: float
    seconds: float
    most: float

    def format(self) -> list[object]:
        """Return the cells of the table."""
        verdict = "PASS" if self.seconds <= self.most else "FAIL"
        bound, seconds = f"{self.bound:.3g}", f"{1e3 * self.seconds:.1f}"
        return [self.name, self.tolerance, self.before, self.after, bound, seconds, f"{verdict} ({1e3 * self.most:g})"]


def make_slab(segments: int) -> Surface:
    """Make a closed slab, bent by a quarter: each of its long sides has so many segments."""
    angle = np.linspace(0.0, np.pi / 2, segments + 1)
    arc = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rings = [np.column_stack([radius * arc, np.full(segments + 1, z)]) for radius in (9.7, 10.0) for z in (0.0, 3.0)]
    low, high = np.arange(segments), np.arange(1, segments + 1)
    size = segments + 1
    faces = []
    for a, b in ((0, 1), (1, 3), (3, 2), (2, 0)):
        faces += [np.stack([a * size + low, a * size + high, b * size + high], axis=1)]
        faces += [np.stack([a * size + low, b * size + high, b * size + low], axis=1)]
    for at, turn in ((0, 1), (segments, -1)):
        corners = np.array([0, 1, 3, 2])[::turn] * size + at
        faces += [corners[None, [0, 1, 2]], corners[None, [0, 2, 3]]]
    return Surface(np.concatenate(rings), np.concatenate(faces))


def find_fastest(run: Callable[[], bldsimp.Report], runs: int) -> tuple[bldsimp.Report, float]:
    """Return what a run reports, and the processor seconds of the fastest."""
    report, fastest = run(), math.inf
    for _ in range(runs):
        start = time.process_time()
        run()
        fastest = min(fastest, time.process_time() - start)
    return report, fastest


def measure(name: str, tolerance: str, run: Callable[[], bldsimp.Report], runs: int, most: float) -> Row:
    """Measure one row."""
    report, seconds = find_fastest(run, runs)
    return Row(name, tolerance, report.before.points, report.after.points, report.deviation, seconds, most)


def measure_files(runs: int) -> Iterator[Row]:
    """Measure the files that are there."""
    for path, tolerances, most in FILES:
        for tolerance in tolerances if path.exists() else ():
            with tempfile.TemporaryDirectory() as folder:
                options, suffix = bldsimp.Options(parse_tolerance(tolerance)), path.suffix[1:]
                out = Path(folder, path.name)

                def run(
                    path: Path = path, suffix: str = suffix, out: Path = out, options: bldsimp.Options = options
                ) -> bldsimp.Report:
                    return simplify_file(path, suffix, out, suffix, options, overwrite=True).report

                yield measure(path.stem, tolerance, run, runs, most)


def measure_surface(name: str, surface: Surface, relative: float, runs: int, most: float) -> Row:
    """Measure a mesh in memory at a share of its diagonal."""
    mesh = (surface.points, surface.faces)

    def run() -> bldsimp.Report:
        return bldsimp.simplify(mesh, tolerance=relative * surface.diagonal).report

    return measure(name, f"{relative:g} d", run, runs, most)


def simplify_surface(surface: Surface, relative: float) -> Surface:
    """Simplify a mesh at a share of its diagonal."""
    points, faces = bldsimp.simplify((surface.points, surface.faces), tolerance=relative * surface.diagonal).mesh
    return Surface(np.asarray(points, np.float64), np.asarray(faces, np.int64))


def count_cells(before: Surface, after: Surface, relative: float) -> tuple[float, int]:
    """Certify the distance of two surfaces, both ways; return it and how many cells that took."""
    origin, precision = before.points.mean(axis=0), 0.1 * relative * before.diagonal
    distance, cells = 0.0, 0
    for one, other in ((before, after), (after, before)):
        tree = _core.FaceTree(other.points - origin, other.faces.astype(np.int32))
        found = tree.bound(one.points - origin, one.faces.astype(np.int32), precision)
        distance, cells = max(distance, found.distance), cells + found.cells
    return distance, cells


def list_pairs() -> Iterator[tuple[str, Surface, Surface]]:
    """Yield the name of each fixed pair, its original and its result."""
    slab = make_slab(400)
    yield "slab of 400 segments at 1e-3", slab, simplify_surface(slab, 1e-3)
    for path, relative in ((FILES[0][0], 1e-3), (FILES[2][0], 1e-3), (SCAN, 1e-2)):
        if path.exists():
            surface = read_surface(path)
            yield f"{path.stem} at {relative:g}", surface, simplify_surface(surface, relative)


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=5)
    runs = parser.parse_args().runs
    rows = list(measure_files(runs))
    for segments in SLABS:
        slab = make_slab(segments)
        rows += [measure_surface(f"slab, {segments}", slab, each, runs, SLAB_SECONDS) for each in SLAB_RELATIVE]
    if SCAN.exists():
        result = simplify_surface(read_surface(SCAN), float(SCAN_TOLERANCE.rstrip("%")) / 100)
        name = f"{SCAN.stem}, {len(result.faces)} triangles"
        rows += [measure_surface(name, result, relative, runs, SCAN_SECONDS) for relative in SCAN_RELATIVE]
    header = ["model", "tolerance", "points", "after", "bound", "processor ms", "few enough"]
    print(format_table(header, [row.format() for row in rows]))
    print("\nCells that certify a fixed pair, by tolerance as a share of the diagonal `d`:\n")
    header = ["pair", "faces before", "after", "bound", *(f"{relative:g}" for relative in RELATIVE)]
    table: list[list[object]] = []
    for name, before, after in list_pairs():
        found = [count_cells(before, after, relative) for relative in RELATIVE]
        cells = (count for _, count in found)
        table.append([name, len(before.faces), len(after.faces), f"{found[-1][0]:.3g}", *cells])
    print(format_table(header, table))


if __name__ == "__main__":
    main()
