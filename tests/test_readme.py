"""What the README shows is what happens."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
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


@pytest.mark.parametrize("target", sorted(set(re.findall(r"\]\(([^):#]+)\)", README))))
def test_links_lead_somewhere(target: str) -> None:
    assert (ROOT / target).exists()


def test_the_two_commands_exist_and_are_shell(data: Path) -> None:
    commands = re.findall(r"^sh (\S+\.sh)", README, re.MULTILINE)
    assert len(commands) == 2
    for command in commands:
        assert (ROOT / command).read_text(encoding="utf-8").startswith("#!/bin/sh\n")
