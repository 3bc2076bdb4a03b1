"""One page that shows a comparison in 3D, offline: original and result side by side, the table, the chart.

The viewer is three.js, as trimesh ships it; geometry and distances are deflated and written in base64,
each once, however many rows show it.
"""

from __future__ import annotations

import base64
import io
import json
import re
import zipfile
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from html import escape
from importlib.resources import files
from pathlib import PurePath
from string import Template
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..errors import BldsimpError
from ..model import Points
from .chart import chart_svg
from .drawn import TRIANGLES, Drawn, drawn
from .measure import noise
from .plot import Line, lines_of
from .row import Comparison, Row
from .surface import Surface

LIBRARY_ENDS = re.compile(r"THREE\.TrackballControls\s*=\s*TrackballControls;\s*\}\)\(\);")
"""Behind three.js and these controls trimesh's template has nothing that is needed."""

Y_UP = (".glb", ".gltf")
"""Formats whose y axis points upwards; buildings in all others are taken to have z there."""

STEPS = 65535
"""Distances are stored in so many steps of the greatest one."""

COLUMNS = (
    ("method", "method", "What made the surface"),
    ("points", "points", "Points that a face uses, after the same weld"),
    ("share", "of original", "Points, in percent of the original's"),
    ("triangles", "triangles", "Triangles"),
    ("deviation", "deviation", "Greatest distance measured between the surfaces, both ways, model units"),
    ("bound", "bound", "No point is farther than this: certified, model units"),
    ("watertight", "watertight", "Whether every edge belongs to two faces"),
    ("border_made", "border made", "Open edges that lie on no open edge of the original"),
    ("seconds", "seconds", "Time that the method took"),
)


def write_page(comparisons: Sequence[Comparison]) -> bytes:
    """Make the page.

    Parameters
    ----------
    comparisons : sequence of Comparison
        Rows with a surface can be looked at, the others stand in the table only.

    Returns
    -------
    bytes
        HTML that needs nothing beside it; the same comparisons give the same bytes.

    Raises
    ------
    BldsimpError
        If the installed trimesh no longer ships the viewer library as it is known here.

    Notes
    -----
    Beside what is drawn, the time goes into distances: of all points drawn and some tens of thousands of
    samples, both ways, for each different surface.
    """
    library = viewer_library()
    packed = Packed()
    numbers = [packed.add(comparison) for comparison in comparisons]
    lines = lines_of(comparisons)
    own = files("bldsimp.compare")
    text = Template(own.joinpath("page.html").read_text("utf-8")).substitute(
        title="bldsimp compare",
        most=f"{TRIANGLES:,}",
        subtitle=escape(subtitle(comparisons)),
        table=table(comparisons, numbers),
        charts="\n".join(chart(k, each, lines, numbers[k]) for k, each in enumerate(comparisons)),
        data=packed.json(),
        blobs=packed.html(),
        library=library,
        program=own.joinpath("page.js").read_text("utf-8"),
    )
    # Names of files need not be Unicode.
    return text.encode("utf-8", "replace")


def viewer_library() -> str:
    """three.js and its TrackballControls, with their licence, out of trimesh's viewer.

    Raises
    ------
    BldsimpError
    """
    packed = files("trimesh").joinpath("resources/templates/viewer.zip")
    if packed.is_file():
        with zipfile.ZipFile(io.BytesIO(packed.read_bytes())) as opened:
            template = opened.read("viewer.html.template").decode("utf-8")
        scripts = "\n".join(re.findall(r"<script[^>]*>(.*?)</script>", template, re.DOTALL))
        end = LIBRARY_ENDS.search(scripts)
        if end and "Three.js Authors" in scripts[: end.start()]:
            return scripts[: end.end()].strip()
    raise BldsimpError(
        "the installed trimesh does not ship three.js in the form that pages need: pip install 'trimesh==5.2.0'"
    )


