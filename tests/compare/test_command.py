"""`bldsimp compare`: files, standard output, errors and exit codes."""

from __future__ import annotations

import json
import os
import pty
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from command_line import COMMAND, assert_one_error, list_names, run_command
from comparisons import HEADER, METHODS, read_rows
from shapes import box, fine_box, obj_text, write

from bldsimp.compare.rows import COLUMNS


@pytest.fixture
def house(tmp_path: Path) -> Path:
    return write(tmp_path / "house.obj", obj_text(*fine_box()))


class TestCommand:
    def test_a_table_and_files_for_programs(self, house: Path, tmp_path: Path) -> None:
        files = ("--csv", tmp_path / "o.csv", "--json", tmp_path / "o.json")
        result = run_command("compare", house, "--tolerances", "auto, 2%,0.125", *files)
        assert result.returncode == 0
        assert result.stderr == b""
        assert [line for line in result.stdout.decode().splitlines() if line.startswith("tolerance ")] == [
            "tolerance auto (3.46e-06)", "tolerance 2% (0.0693)", "tolerance 0.125",
        ]  # fmt: skip
        told = read_rows((tmp_path / "o.csv").read_text())
        assert [line["tolerance"] for line in told] == ["auto"] * 7 + ["2%"] * 7 + ["0.125"] * 7
        assert [line["points"] for line in told if line["method"] in METHODS[:3]] == ["98", "8", "8"] * 3
        document = json.loads((tmp_path / "o.json").read_text())
        assert document["schema"] == "bldsimp.comparison/1"
        (file,) = document["files"]
        assert (file["file"], file["failed"]) == (str(house), False)
        assert file["tolerances"]["0.125"] == 0.125
        for line, one in zip(told, file["rows"], strict=True):
            assert list(one) == [*COLUMNS, "statistics"]
            assert line["deviation"] == ("" if one["deviation"] is None else str(one["deviation"]))
        assert list_names(tmp_path) == ["house.obj", "o.csv", "o.json"]

    def test_the_default_tolerances(self, house: Path) -> None:
        result = run_command("compare", house, "--json", "-")
        document = json.loads(result.stdout)
        assert list(document["files"][0]["tolerances"]) == ["auto", "0.1%", "0.5%"]

    def test_a_pipe_in_and_json_out(self, house: Path) -> None:
        result = run_command(
            "compare", "-", "--from", "obj", "--json", "-", "--tolerances", "0", stdin=house.read_bytes()
        )
        assert result.returncode == 0
        assert json.loads(result.stdout)["files"][0]["rows"][2]["points"] == 8

    def test_rows_for_programs_on_standard_output(self, house: Path, tmp_path: Path) -> None:
        result = run_command("compare", house, "--tolerances", "0", "--csv", "-", cwd=tmp_path)
        assert (result.returncode, result.stderr) == (0, b"")
        assert [line["method"] for line in read_rows(result.stdout.decode())] == METHODS
        assert list_names(tmp_path) == ["house.obj"]

    @pytest.mark.skipif(not Path("/dev/stdout").exists(), reason="no /dev/stdout")
    def test_a_pipe_without_a_name(self, house: Path) -> None:
        result = run_command("compare", house, "--tolerances", "0", "-q", "--csv", "/dev/stdout")
        assert (result.returncode, result.stderr) == (0, b"")
        assert result.stdout.decode().splitlines()[0] == HEADER

    def test_a_closed_standard_output_is_told_before_the_work(self, house: Path, tmp_path: Path) -> None:
        script = f'exec "$@" compare {house.name} --csv o.csv >&-'
        command = ["sh", "-c", script, "sh", *COMMAND]
        result = subprocess.run(command, cwd=tmp_path, capture_output=True, timeout=60)
        assert_one_error(result, 1, "standard output is closed")
        assert list_names(tmp_path) == ["house.obj"]

    @pytest.mark.skipif(sys.platform == "darwin", reason="names of files are Unicode there")
    def test_a_name_that_is_not_unicode(self, house: Path, tmp_path: Path) -> None:
        odd = os.fsdecode(os.fsencode(tmp_path / "caf") + b"\xe9.obj")
        os.rename(house, odd)
        files = ("--csv", tmp_path / "o.csv", "--json", tmp_path / "o.json", "--html", tmp_path / "o.html")
        result = run_command("compare", odd, "--tolerances", "0", *files)
        assert (result.returncode, result.stderr) == (0, b"")
        assert read_rows((tmp_path / "o.csv").read_text("utf-8"))[0]["file"] == str(tmp_path / "caf\\udce9.obj")
        assert json.loads((tmp_path / "o.json").read_text())["files"][0]["file"] == odd

    @pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
    def test_an_interruption_while_files_are_written_leaves_none(
        self, house: Path, tmp_path: Path, number: int, code: int
    ) -> None:
        pipe = tmp_path / "o.json"
        os.mkfifo(pipe)
        arguments = ["-q", "--tolerances", "0", "--csv", tmp_path / "o.csv", "--json", pipe]
        process = subprocess.Popen([*COMMAND, "compare", house, *arguments], stderr=subprocess.PIPE)
        while len(list_names(tmp_path)) < 3 and process.poll() is None:
            time.sleep(0.01)
        time.sleep(0.1)  # now it waits for a reader of the pipe
        process.send_signal(number)
        assert process.wait(timeout=60) == code
        assert list_names(tmp_path) == ["house.obj", "o.json"]

    def test_quiet_prints_nothing(self, house: Path, tmp_path: Path) -> None:
        result = run_command("compare", house, "-q", "--tolerances", "0", "--csv", tmp_path / "o.csv")
        assert (result.stdout, result.stderr, result.returncode) == (b"", b"", 0)

    def test_a_bad_file_among_good_ones(self, house: Path, tmp_path: Path) -> None:
        bad = write(tmp_path / "bad.obj", "v 0 0 0\nf 1 2 3\n")
        other = write(tmp_path / "other.obj", obj_text(*box()))
        missing, target = tmp_path / "no.obj", tmp_path / "o.csv"
        result = run_command("compare", house, bad, other, house, missing, "--tolerances", "0", "--csv", target)
        assert result.returncode == 1
        lines = result.stderr.decode().splitlines()
        assert lines == [f"bldsimp: error: could not be compared: {bad}, {missing}"]
        told = read_rows(target.read_text())
        files = [*[house] * 7, bad, *[other] * 7, missing]  # what is given twice is compared once
        assert [line["file"] for line in told] == [str(file) for file in files]
        for line in (told[7], told[15]):
            assert (line["tolerance"], line["method"], line["points"]) == ("", "original", "")
            assert line["note"].startswith("failed: ")
        assert f"{bad}: failed: " in " ".join(result.stdout.decode().split())

    def test_a_single_bad_file(self, tmp_path: Path) -> None:
        result = run_command("compare", tmp_path / "no.obj", "--json", "-")
        assert result.returncode == 1
        document = json.loads(result.stdout)
        assert document["files"][0]["failed"] is True
        assert document["files"][0]["diagonal"] is None
        assert document["files"][0]["rows"][0]["note"] == "failed: no such file"
        assert result.stderr.decode() == f"bldsimp: error: {tmp_path / 'no.obj'}: failed: no such file\n"

    def test_no_area_at_all(self, tmp_path: Path) -> None:
        flat = write(tmp_path / "flat.obj", "v 0 0 0\nv 1 0 0\nf 1 2 2\n")
        result = run_command("compare", flat, "-q")
        assert result.returncode == 1
        assert b"failed" in result.stderr

    @pytest.mark.parametrize(
        ("arguments", "told"),
        [
            (["--tolerances", "auto,-1"], "'--tolerances': '-1' is not a length"),
            (["--tolerances", ""], "'--tolerances': '' is not a length"),
            (["--csv", "no/folder/o.csv"], "does not exist"),
            (["--csv", "taken.csv"], "exists: give --overwrite"),
            (["--csv", "o.txt", "--json", "o.txt"], "o.txt is also --csv"),
            (["--json", "house.obj", "--overwrite"], "is also a model"),
            (["--plot", "o.pdf"], "a chart cannot be written as '.pdf'"),
            (["what.txt"], "format 'txt' is not known"),
            (["-", "-", "--from", "obj"], "can be read only once"),
            (["--csv", "-", "--json", "-"], "--csv and --json: only one can go to standard output"),
            (["--html", "-"], "--html: '-' works only with --csv and --json"),
            (["--plot", "-"], "--plot: '-' works only with --csv and --json"),
        ],
    )
    def test_what_is_wrong_before_anything_is_read(
        self, house: Path, tmp_path: Path, arguments: list[str], told: str
    ) -> None:
        write(tmp_path / "taken.csv", "mine")
        before = house.read_bytes()
        assert_one_error(run_command("compare", "missing.obj", "house.obj", *arguments, cwd=tmp_path), 2, told)
        assert (tmp_path / "taken.csv").read_text() == "mine"
        assert house.read_bytes() == before
        assert list_names(tmp_path) == ["house.obj", "taken.csv"]

    def test_overwrite_replaces(self, house: Path, tmp_path: Path) -> None:
        target = write(tmp_path / "o.csv", "mine")
        assert run_command("compare", house, "-q", "--tolerances", "0", "--csv", target, "--overwrite").returncode == 0
        assert target.read_text().splitlines()[0] == HEADER

    def test_the_chart(self, house: Path, tmp_path: Path) -> None:
        assert (
            run_command("compare", house, "-q", "--tolerances", "auto,1%", "--plot", tmp_path / "o.svg").returncode == 0
        )
        assert b"<svg" in (tmp_path / "o.svg").read_bytes()

    def test_help_tells_what_is_not_compared(self) -> None:
        told = " ".join(run_command("compare", "--help").stdout.decode().split())
        assert "Only geometry is compared, not textures, colors and normals" in told
        assert "exit code is 1" in told

    def test_a_bar_on_a_terminal_only(self, house: Path) -> None:
        here, there = pty.openpty()
        command = [*COMMAND, "compare", str(house), "--tolerances", "0", "--json", "-"]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=there)
        os.close(there)
        assert json.loads(process.communicate(timeout=60)[0])["files"]
        assert process.returncode == 0
        shown = os.read(here, 65536).decode()
        os.close(here)
        assert "comparing" in shown
        assert "100%" in shown
