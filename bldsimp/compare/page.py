"""Build one page that shows a comparison in 3D, offline: original and result side by side, the table, the chart.

The viewer is three.js, in a file of this folder; geometry and distances are deflated and written in base64,
each once, however many rows show it.
"""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from html import escape
from importlib.resources import files
from pathlib import PurePath
from string import Template
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model import Points
from .display_mesh import TRIANGLES, DisplayMesh, choose_display
from .drawing import format_svg
from .measure import Judge
from .placement import PlacedSurface
from .plot import LineStyle, draw_chart, list_drawable, list_lines
from .rows import Comparison, MethodRow
from .table import format_figures

VIEWER = "three-0.187.0.min.js"

Y_UP = (".glb", ".gltf")
"""Formats whose y axis points upwards; buildings in all others are taken to have z there."""

STEPS = 65535
"""Distances are stored in so many steps of the greatest one."""

COLUMNS = {
    "method": ("method", "Method that made the surface"),
    "points": ("points", "Points that a face uses, after the same weld"),
    "share": ("of original", "Points, in percent of the original's"),
    "triangles": ("triangles", "Triangles"),
    "deviation": ("deviation", "Greatest distance measured between the surfaces, both ways, model units"),
    "bound": ("bound", "No point is farther than this: certified, model units"),
    "watertight": ("watertight", "Whether every edge belongs to two faces"),
    "border_made": ("border made", "Open edges that lie on no open edge of the original"),
    "seconds": ("seconds", "Time of the method"),
}
"""Head and tip of each column."""


def build_page(comparisons: Sequence[Comparison]) -> bytes:
    """Build the page.

    Parameters
    ----------
    comparisons : sequence of Comparison
        Rows with a surface can be shown in 3D, the others are in the table only.

    Returns
    -------
    bytes
        HTML that needs no other file and no network; the same comparisons give the same bytes.

    Notes
    -----
    Most of the time goes into distances: of all points drawn and some tens of thousands of samples, both ways,
    for each different surface.
    """
    data = PageData()
    numbers = [data.add_file(comparison) for comparison in comparisons]
    lines = list_lines(comparisons)
    own = files("bldsimp.compare")
    text = Template(own.joinpath("page.html").read_text("utf-8")).substitute(
        title="bldsimp compare",
        most=f"{TRIANGLES:,}",
        subtitle=escape(summarize(comparisons)),
        table=format_table(comparisons, numbers),
        charts="\n".join(embed_chart(k, each, lines, numbers[k]) for k, each in enumerate(comparisons)),
        data=data.format_json(),
        blobs=data.format_blobs(),
        library=own.joinpath(VIEWER).read_text("utf-8"),
        program=own.joinpath("page.js").read_text("utf-8"),
    )
    # Names of files need not be Unicode.
    return text.encode("utf-8", "replace")


