"""Make the figures of docs/from_the_article.md: points by method, and how the buildings look.

usage: compare_buildings.py [FOLDER]      (docs where none is given)
needs: pip install 'bldsimp[pictures]'

Writes buildings.csv, with all figures, points.svg, the chart of them, and for each building a picture:
the original, and the results of the standard and the improved method.
"""

from __future__ import annotations

import sys
from pathlib import Path

from picture import Style, View, draw_picture
from PIL.Image import Dither

from bldsimp.compare.plot import draw_plot
from bldsimp.compare.rows import Comparison, compare_file
from bldsimp.compare.table import format_csv
from bldsimp.options import COMPARED_TOLERANCES

ROOT = Path(__file__).resolve().parents[1]
TOLERANCES = COMPARED_TOLERANCES.split(",")
SHOWN = ("original", "standard", "improved")
STYLES = {
    "building_a": Style(width=640, height=560),
    "building_b": Style(width=640, height=800, azimuth=125.0, elevation=14.0),
}


def make_views(comparison: Comparison, tolerance: str) -> list[View]:
    """Make the views of the pictures, with their counts."""
    rows = {row.method: row for row in comparison.rows if row.tolerance == tolerance}
    made = []
    for method in SHOWN:
        row, surface = rows[method], rows[method].surface
        if surface is None:
            raise SystemExit(f"{comparison.file}: {method} gave no surface: {row.note}")
        caption = f"{method}\n{row.points:,} points, {row.triangles:,} triangles"
        made.append(View(surface.points, surface.faces.astype("i8"), caption))
    return made


def main() -> None:
    """Compare, write the figures, draw the pictures."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs"
    folder.mkdir(parents=True, exist_ok=True)
    files = [ROOT / "data" / name for name in ("building_a.obj", "building_b.obj")]
    comparisons = [compare_file(file, "obj", f"data/{file.name}", TOLERANCES) for file in files]
    (folder / "buildings.csv").write_text(format_csv(comparisons), encoding="utf-8", newline="")
    (folder / "points.svg").write_bytes(draw_plot(comparisons, ".svg"))
    for file, comparison in zip(files, comparisons, strict=True):
        image = draw_picture(make_views(comparison, TOLERANCES[0]), STYLES[file.stem])
        # A palette makes the file a third as large; the shades of flat facets are few.
        target = folder / f"{file.stem}_methods.png"
        image.quantize(128, dither=Dither.NONE).save(target, optimize=True)


if __name__ == "__main__":
    main()