@dataclass
class Packed:
    """Everything that the program on the page reads."""

    files: list[dict[str, Any]] = field(default_factory=list)
    surfaces: list[dict[str, Any]] = field(default_factory=list)
    rows: list[dict[str, Any]] = field(default_factory=list)
    blobs: dict[bytes, int] = field(default_factory=dict)

    def add(self, comparison: Comparison) -> dict[int, int]:
        """Pack what can be drawn of a comparison; numbers on the page by index of its rows."""
        original = comparison.original
        drawable = [k for k, row in enumerate(comparison.rows) if can_be_drawn(row, original)]
        if original is None or not drawable:
            self.files.append({})
            return {}
        pairs = Pairs(original, self)
        title = f"original · {PurePath(comparison.file).name}"
        self.files.append(
            {
                "caption": [title, *original_facts(comparison, original, pairs.drawn)],
                "original": pairs.number,
                "diagonal": float(np.linalg.norm(np.ptp(original.points, axis=0))),
                "up": "y" if PurePath(comparison.file).suffix.lower() in Y_UP else "z",
            }
        )
        numbers = {}
        for k in drawable:
            row = comparison.rows[k]
            pair = pairs.with_result(row.surface or original)
            numbers[k] = len(self.rows)
            self.rows.append(
                {
                    "file": len(self.files) - 1,
                    "surface": pair.number,
                    "tolerance": comparison.tolerances.get(row.tolerance, 0.0),
                    "deviation": row.deviation or 0.0,
                    "distances": [pair.there, pair.back],
                    "caption": [f"{row.method} · tolerance {row.tolerance}", *result_facts(row, pair.note)],
                }
            )
        return numbers

    def surface(self, shown: Drawn, origin: Points) -> int:
        """Pack a surface as it is drawn; its number."""
        self.surfaces.append(
            {
                "points": self.blob((shown.points - origin).astype("<f4")),
                "faces": self.blob(shown.faces.astype("<u4")),
                "parts": self.blob(shown.parts),
            }
        )
        return len(self.surfaces) - 1

    def distances(self, values: NDArray[np.float64]) -> dict[str, Any]:
        """Pack distances in shares of the greatest one."""
        top = float(values.max(initial=0.0))
        shares = np.rint(values * (STEPS / top)) if top > 0.0 else np.zeros(len(values))
        return {"blob": self.blob(shares.astype("<u2")), "top": top}

    def blob(self, array: NDArray[Any]) -> int:
        """Number of an array's bytes; equal ones are stored once."""
        return self.blobs.setdefault(zlib.compress(array.tobytes(), 6), len(self.blobs))

    def json(self) -> str:
        """For a script element, which ends at the first ``</script``, quoted or not."""
        text = json.dumps({"files": self.files, "surfaces": self.surfaces, "rows": self.rows}, allow_nan=False)
        return text.replace("<", "\\u003c")

    def html(self) -> str:
        """The arrays, one element each."""
        return "\n".join(
            f'<script type="application/octet-stream" id="blob-{number}">{base64.b64encode(data).decode()}</script>'
            for data, number in self.blobs.items()
        )


class Pair(NamedTuple):
    """Number of a result, distances from the original to it and back, and what to say of its drawing."""

    number: int
    there: dict[str, Any]
    back: dict[str, Any]
    note: str


class Pairs:
    """One original and its results, each different one drawn and measured once."""

    def __init__(self, original: Surface, packed: Packed) -> None:
        self.packed = packed
        self.origin: Points = (original.points.min(axis=0) + original.points.max(axis=0)) / 2.0
        self.original = original
        self.drawn = drawn(original)
        self.number = packed.surface(self.drawn, self.origin)
        self.samples = self.drawn.samples() - self.origin
        self.tree = _core.FaceTree(original.points - self.origin, original.faces)
        self.noise = noise(original.points - self.origin)
        none = packed.distances(np.zeros(len(self.samples)))
        self.done = {self.key(original): Pair(self.number, none, none, thinning(self.drawn, original))}

    @staticmethod
    def key(surface: Surface) -> bytes:
        """Equal for equal surfaces."""
        return sha256(surface.points.tobytes()).digest() + sha256(surface.faces.tobytes()).digest()

    def with_result(self, surface: Surface) -> Pair:
        """The original with one result."""
        key = self.key(surface)
        if key not in self.done:
            shown = drawn(surface)
            tree = _core.FaceTree(surface.points - self.origin, surface.faces)
            self.done[key] = Pair(
                self.packed.surface(shown, self.origin),
                self.packed.distances(self.clear(tree.distances(self.samples))),
                self.packed.distances(self.clear(self.tree.distances(shown.samples() - self.origin))),
                thinning(shown, surface),
            )
        return self.done[key]

    def clear(self, distances: NDArray[np.float64]) -> NDArray[np.float64]:
        """Distances without what rounding alone makes of none, as the figures are."""
        return np.maximum(distances - self.noise, 0.0)


def can_be_drawn(row: Row, original: Surface | None) -> bool:
    """Whether there is something to see on both sides."""
    surface = original if row.method == "original" else row.surface
    return original is not None and surface is not None and min(len(original.faces), len(surface.faces)) > 0


def thinning(shown: Drawn, surface: Surface) -> str:
    """What to say where not all is drawn."""
    if not shown.thinned:
        return ""
    return f"drawn with {len(shown.faces):,} of its {len(surface.faces):,} triangles"


def original_facts(comparison: Comparison, original: Surface, shown: Drawn) -> tuple[str, str]:
    """The lines below the left view."""
    own = next((row for row in comparison.rows if row.method == "original"), None)
    parts = [f"{len(original.points):,} points", f"{len(original.faces):,} triangles"]
    parts += closedness(own) if own else []
    more = [f"diagonal {comparison.diagonal:.6g}", thinning(shown, original)]
    return " · ".join(parts), " · ".join(part for part in more if part)


