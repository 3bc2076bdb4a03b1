"""Measure the over-sampled block: points, deviation, time beside manifold3d, peak memory, cost over size.

usage: python benchmarks/block.py [MESH] [--triangles N ...] [--runs R] [--stages]
needs: pip install "bldsimp[bench]"

MESH is a closed model; it is simplified, over-sampled to N triangles, turned about a skew axis and rounded
to single precision. Both programs go from arrays to arrays on the same mesh in the same run, in turns:
bldsimp from welding to the report, manifold3d with its construction from a mesh, `simplify`
and the way back. Times are the least and the median of the runs. Everything is printed as Markdown.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import manifold3d
import numpy as np
from oversample import oversample, simplify_model
from peak_memory import measure_peak
from stages import time_stages
from surface import Surface, is_watertight, measure_deviation, weld_surface
from table import Timing, format_table, time_in_turns

import bldsimp

DATA = Path(__file__).resolve().parents[1] / "data"
SIZES = (10_000, 100_000, 300_000, 1_300_000, 3_000_000)
MANIFOLD_TOLERANCE = 1e-4
MEBIBYTE = 2**20


@dataclass
class Measured:
    """Both programs on one mesh; lengths in model units."""

    before: Surface
    ours: Surface
    theirs: Surface | None
    tolerance: float
    bound: float
    our_time: Timing
    their_time: Timing | None
    memory: int

    @property
    def arrays(self) -> int:
        """Bytes of the mesh's own arrays: float64 points and int64 faces."""
        return int(self.before.points.nbytes + self.before.faces.nbytes)


class Ours:
    """`bldsimp.simplify` with its default tolerance."""

    def __init__(self, mesh: Surface) -> None:
        self.mesh = mesh

    def __call__(self) -> bldsimp.Simplified:
        """From arrays to arrays."""
        return bldsimp.simplify((self.mesh.points, self.mesh.faces))


class Theirs:
    """manifold3d; arrays of the types that it wants are ready before the clock runs."""

    def __init__(self, mesh: Surface) -> None:
        self.points = np.ascontiguousarray(mesh.points, np.float32)
        self.faces = np.ascontiguousarray(mesh.faces, np.uint32)

    def __call__(self) -> manifold3d.Mesh:
        """From arrays to arrays: an empty mesh where it refuses."""
        solid = manifold3d.Manifold(manifold3d.Mesh(self.points, self.faces))
        return solid.simplify(MANIFOLD_TOLERANCE).to_mesh()

    def result(self) -> Surface | None:
        """Its result, or None where it refuses the mesh."""
        mesh = self()
        faces = np.asarray(mesh.tri_verts, np.int64)
        return weld_surface(np.asarray(mesh.vert_properties, np.float64)[:, :3], faces) if len(faces) else None


def measure(mesh: Surface, runs: int) -> Measured:
    """Run both programs on one mesh."""
    ours, theirs = Ours(mesh), Theirs(mesh)
    simplified, their_result = ours(), theirs.result()
    jobs = {"ours": ours} | ({} if their_result is None else {"theirs": theirs})
    timings = time_in_turns(runs, **jobs)
    return Measured(
        before=mesh,
        ours=weld_surface(*simplified.mesh),
        theirs=their_result,
        tolerance=simplified.report.tolerance,
        bound=simplified.report.deviation,
        our_time=timings["ours"],
        their_time=timings.get("theirs"),
        memory=measure_peak(mesh),
    )


def format_figures(all_measured: Sequence[Measured]) -> str:
    """Points, deviation, time and memory over size."""
    ours = ["ours: points", "deviation", "bound", "time", "us/triangle", "memory above arrays"]
    theirs = ["manifold3d: points", "deviation", "time", "ratio"]
    rows = []
    for m in all_measured:
        least = m.our_time.least
        memory = f"{m.memory / MEBIBYTE:.0f} MiB = {m.memory / m.arrays:.1f} x"
        row: list[object] = [
            f"{len(m.before.faces):,}", len(m.before.points), len(m.ours.points), measure_deviation(m.before, m.ours),
            m.bound, m.our_time, least / len(m.before.faces) * 1e6, memory,
        ]  # fmt: skip
        if m.theirs is None or m.their_time is None:
            row += ["refuses", "", "", ""]
        else:
            ratio = m.their_time.least / least
            row += [len(m.theirs.points), measure_deviation(m.before, m.theirs), m.their_time, f"{ratio:.2f} x"]
        rows.append(row)
    return format_table(["triangles", "points", *ours, *theirs], rows)


def fit_growth(all_measured: Sequence[Measured]) -> float:
    """Exponent of time over triangles, by least squares of the logarithms: 1 is linear."""
    size = [math.log(len(m.before.faces)) for m in all_measured]
    cost = [math.log(m.our_time.least) for m in all_measured]
    return float(np.polyfit(size, cost, 1)[0])


def format_stages(meshes: Sequence[Surface], runs: int) -> str:
    """Milliseconds of each stage over size, the least of the runs."""
    columns = []
    for mesh in meshes:
        several = [time_stages(Ours(mesh)) for _ in range(runs)]
        columns.append({stage: min(one[stage] for one in several) * 1e3 for stage in several[0]})
    rows = [[stage, *(f"{column[stage]:.1f}" for column in columns)] for stage in columns[-1]]
    rows.append(["sum", *(f"{sum(column.values()):.1f}" for column in columns)])
    return format_table(["stage, ms", *(f"{len(mesh.faces):,}" for mesh in meshes)], rows)


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", nargs="?", type=Path, default=DATA / "building_a.obj", metavar="MESH")
    parser.add_argument("--triangles", type=int, nargs="+", default=SIZES, metavar="N")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--stages", action="store_true", help="print the time of each stage instead")
    args = parser.parse_args()
    base = simplify_model(args.mesh)
    meshes = [oversample(base, n) for n in args.triangles]
    print(f"{args.mesh.name}: {len(base.points):,} points, watertight: {is_watertight(base.faces)}\n")
    if args.stages:
        print(format_stages(meshes, args.runs))
        return
    measured = [measure(mesh, args.runs) for mesh in meshes]
    print(format_figures(measured))
    if len(measured) > 1:
        print(f"\nTime grows as triangles to the power {fit_growth(measured):.2f}.")


if __name__ == "__main__":
    main()
