"""How scans look: pictures of the original, of bldsimp's result, and of each peer's at as many points.

usage: python benchmarks/scans.py [FOLDER]      (docs where none is given)
needs: pip install "bldsimp[bench,pictures]"; of the other tools that `bldsimp compare --peers` knows, those installed
are asked

Writes scans.md and its pictures. The models are in the folder BLDSIMP_MODELS, and are no part of the repository.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from normals import Walls, run_peers
from peers import build_decimators, build_judge, convert_surface, read_model
from picture import Style, View, draw_picture
from PIL.Image import Dither
from surface import ROOT, Surface, find_models, measure_deviation, weld_surface
from table import format_table

import bldsimp
from bldsimp.compare.measure import Judge
from bldsimp.compare.placement import PlacedSurface

OURS = "bldsimp"
COLUMNS = 4
COLORS = 64

SHADES = Style(width=540, height=430, line=0.0, crease=0.0, gap=6)
"""Without lines: shades show whether a wall is flat."""


@dataclass(frozen=True)
class Scan:
    """A model and its views.

    Attributes
    ----------
    name : str
        Of its pictures.
    title, source, license : str
        Words of the page.
    axes : tuple
        Rows that turn the model so that z points upwards.
    styles : dict of float to Style
        One for each tolerance, as a share of the diagonal.
    inside : bool
        Whether the view is from inside: faces seen from behind are not drawn.
    """

    model: str
    name: str
    title: str
    source: str
    license: str
    axes: tuple[tuple[float, float, float], ...]
    styles: dict[float, Style]
    inside: bool = False


SCANS = (
    Scan(
        "noisy/easy3d_building.off",
        "scan_building",
        "A building, from aerial photographs",
        "`resources/data/building.off` of the repository LiangliangNan/Easy3D",
        "GPL-3.0, and so is that of its pictures",
        ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
        {
            0.005: replace(SHADES, azimuth=-75.0, elevation=30.0, zoom=1.3, aim=(0.56, 0.48)),
            0.001: replace(SHADES, azimuth=-75.0, elevation=30.0, zoom=2.2, aim=(0.68, 0.38)),
        },
    ),
    Scan(
        "noisy/planeopt_copyroom.ply",
        "scan_room",
        "A room, from a depth camera",
        "`models/copyroom/copyroom_c2000_opt.ply` of the repository chaowang15/plane-opt-rgbd",
        "MIT",
        ((-0.3420, -0.5604, 0.7543), (-0.9397, 0.1976, -0.2793), (0.0075, -0.8043, -0.5942)),
        {
            0.005: replace(SHADES, azimuth=110.0, elevation=45.0, zoom=1.2, aim=(0.48, 0.45)),
            0.001: replace(SHADES, azimuth=110.0, elevation=45.0, zoom=2.2, aim=(0.42, 0.52)),
        },
        inside=True,
    ),
)


@dataclass
class Result:
    """The result of one method for a scan; `deviation` in units of the tolerance."""

    method: str
    surface: Surface
    deviation: float
    turned: float
    borders: int

    @property
    def row(self) -> list[object]:
        """Its row of the table."""
        points, faces = map(len, self.surface)
        return [self.method, points, faces, self.deviation, f"{self.turned:.2%}", self.borders]

    @property
    def figures(self) -> str:
        """The second line below its picture."""
        points = f"{len(self.surface.points):,} points"
        return f"{points}, moved by up to {self.deviation:.3g} tolerances" if self.deviation else points


def collect_results(mesh: Surface, judge: Judge, tolerance: float) -> list[Result]:
    """Collect the original, bldsimp, and each peer that does not refuse: with as many points, or its fewest."""
    walls = Walls(mesh, tolerance)
    simplified = weld_surface(*bldsimp.simplify((mesh.points, mesh.faces), tolerance).mesh)
    made = {"original": (mesh, 0.0), OURS: (simplified, measure_deviation(mesh, simplified))}
    answers = run_peers(build_decimators(judge), lambda tool: tool.find_point_count(len(simplified.points)))
    for name, found in answers.items():
        if not isinstance(found, str):
            made[name] = (convert_surface(found.surface), found.deviation)
    return [measure_result(name, *each, judge, walls) for name, each in made.items()]


def measure_result(method: str, surface: Surface, moved: float, judge: Judge, walls: Walls) -> Result:
    """Measure a result."""
    left = judge.count_new_borders(PlacedSurface(surface.points, surface.faces.astype(np.int32)), walls.tolerance)
    return Result(method, surface, moved / walls.tolerance, walls.measure(surface, moved).share, left)


def build_view(scan: Scan, style: Style, result: Result) -> View:
    """Build the view of a result."""
    points = result.surface.points @ np.array(scan.axes).T
    faces = result.surface.faces
    if scan.inside:
        azimuth, elevation = np.radians([style.azimuth, style.elevation])
        flat = np.cos(elevation)
        toward = np.array([np.cos(azimuth) * flat, np.sin(azimuth) * flat, np.sin(elevation)])
        a, b, c = (points[faces[:, k]] for k in range(3))
        faces = faces[np.cross(b - a, c - a) @ toward > 0]
    return View(points, faces, f"{result.method}\n{result.figures}")


def draw(scan: Scan, style: Style, made: list[Result], target: Path) -> None:
    """Write a picture of all results."""
    image = draw_picture([build_view(scan, style, result) for result in made], style, COLUMNS)
    # A palette makes the file a third as large; without lines there are only shades of one color.
    image.quantize(COLORS, dither=Dither.NONE).save(target, optimize=True)


HEADER = ("method", "points", "triangles", "deviation / tolerance", "normals turned", "borders moved")

TEXT = """\
# Scans

A scan is nowhere flat. This page shows two, each at 0.5 % and, closer, at 0.1 % of its diagonal: the original, the
result of bldsimp, and results of other tools with as many points, or with the fewest that they reach. Every face has
one shade and edges are not drawn, so you can see whether a wall is flat. Tools that refuse the model are not shown.
One command makes this page: `python benchmarks/scans.py`.

*Deviation* is measured both ways, in units of the tolerance. *Normals turned* is the share of the original's area
where the nearest face of the result is turned by more than 30 degrees. *Borders moved* counts open edges that lie
farther than the tolerance from every open edge of the original.
"""


def write_section(scan: Scan, folder: Path) -> str:
    """Draw a scan at all tolerances, and write its section."""
    mesh = read_model(find_models() / scan.model)
    judge = build_judge(mesh)
    parts = [f"\n## {scan.title}\n\nThe model is {scan.source};\nits license is {scan.license}.\n"]
    for relative, style in scan.styles.items():
        made = collect_results(mesh, judge, relative * judge.diagonal)
        name = f"{scan.name}_{1000 * relative:g}.png"
        draw(scan, style, made, folder / name)
        rows = [one.row for one in made]
        title = f"At {100 * relative:g} %"
        parts.append(f"\n### {title}\n\n![{scan.title}: {title}]({name})\n\n{format_table(HEADER, rows)}\n")
    return "".join(parts)


def main() -> None:
    """Write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, default=ROOT / "docs", metavar="FOLDER")
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    text = TEXT + "".join(write_section(scan, folder) for scan in SCANS)
    (folder / "scans.md").write_text(text, encoding="utf-8", newline="")


if __name__ == "__main__":
    main()
