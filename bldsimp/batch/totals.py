"""Totals over rows: sizes, the slowest files, errors by kind."""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

from .row import FileRow, escape_name

MOST_NAMED = 5
"""How many of the slowest files, and of the files with each kind of error, are named."""


@dataclass
class Totals:
    """Sums over rows.

    Attributes
    ----------
    done, failed : int
        Files.
    skipped : int
        Files that an earlier run has done.
    points, triangles, bytes : list of int
        Of the files that are done, before and after.
    seconds : float
        Sum of the time that each file took.
    warned : int
        Files that are done with warnings.
    slowest : list of (float, str)
        Seconds and names.
    errors : Counter of str
        How many files failed, by kind.
    named : dict of str to list of (str, str)
        Names and errors of some of these files, by kind.
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
    errors: Counter[str] = field(default_factory=Counter)
    named: dict[str, list[tuple[str, str]]] = field(default_factory=dict)

    def add(self, row: FileRow) -> None:
        """Count a row."""
        self.seconds += row.seconds
        if row.failed:
            self.failed += 1
            kind = row.kind or "internal"
            self.errors[kind] += 1
            names = self.named.setdefault(kind, [])
            if len(names) < MOST_NAMED:
                names.append((escape_name(row.input), row.error or ""))
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
        push(self.slowest, (row.seconds, escape_name(row.input)))


def sum_rows(rows: Iterable[FileRow]) -> Totals:
    """Sum the rows of a manifest; where a file was done again, its last row counts.

    Notes
    -----
    Linear in the rows; one of each file is held.
    """
    last = {row.input: row for row in rows}
    totals = Totals()
    for row in last.values():
        totals.add(row)
    return totals
