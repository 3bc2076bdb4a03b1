"""Time the whole program in a fresh process, beside one that only imports trimesh, loads the file and exports it.

usage: python benchmarks/startup.py [MESH] [--triangles N] [--runs R]
needs: pip install bldsimp

MESH is simplified first and then over-sampled to N triangles; both programs read the same file and write the
same format. They run in turns; the ratio is that of the medians. Everything is printed as Markdown.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from oversample import oversample, simplify_model
from surface import ROOT, Surface
from table import format_table, time_in_turns

LIMIT = 1.5
"""The program may take this many times as long as trimesh alone."""

FORMATS = (("ply", "ply"), ("obj", "glb"), ("glb", "glb"))

# The same as the installed `bldsimp`, with the interpreter that runs this file.
OURS = "import sys; from bldsimp.cli import main; sys.exit(main())"

# Without `process` trimesh welds nothing, which is the least that it can do.
THEIRS = "import sys, trimesh; trimesh.load(sys.argv[1], process=False).export(sys.argv[2])"


def run_ours(source: Path, target: Path) -> None:
    """Run `bldsimp simplify` as a whole process."""
    _run([sys.executable, "-c", OURS, "simplify", str(source), str(target), "--overwrite"])


def run_theirs(source: Path, target: Path) -> None:
    """Load and export with trimesh as a whole process."""
    _run([sys.executable, "-c", THEIRS, str(source), str(target)])


def _run(command: Sequence[str]) -> None:
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def measure_figures(mesh: Surface, runs: int) -> str:
    """Measure the times of both programs for each pair of formats."""
    import trimesh

    rows = []
    with tempfile.TemporaryDirectory() as scratch:
        for read, written in FORMATS:
            source, target = Path(scratch) / f"fine.{read}", Path(scratch) / f"simplified.{written}"
            trimesh.Trimesh(mesh.points, mesh.faces, process=False).export(source)
            jobs = {"ours": partial(run_ours, source, target), "theirs": partial(run_theirs, source, target)}
            for job in jobs.values():  # once, so that no program pays for a cold disk
                job()
            timings = time_in_turns(runs, **jobs)
            ratio = timings["ours"].median / timings["theirs"].median
            rows.append([
                f"{read.upper()} -> {written.upper()}", len(mesh.faces), timings["ours"], timings["theirs"],
                f"{ratio:.2f} x", ratio <= LIMIT,
            ])  # fmt: skip
    return format_table(["files", "triangles", "bldsimp", "trimesh alone", "ratio", f"at most {LIMIT}"], rows)


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", nargs="?", type=Path, default=ROOT / "data" / "building_a.obj", metavar="MESH")
    parser.add_argument("--triangles", type=int, default=17_000, metavar="N")
    parser.add_argument("--runs", type=int, default=5)
    args = parser.parse_args()
    print(measure_figures(oversample(simplify_model(args.mesh), args.triangles), args.runs))


if __name__ == "__main__":
    main()
