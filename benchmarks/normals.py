"""Measure whether walls look like walls: the share of the surface whose normal turns, beside peers.

usage: python benchmarks/normals.py [CSV] [--tolerance RELATIVE ...]
needs: pip install "bldsimp[bench]"; of the other tools that `bldsimp compare --peers` knows, those installed are asked

CSV has the columns of `anchors.py`; the clean models are taken, which are those in the folders exact and city. Each is
welded exactly, and faces that repeat a point and copies of faces, with whichever winding, are left out. Each peer is
asked twice, as `bldsimp compare` asks it: for the fewest points within the same tolerance, and for as many points as
bldsimp keeps. Samples are spread over the original by area, libigl finds the face of the result nearest to each, and
the angle between the normals of the two faces is taken; without their signs where the original's winding clashes.

A share has two parts: what lies no farther than the tolerance from a crease of the original (an edge that bends by as
much, or does not belong to two faces), where a step may be swallowed or a corner may come to lie on the other wall; and
walls, which is all the rest. Everything is printed as Markdown.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import igl
import numpy as np
from anchors import Anchor, read_anchors
from numpy.typing import NDArray
from peers import build_decimators, build_judge, convert_surface, read_model
from surface import Surface, find_models, measure_deviation, spread_samples, weld_surface
from table import format_table

import bldsimp
from bldsimp.compare.decimate import Decimation, Decimator, RefusalError

CLEAN = ("exact", "city")
"""Folders of models that are no scans."""

RELATIVE = 1e-3
"""Tolerance unless others are asked for, as a share of the diagonal."""

TURNED_DEGREES = 30.0
"""A normal that turns by more is seen."""

SAMPLES = 200_000

EXTRA_POINTS = 0.05
"""So many more points than bldsimp, by its own, still count as as many."""

OURS = "bldsimp"

Floats = NDArray[np.float64]


@dataclass
class Turned:
    """Points of a result, and the share of the original's area whose normal turns; `walls` is a part of `share`."""

    points: int
    deviation: float
    share: float
    walls: float


class Walls:
    """Samples of one original, its normals there, and which of them are away from its creases.

    Parameters
    ----------
    original : Surface
    tolerance : float
        How far from a crease a wall begins; model units.
    """

    def __init__(self, original: Surface, tolerance: float) -> None:
        self.tolerance = tolerance
        self.origin = original.points.mean(axis=0)
        original = Surface(original.points - self.origin, original.faces)
        self.samples, faces = spread_samples(original, SAMPLES)
        normals = find_normals(original)
        self.normals = normals[faces]
        self.signed = is_consistent(original.faces)
        ends = find_creases(original, normals)
        squared = igl.point_mesh_squared_distance(self.samples, original.points, ends)[0]
        self.away = np.sqrt(squared) > tolerance

    def measure(self, result: Surface, deviation: float) -> Turned:
        """Measure the shares of a result."""
        local = Surface(np.ascontiguousarray(result.points - self.origin), np.ascontiguousarray(result.faces))
        nearest = igl.point_mesh_squared_distance(self.samples, *local)[1]
        agree = (self.normals * find_normals(local)[nearest]).sum(axis=1)
        turned = (agree if self.signed else np.abs(agree)) < np.cos(np.radians(TURNED_DEGREES))
        return Turned(len(result.points), deviation, float(turned.mean()), float((turned & self.away).mean()))


