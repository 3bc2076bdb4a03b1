"""Count and time what one `simplify_file` runs: calls of kernels, Python functions, seconds of each stage.

usage: python benchmarks/pipeline.py [MODEL ...] [--tolerance auto|LENGTH|PERCENT% ...] [--runs R]
needs: pip install bldsimp

Each model is read, simplified and written as GLB. Functions are those of the package that run at least once, by their
code objects. Seconds are those of the fastest run; a first run, which loads modules, is not timed. Everything is
printed as Markdown.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import CodeType, FrameType

from stages import count_calls, time_stages
from surface import ROOT
from table import format_table

import bldsimp
from bldsimp.job import simplify_file
from bldsimp.options import parse_tolerance

MODELS = ("building_a.glb", "house_textured.glb")
TOLERANCES = ("auto", "0.1%")

ONCE = {
    "weld": {"weld"},
    "pair halfedges": {"pair halfedges"},
    "assign rows": {"assign rows", "find rows"},
    "find charts": {"find charts"},
}
"""Kernels whose calls show whether work is repeated (meshes times passes), with their names in other versions."""


def find_functions(run: Callable[[], object]) -> set[CodeType]:
    """Collect the code objects of the package's functions that run."""
    package = str(Path(bldsimp.__file__).parent)
    found: set[CodeType] = set()

    def enter(frame: FrameType, event: str, _: object) -> None:
        if event == "call" and frame.f_code.co_filename.startswith(package):
            found.add(frame.f_code)

    threading.setprofile(enter)
    sys.setprofile(enter)
    try:
        run()
    finally:
        sys.setprofile(None)
        threading.setprofile(None)
    return {code for code in found if not code.co_name.startswith("<")}


def measure(model: Path, tolerance: str, runs: int) -> tuple[list[object], dict[str, float]]:
    """Measure one model at one tolerance: a row of figures, and the milliseconds of each stage."""
    with tempfile.TemporaryDirectory() as folder:
        options = bldsimp.Options(parse_tolerance(tolerance))
        format_ = model.suffix.lower().lstrip(".")
        run = partial(simplify_file, model, format_, Path(folder) / "out.glb", "glb", options, overwrite=True)
        meshes = len(run().scene.meshes)
        calls = count_calls(run)
        functions = find_functions(run)
        files = {code.co_filename for code in functions}
        timings = [time_stages(run) for _ in range(runs)]
    fastest = min(timings, key=lambda seconds: sum(seconds.values()))
    once = [sum(calls[name] for name in names) for names in ONCE.values()]
    row = [
        f"{model.stem} {tolerance}", meshes, *once, calls.total(), len(functions), len(files),
        sum(fastest.values()) * 1e3,
    ]  # fmt: skip
    return row, {name: 1e3 * seconds for name, seconds in fastest.items()}


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "models", nargs="*", type=Path, metavar="MODEL", default=[ROOT / "data" / name for name in MODELS]
    )
    parser.add_argument("--tolerance", nargs="+", default=TOLERANCES, metavar="TOLERANCE")
    parser.add_argument("--runs", type=int, default=5)
    args = parser.parse_args()
    cases = [(model, tolerance) for model in args.models for tolerance in args.tolerance]
    rows, columns = zip(*(measure(model, tolerance, args.runs) for model, tolerance in cases), strict=True)
    print(format_table(["model", "meshes", *ONCE, "all kernels", "functions", "files", "ms"], rows))
    stages = dict.fromkeys(name for column in columns for name in column)
    print()
    shown = [[name, *(f"{column[name]:.2f}" if name in column else "" for column in columns)] for name in stages]
    print(format_table(["stage, ms", *(row[0] for row in rows)], shown))


if __name__ == "__main__":
    main()
