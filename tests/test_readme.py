"""What the README and docs/compare.md show is what happens."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")
PROGRAM = Path(sys.executable).parent / "bldsimp"


def find_blocks(text: str, language: str) -> list[str]:
    """Return the blocks of code in a language of a Markdown text; those without a language are output."""
    return [block for kind, block in re.findall(r"^```(\w*)\n(.*?)^```$", text, re.M | re.S) if kind == language]


def run(arguments: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """Run the command line in a folder that has `data/`, and return what it prints."""
    if not (folder / "data").exists():
        (folder / "data").symlink_to(ROOT / "data")
    return subprocess.run([PROGRAM, *arguments], check=True, capture_output=True, text=True, cwd=folder)


def test_the_first_lines_say_what_it_does_how_to_install_it_and_what_it_prints(tmp_path: Path) -> None:
    first = README.splitlines()[:15]
    assert "pip install ." in first
    (command,) = [line for line in first if line.startswith("bldsimp ")]
    shown = find_blocks(README, "")[0]
    assert shown.splitlines() == first[-4:]
    printed = run(command.split()[1:], tmp_path).stderr
    timeless = [re.sub(r"(seconds +).*", r"\1", text) for text in (shown, printed)]
    assert timeless[0] == timeless[1]
    picture = re.search(r"!\[[^]]*?([\d,]+) points become ([\d,]*\d)", README)
    assert picture
    assert f"points {picture[1]} -> {picture[2]}," in shown


def test_the_python_example_prints_what_its_comment_says(
    tmp_path: Path, data: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "data").mkdir()
    shutil.copy(data / "building_a.obj", tmp_path / "data")
    monkeypatch.chdir(tmp_path)
    (example,) = find_blocks(README, "python")
    assert len(example.splitlines()) == 6
    exec(compile(example, "README.md", "exec"), {})
    assert capsys.readouterr().out.strip() == example.strip().rsplit("# ", 1)[1]
    assert (tmp_path / "house.ply").stat().st_size > 0


def test_the_comparison_is_real(tmp_path: Path) -> None:
    text = (ROOT / "docs" / "compare.md").read_text(encoding="utf-8")
    command = find_blocks(text, "sh")[0].splitlines()[0]
    shown = find_blocks(text, "")[0]
    printed = run(command.split()[1:], tmp_path).stdout
    # What fast-simplification finds depends on its version.
    timeless = [re.sub(r"(?m) +[0-9.]+$", "", text) for text in (shown, printed)]
    ours = [[line for line in text.splitlines() if not line.startswith(("fast", "  "))] for text in timeless]
    assert ours[0] == ours[1]
    assert len(ours[0]) == 7
    assert "standard / improved: orientation tests" in shown
    assert shown.split("standard / improved: ")[1] == printed.split("standard / improved: ")[1]


def test_the_two_commands_exist_and_are_shell() -> None:
    commands = re.findall(r"^sh (\S+\.sh)", README, re.MULTILINE)
    assert len(commands) == 2
    for command in commands:
        assert (ROOT / command).read_text(encoding="utf-8").startswith("#!/bin/sh\n")
