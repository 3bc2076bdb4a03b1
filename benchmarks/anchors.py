"""Compare the remaining points with the best of several peers, on models whose figures for the peers are recorded.

usage: python benchmarks/anchors.py [CSV] [--tolerance RELATIVE ...]
needs: pip install "bldsimp[bench]"

CSV has the columns model, points, triangles, watertight, tolerance_relative, best_peer and best_points; its
models are in the folder BLDSIMP_MODELS. Each mesh is welded exactly, and faces that repeat a point and copies
of faces, with whichever winding, are left out first, as the peers had it. The judge measures the deviation
both ways with an independent library; what it finds between a mesh and itself is its own noise. Everything
is printed as Markdown.
"""

from __future__ import annotations

import argparse
import csv
from dataclasses import dataclass
from pathlib import Path

from surface import Surface, find_models, is_watertight, measure_deviation, read_surface, weld_surface
from table import format_rung_shares, format_table

import bldsimp

LOSSLESS = 1e-6
"""Relative tolerance of the rows that are measured unless others are asked for."""

OPEN_ALLOWANCE = 1.005
"""An open model may keep this many times the points of the best peer, since most peers tear its borders."""

ALLOWANCES = {"pmp_fandisk.off": 1.1}
"""Models with an allowance of their own: on a curved part it pays that the best peer moves points."""


@dataclass
class Anchor:
    """One row of the CSV: a model, a tolerance, and the fewest points that a peer needs."""

    model: str
    points: int
    triangles: int
    watertight: bool
    relative: float
    best_peer: str
    best_points: int

    @property
    def limit(self) -> int:
        """The most points that bldsimp may keep."""
        usual = 1.0 if self.watertight else OPEN_ALLOWANCE
        return int(self.best_points * ALLOWANCES.get(Path(self.model).name, usual))


def read_anchors(path: Path) -> list[Anchor]:
    """Read all rows of the CSV.

    Raises
    ------
    SystemExit
        If there is no such file.
    """
    if not path.is_file():
        raise SystemExit(f"{path}: no such file: give the CSV with the peers' figures")
    with path.open(newline="") as lines:
        return [
            Anchor(
                model=row["model"],
                points=int(row["points"]),
                triangles=int(row["triangles"]),
                watertight=row["watertight"] == "True",
                relative=float(row["tolerance_relative"]),
                best_peer=row["best_peer"],
                best_points=int(row["best_points"]),
            )
            for row in csv.DictReader(lines)
        ]


def measure_anchor(anchor: Anchor, mesh: Surface) -> list[object]:
    """Measure one row of the table."""
    tolerance = anchor.relative * mesh.diagonal
    simplified = bldsimp.simplify((mesh.points, mesh.faces), tolerance)
    report, after = simplified.report, weld_surface(*simplified.mesh)
    found = measure_deviation(mesh, after)
    return [
        anchor.model, f"{anchor.relative:g}", len(mesh.points), len(after.points),
        f"{anchor.best_points:,} ({anchor.best_peer})", f"{len(after.points) / anchor.best_points:.4f}",
        anchor.limit, len(after.points) <= anchor.limit,
        found / tolerance, measure_deviation(mesh, mesh) / tolerance, report.deviation / tolerance,
        f"{_describe_edges(mesh)} -> {_describe_edges(after)}", report.facets, format_rung_shares(report),
    ]  # fmt: skip


def _describe_edges(mesh: Surface) -> str:
    return "closed" if is_watertight(mesh.faces) else "open"


HEADER = (
    "model", "relative tolerance", "points", "ours", "best peer", "ratio", "limit", "met",
    "deviation / tolerance", "judge's noise / tolerance", "bound / tolerance", "edges", "facets", "rungs",
)  # fmt: skip


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("csv", nargs="?", type=Path, metavar="CSV", help="default: beside the models' folder")
    parser.add_argument("--tolerance", type=float, nargs="+", default=[LOSSLESS], metavar="RELATIVE")
    args = parser.parse_args()
    folder = find_models()
    anchors = read_anchors(args.csv or folder.parent / "anchors.csv")
    rows, surprises = [], []
    for anchor in (one for one in anchors if one.relative in args.tolerance):
        mesh = weld_surface(*read_surface(folder / anchor.model), one_sided=True)
        found = (len(mesh.points), len(mesh.faces), is_watertight(mesh.faces))
        if found != (anchor.points, anchor.triangles, anchor.watertight):
            surprises.append(f"{anchor.model}: points, triangles, watertight are {found}, not as in the CSV.")
        rows.append(measure_anchor(anchor, mesh))
    print(format_table(HEADER, rows))
    met = sum(bool(row[HEADER.index("met")]) for row in rows)
    print(f"\nWithin the limit: {met} of {len(rows)}.")
    print("".join(f"\n{surprise}" for surprise in surprises), end="")


if __name__ == "__main__":
    main()
