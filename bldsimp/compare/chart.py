"""The chart of a page: `plot` in small, as SVG whose marks can be clicked; needs no plotting library."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape

from .plot import LOG_RATIO, Line, drawable, positions
from .row import Comparison, Row

WIDTH, HEIGHT = 460, 330
LEFT, RIGHT, TOP, BOTTOM = 58, 20, 14, 46
"""Margins."""

LABEL_APART = 40
"""Names of tolerances that are nearer than this to each other stand in two rows."""

LONE = 8
"""Half the length of a line without marks at a single tolerance."""

MARKS = {
    "s": "M-4-4h8v8h-8z",
    "o": "M-4.5 0a4.5 4.5 0 1 0 9 0a4.5 4.5 0 1 0-9 0z",
    "^": "M0-5L5 4H-5z",
    "v": "M0 5L5-4H-5z",
    "<": "M-5 0L4-5V5z",
    "D": "M0-5.5L5.5 0L0 5.5L-5.5 0z",
    "P": "M-1.7-5h3.4v3.3h3.3v3.4h-3.3v3.3h-3.4v-3.3h-3.3v-3.4h3.3z",
    "X": "M-3.5-5L0-2L3.5-5L5-3.5L2 0L5 3.5L3.5 5L0 2L-3.5 5L-5 3.5L-2 0L-5-3.5z",
    "*": "M0-6L1.5-2L5.7-1.9L2.4.8L3.5 4.9L0 2.5L-3.5 4.9L-2.4.8L-5.7-1.9L-1.5-2z",
}
"""Outlines of matplotlib's markers."""


@dataclass(frozen=True)
class Axis:
    """Numbers to places; on a log scale if `log`."""

    low: float
    high: float
    start: float
    end: float
    log: bool

    def __call__(self, value: float) -> float:
        low, high, value = (math.log10(v) if self.log else v for v in (self.low, self.high, value))
        share = (value - low) / (high - low) if high > low else 0.5
        return round(self.start + share * (self.end - self.start), 1)


def chart_svg(comparison: Comparison, lines: Mapping[str, Line], numbers: Mapping[int, int]) -> str:
    """Points against tolerance for one file.

    Parameters
    ----------
    comparison : Comparison
    lines : mapping of str to Line
        How methods are drawn; those that have no row here are left out.
    numbers : mapping of int to int
        Number on the page of each of the comparison's rows that can be chosen.

    Returns
    -------
    str
        SVG and a list of what the lines mean, or nothing where no row has a count.
    """
    known = comparison.tolerances
    rows = [(k, row) for k, row in enumerate(comparison.rows) if drawable(row) and row.tolerance in known]
    if not rows:
        return ""
    place = positions(comparison)
    counts = [row.points or 0 for _, row in rows]
    log = max(counts) > LOG_RATIO * min(counts)
    x = Axis(min(place.values()), max(place.values()), LEFT + 14, WIDTH - RIGHT - 14, True)
    y = Axis(min(counts) / 1.3 if log else 0.0, max(counts) * (1.3 if log else 1.1), HEIGHT - BOTTOM, TOP, log)
    parts = [*_grid(y, ticks(y)), *_tolerances(x, place)]
    used = [method for method in lines if any(row.method == method for _, row in rows)]
    for method in sorted(used, key=lambda name: lines[name].above):
        own = sorted((place[row.tolerance], k) for k, row in rows if row.method == method)
        spots = [(x(at), y(comparison.rows[k].points or 0), k) for at, k in own]
        parts.append(_curve([spot[:2] for spot in spots], lines[method]))
        parts += [_mark(spot, comparison.rows[spot[2]], lines[method], numbers) for spot in spots]
    name = escape(f"Points against tolerance, {comparison.file}")
    drawing = f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{name}">{"".join(parts)}</svg>'
    return drawing + "<ul>" + "".join(_entry(method, lines[method]) for method in used) + "</ul>"


