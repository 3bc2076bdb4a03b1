"""Simplify and let the judge look: what the tests of promises share."""

from __future__ import annotations

from dataclasses import dataclass

import judge
import numpy as np
from solids import Shape

import bldsimp
from bldsimp.report import Report


@dataclass(frozen=True)
class Verdict:
    """Input and result as the judge sees them, and what the program says of them."""

    before: judge.Surface
    after: judge.Surface
    report: Report
    result: Shape


def simplify_and_judge(mesh: Shape, tolerance: float | None = None, *, share: float | None = None) -> Verdict:
    """Simplify within a length, or a share of the diagonal, or by default within `auto`."""
    before = judge.make_surface(*mesh)
    if share is not None:
        tolerance = share * judge.measure_extent(before)
    result = bldsimp.simplify(mesh, tolerance)
    return Verdict(before, judge.make_surface(*result.mesh), result.report, result.mesh)


def find_broken(case: Verdict, count: int = 200) -> list[str]:
    """Promises that a result breaks."""
    report = case.report
    found = judge.find_broken(
        case.before, case.after, report.tolerance, report.deviation,
        healed=report.healed_t_junctions, dropped=bool(report.removed_components),
        closed=bool(report.removed_details), count=count,
    )  # fmt: skip
    told = (report.after.points, report.after.triangles)
    seen = (len(np.unique(case.result[1])), len(case.result[1]))
    if told != seen:
        found.append(f"the report tells {told}, the result has {seen}")
    # A face that lies back to back with another may be turned into its copy.
    if len(case.after.faces) != len(case.result[1]) and not report.reversed_faces:
        found.append(f"{len(case.result[1]) - len(case.after.faces)} copies of faces")
    return found
