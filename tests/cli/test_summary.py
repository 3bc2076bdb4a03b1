"""The words in which people read a report."""

from __future__ import annotations

from reports import make_report

from bldsimp.cli.summary import describe_report
from bldsimp.report import Counts, RemovedComponent, UnchangedPart


def test_sizes_deviation_and_closure() -> None:
    text = describe_report(
        make_report(
            facet_levels={"simplified": 40, "points_put_back": 2},
            facets=42,
            fallback_reasons={"clash": 2},
            reversed_faces=3,
        )
    )
    assert "points 1,000 -> 100, triangles 2,000 -> 196, 100 kB -> 4 kB" in text
    assert "deviation at most 0.005 (tolerance 0.01" in text
    assert "watertight" in text
    assert "42: 40 simplified, 2 points put back; kept because edges would overlap (2)" in text
    assert "3 faces reversed" in text
    assert "note" not in text
    opened = describe_report(make_report(after=Counts(100, 100, 196, False)))
    assert "watertight -> open" in opened


def test_a_hint_says_what_may_remove_more() -> None:
    kept = Counts(990, 990, 1980, True)
    # A promise would be false: at a larger tolerance a model may as well keep more.
    assert "try a larger tolerance such as --tolerance 0.1 (moves the surface by up to 0.1)" in describe_report(
        make_report(after=kept)
    )
    coarse = describe_report(make_report(after=kept, epsilon=0.5))
    assert "rounded more coarsely (0.25) than the tolerance: try --tolerance 2\n" in coarse
    assert "larger tolerance" not in coarse
    # Of a model without size every tolerance is alike.
    point = make_report(before=Counts(1, 3, 2), after=Counts(1, 3, 2), diagonal=0.0, tolerance=0.0)
    assert "note" not in describe_report(point)
    passed = describe_report(make_report(after=kept, unchanged_parts=[UnchangedPart("wall", "cannot update skin")]))
    assert "larger tolerance" not in passed
    assert "unchanged  wall: cannot update skin" in passed


def test_baseline_and_rounding() -> None:
    text = describe_report(make_report(baseline=850, rounding=1e-6, deviation=0.005001))
    assert "fast-simplification needs 850 points for the same deviation (8.5 times as many)" in text
    assert "including 1e-06 from rounding when written" in text


def test_removed_components_are_listed_by_part() -> None:
    def of(name: str, reason: str = "within_tolerance") -> RemovedComponent:
        return RemovedComponent(name, 12, [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]], reason)

    assert "removed" not in describe_report(make_report())
    few = describe_report(
        make_report(removed_components=[of("sill"), of("door"), of("sill"), of("aerial", "smaller_than_min_component")])
    )
    assert "removed    3 components within the tolerance of the rest: sill (2), door\n" in few
    assert "removed    1 component smaller than --min-component, not counted in the deviation: aerial\n" in few
    many = describe_report(make_report(removed_components=[of(f"part {i}") for i in range(13)]))
    assert "13 components within the tolerance of the rest: part 0, part 1," in many
    assert "part 9 and 3 more parts\n" in many
    assert "part 10" not in many


def test_names_cannot_forge_lines() -> None:
    text = describe_report(
        make_report(unchanged_parts=[UnchangedPart("wall\nseconds    0\x1b[31m", "cannot update skin")])
    )
    assert "unchanged  wall seconds    0 [31m: cannot update skin" in text