@dataclass
class PageData:
    """Everything that the program on the page reads."""

    files: list[dict[str, Any]] = field(default_factory=list)
    surfaces: list[dict[str, Any]] = field(default_factory=list)
    rows: list[dict[str, Any]] = field(default_factory=list)
    blobs: dict[bytes, int] = field(default_factory=dict)

    def add_file(self, comparison: Comparison) -> dict[int, int]:
        """Add the surfaces of a comparison that can be drawn; return numbers on the page by index of its rows."""
        original = comparison.original
        shown = {
            k: surface
            for k, row in enumerate(comparison.rows)
            if (surface := original if row.method == "original" else row.surface) and len(surface.faces)
        }
        self.files.append({})
        if original is None or not len(original.faces) or not shown:
            return {}
        pairs = SurfacePairs(original, self)
        self.files[-1] = {
            "caption": [f"original · {PurePath(comparison.file).name}", *describe_original(comparison, pairs.note)],
            "original": pairs.number,
            "diagonal": pairs.judge.diagonal,
            "up": "y" if PurePath(comparison.file).suffix.lower() in Y_UP else "z",
        }
        numbers = {}
        for k, surface in shown.items():
            row, (pair, note) = comparison.rows[k], pairs.add_result(surface)
            numbers[k] = len(self.rows)
            self.rows.append(
                {
                    "file": len(self.files) - 1,
                    "tolerance": comparison.tolerances.get(row.tolerance, 0.0),
                    "deviation": row.deviation or 0.0,
                    **pair,
                    "caption": [f"{row.method} · tolerance {row.tolerance}", *describe_result(row, note)],
                }
            )
        return numbers

    def add_surface(self, mesh: DisplayMesh, origin: Points) -> int:
        """Add a surface as it is drawn; return its number."""
        arrays = {
            "points": (mesh.points - origin).astype("<f4"),
            "faces": mesh.faces.astype("<u4"),
            "steps": mesh.steps,
        }
        self.surfaces.append({name: self.add_blob(array) for name, array in arrays.items()})
        return len(self.surfaces) - 1

    def add_distances(self, values: NDArray[np.float64]) -> dict[str, Any]:
        """Add distances in shares of the greatest one."""
        top = float(values.max(initial=0.0))
        shares = np.rint(values * (STEPS / top)) if top > 0.0 else np.zeros(len(values))
        return {"blob": self.add_blob(shares.astype("<u2")), "top": top}

    def add_blob(self, array: NDArray[Any]) -> int:
        """Add an array's bytes, equal ones once; return their number."""
        return self.blobs.setdefault(zlib.compress(array.tobytes(), 6), len(self.blobs))

    def format_json(self) -> str:
        """Write all but the arrays for a script element, which ends at the first ``</script``, quoted or not."""
        text = json.dumps({"files": self.files, "surfaces": self.surfaces, "rows": self.rows}, allow_nan=False)
        return text.replace("<", "\\u003c")

    def format_blobs(self) -> str:
        """Write the arrays, one element each."""
        return "\n".join(
            f'<script type="application/octet-stream" id="blob-{number}">{base64.b64encode(data).decode()}</script>'
            for data, number in self.blobs.items()
        )


class SurfacePairs:
    """One original and its results, each different one drawn and measured once."""

    def __init__(self, original: PlacedSurface, data: PageData) -> None:
        self.data, self.judge = data, Judge(original)
        shown = choose_display(original)
        self.number = data.add_surface(shown, self.judge.origin)
        self.note = note_thinning(shown, original)
        self._samples = shown.place_samples() - self.judge.origin
        none = data.add_distances(np.zeros(len(self._samples)))
        self._done = {self._identify(original): ({"surface": self.number, "distances": [none, none]}, self.note)}

    @staticmethod
    def _identify(surface: PlacedSurface) -> bytes:
        """Return a key that is equal for equal surfaces."""
        return sha256(surface.points.tobytes()).digest() + sha256(surface.faces.tobytes()).digest()

    def add_result(self, surface: PlacedSurface) -> tuple[dict[str, Any], str]:
        """Add one result; return its number and distances, from the original to it and back, and a note."""
        key = self._identify(surface)
        if key not in self._done:
            shown, origin = choose_display(surface), self.judge.origin
            tree = _core.FaceTree(surface.points - origin, surface.faces)
            there, back = tree.distances(self._samples), self.judge.tree.distances(shown.place_samples() - origin)
            number = self.data.add_surface(shown, origin)
            # Rounding alone is no distance, as in the figures.
            distances = [self.data.add_distances(np.maximum(way - self.judge.noise, 0.0)) for way in (there, back)]
            self._done[key] = {"surface": number, "distances": distances}, note_thinning(shown, surface)
        return self._done[key]


def note_thinning(shown: DisplayMesh, surface: PlacedSurface) -> str:
    """Note how much of a surface is drawn; nothing where all of it is."""
    if not shown.thinned:
        return ""
    return f"drawn with {len(shown.faces):,} of its {len(surface.faces):,} triangles"


def describe_original(comparison: Comparison, note: str) -> tuple[str, str]:
    """Write the lines below the left view."""
    own = next((row for row in comparison.rows if row.method == "original"), MethodRow("", "", ""))
    return join_facts(*list_counts(own)), join_facts(f"diagonal {comparison.diagonal:.6g}", note)