def result_facts(row: Row, note: str) -> tuple[str, str]:
    """The lines below the right view."""
    counts = (("points", row.points), ("triangles", row.triangles))
    parts = [f"{count:,} {name}" for name, count in counts if count is not None]
    if row.deviation is not None:
        certified = "" if row.bound is None else f" (certified: at most {row.bound:.3g})"
        parts.append(f"deviation {row.deviation:.3g}{certified}")
    more = closedness(row)
    if row.border_made:
        more.append(f"{row.border_made:,} border edges made")
    if row.seconds is not None:
        more.append(f"{row.seconds:.2f} s")
    return " · ".join(parts), " · ".join(part for part in (*more, row.note, note) if part)


def closedness(row: Row) -> list[str]:
    """Whether a surface is closed, where that is known."""
    return [] if row.watertight is None else ["watertight" if row.watertight else "open"]


def chart(k: int, comparison: Comparison, lines: dict[str, Line], numbers: dict[int, int]) -> str:
    """The chart of one file; the first one's is shown at first."""
    title = f"<figcaption>Points against tolerance, {escape(PurePath(comparison.file).name)}</figcaption>"
    drawing = chart_svg(comparison, lines, numbers)
    hidden = " hidden" if k else ""
    return f'<figure class="chart sheet" data-file="{k}"{hidden}>{title}{drawing}</figure>' if drawing else ""


def subtitle(comparisons: Sequence[Comparison]) -> str:
    """How much there is on the page."""
    tolerances = dict.fromkeys(written for each in comparisons for written in each.tolerances)
    methods = dict.fromkeys(row.method for each in comparisons for row in each.rows if row.method)
    counts = ((len(comparisons), "file", "s"), (len(tolerances), "tolerance", "s"), (len(methods), "method", "s"))
    return ", ".join(f"{count} {name}{end if count != 1 else ''}" for count, name, end in counts)


def table(comparisons: Sequence[Comparison], numbers: Sequence[dict[int, int]]) -> str:
    """All rows, by file and tolerance."""
    heads = "".join(f'<th scope="col" title="{tip}">{name}</th>' for _, name, tip in COLUMNS)
    parts = [f"<table><thead><tr>{heads}</tr></thead>"]
    first = first_shown(comparisons, numbers)
    for comparison, known in zip(comparisons, numbers, strict=True):
        base = next((row.points for row in comparison.rows if row.method == "original"), None)
        before = None
        for k, row in enumerate(comparison.rows):
            if row.tolerance != before:
                parts += ["</tbody>" if before is not None else "", "<tbody>", heading(comparison, row.tolerance)]
                before = row.tolerance
            parts.append(table_row(row, base, known.get(k), first))
        parts.append("</tbody>" if before is not None else "")
    return "\n".join([*filter(None, parts), "</table>"])


def first_shown(comparisons: Sequence[Comparison], numbers: Sequence[dict[int, int]]) -> int:
    """Number of the row that is shown at first: what bldsimp made, where there is that."""
    shown = [
        (row.method != "improved", known[k])
        for each, known in zip(comparisons, numbers, strict=True)
        for k, row in enumerate(each.rows)
        if k in known
    ]
    return min(shown, default=(True, -1))[1]


def heading(comparison: Comparison, tolerance: str) -> str:
    """The line above the rows of one file and tolerance."""
    value = comparison.tolerances.get(tolerance)
    text = "" if value is None else f" <span>tolerance {escape(tolerance)} = {value:.3g} model units</span>"
    return f'<tr><th scope="rowgroup" colspan="{len(COLUMNS)}">{escape(comparison.file)}{text}</th></tr>'


def table_row(row: Row, base: int | None, number: int | None, first: int) -> str:
    """One row; with a number it can be chosen."""
    values = [cell(row, base, key) for key, _, _ in COLUMNS[1:]]
    name = f'<span class="plain">{escape(row.method)}</span>'
    note = f'<div class="note">{escape(row.note)}</div>' if row.note else ""
    chosen = ""
    if number is not None:
        name = f'<label><input type="radio" name="row">{escape(row.method)}</label>'
        chosen = f' data-row="{number}"' + (" data-first" if number == first else "")
    cells = "".join(f"<td>{value}</td>" for value in values)
    return f"<tr{chosen}><td>{name}{note}</td>{cells}</tr>"


def cell(row: Row, base: int | None, key: str) -> str:
    """One figure; what is worse than in the original is marked."""
    if key == "share":
        return f"{100.0 * row.points / base:.1f} %" if row.points is not None and base else ""
    value = getattr(row, key)
    if value is None:
        return ""
    if key == "watertight":
        return "yes" if value else "no"
    if key == "border_made":
        return f'<span class="bad">{value:,}</span>' if value else "0"
    if key == "seconds":
        return f"{value:.2f}"
    return f"{value:,}" if key in ("points", "triangles") else f"{value:.3g}"
