"""Format comparisons as text for people, and as CSV and JSON for programs."""

from __future__ import annotations

import csv
import io
import json
import textwrap
from collections.abc import Sequence

from ..display import sanitize_line
from .rows import COLUMNS, Comparison, MethodRow

SCHEMA = "bldsimp.comparison/1"
"""Name and version of the JSON; the number rises when a field changes its meaning or is removed."""

WIDTH = 100
"""Greatest width of the table, in characters."""

FIGURES = {
    "points": "{:,}", "triangles": "{:,}", "deviation": "{:.3g}", "bound": "{:.3g}", "watertight": "{}",
    "border_made": "{:,}", "seconds": "{:.2f}",
}  # fmt: skip
"""How a column is written for people, in its order."""

HEADER = ("method", *(name.replace("_", " ") for name in FIGURES))


def format_text(comparisons: list[Comparison]) -> str:
    """Write a table for each file and tolerance, at most `WIDTH` wide, without a newline at the end."""
    return "\n\n".join(_format_file(comparison) for comparison in comparisons)


def format_csv(comparisons: list[Comparison]) -> str:
    """Write all rows under the header `COLUMNS`: empty where there is no figure, truth as ``true`` and ``false``."""
    rows = [[_format_value(getattr(row, name)) for name in COLUMNS] for each in comparisons for row in each.rows]
    return "".join(map(_format_line, [COLUMNS, *rows]))


def format_json(comparisons: list[Comparison]) -> str:
    """Write all comparisons as docs/report.md describes, with a newline at the end."""
    files = [
        {
            "file": comparison.file,
            "failed": comparison.failed,
            "diagonal": None if comparison.failed else comparison.diagonal,
            "tolerances": comparison.tolerances,
            "rows": [
                {**{name: getattr(row, name) for name in COLUMNS}, "statistics": row.statistics}
                for row in comparison.rows
            ],
        }
        for comparison in comparisons
    ]
    return json.dumps({"schema": SCHEMA, "files": files}, indent=2, allow_nan=False) + "\n"


def _format_line(cells: Sequence[str]) -> str:
    """Write one line of CSV, with a newline at the end."""
    text = io.StringIO()
    # With a newline alone as its line end, the writer would leave a carriage return in a name unquoted.
    csv.writer(text, lineterminator="\r\n").writerow(cells)
    return text.getvalue().removesuffix("\r\n") + "\n"


def _format_value(value: object) -> str:
    """Write a value so that a program reads it back exactly."""
    if value is None:
        return ""
    return str(value).lower() if isinstance(value, bool) else str(value)


def _format_file(comparison: Comparison) -> str:
    """Write a head for one file, then a table for each tolerance."""
    if comparison.failed:
        return _wrap(f"{comparison.file}: ", comparison.rows[0].note)
    blocks = [f"{sanitize_line(comparison.file)}: diagonal {comparison.diagonal:.6g}, lengths in model units"]
    for text, length in comparison.tolerances.items():
        rows = [row for row in comparison.rows if row.tolerance == text]
        shown = f"tolerance {text}" if text == f"{length:g}" else f"tolerance {text} ({length:.3g})"
        blocks.append("\n".join([shown, *_align(rows), *_list_notes(rows), *_describe_statistics(rows)]))
    return "\n\n".join(blocks)


def _align(rows: list[MethodRow]) -> list[str]:
    """Align the cells of all rows: words to the left, figures to the right."""
    cells = [HEADER, *(_format_cells(row, [above.method for above in rows[:i]]) for i, row in enumerate(rows))]
    widths = [max(len(line[i]) for line in cells) for i in range(len(HEADER))]
    return [
        "  ".join([line[0].ljust(widths[0]), *(c.rjust(w) for c, w in zip(line[1:], widths[1:], strict=True))])
        for line in cells
    ]


def _format_cells(row: MethodRow, above: list[str]) -> tuple[str, ...]:
    """Write the cells of a row; a variant of a method above is indented, without that method's name."""
    parent = next((f"{method} " for method in above if row.method.startswith(f"{method} ")), "")
    name = ("  " if parent else "") + row.method.removeprefix(parent)
    return name, *(text or "-" for text in format_figures(row).values())


def format_figures(row: MethodRow) -> dict[str, str]:
    """Write the figures of a row for people, by column; empty where there is none."""
    figures = {}
    for name, style in FIGURES.items():
        value = getattr(row, name)
        figures[name] = "" if value is None else style.format(value)
    return figures | {"watertight": {True: "yes", False: "no", None: ""}[row.watertight]}


def _list_notes(rows: list[MethodRow]) -> list[str]:
    """Write the notes below a table, each once for all methods that share it."""
    methods: dict[str, list[str]] = {}
    for row in rows:
        if row.note:
            methods.setdefault(row.note, []).append(row.method)
    return [_wrap(f"  {_join_names(names)}: ", note) for note, names in methods.items()]


def _join_names(names: list[str]) -> str:
    """Join names, without the words that a name shares with the first."""
    shared = names[0] + " "
    return ", ".join([names[0], *(name.removeprefix(shared) for name in names[1:])])


def _describe_statistics(rows: list[MethodRow]) -> list[str]:
    """Describe the work of the triangulations, all methods side by side."""
    counted = [row for row in rows if row.statistics]
    if not counted:
        return []

    def join(name: str) -> str:
        return " / ".join(f"{row.statistics[name]:,}" for row in counted)

    walked = (row.statistics["walked"] / max(row.statistics["located"], 1) for row in counted)
    text = (
        f"orientation tests by poles {join('by_poles')}, by determinant {join('by_determinant')};"
        f" triangles walked per located point {' / '.join(f'{mean:.2f}' for mean in walked)};"
        f" diagonals swapped {join('flips')}"
    )
    return [_wrap(f"  {' / '.join(row.method for row in counted)}: ", text)]


def _wrap(head: str, text: str) -> str:
    return textwrap.fill(sanitize_line(head + text), WIDTH, subsequent_indent="    ", break_on_hyphens=False)
