"""What the README shows is what happens."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_python_example_prints_what_its_comment_says(
    tmp_path: Path, data: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "data").mkdir()
    shutil.copy(data / "building_a.obj", tmp_path / "data")
    monkeypatch.chdir(tmp_path)
    (example,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    exec(compile(example, "README.md", "exec"), {})
    assert capsys.readouterr().out.strip() == example.strip().rsplit("# ", 1)[1]
    assert (tmp_path / "building_a_light.ply").stat().st_size > 0


def test_the_summary_of_the_first_run_is_real(tmp_path: Path, data: Path) -> None:
    shown = README.split("The first one ends with:\n\n```\n")[1].split("```")[0]
    target = tmp_path / "light.glb"
    command = [Path(sys.executable).parent / "bldsimp", "simplify", data / "building_a.glb", target]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stderr
    timeless = [re.sub(r"(seconds +).*", r"\1", text) for text in (shown, printed)]
    assert timeless[0] == timeless[1]


def test_the_comparison_is_real(data: Path) -> None:
    shown = README.split("prints, for the tower of `data/`:\n\n```\n")[1].split("```")[0]
    command = [Path(sys.executable).parent / "bldsimp", "compare", "data/building_b.obj", "--tolerances", "auto"]
    printed = subprocess.run(command, check=True, capture_output=True, text=True, cwd=data.parent).stdout
    # What fast-simplification finds depends on its version.
    timeless = [re.sub(r"(?m) +[0-9.]+$", "", text) for text in (shown, printed)]
    ours = [[line for line in text.splitlines() if not line.startswith(("fast", "  "))] for text in timeless]
    assert ours[0] == ours[1]
    assert len(ours[0]) == 7
    assert "standard / improved: orientation tests" in shown
    assert shown.split("standard / improved: ")[1] == printed.split("standard / improved: ")[1]


@pytest.mark.parametrize("target", sorted(set(re.findall(r"\]\(([^):#]+)\)", README))))
def test_links_lead_somewhere(target: str) -> None:
    assert (ROOT / target).exists()


def test_the_two_commands_exist_and_are_shell() -> None:
    commands = re.findall(r"^sh (\S+\.sh)", README, re.MULTILINE)
    assert len(commands) == 2
    for command in commands:
        assert (ROOT / command).read_text(encoding="utf-8").startswith("#!/bin/sh\n")
