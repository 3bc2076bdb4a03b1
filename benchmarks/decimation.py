"""Compare the points that fast-simplification keeps within a tolerance with recorded figures of the same protocol.

usage: python benchmarks/decimation.py [CSV]
needs: pip install bldsimp

CSV has the columns model, tolerance_relative, fast_simplification and fast_simplification_border; its models
are in the folder BLDSIMP_MODELS. The protocol: each mesh welded exactly, faces that repeat a point and copies
of faces, with whichever winding, left out; points in single precision where they are; the target bisected
geometrically between 12 and the number of faces, in 14 steps; a result counts if all points and 20,000 samples
(seed 1) of both surfaces are within the tolerance; the last that counts is the figure. Search and measure are those
of `bldsimp compare`, which does without single precision and works about the model's middle.

The greatest deviation is no smooth function of the target: where the last bits of the input or one sample
change, the bisection may turn the other way and end several percent off.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from surface import find_models, read_surface, weld_surface
from table import format_table

from bldsimp.compare.decimate import Decimator, FastSimplification
from bldsimp.compare.measure import Judge
from bldsimp.compare.placement import PlacedSurface

NEAR = 0.05
"""A figure is reproduced if it is off by no more than this share."""

VARIANTS = {
    "fast_simplification": FastSimplification(),
    "fast_simplification_border": FastSimplification(preserve_border=True),
}


class InSinglePrecision:
    """fast-simplification on single-precision points where the file has them, not about the middle."""

    def __init__(self, variant: FastSimplification, origin: NDArray[np.float64]) -> None:
        self.variant, self.origin = variant, origin

    def __call__(
        self, points: NDArray[np.float64], faces: NDArray[np.int32], target: int
    ) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
        """Return points about the middle, and faces."""
        stored = (points + self.origin).astype(np.float32).astype(np.float64)
        found, cells = self.variant(stored, faces, target)
        return found - self.origin, cells


def build_decimators(path: Path) -> tuple[Judge, dict[str, Decimator]]:
    """Build the judge of a model, and its decimators by column."""
    points, faces = weld_surface(*read_surface(path), one_sided=True)
    judge = Judge(PlacedSurface(np.ascontiguousarray(points), np.ascontiguousarray(faces, np.int32)))
    return judge, {
        column: Decimator(judge, InSinglePrecision(variant, judge.origin)) for column, variant in VARIANTS.items()
    }


def build_rows(anchors: list[dict[str, str]], folder: Path) -> list[list[object]]:
    """Build a row of the table for each model, tolerance and variant."""
    rows: list[list[object]] = []
    known: dict[str, tuple[Judge, dict[str, Decimator]]] = {}
    for anchor in anchors:
        model, relative = anchor["model"], float(anchor["tolerance_relative"])
        if model not in known:
            known = {model: build_decimators(folder / model)}
        judge, own = known[model]
        for column, decimator in own.items():
            found = decimator.find_fewest_points(relative * judge.diagonal)
            count = len(found.surface.points) if found else None
            rows.append([model, f"{relative:g}", column, *compare_counts(count, anchor[column])])
    return rows


def compare_counts(found: int | None, recorded: str) -> list[object]:
    """Compare our figure with the recorded one: both, their ratio, and whether they agree."""
    if not recorded.isdigit() or found is None:
        return [found if found is not None else "none", recorded, "", found is None and not recorded.isdigit()]
    ratio = found / int(recorded)
    return [found, int(recorded), f"{ratio:.3f}", abs(ratio - 1.0) <= NEAR]


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("csv", nargs="?", type=Path, metavar="CSV", help="default: beside the models' folder")
    args = parser.parse_args()
    folder = find_models()
    path = args.csv or folder.parent / "anchors.csv"
    if not path.is_file():
        raise SystemExit(f"{path}: no such file: give the CSV with the recorded figures")
    with path.open(newline="") as lines:
        rows = build_rows(list(csv.DictReader(lines)), folder)
    print(format_table(("model", "relative tolerance", "variant", "points", "recorded", "ratio", "reproduced"), rows))
    print(f"\nWithin {NEAR:.0%}: {sum(bool(row[-1]) for row in rows)} of {len(rows)}.")


if __name__ == "__main__":
    main()
