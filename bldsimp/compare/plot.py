"""Draw points against tolerance: a panel per building, a line per method.

Lines differ in mark and dashes as well as in color (the palette of Okabe and Ito, which
color-blind people can tell apart), so gray prints can be read too.
"""

from __future__ import annotations

import math
import re
import textwrap
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path as FilePath

from ..display import sanitize_line
from ..errors import UsageError
from .drawing import Drawing, Path, Shape, ShapeGroup, Text, format_svg, measure_words, render_png
from .rows import SAME_POINTS, Comparison, MethodRow

SUFFIXES = (".svg", ".png")
"""Formats of a chart."""

LOG_RATIO = 5.0
"""Counts that differ by more than this factor are drawn on a log scale, else from 0."""

MOST_TICKS = 6
"""Level lines of a scale from 0."""

COLUMNS_AT_MOST = 3
PANEL_WIDTH, PANEL_HEIGHT = 420.0, 330.0
LEFT, RIGHT, TOP, BOTTOM = 58.0, 16.0, 46.0, 62.0
"""Margins of a panel, around its curves."""

TITLE_LETTERS = 42
"""Greatest length of a title; a longer name loses its middle."""

LONE = 8.0
"""Half the length of a line without marks at a single tolerance."""

INK, GRID, RULE = "#1d2733", "#e6eaee", "#9aa5b1"

Outline = tuple[tuple[float, float], ...]
Spot = tuple[float, float, int]
"""Place in a panel, and index of the row."""


def outline(corners: int, turn: float = 0.0, radii: tuple[float, ...] = (5.5,)) -> Outline:
    """Return a regular polygon, turned by degrees; with two radii, every second corner is nearer to the middle."""
    angles = [math.radians(turn - 90.0 + 360.0 * k / corners) for k in range(corners)]
    radius = [radii[k % len(radii)] for k in range(corners)]
    return tuple((r * math.cos(angle), r * math.sin(angle)) for r, angle in zip(radius, angles, strict=True))


@dataclass(frozen=True)
class LineStyle:
    """How a method is drawn; dashes are in units of the width."""

    color: str
    mark: Outline
    dashes: tuple[float, ...]
    width: float = 1.6
    filled: bool = False
    """Other marks are open: they show what lies below them, where methods agree."""


LINES = {
    "original": LineStyle("#666666", (), (1, 1.5)),
    "standard": LineStyle("#D55E00", outline(4, 45, (6,)), (5, 2)),
    "improved": LineStyle("#0072B2", outline(24, radii=(4.2,)), (), 2.4, filled=True),
    "fast-simplification": LineStyle("#009E73", outline(3), (4, 1.5, 1, 1.5)),
    "fast-simplification border": LineStyle("#CC79A7", outline(3, 180), (1.5, 1.2)),
    "fast-simplification lossless": LineStyle("#E69F00", outline(4), (7, 1.5, 1, 1.5, 1, 1.5)),
}
OTHERS = (
    LineStyle("#56B4E9", outline(8, 0, (6, 2)), (3, 1)),
    LineStyle("#000000", outline(8, 45, (6, 2)), (2, 2)),
    LineStyle("#56B4E9", outline(3, 270), (6, 3)),
    LineStyle("#000000", outline(10, 0, (6, 2.5)), (1, 2)),
)
"""For peers, in the order in which they occur."""


@dataclass(frozen=True)
class Axis:
    """Maps numbers to places; on a log scale if `log`."""

    low: float
    high: float
    start: float
    end: float
    log: bool

    def __call__(self, value: float) -> float:
        """Return the place of a number."""
        low, high, value = (math.log10(v) if self.log else v for v in (self.low, self.high, value))
        share = (value - low) / (high - low) if high > low else 0.5
        return round(self.start + share * (self.end - self.start), 1)


def draw_plot(comparisons: Sequence[Comparison], suffix: str) -> bytes:
    """Draw the number of points that each method keeps at each tolerance.

    Parameters
    ----------
    comparisons : sequence of Comparison
        A panel each. One that failed shows its reason.
    suffix : str
        ``.svg`` or ``.png``.

    Returns
    -------
    bytes
        The file; the same rows give the same bytes.

    Raises
    ------
    UsageError
        If the suffix is another one, or PNG is wanted and matplotlib is not installed.

    Notes
    -----
    Tolerances are drawn in percent of the diagonal on a log scale, so that models of any size compare. Rows
    without a count are left out of their line and named below the panels.
    """
    check_plot(suffix)
    drawing = draw_chart(comparisons, list_lines(comparisons), write_remarks(comparisons))
    if suffix.lower() == ".png":
        return render_png(drawing)
    return (format_svg(drawing, "Points against tolerance") + "\n").encode()


