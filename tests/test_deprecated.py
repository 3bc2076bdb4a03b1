"""Old names still work, and warn; the changelog lists each."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from conftest import ROOT
from shapes import fine_box

import bldsimp
from bldsimp.cli import main
from bldsimp.report import OLD_NAMES, Report

CHANGELOG = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8").split("### Changed")[1].split("\n### ")[0]
SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]

Uses = dict[tuple[str, str], Callable[[], tuple[Any, Any]]]

USES: Uses = {
    ("Light", "SimplifiedMesh"): lambda: (bldsimp.Light, bldsimp.SimplifiedMesh),
    ("neighbours", "neighbors"): lambda: (
        bldsimp.triangulate(SQUARE).neighbours,
        bldsimp.triangulate(SQUARE).neighbors,
    ),
    ("min_part", "min_component"): lambda: (bldsimp.Options(min_part=2.0), bldsimp.Options(min_component=2.0)),
}


@pytest.mark.parametrize(("old", "new"), USES, ids=lambda name: name)
def test_an_old_name_warns_and_means_the_new_one(old: str, new: str) -> None:
    with pytest.warns(DeprecationWarning, match=f"{old} is deprecated: use {new}"):
        before, after = USES[old, new]()
    assert repr(before) == repr(after)
    assert old in CHANGELOG
    assert new in CHANGELOG


@pytest.mark.parametrize("old", OLD_NAMES)
def test_old_fields_of_a_report_warn_and_mean_the_new_ones(old: str) -> None:
    new = OLD_NAMES[old]
    report: Report = bldsimp.simplify(fine_box()).report
    with pytest.warns(DeprecationWarning, match=f"{old} is deprecated: use {new}"):
        assert getattr(report, old) == getattr(report, new)
    assert f"| `{old}` | `{new}` |" in CHANGELOG
    assert old not in dir(bldsimp)


def test_an_old_option_warns(capsys: pytest.CaptureFixture[str], data: Any, tmp_path: Any) -> None:
    source, target = str(data / "building_a.glb"), str(tmp_path / "out.glb")
    assert main(["simplify", source, target, "--min-part", "0.1"]) == 0
    assert "--min-part is deprecated: use --min-component" in capsys.readouterr().err
    assert "`--min-part`" in CHANGELOG


def test_the_package_does_not_use_its_old_names() -> None:
    assert set(bldsimp.__all__).isdisjoint(old for old, _ in USES)
