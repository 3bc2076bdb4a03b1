"""Shares of facets as they stand in a table."""

from __future__ import annotations

from bldsimp import Report


def rung_shares(report: Report) -> str:
    """Share of the facets on each rung that has any, best rung first."""
    named = [(name.replace("_", " "), share(count, report.facets)) for name, count in report.rungs.items()]
    return ", ".join(f"{name} {shown}" for name, shown in named if shown)


def share(part: int, whole: int) -> str:
    """A count and what share of the whole it is; nothing where it is nothing."""
    return f"{part:,} = {percent(part, whole)}" if part else ""


def percent(part: int, whole: int) -> str:
    """A share in percent, rounded so that only all of it shows as 100 %."""
    shown = 100.0 * part / max(whole, 1)
    digits = 3 if shown < 99.0 else 5
    return f"{shown:.{digits}g} %"
