"""Old names still work, and warn. The changelog lists each."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path

import pytest
from conftest import ROOT
from shapes import fine_box

import bldsimp
from bldsimp import _MOVED
from bldsimp.cli import main
from bldsimp.report import OLD_NAMES, Report

CHANGELOG = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8").split("### Changed")[1].split("\n### ")[0]
SQUARE = bldsimp.triangulate([[0, 0], [1, 0], [1, 1], [0, 1]], [])


@pytest.mark.parametrize("old", _MOVED)
def test_a_name_that_moved_warns_and_is_the_same(old: str) -> None:
    home, _, new = _MOVED[old].partition(".")
    with pytest.warns(DeprecationWarning, match=re.escape(f"bldsimp.{old} is now bldsimp.{_MOVED[old]}")):
        found = getattr(bldsimp, old)
    assert found is getattr(import_module(f"bldsimp.{home}"), new)
    assert old not in bldsimp.__all__
    assert f"| `bldsimp.{old}` | `bldsimp.{_MOVED[old]}` |" in CHANGELOG


def test_the_old_spelling_of_neighbors_warns() -> None:
    with pytest.warns(DeprecationWarning, match="neighbours is now neighbors"):
        assert SQUARE.neighbours is SQUARE.neighbors
    assert "| `Triangulation.neighbours` | `Triangulation.neighbors` |" in CHANGELOG


def test_the_old_name_of_min_component_warns() -> None:
    with pytest.warns(DeprecationWarning, match="min_part is deprecated: use min_component"):
        options = bldsimp.Options(min_part=2.0)
    assert options == bldsimp.Options(min_component=2.0)
    with pytest.warns(DeprecationWarning, match="min_part is deprecated: use min_component"):
        assert options.min_part == 2.0
    assert "| `Options.min_part` | `Options.min_component` |" in CHANGELOG


@pytest.mark.parametrize("old", OLD_NAMES)
def test_old_fields_of_a_report_warn_and_mean_the_new_ones(old: str) -> None:
    new = OLD_NAMES[old]
    report: Report = bldsimp.simplify(fine_box()).report
    with pytest.warns(DeprecationWarning, match=f"{old} is deprecated: use {new}"):
        assert getattr(report, old) == getattr(report, new)
    assert f"| `{old}` | `{new}` |" in CHANGELOG


def test_an_old_option_warns(capsys: pytest.CaptureFixture[str], data: Path, tmp_path: Path) -> None:
    source, target = str(data / "building_a.glb"), str(tmp_path / "out.glb")
    assert main(["simplify", source, target, "--min-part", "0.1"]) == 0
    assert "--min-part is deprecated: use --min-component" in capsys.readouterr().err
    assert "`--min-part`" in CHANGELOG