def check_plot(suffix: str) -> None:
    """Raise errors of `draw_plot` early, before there are any rows.

    Raises
    ------
    UsageError
    """
    if suffix.lower() not in SUFFIXES:
        raise UsageError(f"a chart cannot be written as '{suffix}': use {' or '.join(SUFFIXES)}")
    if suffix.lower() == ".png" and find_spec("matplotlib") is None:
        raise UsageError("a chart as PNG needs matplotlib: pip install matplotlib, or write .svg")


def draw_chart(
    comparisons: Sequence[Comparison],
    lines: Mapping[str, LineStyle],
    remarks: Sequence[str] = (),
    numbers: Sequence[Mapping[int, int]] | None = None,
) -> Drawing:
    """Draw a panel for each comparison, with one legend and remarks below them.

    Parameters
    ----------
    comparisons : sequence of Comparison
    lines : mapping of str to LineStyle
        How methods are drawn; those without a point here are left out of the legend.
    remarks : sequence of str
    numbers : sequence of mapping of int to int, optional
        For each comparison the number on a page of each of its rows that can be chosen, by the row's index.
    """
    columns = min(max(len(comparisons), 1), COLUMNS_AT_MOST)
    width, height = columns * PANEL_WIDTH, PANEL_HEIGHT * max(-(-len(comparisons) // columns), 1)
    names = name_files(comparisons)
    shapes: list[Shape] = []
    for k, comparison in enumerate(comparisons):
        row, column = divmod(k, columns)
        panel = draw_panel(comparison, lines, names[comparison.file], numbers[k] if numbers else {})
        shapes.append(ShapeGroup(column * PANEL_WIDTH, row * PANEL_HEIGHT, panel))
    drawn = {row.method for each in comparisons for row in list_drawable(each).values()}
    x, y = 0.0, height + 12.0
    for method in (method for method in lines if method in drawn):
        room = 62.0 + measure_words(method, 12.0)
        if x and x + room > width:
            x, y = 0.0, y + 20.0
        shapes.append(ShapeGroup(16.0 + x, y, draw_entry(method, lines[method])))
        x += room
    y += 22.0
    letters = int(width / measure_words(" ", 10.0)) - 4
    for line in (line for text in remarks for line in textwrap.wrap(sanitize_line(text), letters)):
        shapes.append(Text(12.0, y, line, 10.0))
        y += 13.0
    return Drawing(width, y, shapes)


def draw_entry(method: str, line: LineStyle) -> list[Shape]:
    """Draw the entry of a method in the legend."""
    return [
        Path(((0.0, -4.0), (34.0, -4.0)), line.color, line.width, line.dashes),
        ShapeGroup(17.0, -4.0, draw_mark(line)),
        Text(40.0, 0.0, method),
    ]


def draw_mark(line: LineStyle) -> list[Shape]:
    """Draw the mark of a line about its place; nothing where it has none."""
    return [Path(line.mark, line.color, 1.4, (), line.color if line.filled else "#fff")] if line.mark else []


def draw_panel(
    comparison: Comparison, lines: Mapping[str, LineStyle], title: str, numbers: Mapping[int, int]
) -> list[Shape]:
    """Draw the curves of one comparison, or the reason why there are none."""
    half = TITLE_LETTERS // 2
    short = title if len(title) <= TITLE_LETTERS else f"{title[: half - 1]}…{title[-half:]}"
    shapes: list[Shape] = [Text(12.0, 20.0, short, 13.0, INK, weight="bold")]
    rows = list_drawable(comparison)
    if not rows:
        reasons = "; ".join(dict.fromkeys(row.note for row in comparison.rows if row.note)) or "no figures"
        for k, text in enumerate(textwrap.wrap(sanitize_line(reasons), 48)):
            shapes.append(Text(PANEL_WIDTH / 2, PANEL_HEIGHT / 2 + 16.0 * k, text, anchor="middle"))
        return shapes
    place = place_tolerances(comparison)
    x = Axis(min(place.values()), max(place.values()), LEFT + 14.0, PANEL_WIDTH - RIGHT - 14.0, True)
    y = choose_count_axis([row.points or 0 for row in rows.values()])
    shapes += [*draw_levels(y), *draw_tolerances(x, place, comparison)]
    curves: list[Shape] = []
    # The filled line is the last, above all others.
    for method, line in sorted(lines.items(), key=lambda item: item[1].filled):
        own = sorted((place[row.tolerance], k) for k, row in rows.items() if row.method == method)
        spots = [(x(at), y(rows[k].points or 0), k) for at, k in own]
        curves += draw_curve(spots, line, rows, numbers)
        if line.filled:
            shapes += write_counts(spots, line, rows)
    return shapes + curves


def list_drawable(comparison: Comparison) -> dict[int, MethodRow]:
    """Return the rows that have their place in a panel, by index."""
    known = comparison.tolerances
    return {k: row for k, row in enumerate(comparison.rows) if is_drawable(row) and row.tolerance in known}


def place_tolerances(comparison: Comparison) -> dict[str, float]:
    """Return each tolerance in percent of the diagonal; 0 a decade below the least other one."""
    whole = comparison.diagonal or 100.0
    percent = {written: 100.0 * (value / whole) for written, value in comparison.tolerances.items()}
    least = min((value for value in percent.values() if value > 0.0), default=1.0)
    return {written: value or least / 10.0 for written, value in percent.items()}


def choose_count_axis(counts: Sequence[int]) -> Axis:
    """Choose a log scale where counts differ by much, else one from 0."""
    log = max(counts) > LOG_RATIO * min(counts)
    low, high = (min(counts) / 1.9, max(counts) * 1.2) if log else (0.0, max(counts) * 1.1)
    return Axis(low, high, PANEL_HEIGHT - BOTTOM, TOP, log)


def choose_ticks(axis: Axis) -> Sequence[float]:
    """Choose round numbers within an axis of counts: 1, 2, 5 times powers of ten, or even steps from 0."""
    if axis.log:
        lowest, highest = math.floor(math.log10(axis.low)), math.ceil(math.log10(axis.high))
        found = [m * 10.0**e for e in range(lowest, highest + 1) for m in (1, 2, 5)]
        return [value for value in found if axis.low <= value <= axis.high]
    step = 10.0 ** math.floor(math.log10(axis.high))
    step *= next(part for part in (0.1, 0.2, 0.5, 1.0, 2.0) if axis.high / (part * step) <= MOST_TICKS)
    return [k * step for k in range(int(axis.high / step) + 1)]


def draw_levels(y: Axis) -> Iterator[Shape]:
    """Draw level lines with their counts."""
    yield Text(12.0, TOP - 6.0, "points")
    for value in choose_ticks(y):
        yield Path(((LEFT, y(value)), (PANEL_WIDTH - RIGHT, y(value))), GRID)
        # The word above stands where the highest count might be.
        if y(value) > TOP + 8.0:
            yield Text(LEFT - 6.0, y(value) + 4.0, f"{value:,.0f}", anchor="end")


def draw_tolerances(x: Axis, place: Mapping[str, float], comparison: Comparison) -> Iterator[Shape]:
    """Draw the lower axis: each tolerance where it lies, as the user wrote it, and in percent."""
    low = PANEL_HEIGHT - BOTTOM
    yield Path(((LEFT, low), (PANEL_WIDTH - RIGHT, low)), RULE)
    ends = [-math.inf, -math.inf]
    for written, at in sorted(place.items(), key=lambda item: item[1]):
        words = written.strip()
        if not words.endswith("%") and comparison.tolerances[written] > 0.0:
            words += f" = {at:.2g}%"
        # Words that would touch the ones before stand in the second row.
        half = measure_words(words, 12.0) / 2
        middle = min(x(at), PANEL_WIDTH - 4.0 - half)
        row = 0 if middle - half >= ends[0] else 1
        ends[row] = middle + half + measure_words(" ", 12.0)
        yield Path(((x(at), low), (x(at), low + 5.0)), RULE)
        yield Text(middle, low + 18.0 + 14.0 * row, words, anchor="middle")
    words = f"tolerance, log scale; diagonal {comparison.diagonal:.6g} model units"
    yield Text(PANEL_WIDTH - RIGHT, PANEL_HEIGHT - 12.0, words, anchor="end")


def draw_curve(
    spots: Sequence[Spot], line: LineStyle, rows: Mapping[int, MethodRow], numbers: Mapping[int, int]
) -> Iterator[Shape]:
    """Draw one line through its places, with a mark at each."""
    track = [spot[:2] for spot in spots]
    if len(track) == 1 and not line.mark:
        # Neither a line nor a mark would be seen.
        ((x, y),) = track
        track = [(x - LONE, y), (x + LONE, y)]
    if len(track) > 1:
        yield Path(track, line.color, line.width, line.dashes)
    for x, y, k in spots:
        title = f"{rows[k].method} at {rows[k].tolerance}: {rows[k].points:,} points"
        yield ShapeGroup(x, y, draw_mark(line), title, numbers.get(k))


def write_counts(spots: Sequence[Spot], line: LineStyle, rows: Mapping[int, MethodRow]) -> Iterator[Shape]:
    """Write counts below the places of a line; to the right of those that it rises to."""
    before = math.inf
    for x, y, k in spots:
        aside, anchor = (5.0, "start") if y < before < math.inf else (0.0, "middle")
        yield Text(x + aside, y + 18.0, f"{rows[k].points:,}", 10.0, line.color, anchor, halo=True)
        before = y


def list_lines(comparisons: Sequence[Comparison]) -> dict[str, LineStyle]:
    """Choose the line of each method that has a count, in the order in which methods occur."""
    methods = dict.fromkeys(row.method for each in comparisons for row in each.rows if is_drawable(row))
    peers = [method for method in methods if method not in LINES]
    others = {method: OTHERS[k % len(OTHERS)] for k, method in enumerate(peers)}
    return {method: LINES.get(method) or others[method] for method in methods}


def is_drawable(row: MethodRow) -> bool:
    """Return whether a row has its place in the chart; as many points as `improved` would say nothing."""
    return row.points is not None and row.points > 0 and row.method != SAME_POINTS


def write_remarks(comparisons: Sequence[Comparison]) -> list[str]:
    """Write remarks: the meaning of lines, the points that are missing and why, and the place of 0."""
    lines = [f"{note}: {', '.join(methods)}" for note, methods in find_shared_notes(comparisons).items()]
    for place, methods in find_missing(comparisons).items():
        lines.append(f"not drawn: {', '.join(methods)}; {place}")
    if any(row.method == SAME_POINTS for each in comparisons for row in each.rows):
        lines.append(f"not drawn: {SAME_POINTS} (as many points as improved, by its definition)")
    if any(value == 0.0 for each in comparisons for value in each.tolerances.values()):
        lines.append("0 has no place on a log scale: it stands a decade below the least other tolerance")
    return lines


def find_shared_notes(comparisons: Sequence[Comparison]) -> dict[str, list[str]]:
    """Find the notes that all drawn points of a method share, and the methods."""
    notes: dict[str, set[str]] = {}
    for each in comparisons:
        for row in filter(is_drawable, each.rows):
            notes.setdefault(row.method, set()).add(strip_figures(row.note))
    shared: dict[str, list[str]] = {}
    for method, own in notes.items():
        if len(own) == 1 and own != {""}:
            shared.setdefault(own.pop(), []).append(method)
    return shared


def find_missing(comparisons: Sequence[Comparison]) -> dict[str, list[str]]:
    """Find where and why points are missing, in words, and of which methods."""
    names = name_files(comparisons)
    found: dict[tuple[str, str], dict[str, list[str]]] = {}
    for each in comparisons:
        for row in each.rows:
            if each.original is not None and not is_drawable(row) and row.method != SAME_POINTS:
                files = found.setdefault((row.method, strip_figures(row.note)), {})
                files.setdefault(names[each.file], []).append(row.tolerance)
    methods: dict[str, list[str]] = {}
    for (method, note), files in found.items():
        places = "; ".join(f"{name} at {', '.join(written)}" for name, written in files.items())
        methods.setdefault(places + (f": {note}" if note else ""), []).append(method)
    return methods


def name_files(comparisons: Sequence[Comparison]) -> dict[str, str]:
    """Name each file: by its last part alone where no other file has the same one."""
    names = {each.file: FilePath(each.file).name for each in comparisons}
    taken = Counter(names.values())
    return {file: name if taken[name] == 1 else file for file, name in names.items()}


def strip_figures(note: str) -> str:
    """Drop the figures of a note, which stand in brackets at its end and differ from row to row."""
    return re.sub(r"\s*\([^()]*\)$", "", note)
