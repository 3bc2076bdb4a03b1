"""The table, CSV and JSON: the same figures for people and programs."""

from __future__ import annotations

import csv
import io
import re
from pathlib import Path

import pytest
from comparisons import HEADER, METHODS, compare_data, read_rows
from shapes import fine_box, obj_text, write

from bldsimp.compare.rows import COLUMNS, Comparison, MethodRow, compare_file
from bldsimp.compare.table import WIDTH, format_csv, format_text


@pytest.fixture
def house(tmp_path: Path) -> Path:
    return write(tmp_path / "house.obj", obj_text(*fine_box()))


@pytest.fixture
def data_comparisons(data: Path) -> list[Comparison]:
    return compare_data(data)


class TestText:
    def test_it_is_aligned_and_fits(self, data_comparisons: list[Comparison]) -> None:
        text = format_text(data_comparisons)
        assert max(map(len, text.splitlines())) <= WIDTH
        lines = text.splitlines()
        starts = [i for i, line in enumerate(lines) if line.startswith("method ")]
        assert len(starts) == 4
        for start in starts:
            table = lines[start : start + 8]
            assert len({len(line) for line in table}) == 1
            shown = ["method", *METHODS[:4], "border", "lossless", "same points"]
            assert [re.split("  +", line.strip())[0] for line in table] == shown
        assert "16,872" in text
        assert "diagonal 18.4751, lengths in model units" in text
        assert "orientation tests by poles 0 / " in text

    def test_csv_reads_back_exactly(self, data_comparisons: list[Comparison]) -> None:
        text = format_csv(data_comparisons)
        assert text.splitlines()[0] == HEADER == ",".join(COLUMNS)
        told = read_rows(text)
        assert len(told) == 28
        for line, one in zip(told, (one for each in data_comparisons for one in each.rows), strict=True):
            assert (line["file"], line["tolerance"], line["method"]) == (one.file, one.tolerance, one.method)
            assert line["points"] == ("" if one.points is None else str(one.points))
            assert (float(line["deviation"]) if line["deviation"] else None) == one.deviation
            assert line["watertight"] in ("true", "false", "")

    def test_a_failure_with_a_comma_stays_one_field(self) -> None:
        failed = Comparison("a,b.obj", None, 0.0, {}, [MethodRow("a,b.obj", "", "original", note='no, "no"')], True)
        assert read_rows(format_csv([failed]))[0]["note"] == 'no, "no"'

    @pytest.mark.parametrize("file", ["a\rb.obj", "a\nb.obj", "a\r\nb.obj", 'a"b".obj', "a,b;c.obj", " a "])
    def test_csv_keeps_any_name(self, file: str) -> None:
        failed = Comparison(file, None, 0.0, {}, [MethodRow(file, "", "original")], True)
        text = format_csv([failed, failed])
        assert text.startswith(HEADER + "\n")
        assert [line["file"] for line in csv.DictReader(io.StringIO(text, newline=""))] == [file, file]

    def test_the_table_keeps_control_characters_from_the_terminal(self, house: Path) -> None:
        done = compare_file(house, "obj", "\x1b[31m\nred.obj", ["0"])
        failed = Comparison("\x1b[31m\nred.obj", None, 0.0, {}, [MethodRow("", "", "original", note="a\x1b\nb")], True)
        lines = format_text([done, failed]).splitlines()
        assert lines[0].startswith(" [31m red.obj: diagonal ")
        assert lines[-1].strip().startswith("[31m red.obj: a  b")
        assert all(line.isprintable() for line in lines)
