"""Points against tolerance, a panel per building and a line per method; needs the extra ``plots``.

Lines differ in marker and dashes as well as in colour (the palette of Okabe and Ito, which the
colour-blind can tell apart), so that they can be read in grey print too.
"""

from __future__ import annotations

import io
import math
import re
import textwrap
import warnings
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import UsageError
from ..display import sanitize_line
from .comparison import SAME_POINTS
from .row import Comparison, Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SUFFIXES = (".svg", ".png")
"""What a chart can be written as."""

LOG_RATIO = 5.0
"""Counts that differ by more than this factor are drawn on a log scale, else from 0."""

COLUMNS_AT_MOST = 3
PANEL = (4.6, 3.6)
"""Width and height of a panel, inches."""

TITLE_LETTERS = 34
"""A panel has room for so many; of a longer name the middle is left out."""

DOTS_PER_INCH = 200


@dataclass(frozen=True)
class Line:
    """How a method is drawn."""

    colour: str
    marker: str
    dashes: Any
    width: float = 1.4
    above: int = 2


LINES = {
    "original": Line("#666666", "", (0, (1, 1.5))),
    "standard": Line("#D55E00", "s", (0, (5, 2))),
    "improved": Line("#0072B2", "o", "solid", 2.2, 5),
    "fast-simplification": Line("#009E73", "^", (0, (4, 1.5, 1, 1.5))),
    "fast-simplification border": Line("#CC79A7", "v", (0, (1.5, 1.2))),
    "fast-simplification lossless": Line("#E69F00", "D", (0, (7, 1.5, 1, 1.5, 1, 1.5))),
}
OTHERS = (
    Line("#56B4E9", "P", (0, (3, 1))),
    Line("#000000", "X", (0, (2, 2))),
    Line("#56B4E9", "<", (0, (6, 3))),
    Line("#000000", "*", (0, (1, 2))),
)
"""For peers, in the order in which they occur."""

RC: Any = {
    # Without a salt of its own, each SVG would name its parts anew.
    "svg.hashsalt": "bldsimp",
    "svg.fonttype": "path",
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "legend.fontsize": 8.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
}


def write_plot(comparisons: Sequence[Comparison], suffix: str) -> bytes:
    """Draw how many points each method keeps at each tolerance.

    Parameters
    ----------
    comparisons : sequence of Comparison
        A panel each. One that failed shows its reason.
    suffix : str
        ``.svg`` or ``.png``.

    Returns
    -------
    bytes
        The file; the same rows give the same bytes, whatever the user's own matplotlib settings are.

    Raises
    ------
    UsageError
        If the suffix is another one, or matplotlib is not installed.

    Notes
    -----
    Tolerances are drawn in percent of the diagonal on a log scale, so that models of any size compare;
    what was not given in percent (``auto``, lengths, 0) is named where it lies. Rows without a
    count are left out of their line and named below the panels.
    """
    check_plot(suffix)
    import matplotlib

    with matplotlib.rc_context(), warnings.catch_warnings():
        # A name in a script that the font lacks shows as boxes, which need no words.
        warnings.filterwarnings("ignore", r"Glyph \d+")
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(RC)
        return saved(chart(comparisons), suffix.lower().removeprefix("."))


def check_plot(suffix: str) -> None:
    """Raise what `write_plot` would raise before there are any rows.

    Raises
    ------
    UsageError
    """
    if suffix.lower() not in SUFFIXES:
        raise UsageError(f"a chart cannot be written as '{suffix}': use {' or '.join(SUFFIXES)}")
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError as error:
        raise UsageError("charts need matplotlib: pip install matplotlib") from error


def saved(figure: Figure, kind: str) -> bytes:
    """The figure as a file, without the date and the versions that matplotlib would put in."""
    unnamed = {"svg": {"Date": None, "Creator": None}, "png": {"Software": None}}
    stream = io.BytesIO()
    figure.savefig(stream, format=kind, dpi=DOTS_PER_INCH, metadata=unnamed[kind])
    return stream.getvalue()