def find_normals(surface: Surface) -> Floats:
    """Return the normal of each face; zero where it has no area."""
    a, b, c = (surface.points[surface.faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1)
    return np.asarray(normals / np.where(lengths > 0, lengths, 1.0)[:, None])


def is_consistent(faces: NDArray[np.int64]) -> bool:
    """Whether no two faces use an edge in the same direction."""
    halfedges = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    return len(np.unique(halfedges, axis=0)) == len(halfedges)


def find_creases(surface: Surface, normals: Floats) -> NDArray[np.int64]:
    """Edges at which a surface bends by enough, or that do not belong to two faces; by their ends, (k, 2)."""
    halfedges = np.stack([surface.faces, np.roll(surface.faces, -1, axis=1)], axis=2).reshape(-1, 2)
    edges, of_halfedge, uses = np.unique(np.sort(halfedges, axis=1), axis=0, return_inverse=True, return_counts=True)
    order = np.argsort(of_halfedge.reshape(-1), kind="stable")
    first = np.cumsum(uses) - uses
    one, other = (normals[order[place] // 3] for place in (first, first + uses - 1))
    # Which of two faces of opposite winding is turned is not known, so that a fold of 180 degrees is none.
    flat = np.abs((one * other).sum(axis=1)) > np.cos(np.radians(TURNED_DEGREES))
    return np.ascontiguousarray(edges[(uses != 2) | ~flat])


def run_peers(
    tools: dict[str, Decimator], question: Callable[[Decimator], Decimation | str]
) -> dict[str, Decimation | str]:
    """Run each peer; return its result, or the reason why there is none."""
    answers: dict[str, Decimation | str] = {}
    for name, tool in tools.items():
        try:
            answers[name] = question(tool)
        except RefusalError:
            answers[name] = "refuses the input"
    return answers


def find_fewest(tolerance: float) -> Callable[[Decimator], Decimation | str]:
    """Asks for the fewest points within a tolerance."""
    return lambda tool: tool.find_fewest_points(tolerance) or "no reduction"


def find_as_many(points: int) -> Callable[[Decimator], Decimation | str]:
    """Asks for a number of points."""

    def question(tool: Decimator) -> Decimation | str:
        found = tool.find_point_count(points)
        least = len(found.surface.points)
        return found if least <= (1.0 + EXTRA_POINTS) * points else f"stops at {least:,}"

    return question


def measure_results(model: str, walls: Walls, ours: Turned, answers: dict[str, Decimation | str]) -> list[list[object]]:
    """Measure a row for bldsimp, and one for each peer; the last cell says whether less turns in ours, if known."""
    rows: list[list[object]] = [[model, OURS, ours.points, *format_shares(ours, walls.tolerance), ""]]
    for name, found in answers.items():
        if isinstance(found, str):
            rows.append([model, name, found, "", "", "", ""])
            continue
        theirs = walls.measure(convert_surface(found.surface), found.deviation)
        less = ours.share < theirs.share or not ours.share
        rows.append([model, name, theirs.points, *format_shares(theirs, walls.tolerance), less])
    return rows


def format_shares(turned: Turned, tolerance: float) -> list[object]:
    """Write the figures of one result."""
    return [turned.deviation / tolerance, f"{turned.share:.3%}", f"{turned.walls:.3%}"]


def compare_models(anchor: Anchor, folder: Path) -> tuple[list[list[object]], list[list[object]]]:
    """Rows of one model: within the tolerance, and at the same number of points."""
    mesh = read_model(folder / anchor.model)
    judge = build_judge(mesh)
    tools = build_decimators(judge)
    walls = Walls(mesh, anchor.relative * judge.diagonal)
    simplified = weld_surface(*bldsimp.simplify((mesh.points, mesh.faces), walls.tolerance).mesh)
    ours = walls.measure(simplified, measure_deviation(mesh, simplified))
    within, same = run_peers(tools, find_fewest(walls.tolerance)), run_peers(tools, find_as_many(ours.points))
    return measure_results(anchor.model, walls, ours, within), measure_results(anchor.model, walls, ours, same)


def compare_shares(rows: list[list[object]]) -> str:
    """On how many models less turns in ours than in each peer's result."""
    models = dict.fromkeys(str(row[0]) for row in rows)
    lost = {str(row[0]) for row in rows if row[-1] is False}
    return f"Below every peer's on {len(models) - len(lost)} of {len(models)} models."


HEADER = ("model", "method", "points", "deviation / tolerance", "turned", "of it on walls", "ours is less")


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("csv", nargs="?", type=Path, metavar="CSV", help="default: beside the models' folder")
    parser.add_argument("--tolerance", type=float, nargs="+", default=[RELATIVE], metavar="RELATIVE")
    args = parser.parse_args()
    folder = find_models()
    anchors = read_anchors(args.csv or folder.parent / "anchors.csv")
    for relative in args.tolerance:
        wanted = [one for one in anchors if one.relative == relative and PurePosixPath(one.model).parts[0] in CLEAN]
        both = [compare_models(anchor, folder) for anchor in wanted]
        titles = ("each peer's fewest points within it", "each peer at as many points as bldsimp")
        for title, rows in zip(titles, ([row for each in both for row in each[k]] for k in (0, 1)), strict=True):
            print(f"Tolerance {relative:g} of the diagonal, {title}:\n")
            print(f"{format_table(HEADER, rows)}\n\n{compare_shares(rows)}\n")


if __name__ == "__main__":
    main()
