"""Comparisons as text for people, and as CSV and JSON for programs."""

from __future__ import annotations

import csv
import io
import json
import textwrap
from collections.abc import Sequence
from typing import Any

from ..display import sanitize_line
from .row import COLUMNS, Comparison, Row

SCHEMA = "bldsimp.comparison/1"
"""Name and version of the JSON; the number rises when a field changes its meaning or goes."""

WIDTH = 100
"""Columns of a terminal that the table fits into."""

HEADER = ("method", "points", "triangles", "deviation", "bound", "watertight", "border made", "seconds")


def to_text(comparisons: list[Comparison]) -> str:
    """Tables, one for each file and tolerance, without a newline at the end; at most `WIDTH` columns wide."""
    return "\n\n".join(_blocks(comparison) for comparison in comparisons)


def to_csv(comparisons: list[Comparison]) -> str:
    """All rows under the header `COLUMNS`; empty where there is no figure, truth as ``true`` and ``false``."""
    rows = [[_plain(getattr(row, name)) for name in COLUMNS] for each in comparisons for row in each.rows]
    return "".join(map(_line, [COLUMNS, *rows]))


def to_json(comparisons: list[Comparison]) -> str:
    """All comparisons as described in docs/report.md, ending in a newline."""
    files = [
        {
            "file": comparison.file,
            "failed": comparison.failed,
            "diagonal": None if comparison.failed else comparison.diagonal,
            "tolerances": comparison.tolerances,
            "rows": [_values(row) for row in comparison.rows],
        }
        for comparison in comparisons
    ]
    return json.dumps({"schema": SCHEMA, "files": files}, indent=2, allow_nan=False) + "\n"


def _values(row: Row) -> dict[str, Any]:
    return {**{name: getattr(row, name) for name in COLUMNS}, "statistics": row.statistics}


def _line(cells: Sequence[str]) -> str:
    """One line of CSV, ending in a newline."""
    text = io.StringIO()
    # Told to end lines in a newline alone, the writer would leave a carriage return in a name unquoted.
    csv.writer(text, lineterminator="\r\n").writerow(cells)
    return text.getvalue().removesuffix("\r\n") + "\n"


def _plain(value: object) -> str:
    """A value as a program reads it back exactly."""
    if value is None:
        return ""
    return str(value).lower() if isinstance(value, bool) else str(value)


def _blocks(comparison: Comparison) -> str:
    """One file: a head, then a table for each tolerance."""
    if comparison.failed:
        return _wrapped(f"{comparison.file}: ", comparison.rows[0].note)
    blocks = [f"{sanitize_line(comparison.file)}: diagonal {comparison.diagonal:.6g}, lengths in model units"]
    for text, length in comparison.tolerances.items():
        rows = [row for row in comparison.rows if row.tolerance == text]
        shown = f"tolerance {text}" if text == f"{length:g}" else f"tolerance {text} ({length:.3g})"
        blocks.append("\n".join([shown, *_table(rows), *_notes(rows), *_statistics(rows)]))
    return "\n\n".join(blocks)


def _table(rows: list[Row]) -> list[str]:
    """Aligned lines: words to the left, figures to the right."""
    cells = [HEADER, *(_cells(row, [above.method for above in rows[:i]]) for i, row in enumerate(rows))]
    widths = [max(len(line[i]) for line in cells) for i in range(len(HEADER))]
    return [
        "  ".join([line[0].ljust(widths[0]), *(c.rjust(w) for c, w in zip(line[1:], widths[1:], strict=True))])
        for line in cells
    ]


def _cells(row: Row, above: list[str]) -> tuple[str, ...]:
    """One line; a variant of a method above stands below that, without its name."""
    parent = next((f"{method} " for method in above if row.method.startswith(f"{method} ")), "")
    return (
        ("  " if parent else "") + row.method.removeprefix(parent),
        *("-" if count is None else f"{count:,}" for count in (row.points, row.triangles)),
        *("-" if length is None else f"{length:.3g}" for length in (row.deviation, row.bound)),
        "-" if row.watertight is None else "yes" if row.watertight else "no",
        "-" if row.border_made is None else f"{row.border_made:,}",
        "-" if row.seconds is None else f"{row.seconds:.2f}",
    )


def _notes(rows: list[Row]) -> list[str]:
    """Notes below a table; the same one of several methods once."""
    methods: dict[str, list[str]] = {}
    for row in rows:
        if row.note:
            methods.setdefault(row.note, []).append(row.method)
    return [_wrapped(f"  {_together(names)}: ", note) for note, names in methods.items()]


def _together(names: list[str]) -> str:
    """Names in a row; the word that a name shares with the first is left out."""
    shared = names[0] + " "
    return ", ".join([names[0], *(name.removeprefix(shared) for name in names[1:])])


def _statistics(rows: list[Row]) -> list[str]:
    """What the triangulations did, the methods that tell beside each other."""
    telling = [row for row in rows if row.statistics]
    if not telling:
        return []

    def beside(name: str) -> str:
        return " / ".join(f"{row.statistics[name]:,}" for row in telling)

    walked = (row.statistics["walked"] / max(row.statistics["located"], 1) for row in telling)
    told = (
        f"orientation tests by poles {beside('by_poles')}, by determinant {beside('by_determinant')};"
        f" triangles walked per located point {' / '.join(f'{mean:.2f}' for mean in walked)};"
        f" diagonals swapped {beside('flips')}"
    )
    return [_wrapped(f"  {' / '.join(row.method for row in telling)}: ", told)]


def _wrapped(head: str, text: str) -> str:
    return textwrap.fill(sanitize_line(head + text), WIDTH, subsequent_indent="    ", break_on_hyphens=False)
