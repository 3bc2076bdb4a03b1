"""The report: its schema as documented, with the names that it had before."""

from __future__ import annotations

import json
import re
from dataclasses import fields

import pytest
from conftest import ROOT
from reports import make_report

from bldsimp import Report
from bldsimp.inspection import Inspection, MeshInspection
from bldsimp.report import OLD_NAMES, SCHEMA, Counts, RemovedComponent, UnchangedPart

DOCUMENT = (ROOT / "docs" / "report.md").read_text()


def test_every_field_is_documented_and_no_other() -> None:
    table = DOCUMENT.split("Counts:")[0]
    told = {name for row in re.findall(r"^\| (`.*?) \|", table, re.M) for name in re.findall(r"`(\w+)`", row)}
    assert told == {field.name for field in fields(Report)}
    counts = DOCUMENT.split("Counts:")[1].split("\n\n`bldsimp.report/1")[0]
    told = {name for row in re.findall(r"^\| (`.*?) \|", counts, re.M) for name in re.findall(r"`(\w+)`", row)}
    assert told == {field.name for field in fields(Counts)}
    rest = DOCUMENT.split("## `bldsimp inspect`")[1]
    names = {field.name for field in fields(Inspection)} - {"schema"}
    assert all(f"`{name}`" in rest for name in names)
    counted = {field.name for field in fields(Counts)}
    assert all(f"`{field.name}`" in rest for field in fields(MeshInspection) if field.name not in counted)


def test_json_begins_with_the_schema_and_reads_back() -> None:
    text = make_report(unchanged_parts=[UnchangedPart("wall", "cannot update skin")]).to_json()
    found = json.loads(text)
    assert next(iter(found)) == "schema"
    assert found["schema"] == SCHEMA
    assert SCHEMA in DOCUMENT
    assert found["unchanged_parts"] == [{"name": "wall", "reason": "cannot update skin"}]
    with pytest.raises(ValueError, match="not JSON compliant"):
        make_report(deviation=float("nan")).to_json()


def test_old_names_are_there_for_one_more_version_and_documented_as_deprecated() -> None:
    some = make_report(
        facet_levels={"simplified": 3}, fallback_reasons={"clash": 1}, healed_t_junctions=1, contact_points=2,
        closed_boundary_loops=3, reversed_faces=4, removed_degenerate_faces=5, removed_duplicate_faces=6,
        removed_components=[RemovedComponent("speck", 12, [[0.0] * 3, [1.0] * 3], "smaller_than_min_component")],
        unchanged_parts=[UnchangedPart("wall", "cannot update skin")],
    )  # fmt: skip
    found = some.to_dict()
    for old, new in OLD_NAMES.items():
        assert f"| `{old}` | `{new}` |" in DOCUMENT
        assert getattr(some, old) == getattr(some, new)
        assert old == "dropped" or found[old] == found[new]
    assert found["dropped"] == [found["removed_components"][0] | {"reason": "smaller_than_min_part"}]
    some.turned += 1
    assert some.reversed_faces == 5