def chart(comparisons: Sequence[Comparison]) -> Figure:
    """All panels, with one legend and the list of what is not drawn below them."""
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    lines = lines_of(comparisons)
    columns = min(max(len(comparisons), 1), COLUMNS_AT_MOST)
    rows = max(-(-len(comparisons) // columns), 1)
    width = round(columns * PANEL[0] * 14)
    words = "\n".join(textwrap.fill(verbatim(text), width) for text in remarks(comparisons))
    legend_columns = min(len(lines), 1 + columns)
    legend_rows = -(-len(lines) // legend_columns) if lines else 0
    below = 0.25 + 0.19 * legend_rows + 0.13 * len(words.splitlines())
    height = rows * PANEL[1] + below
    layout = ConstrainedLayoutEngine(rect=(0.0, below / height, 1.0, 1.0 - below / height))
    figure = Figure(figsize=(columns * PANEL[0], height), layout=layout)
    handles, names = {}, names_of(comparisons)
    for k, comparison in enumerate(comparisons):
        axes = figure.add_subplot(rows, columns, k + 1)
        axes.set_title(verbatim(shortened(names[comparison.file])), loc="left", weight="bold")
        handles.update(draw(axes, comparison, lines))
    if handles:
        ordered = [name for name in lines if name in handles]
        figure.legend(
            [handles[name] for name in ordered],
            ordered,
            loc="upper center",
            bbox_to_anchor=(0.5, below / height),
            ncols=legend_columns,
            frameon=False,
            handlelength=4.0,
        )
    if words:
        figure.text(0.015, 0.05 / height, words, fontsize=7.5, color="#444444", va="bottom")
    return figure


def lines_of(comparisons: Sequence[Comparison]) -> dict[str, Line]:
    """How each method with a count is drawn, in the order in which methods occur."""
    methods = dict.fromkeys(row.method for each in comparisons for row in each.rows if drawable(row))
    peers = [method for method in methods if method not in LINES]
    others = {method: OTHERS[k % len(OTHERS)] for k, method in enumerate(peers)}
    return {method: LINES.get(method) or others[method] for method in methods}


def drawable(row: Row) -> bool:
    """Whether a row has its place in the chart; as many points as `improved` would tell nothing."""
    return row.points is not None and row.points > 0 and row.method != SAME_POINTS


def remarks(comparisons: Sequence[Comparison]) -> list[str]:
    """What a reader must know: what lines mean, which points are lacking and why, what is not to scale."""
    lines = [f"{note}: {', '.join(methods)}" for note, methods in meanings(comparisons).items()]
    for place, methods in lacking(comparisons).items():
        lines.append(f"not drawn: {', '.join(methods)}; {place}")
    if any(row.method == SAME_POINTS for each in comparisons for row in each.rows):
        lines.append(f"not drawn: {SAME_POINTS} (as many points as improved, by its definition)")
    if any(value == 0.0 for each in comparisons for value in each.tolerances.values()):
        lines.append("0 has no place on a log scale: it stands a decade below the least other tolerance")
    return lines


def meanings(comparisons: Sequence[Comparison]) -> dict[str, list[str]]:
    """Notes that all drawn points of a method share, and the methods."""
    notes: dict[str, set[str]] = {}
    for each in comparisons:
        for row in filter(drawable, each.rows):
            notes.setdefault(row.method, set()).add(gist(row.note))
    shared: dict[str, list[str]] = {}
    for method, own in notes.items():
        if len(own) == 1 and own != {""}:
            shared.setdefault(own.pop(), []).append(method)
    return shared


def lacking(comparisons: Sequence[Comparison]) -> dict[str, list[str]]:
    """Where and why points are lacking, in words, and of which methods."""
    names = names_of(comparisons)
    found: dict[tuple[str, str], dict[str, list[str]]] = {}
    for each in comparisons:
        for row in each.rows:
            if each.original is not None and not drawable(row) and row.method != SAME_POINTS:
                files = found.setdefault((row.method, gist(row.note)), {})
                files.setdefault(names[each.file], []).append(row.tolerance)
    methods: dict[str, list[str]] = {}
    for (method, note), files in found.items():
        places = "; ".join(f"{name} at {', '.join(written)}" for name, written in files.items())
        methods.setdefault(places + (f": {note}" if note else ""), []).append(method)
    return methods


def names_of(comparisons: Sequence[Comparison]) -> dict[str, str]:
    """What each file is called: its name alone where no other file has the same one."""
    names = {each.file: Path(each.file).name for each in comparisons}
    taken = Counter(names.values())
    return {file: name if taken[name] == 1 else file for file, name in names.items()}


def shortened(name: str) -> str:
    """A name that a panel has room for."""
    half = TITLE_LETTERS // 2
    return name if len(name) <= TITLE_LETTERS else f"{name[: half - 1]}…{name[-half:]}"


def verbatim(text: str) -> str:
    """Words of unknown origin as matplotlib shows them as they are: no formulas, no control characters."""
    return sanitize_line(text).replace("$", r"\$")


def gist(note: str) -> str:
    """A note without its figures, which stand in brackets at its end and differ from row to row."""
    return re.sub(r"\s*\([^()]*\)$", "", note)


def draw(axes: Axes, comparison: Comparison, lines: dict[str, Line]) -> dict[str, Any]:
    """One panel; returns what the legend shows of each method."""
    rows = [row for row in comparison.rows if drawable(row)]
    if not rows:
        say_why(axes, comparison)
        return {}
    position = positions(comparison)
    handles = {}
    for method, line in lines.items():
        own = sorted((position[row.tolerance], row.points) for row in rows if row.method == method)
        if not own:
            continue
        x, y = zip(*own, strict=True)
        (handles[method],) = axes.plot(
            x,
            y,
            color=line.colour,
            linestyle=line.dashes,
            linewidth=line.width,
            # A line of one point would not be seen without one.
            marker=line.marker or ("_" if len(x) == 1 else ""),
            markersize=5.5,
            # Open markers show what lies below them, where methods agree.
            markerfacecolor=line.colour if method == "improved" else "none",
            zorder=line.above,
        )
        if method == "improved":
            tell(axes, x, y)
    axes.set_xscale("log")
    axes.margins(x=0.08)
    axes.set_xlabel(f"tolerance, % of the diagonal ({comparison.diagonal:.6g} model units)")
    axes.xaxis.set_major_formatter(percent_text)
    axes.set_ylabel("points")
    scale_counts(axes, [row.points for row in rows if row.points is not None])
    name_places(axes, comparison)
    axes.grid(True, which="major", color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    return handles


def positions(comparison: Comparison) -> dict[str, float]:
    """Where each tolerance stands, percent of the diagonal; 0 a decade below the least other one."""
    whole = comparison.diagonal or 100.0
    percent = {written: 100.0 * (value / whole) for written, value in comparison.tolerances.items()}
    least = min((value for value in percent.values() if value > 0.0), default=1.0)
    return {written: value or least / 10.0 for written, value in percent.items()}


def scale_counts(axes: Axes, counts: list[int]) -> None:
    """A log scale where counts differ by much, else one from 0."""
    from matplotlib.ticker import LogLocator, NullFormatter

    if max(counts) > LOG_RATIO * min(counts):
        axes.set_yscale("log")
        # Room for a number below the lowest point and a name above the highest.
        axes.set_ylim(min(counts) / 1.6, max(counts) * 1.6)
        axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.yaxis.set_minor_formatter(NullFormatter())
    else:
        axes.set_ylim(0.0, max(counts) * 1.15)
    axes.yaxis.set_major_formatter(count_text)


def name_places(axes: Axes, comparison: Comparison) -> None:
    """Mark tolerances that were not written as a percentage, as they were written."""
    for written, place in positions(comparison).items():
        value = comparison.tolerances[written]
        if written.strip().endswith("%") and value > 0.0:
            continue
        axes.axvline(place, color="#888888", linewidth=0.8, zorder=1)
        axes.annotate(
            written.strip(),
            (place, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(3, -1),
            textcoords="offset points",
            va="top",
            fontsize=8,
            color="#333333",
        )


def tell(axes: Axes, x: Sequence[float], y: Sequence[int]) -> None:
    """Write the counts below the points of a line; to the right of those that it comes up to."""
    for k, (place, count) in enumerate(zip(x, y, strict=True)):
        rises = k > 0 and count > y[k - 1]
        axes.annotate(
            f"{count:,}",
            (place, count),
            xytext=(5 if rises else 0, -6),
            textcoords="offset points",
            ha="left" if rises else "center",
            va="top",
            fontsize=7.5,
            color=LINES["improved"].colour,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.4, "alpha": 0.8},
            # Above the names of tolerances, below every line.
            zorder=1.5,
        )


def say_why(axes: Axes, comparison: Comparison) -> None:
    """A panel without a chart: the reason, in words."""
    reasons = dict.fromkeys(row.note for row in comparison.rows if row.note)
    text = textwrap.fill(verbatim("; ".join(reasons)) or "no figures", 48)
    axes.text(0.5, 0.5, text, ha="center", va="center", transform=axes.transAxes, color="#444444")
    axes.set_axis_off()


def count_text(value: float, _: Any = None) -> str:
    """A count with its thousands apart."""
    return f"{value:,.0f}"


def percent_text(value: float, _: Any = None) -> str:
    """A percentage without needless zeros; small ones as powers of ten."""
    if value <= 0.0:
        return ""
    if value < 0.9e-4:
        exponent = round(math.log10(value))
        return f"$10^{{{exponent}}}$" if math.isclose(value, 10.0**exponent) else ""
    return f"{value:g}"
