"""How many facets stand on which rung, in one cell of a table."""

from __future__ import annotations

from bldsimp import Report


def rung_shares(report: Report) -> str:
    """Share of the facets on each rung that has any, best rung first."""
    shares = [
        f"{name.replace('_', ' ')} {percent(count, report.facets)}"
        for name, count in report.rungs.items()
        if count
    ]
    return ", ".join(shares)


def percent(part: int, whole: int) -> str:
    """A share in percent; three digits, so that a single facet of many still shows."""
    return f"{100.0 * part / max(whole, 1):.3g} %"
