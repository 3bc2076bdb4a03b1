"""A report to test with."""

from __future__ import annotations

from bldsimp import Report
from bldsimp.report import Counts


def make_report(**changes: object) -> Report:
    """Make the report of a run that went well, with some values changed."""
    values: dict = {
        "tolerance": 0.01, "diagonal": 20.0, "deviation": 0.005, "epsilon": 1e-6, "seconds": 0.25,
        "before": Counts(1000, 1200, 2000, True, bytes=100_000),
        "after": Counts(100, 100, 196, True, bytes=4_000),
    }  # fmt: skip
    return Report(**{**values, **changes})
