"""Rows in numbers: totals, the slowest files, errors by kind."""

from __future__ import annotations

import heapq
from collections.abc import Iterable
from dataclasses import dataclass, field

from ..report import one_line, size_in_words
from .row import KINDS, Row, escaped

MOST_NAMED = 5
"""So many slowest files, and files of each kind of error, are named."""


@dataclass
class Totals:
    """Sums over rows.

    Attributes
    ----------
    done, failed : int
        Files.
    skipped : int
        Files that an earlier run has done.
    triangles, points, bytes : list of int
        Of the files that are done, before and after.
    seconds : float
        Of all files, one after the other.
    warned : int
        Files that are done with warnings.
    slowest : list of (float, str)
        Seconds and names.
    errors : dict of str to int
        Files by the kind of what they failed by.
    named : dict of str to list of (str, str)
        Names and errors of some of them.
    """

    done: int = 0
    failed: int = 0
    skipped: int = 0
    points: list[int] = field(default_factory=lambda: [0, 0])
    triangles: list[int] = field(default_factory=lambda: [0, 0])
    bytes: list[int] = field(default_factory=lambda: [0, 0])
    seconds: float = 0.0
    warned: int = 0
    slowest: list[tuple[float, str]] = field(default_factory=list)
    errors: dict[str, int] = field(default_factory=dict)
    named: dict[str, list[tuple[str, str]]] = field(default_factory=dict)

    def add(self, row: Row) -> None:
        """Count a row."""
        self.seconds += row.seconds
        if row.failed:
            self.failed += 1
            kind = row.kind or "internal"
            self.errors[kind] = self.errors.get(kind, 0) + 1
            names = self.named.setdefault(kind, [])
            if len(names) < MOST_NAMED:
                names.append((escaped(row.input), row.error or ""))
            return
        self.done += 1
        self.warned += bool(row.warnings)
        for total, before, after in (
            (self.points, row.points_before, row.points_after),
            (self.triangles, row.triangles_before, row.triangles_after),
            (self.bytes, row.input_bytes, row.output_bytes),
        ):
            total[0] += before or 0
            total[1] += after or 0
        push = heapq.heappush if len(self.slowest) < MOST_NAMED else heapq.heappushpop
        push(self.slowest, (row.seconds, escaped(row.input)))


def totals_of(rows: Iterable[Row]) -> Totals:
    """Totals of a manifest: where a file was done again, its last row counts.

    Notes
    -----
    Linear in the rows; one of each file is held.
    """
    last = {row.input: row for row in rows}
    totals = Totals()
    for row in last.values():
        totals.add(row)
    return totals


def totals_text(totals: Totals) -> str:
    """Totals for a person.

    Returns
    -------
    str
        Lines without a newline at the end.
    """
    lines = [_files(totals)]
    if totals.done:
        pairs = [("points", totals.points), ("triangles", totals.triangles)]
        sizes = ", ".join(f"{name} {before:,} -> {after:,}" for name, (before, after) in pairs)
        lines.append(f"size       {sizes}, {' -> '.join(map(size_in_words, totals.bytes))}")
        slowest = ", ".join(f"{name} ({seconds:.2f})" for seconds, name in sorted(totals.slowest, reverse=True))
        lines.append(f"seconds    {totals.seconds:,.1f} in all files; slowest: {slowest}")
    for kind in sorted(totals.errors, key=lambda kind: (-totals.errors[kind], kind)):
        count = totals.errors[kind]
        lines.append(f"failed     {count:,} x {KINDS.get(kind, kind)}:")
        lines += [f"           {name}: {error}" for name, error in totals.named[kind]]
        if count > MOST_NAMED:
            lines.append(f"           and {count - MOST_NAMED:,} more")
    return "\n".join(map(one_line, lines))


def _files(totals: Totals) -> str:
    text = f"files      {totals.done:,} done"
    text += f" ({totals.warned:,} with warnings)" if totals.warned else ""
    text += f", {totals.failed:,} failed" if totals.failed else ""
    return text + (f", {totals.skipped:,} done before" if totals.skipped else "")
