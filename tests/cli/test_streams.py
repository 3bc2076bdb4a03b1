"""The command line with streams that are closed, full, or gone, and signals while it starts."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from pathlib import Path

import pytest
from command_line import COMMAND, assert_box, assert_one_error, list_names, run_command, run_in_shell
from shapes import Gltf, fine_box, obj_text, write


@pytest.fixture
def house(tmp_path: Path) -> Path:
    return write(tmp_path / "house.obj", obj_text(*fine_box()))


class TestStreams:
    """Closed, full, or gone: one line where there is still a place for it, and no traceback."""

    def test_a_report_to_standard_output(self, house: Path, tmp_path: Path) -> None:
        result = run_command("simplify", house, tmp_path / "out.obj", "--report", "-", "-q")
        assert (result.returncode, result.stderr) == (0, b"")
        assert json.loads(result.stdout)["after"]["points"] == 8
        assert list_names(tmp_path) == ["house.obj", "out.obj"]

    @pytest.mark.parametrize(
        ("arguments", "closed"),
        [
            (["inspect", "IN"], ">&-"),
            (["simplify", "IN", "-", "--to", "obj"], ">&-"),
            (["simplify", "IN", "out.obj", "--report", "-"], ">&-"),
            (["simplify", "-", "out.obj", "--from", "obj"], "<&-"),
        ],
    )
    def test_closed_where_needed(self, house: Path, tmp_path: Path, arguments: list[str], closed: str) -> None:
        words = [str(house) if word == "IN" else word for word in arguments]
        result = run_in_shell(closed, words, tmp_path)
        assert_one_error(result, 1, "standard input is closed" if "<" in closed else "standard output is closed")
        assert list_names(tmp_path) == ["house.obj"]

    @pytest.mark.parametrize("closed", [">&-", "<&-", "2>&-"])
    def test_closed_where_not_needed(self, house: Path, tmp_path: Path, closed: str) -> None:
        result = run_in_shell(closed, ["simplify", str(house), "out.obj", "-q"], tmp_path)
        assert (result.returncode, result.stdout, result.stderr) == (0, b"", b"")
        assert_box(tmp_path / "out.obj", "obj")

    @pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
    def test_full(self, house: Path, tmp_path: Path) -> None:
        for words in (["inspect", str(house)], ["--help"], ["simplify", str(house), "a.obj", "--report", "-", "-q"]):
            assert_one_error(run_in_shell(">/dev/full", words, tmp_path), 1, "No space left")
        result = run_in_shell("2>/dev/full", ["simplify", str(house), "out.obj"], tmp_path)
        assert (result.returncode, result.stdout, result.stderr) == (1, b"", b"")
        assert_box(tmp_path / "out.obj", "obj")
        assert run_in_shell("2>/dev/full", ["inspect", "none.obj"], tmp_path).returncode == 1

    def test_a_name_that_the_encoding_lacks(self, tmp_path: Path) -> None:
        document = Gltf()
        document.mesh(document.box(), name="Haus \u017b \ud800 \x1b[31m\nred")
        source = write(tmp_path / "in.glb", document.glb())
        result = run_command("inspect", source, env={**os.environ, "PYTHONIOENCODING": "latin-1"})
        assert result.returncode == 0
        assert b"mesh        Haus \\u017b ?  [31m red\n" in result.stdout

    @pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
    def test_a_signal_while_modules_load(self, house: Path, tmp_path: Path, number: int, code: int) -> None:
        words = [COMMAND[0], "-X", "importtime", *COMMAND[1:], "simplify", house, tmp_path / "out.obj"]
        process = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
        assert process.stderr is not None
        told = ""
        while "numpy" not in told:
            told = process.stderr.readline()
            assert told
        process.send_signal(number)
        rest = [line for line in process.stderr if not line.startswith("import time:")]
        assert process.wait(timeout=60) == code
        assert rest == (["bldsimp: error: interrupted\n"] if number == signal.SIGINT else [])
        assert list_names(tmp_path) == ["house.obj"]
