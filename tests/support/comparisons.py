"""Comparisons that several tests read."""

from __future__ import annotations

import csv
import io
from functools import cache
from pathlib import Path

from bldsimp.compare.rows import Comparison, MethodRow, compare_file

HEADER = "file,tolerance,method,points,triangles,deviation,bound,watertight,border_made,seconds,note"
METHODS = [
    "original", "standard", "improved", "fast-simplification", "fast-simplification border",
    "fast-simplification lossless", "fast-simplification same points",
]  # fmt: skip
NOT_MET = ("no reduction", "does not reach", "refuses")


def read_rows(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def find_row(comparison: Comparison, method: str, tolerance: str) -> MethodRow:
    (found,) = [row for row in comparison.rows if (row.method, row.tolerance) == (method, tolerance)]
    return found


@cache
def compare_data(folder: Path) -> list[Comparison]:
    """Compare both buildings at a tolerance that loses nothing, and at one that does."""
    return [compare_file(folder / name, "obj", name, ["auto", "0.1%"]) for name in ("building_a.obj", "building_b.obj")]
