"""Print tables as all benchmarks do: Markdown, numbers to the right, times as the least of several runs."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from bldsimp.report import Report


@dataclass
class Timing:
    """Seconds of several runs of one thing."""

    seconds: list[float] = field(default_factory=list)

    @property
    def least(self) -> float:
        """The run that others on the machine disturbed least."""
        return min(self.seconds)

    @property
    def median(self) -> float:
        """The usual run."""
        return statistics.median(self.seconds)

    def __str__(self) -> str:
        return f"{format_time(self.least)} / {format_time(self.median)}"


def time_in_turns(runs: int, **jobs: Callable[[], object]) -> dict[str, Timing]:
    """Time jobs in turns, so that a busy moment of the machine falls on all of them."""
    timings = {name: Timing() for name in jobs}
    for _ in range(runs):
        for name, job in jobs.items():
            start = time.perf_counter()
            job()
            timings[name].seconds.append(time.perf_counter() - start)
    return timings


def format_table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Write a Markdown table; its first column is aligned left, all others right."""
    cells = [list(header), *([_format_cell(cell) for cell in row] for row in rows)]
    widths = [max(len(row[i]) for row in cells) for i in range(len(header))]
    rule = [("-" * (w + 1) + ":") if i else "-" * (w + 2) for i, w in enumerate(widths)]
    lines = []
    for first, *others in cells:
        padded = [first.ljust(widths[0]), *(c.rjust(w) for c, w in zip(others, widths[1:], strict=True))]
        lines.append("| " + " | ".join(padded) + " |")
    return "\n".join([lines[0], "|" + "|".join(rule) + "|", *lines[1:]])


def format_time(seconds: float) -> str:
    """Write seconds to three digits, in the unit that suits them."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"


def _format_cell(cell: object) -> str:
    if isinstance(cell, bool):
        return "yes" if cell else "no"
    if isinstance(cell, int):
        return f"{cell:,}"
    return f"{cell:.3g}" if isinstance(cell, float) else str(cell)


def format_rung_shares(report: Report) -> str:
    """Write the share of the facets on each rung that has any, best rung first."""
    named = [
        (name.replace("_", " "), format_share(count, report.facets)) for name, count in report.facet_levels.items()
    ]
    return ", ".join(f"{name} {shown}" for name, shown in named if shown)


def format_share(part: int, whole: int) -> str:
    """Write a count and its share of the whole; nothing where it is 0."""
    return f"{part:,} = {format_percent(part, whole)}" if part else ""


def format_percent(part: int, whole: int) -> str:
    """Write a share in percent, rounded so that only the whole shows as 100 %."""
    shown = 100.0 * part / max(whole, 1)
    digits = 3 if 100 * part < 99 * whole else 5
    return f"{shown:.{digits}g} %"