def describe_result(row: MethodRow, note: str) -> tuple[str, str]:
    """Write the lines below the right view."""
    figures = format_figures(row)
    *counts, closed = list_counts(row)
    deviation = figures["deviation"] and f"deviation {figures['deviation']}"
    deviation += figures["bound"] and f" (certified: at most {figures['bound']})"
    borders = f"{figures['border_made']} border edges made" if row.border_made else ""
    return (
        join_facts(*counts, deviation),
        join_facts(closed, borders, figures["seconds"] and f"{figures['seconds']} s", row.note, note),
    )


def list_counts(row: MethodRow) -> list[str]:
    """Write points, triangles and whether the surface is closed; empty where that is not known."""
    figures = format_figures(row)
    counts = [figures[name] and f"{figures[name]} {name}" for name in ("points", "triangles")]
    return [*counts, {"yes": "watertight", "no": "open"}.get(figures["watertight"], "")]


def join_facts(*facts: str) -> str:
    """Join the facts that there are."""
    return " · ".join(filter(None, facts))


def embed_chart(k: int, comparison: Comparison, lines: dict[str, LineStyle], numbers: dict[int, int]) -> str:
    """Draw the chart of one file, whose marks choose rows; only the first file's is visible at first."""
    if not list_drawable(comparison):
        return ""
    drawing = draw_chart([comparison], lines, numbers=[numbers])
    svg = format_svg(drawing, f"Points against tolerance, {comparison.file}")
    return f'<figure class="chart panel" data-file="{k}"{" hidden" if k else ""}>{svg}</figure>'


def summarize(comparisons: Sequence[Comparison]) -> str:
    """Count the files, tolerances and methods of the page."""
    tolerances = {written for each in comparisons for written in each.tolerances}
    methods = {row.method for each in comparisons for row in each.rows if row.method}
    counts = {"file": len(comparisons), "tolerance": len(tolerances), "method": len(methods)}
    return ", ".join(f"{count} {name}{'s' * (count != 1)}" for name, count in counts.items())


def format_table(comparisons: Sequence[Comparison], numbers: Sequence[dict[int, int]]) -> str:
    """Write all rows as HTML, by file and tolerance."""
    heads = "".join(f'<th scope="col" title="{tip}">{name}</th>' for name, tip in COLUMNS.values())
    parts = [f"<table><thead><tr>{heads}</tr></thead>"]
    for comparison, known in zip(comparisons, numbers, strict=True):
        base = next((row.points for row in comparison.rows if row.method == "original"), None)
        for tolerance in dict.fromkeys(row.tolerance for row in comparison.rows):
            parts.append(f"<tbody>{format_heading(comparison, tolerance)}")
            rows = [(k, row) for k, row in enumerate(comparison.rows) if row.tolerance == tolerance]
            parts += [format_row(row, base, known.get(k)) for k, row in rows]
            parts.append("</tbody>")
    return "\n".join([*parts, "</table>"])


def format_heading(comparison: Comparison, tolerance: str) -> str:
    """Write the line above the rows of one file and tolerance."""
    value = comparison.tolerances.get(tolerance)
    text = "" if value is None else f" <span>tolerance {escape(tolerance)} = {value:.3g} model units</span>"
    return f'<tr><th scope="rowgroup" colspan="{len(COLUMNS)}">{escape(comparison.file)}{text}</th></tr>'


def format_row(row: MethodRow, base: int | None, number: int | None) -> str:
    """Write one row; with a number it can be chosen, and the first of `improved` is at first."""
    figures = format_figures(row)
    figures["share"] = f"{100.0 * row.points / base:.1f} %" if row.points is not None and base else ""
    if row.border_made:
        # Worse than the original.
        figures["border_made"] = f'<span class="bad">{figures["border_made"]}</span>'
    name = f'<span class="plain">{escape(row.method)}</span>'
    chosen = ""
    if number is not None:
        name = f'<label><input type="radio" name="row">{escape(row.method)}</label>'
        chosen = f' data-row="{number}"' + " data-first" * (row.method == "improved")
    note = f'<div class="note">{escape(row.note)}</div>' if row.note else ""
    cells = "".join(f"<td>{figures[key]}</td>" for key in COLUMNS if key != "method")
    return f"<tr{chosen}><td>{name}{note}</td>{cells}</tr>"