def ticks(axis: Axis) -> Sequence[float]:
    """Round numbers within an axis of counts: 1, 2, 5 times powers of ten, or even steps from 0."""
    if axis.log:
        lowest, highest = math.floor(math.log10(axis.low)), math.ceil(math.log10(axis.high))
        found = [m * 10.0**e for e in range(lowest, highest + 1) for m in (1, 2, 5)]
        return [value for value in found if axis.low <= value <= axis.high]
    step = 10.0 ** math.floor(math.log10(axis.high))
    step *= next(part for part in (0.1, 0.2, 0.5, 1.0, 2.0) if axis.high / (part * step) <= 6)
    return [k * step for k in range(int(axis.high / step) + 1)]


def _grid(y: Axis, values: Sequence[float]) -> list[str]:
    """Level lines with their counts."""
    parts = [f'<text x="{LEFT - 46}" y="{TOP - 2}">points</text>']
    for value in values:
        parts.append(f'<path class="grid" d="M{LEFT} {y(value)}H{WIDTH - RIGHT}"/>')
        # The word above stands where the highest count might be.
        if y(value) > TOP + 12:
            parts.append(f'<text x="{LEFT - 6}" y="{y(value)}" dy=".35em" text-anchor="end">{value:,.0f}</text>')
    return parts


def _tolerances(x: Axis, place: Mapping[str, float]) -> list[str]:
    """The lower axis: each tolerance where it lies, as it was written."""
    parts = [f'<path class="axis" d="M{LEFT} {HEIGHT - BOTTOM}H{WIDTH - RIGHT}"/>']
    ends = [-math.inf, -math.inf]
    for written, at in sorted(place.items(), key=lambda item: item[1]):
        row = 0 if x(at) - ends[0] >= LABEL_APART else 1
        ends[row] = x(at)
        low = HEIGHT - BOTTOM
        parts.append(f'<path class="axis" d="M{x(at)} {low}v5"/>')
        parts.append(f'<text x="{x(at)}" y="{low + 17 + 13 * row}" text-anchor="middle">{escape(written)}</text>')
    parts.append(f'<text x="{WIDTH - RIGHT}" y="{HEIGHT - 3}" text-anchor="end">tolerance, log scale</text>')
    return parts


def _stroke(line: Line) -> str:
    dashes = "" if line.dashes == "solid" else " ".join(f"{part * line.width:g}" for part in line.dashes[1])
    return f'stroke="{line.colour}" stroke-width="{line.width}"' + (f' stroke-dasharray="{dashes}"' if dashes else "")


def _shape(line: Line, filled: bool) -> str:
    if not line.marker:
        return ""
    inside = line.colour if filled else "#fff"
    return f'<path d="{MARKS[line.marker]}" fill="{inside}" stroke="{line.colour}" stroke-width="1.4"/>'


def _curve(spots: Sequence[tuple[float, float]], line: Line) -> str:
    if len(spots) == 1 and not line.marker:
        # Neither a line nor a mark would be seen.
        ((x, y),) = spots
        spots = [(x - LONE, y), (x + LONE, y)]
    return f'<path class="curve" {_stroke(line)} d="M{"L".join(f"{x} {y}" for x, y in spots)}"/>'


def _mark(spot: tuple[float, float, int], row: Row, line: Line, numbers: Mapping[int, int]) -> str:
    x, y, k = spot
    chosen = f' class="mark" data-row="{numbers[k]}"' if k in numbers else ""
    title = escape(f"{row.method} at {row.tolerance}: {row.points:,} points")
    return (
        f'<g{chosen} transform="translate({x} {y})"><title>{title}</title>'
        f'<circle class="hit" r="11"/><circle class="ring" r="9"/>{_shape(line, row.method == "improved")}</g>'
    )


def _entry(method: str, line: Line) -> str:
    """A method in the list below the chart."""
    shape = f'<g transform="translate(17 7)">{_shape(line, method == "improved")}</g>'
    drawing = f'<svg viewBox="0 0 34 14" aria-hidden="true"><path {_stroke(line)} d="M0 7H34"/>{shape}</svg>'
    return f"<li>{drawing}{escape(method)}</li>"
