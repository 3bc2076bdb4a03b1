"""Tables as all benchmarks print them: Markdown, numbers to the right, times as the least of several runs."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field


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
        return f"{shown_time(self.least)} / {shown_time(self.median)}"


def time_in_turns(runs: int, **jobs: Callable[[], object]) -> dict[str, Timing]:
    """Time jobs in turns, so that a busy moment of the machine falls on all of them."""
    timings = {name: Timing() for name in jobs}
    for _ in range(runs):
        for name, job in jobs.items():
            start = time.perf_counter()
            job()
            timings[name].seconds.append(time.perf_counter() - start)
    return timings


def table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A Markdown table; its first column stands on the left, all others on the right."""
    cells = [list(header), *([_shown(cell) for cell in row] for row in rows)]
    widths = [max(len(row[i]) for row in cells) for i in range(len(header))]
    rule = [("-" * (w + 1) + ":") if i else "-" * (w + 2) for i, w in enumerate(widths)]
    lines = []
    for first, *others in cells:
        padded = [first.ljust(widths[0]), *(c.rjust(w) for c, w in zip(others, widths[1:], strict=True))]
        lines.append("| " + " | ".join(padded) + " |")
    return "\n".join([lines[0], "|" + "|".join(rule) + "|", *lines[1:]])


def shown_time(seconds: float) -> str:
    """Seconds to three digits, in the unit that suits them."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"


def _shown(cell: object) -> str:
    if isinstance(cell, bool):
        return "yes" if cell else "no"
    if isinstance(cell, int):
        return f"{cell:,}"
    return f"{cell:.3g}" if isinstance(cell, float) else str(cell)
