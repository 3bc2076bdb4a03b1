"""The report: its schema as documented, and the summary that people read."""

from __future__ import annotations

import json
import re
from dataclasses import fields

import pytest
from conftest import ROOT

from bldsimp import Report
from bldsimp.inspection import Inspection, MeshInspection
from bldsimp.report import SCHEMA, Counts, DroppedPart, PassedOn, summary

DOCUMENT = (ROOT / "docs" / "report.md").read_text()


def report(**changes: object) -> Report:
    """A run that went well."""
    values: dict = {
        "tolerance": 0.01, "diagonal": 20.0, "deviation": 0.005, "epsilon": 1e-6, "seconds": 0.25,
        "before": Counts(1000, 1200, 2000, True, bytes=100_000),
        "after": Counts(100, 100, 196, True, bytes=4_000),
    }  # fmt: skip
    return Report(**{**values, **changes})


def test_every_field_is_documented_and_no_other() -> None:
    table = DOCUMENT.split("Counts:")[0]
    told = {name for row in re.findall(r"^\| (`.*?) \|", table, re.M) for name in re.findall(r"`(\w+)`", row)}
    assert told == {field.name for field in fields(Report)}
    counts = DOCUMENT.split("Counts:")[1].split("\n\n`bldsimp inspect")[0]
    told = {name for row in re.findall(r"^\| (`.*?) \|", counts, re.M) for name in re.findall(r"`(\w+)`", row)}
    assert told == {field.name for field in fields(Counts)}
    rest = DOCUMENT.split("`bldsimp inspect")[1]
    names = {field.name for field in fields(Inspection)} - {"schema"}
    assert all(f"`{name}`" in rest for name in names)
    counted = {field.name for field in fields(Counts)}
    assert all(f"`{field.name}`" in rest for field in fields(MeshInspection) if field.name not in counted)


def test_json_begins_with_the_schema_and_reads_back() -> None:
    text = report(passed_on=[PassedOn("wall", "carries skin")]).to_json()
    found = json.loads(text)
    assert next(iter(found)) == "schema"
    assert found["schema"] == SCHEMA
    assert SCHEMA in DOCUMENT
    assert found["passed_on"] == [{"name": "wall", "reason": "carries skin"}]
    with pytest.raises(ValueError, match="not JSON compliant"):
        report(deviation=float("nan")).to_json()


def test_the_summary_tells_sizes_deviation_and_closure() -> None:
    text = summary(report(rungs={"simplified": 40, "points_put_back": 2}, facets=42, reasons={"clash": 2}, turned=3))
    assert "points 1,000 -> 100, triangles 2,000 -> 196, 100 kB -> 4 kB" in text
    assert "deviation at most 0.005 (tolerance 0.01" in text
    assert "watertight" in text
    assert "42: 40 simplified, 2 points put back; kept because: edges would be laid on one another (2)" in text
    assert "3 faces turned" in text
    assert "note" not in text
    opened = summary(report(after=Counts(100, 100, 196, False)))
    assert "watertight -> open" in opened


def test_what_may_drop_more_is_named() -> None:
    kept = Counts(990, 990, 1980, True)
    # A promise would be false: at a larger tolerance a model may as well keep more.
    assert "say --tolerance 0.1, may drop more" in summary(report(after=kept))
    coarse = summary(report(after=kept, epsilon=0.5))
    assert "rounding (0.25) is coarser than the tolerance; --tolerance 2 may see through it" in coarse
    assert "drop more" not in coarse
    # Of a model without size every tolerance is alike.
    point = report(before=Counts(1, 3, 2), after=Counts(1, 3, 2), diagonal=0.0, tolerance=0.0)
    assert "note" not in summary(point)
    passed = summary(report(after=kept, passed_on=[PassedOn("wall", "carries skin")]))
    assert "drop more" not in passed
    assert "passed on  wall: carries skin" in passed


def test_the_baseline_and_rounding_are_told() -> None:
    text = summary(report(baseline=850, rounding=1e-6, deviation=0.005001))
    assert "fast-simplification needs 850 points for the same deviation (8.5 times as many)" in text
    assert "of which 1e-06 is rounding on writing" in text


def test_what_went_as_a_whole_is_told_by_part() -> None:
    def of(name: str, reason: str = "within_tolerance") -> DroppedPart:
        return DroppedPart(name, 12, [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]], reason)

    assert "dropped" not in summary(report())
    few = summary(report(dropped=[of("sill"), of("door"), of("sill"), of("aerial", "smaller_than_min_part")]))
    assert "dropped    3 components within the tolerance of what remains: sill (2), door\n" in few
    assert "dropped    1 component smaller than asked for, which the deviation does not count: aerial\n" in few
    many = summary(report(dropped=[of(f"part {i}") for i in range(13)]))
    assert "13 components within the tolerance of what remains: part 0, part 1," in many
    assert "part 9 and 3 more parts\n" in many
    assert "part 10" not in many


def test_names_cannot_forge_lines() -> None:
    text = summary(report(passed_on=[PassedOn("wall\nseconds    0\x1b[31m", "carries skin")]))
    assert "passed on  wall seconds    0 [31m: carries skin" in text
