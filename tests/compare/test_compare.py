"""`bldsimp compare`: a fair comparison, told the same way to people and programs."""

from __future__ import annotations

import csv
import io
import json
import math
import os
import pty
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from shapes import FAR, Gltf, box, fine_box, obj_text, open_cone, write
from test_cli import COMMAND, names, one_error, run

from bldsimp import simplify
from bldsimp.compare.comparison import VARIANTS, compare_file, method_names
from bldsimp.compare.decimate import LEAST_TRIANGLES, Decimator, FastSimplification, Refused
from bldsimp.compare.measure import Judge
from bldsimp.compare.peers import FINEST, PEERS, Peer, installed_peers
from bldsimp.compare.row import COLUMNS, Comparison, Row
from bldsimp.compare.surface import Surface, welded
from bldsimp.compare.table import WIDTH, to_csv, to_text
from bldsimp.errors import UsageError

HEADER = "file,tolerance,method,points,triangles,deviation,bound,watertight,border_made,seconds,note"
METHODS = [
    "original", "standard", "improved", "fast-simplification", "fast-simplification border",
    "fast-simplification lossless", "fast-simplification same points",
]  # fmt: skip
NOT_MET = ("no reduction", "does not get down", "refuses")


@pytest.fixture
def house(tmp_path: Path) -> Path:
    return write(tmp_path / "house.obj", obj_text(*fine_box()))


@pytest.fixture(scope="module")
def of_data(data: Path) -> list[Comparison]:
    """Both buildings at a tolerance that loses nothing, and at one that does."""
    return [compare_file(data / name, "obj", name, ["auto", "0.1%"]) for name in ("building_a.obj", "building_b.obj")]


def rows_of(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def row(comparison: Comparison, method: str, tolerance: str) -> Row:
    (found,) = [row for row in comparison.rows if (row.method, row.tolerance) == (method, tolerance)]
    return found


class TestFairness:
    def test_each_tolerance_has_every_method_in_its_order(self, of_data: list[Comparison]) -> None:
        assert method_names([]) == METHODS
        for comparison in of_data:
            assert [row.method for row in comparison.rows] == 2 * METHODS
            assert [row.tolerance for row in comparison.rows] == ["auto"] * 7 + ["0.1%"] * 7
            assert comparison.tolerances["0.1%"] == pytest.approx(1e-3 * comparison.diagonal)

    def test_improved_is_what_simplify_does_and_never_more_than_standard(self, of_data: list[Comparison]) -> None:
        for comparison in of_data:
            original = comparison.original
            for text, tolerance in comparison.tolerances.items():
                improved = row(comparison, "improved", text)
                light = simplify((original.points, original.faces), tolerance)
                assert (improved.points, improved.triangles) == (len(light.mesh[0]), len(light.mesh[1]))
                assert improved.bound == pytest.approx(light.report.deviation)
                assert improved.points <= row(comparison, "standard", text).points
                assert improved.points < improved.triangles < row(comparison, "original", text).triangles

    def test_the_bound_is_not_below_the_deviation_which_is_within_the_tolerance(
        self, of_data: list[Comparison]
    ) -> None:
        for comparison in of_data:
            for one in comparison.rows:
                if one.method == "improved":
                    assert 0.0 < one.deviation <= one.bound <= comparison.tolerances[one.tolerance]
                if one.method == "standard":
                    assert one.deviation <= comparison.tolerances[one.tolerance]

    def test_every_row_is_measured_alike(self, of_data: list[Comparison]) -> None:
        for comparison in of_data:
            judge = Judge(comparison.original)
            for one in comparison.rows[7:]:
                if one.surface is None:
                    assert one.note.startswith(NOT_MET)
                    continue
                assert one.deviation == (0.0 if one.method == "original" else judge.deviation(one.surface))
                assert (one.points, one.triangles) == (len(one.surface.points), len(one.surface.faces))

    def test_decimators_stay_within_the_deviation_of_improved_or_have_its_points(
        self, of_data: list[Comparison]
    ) -> None:
        met = 0
        for comparison in of_data:
            judge = Judge(comparison.original)
            for text in comparison.tolerances:
                improved = row(comparison, "improved", text)
                for method in VARIANTS:
                    one = row(comparison, method, text)
                    if one.points is not None:
                        assert one.deviation <= improved.deviation + judge.blur
                        met += 1
                same = row(comparison, METHODS[-1], text)
                assert improved.points <= same.points <= 1.01 * improved.points + 1
                assert same.deviation > improved.deviation
        assert met > 4

    def test_statistics_are_there_for_the_two_that_triangulate(self, of_data: list[Comparison]) -> None:
        for one in of_data[1].rows:
            assert bool(one.statistics) == (one.method in ("standard", "improved"))
        standard, improved = (row(of_data[1], method, "auto").statistics for method in ("standard", "improved"))
        assert standard["by_poles"] == 0 < improved["by_poles"]
        assert min(improved[name] for name in ("by_determinant", "located", "walked", "flips")) > 0

    @pytest.mark.parametrize("shift", FAR)
    def test_map_coordinates_measure_as_well(self, tmp_path: Path, shift: float) -> None:
        path = write(tmp_path / "far.obj", obj_text(*fine_box(shift=shift)))
        comparison = compare_file(path, "obj", "far", ["0"])
        improved = row(comparison, "improved", "0")
        assert (improved.points, improved.deviation, improved.border_made) == (8, pytest.approx(0.0, abs=1e-14), 0)

    def test_all_instances_are_compared_mirrored_ones_too(self, tmp_path: Path) -> None:
        gltf = Gltf()
        gltf.mesh(gltf.box(fine=True))
        gltf.json["nodes"].append({"mesh": 0, "translation": [9.0, 0.0, 0.0], "scale": [-1.0, 1.0, 1.0]})
        gltf.json["scenes"][0]["nodes"].append(1)
        comparison = compare_file(write(tmp_path / "two.glb", gltf.glb()), "glb", "two", ["auto"])
        assert [one.points for one in comparison.rows[:3]] == [2 * 98, 16, 16]
        assert row(comparison, "improved", "auto").watertight

    def test_attributes_are_not_regarded(self, tmp_path: Path) -> None:
        gltf = Gltf()
        colours = gltf.accessor(np.ones((98, 3)))
        gltf.mesh(gltf.box(fine=True, COLOR_0=colours))
        comparison = compare_file(write(tmp_path / "red.glb", gltf.glb()), "glb", "red", ["auto"])
        assert row(comparison, "improved", "auto").points == 8

    @pytest.mark.parametrize("shape", [([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]), open_cone(3), box()])
    def test_shapes_smaller_than_the_least_target(self, tmp_path: Path, shape) -> None:
        comparison = compare_file(write(tmp_path / "tiny.obj", obj_text(*shape)), "obj", "tiny", ["auto"])
        assert not comparison.failed
        improved = row(comparison, "improved", "auto")
        assert improved.points == len(shape[0])
        assert improved.border_made == 0


def faces_apart(count: int) -> Surface:
    """Faces that share no point."""
    rows = np.arange(3 * count)
    return welded(np.stack([rows, rows % 3, rows % 2], axis=1).astype(float), rows.reshape(-1, 3).astype(np.int32))


class TestDecimator:
    def test_runs_are_shared_between_limits(self) -> None:
        points, faces = fine_box(12)
        asked: list[int] = []
        tool = FastSimplification()

        def counted(points, faces, target):
            asked.append(target)
            return tool(points, faces, target)

        start = welded(points, faces)
        shared = Decimator(Judge(start), counted)
        both = [shared.fewest_points(limit) for limit in (1e-3, 0.2, 1e-3)]
        alone = [Decimator(Judge(start), tool).fewest_points(limit) for limit in (1e-3, 0.2)]
        assert [len(found.surface.points) for found in both] == [len(alone[k].surface.points) for k in (0, 1, 0)]
        assert both[0].deviation == alone[0].deviation <= 1e-3
        repeated = len(asked) - len(set(asked))
        assert repeated <= 6

    def test_a_target_that_is_never_met_is_none(self) -> None:
        start = welded(*open_cone())
        assert Decimator(Judge(start), FastSimplification()).fewest_points(0.0) is None

    def test_lossless_is_asked_once(self) -> None:
        calls: list[int] = []

        def one_result(points, faces, target):
            calls.append(target)
            return points[:0], faces[:0]

        start = welded(*fine_box())
        assert Decimator(Judge(start), one_result, aimed=False).fewest_points(1.0) is None
        assert len(calls) == 1

    @pytest.mark.parametrize("points", [8, 40, 97, 98])
    def test_as_many_points_as_asked(self, points: int) -> None:
        start = welded(*fine_box())
        found = Decimator(Judge(start), FastSimplification()).at_points(points)
        assert points <= len(found.surface.points) <= points + 1
        assert found.deviation == Judge(start).deviation(found.surface)

    @pytest.mark.parametrize("points", [90, 300, 597])
    def test_a_tool_that_takes_a_length_is_asked_for_points_too(self, points: int) -> None:
        def longer_is_fewer(points, faces, target):
            return points, faces[: round(len(faces) * math.log(target) / math.log(FINEST))]

        found = Decimator(Judge(faces_apart(200)), longer_is_fewer, most=FINEST).at_points(points)
        assert points <= len(found.surface.points) <= points + 3

    def test_points_that_stay_the_same_for_many_targets_are_left_behind(self) -> None:
        def stops_early(points, faces, target):
            return points, faces[: max(target, 900)]

        found = Decimator(Judge(faces_apart(20_000)), stops_early).at_points(2_730)
        assert 2_730 <= len(found.surface.points) <= 2_760

    def test_no_fewer_points_than_the_tool_gives(self) -> None:
        start = welded(*fine_box())
        found = Decimator(Judge(start), lambda points, faces, target: (points, faces)).at_points(20)
        assert len(found.surface.points) == 98


class TestNotMet:
    def test_it_is_told_instead_of_a_number(self, tmp_path: Path) -> None:
        comparison = compare_file(write(tmp_path / "cone.obj", obj_text(*open_cone())), "obj", "cone", ["auto"])
        for method in ("fast-simplification", "fast-simplification border"):
            one = row(comparison, method, "auto")
            assert one.note.startswith("no reduction within the same deviation as improved")
            assert (one.points, one.triangles, one.deviation, one.seconds) == (None,) * 4
        line = to_csv([comparison]).splitlines()[4]
        assert line.startswith("cone,auto,fast-simplification,,,,,,,,no reduction within")

    def test_a_peer_that_refuses(self, house: Path) -> None:
        def refuse(module, points, faces, target):
            raise Refused("not to its taste")

        comparison = compare_file(house, "obj", "house", ["auto"], [Peer("json", refuse)])
        one = comparison.rows[-1]
        assert (one.method, one.points, one.note) == ("json", None, "refuses the input: not to its taste")

    def test_borders_that_are_torn_are_counted(self, house: Path) -> None:
        def tear(module, points, faces, target):
            return points, faces[2:]

        comparison = compare_file(house, "obj", "house", ["1"], [Peer("json", tear)])
        assert row(comparison, "original", "1").border_made == 0
        torn = Judge(comparison.original).borders_made(
            Surface(comparison.original.points, comparison.original.faces[2:]), 1e-3
        )
        assert torn == 4


class TestPeers:
    def test_only_what_is_installed_is_asked_and_nothing_loaded(self) -> None:
        code = (
            "import sys; from bldsimp.compare.peers import installed_peers; print([p.name for p in installed_peers()]);"
            "assert not {'manifold3d', 'meshoptimizer', 'open3d', 'pymeshlab', 'pyfqmr'} & set(sys.modules)"
        )
        told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
        assert told.strip() == str([peer.name for peer in installed_peers()])
        assert [peer.name for peer in PEERS] == ["manifold3d", "meshoptimizer", "open3d", "pymeshlab", "pyfqmr"]

    @pytest.mark.parametrize("peer", PEERS, ids=lambda peer: peer.name)
    def test_each_reduces_a_fine_box_at_the_same_deviation(self, peer: Peer, tmp_path: Path) -> None:
        pytest.importorskip(peer.name, reason=f"{peer.name} is not installed")
        path = write(tmp_path / "box.obj", obj_text(*fine_box(8)))
        comparison = compare_file(path, "obj", "box", ["0.01"], [peer])
        one = comparison.rows[-1]
        assert one.method == peer.name
        assert one.points is not None, one.note
        assert 8 <= one.points < 386
        assert one.deviation <= row(comparison, "improved", "0.01").deviation + Judge(comparison.original).blur
        assert one.watertight
        assert one.seconds > 0.0

    def test_manifold_refuses_what_is_open(self, tmp_path: Path) -> None:
        pytest.importorskip("manifold3d", reason="manifold3d is not installed")
        path = write(tmp_path / "cone.obj", obj_text(*open_cone()))
        one = compare_file(path, "obj", "cone", ["0.1"], [PEERS[0]]).rows[-1]
        assert one.points is None
        assert one.note.startswith("refuses the input: NotManifold")


class TestText:
    def test_it_is_aligned_and_fits(self, of_data: list[Comparison]) -> None:
        text = to_text(of_data)
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

    def test_csv_reads_back_exactly(self, of_data: list[Comparison]) -> None:
        text = to_csv(of_data)
        assert text.splitlines()[0] == HEADER == ",".join(COLUMNS)
        told = rows_of(text)
        assert len(told) == 28
        for line, one in zip(told, (one for each in of_data for one in each.rows), strict=True):
            assert (line["file"], line["tolerance"], line["method"]) == (one.file, one.tolerance, one.method)
            assert line["points"] == ("" if one.points is None else str(one.points))
            assert (float(line["deviation"]) if line["deviation"] else None) == one.deviation
            assert line["watertight"] in ("true", "false", "")

    def test_a_failure_with_a_comma_stays_one_field(self) -> None:
        failed = Comparison("a,b.obj", None, 0.0, {}, [Row("a,b.obj", "", "original", note='no, "no"')], True)
        assert rows_of(to_csv([failed]))[0]["note"] == 'no, "no"'

    @pytest.mark.parametrize("file", ["a\rb.obj", "a\nb.obj", "a\r\nb.obj", 'a"b".obj', "a,b;c.obj", " a "])
    def test_csv_keeps_any_name(self, file: str) -> None:
        failed = Comparison(file, None, 0.0, {}, [Row(file, "", "original")], True)
        text = to_csv([failed, failed])
        assert text.startswith(HEADER + "\n")
        assert [line["file"] for line in csv.DictReader(io.StringIO(text, newline=""))] == [file, file]

    def test_the_table_keeps_control_characters_from_the_terminal(self, house: Path) -> None:
        done = compare_file(house, "obj", "\x1b[31m\nred.obj", ["0"])
        failed = Comparison("\x1b[31m\nred.obj", None, 0.0, {}, [Row("", "", "original", note="a\x1b\nb")], True)
        lines = to_text([done, failed]).splitlines()
        assert lines[0].startswith(" [31m red.obj: diagonal ")
        assert lines[-1].strip().startswith("[31m red.obj: a  b")
        assert all(line.isprintable() for line in lines)


class TestCommand:
    def test_a_table_and_files_for_programs(self, house: Path, tmp_path: Path) -> None:
        files = ("--csv", tmp_path / "o.csv", "--json", tmp_path / "o.json")
        result = run("compare", house, "--tolerances", "auto, 2%,0.125", *files)
        assert result.returncode == 0
        assert result.stderr == b""
        assert [line for line in result.stdout.decode().splitlines() if line.startswith("tolerance ")] == [
            "tolerance auto (3.46e-06)", "tolerance 2% (0.0693)", "tolerance 0.125",
        ]  # fmt: skip
        told = rows_of((tmp_path / "o.csv").read_text())
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
        assert names(tmp_path) == ["house.obj", "o.csv", "o.json"]

    def test_the_default_tolerances(self, house: Path) -> None:
        result = run("compare", house, "--json", "-")
        document = json.loads(result.stdout)
        assert list(document["files"][0]["tolerances"]) == ["auto", "0.1%", "0.5%"]

    def test_a_pipe_in_and_json_out(self, house: Path) -> None:
        result = run("compare", "-", "--from", "obj", "--json", "-", "--tolerances", "0", stdin=house.read_bytes())
        assert result.returncode == 0
        assert json.loads(result.stdout)["files"][0]["rows"][2]["points"] == 8

    def test_rows_for_programs_on_standard_output(self, house: Path, tmp_path: Path) -> None:
        result = run("compare", house, "--tolerances", "0", "--csv", "-", cwd=tmp_path)
        assert (result.returncode, result.stderr) == (0, b"")
        assert [line["method"] for line in rows_of(result.stdout.decode())] == METHODS
        assert names(tmp_path) == ["house.obj"]

    @pytest.mark.skipif(not Path("/dev/stdout").exists(), reason="no /dev/stdout")
    def test_a_pipe_without_a_name(self, house: Path) -> None:
        result = run("compare", house, "--tolerances", "0", "-q", "--csv", "/dev/stdout")
        assert (result.returncode, result.stderr) == (0, b"")
        assert result.stdout.decode().splitlines()[0] == HEADER

    def test_a_closed_standard_output_is_told_before_the_work(self, house: Path, tmp_path: Path) -> None:
        script = f'exec "$@" compare {house.name} --csv o.csv >&-'
        command = ["sh", "-c", script, "sh", *COMMAND]
        result = subprocess.run(command, cwd=tmp_path, capture_output=True, timeout=60)
        one_error(result, 1, "standard output is closed")
        assert names(tmp_path) == ["house.obj"]

    @pytest.mark.skipif(sys.platform == "darwin", reason="names of files are Unicode there")
    def test_a_name_that_is_not_unicode(self, house: Path, tmp_path: Path) -> None:
        odd = os.fsdecode(os.fsencode(tmp_path / "caf") + b"\xe9.obj")
        os.rename(house, odd)
        files = ("--csv", tmp_path / "o.csv", "--json", tmp_path / "o.json", "--html", tmp_path / "o.html")
        result = run("compare", odd, "--tolerances", "0", *files)
        assert (result.returncode, result.stderr) == (0, b"")
        assert rows_of((tmp_path / "o.csv").read_text("utf-8"))[0]["file"] == str(tmp_path / "caf\\udce9.obj")
        assert json.loads((tmp_path / "o.json").read_text())["files"][0]["file"] == odd

    @pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
    def test_an_interruption_while_files_are_written_leaves_none(
        self, house: Path, tmp_path: Path, number: int, code: int
    ) -> None:
        pipe = tmp_path / "o.json"
        os.mkfifo(pipe)
        arguments = ["-q", "--tolerances", "0", "--csv", tmp_path / "o.csv", "--json", pipe]
        process = subprocess.Popen([*COMMAND, "compare", house, *arguments], stderr=subprocess.PIPE)
        while len(names(tmp_path)) < 3 and process.poll() is None:
            time.sleep(0.01)
        time.sleep(0.1)  # now it waits for a reader of the pipe
        process.send_signal(number)
        assert process.wait(timeout=60) == code
        assert names(tmp_path) == ["house.obj", "o.json"]

    def test_quiet_prints_nothing(self, house: Path, tmp_path: Path) -> None:
        result = run("compare", house, "-q", "--tolerances", "0", "--csv", tmp_path / "o.csv")
        assert (result.stdout, result.stderr, result.returncode) == (b"", b"", 0)

    def test_a_bad_file_among_good_ones(self, house: Path, tmp_path: Path) -> None:
        bad = write(tmp_path / "bad.obj", "v 0 0 0\nf 1 2 3\n")
        other = write(tmp_path / "other.obj", obj_text(*box()))
        missing, target = tmp_path / "no.obj", tmp_path / "o.csv"
        result = run("compare", house, bad, other, house, missing, "--tolerances", "0", "--csv", target)
        assert result.returncode == 1
        lines = result.stderr.decode().splitlines()
        assert lines == [f"bldsimp: error: could not be compared: {bad}, {missing}"]
        told = rows_of(target.read_text())
        files = [*[house] * 7, bad, *[other] * 7, missing]  # what is given twice is compared once
        assert [line["file"] for line in told] == [str(file) for file in files]
        for line in (told[7], told[15]):
            assert (line["tolerance"], line["method"], line["points"]) == ("", "original", "")
            assert line["note"].startswith("failed: ")
        assert f"{bad}: failed: " in " ".join(result.stdout.decode().split())

    def test_a_single_bad_file(self, tmp_path: Path) -> None:
        result = run("compare", tmp_path / "no.obj", "--json", "-")
        assert result.returncode == 1
        document = json.loads(result.stdout)
        assert document["files"][0]["failed"] is True
        assert document["files"][0]["diagonal"] is None
        assert document["files"][0]["rows"][0]["note"] == "failed: no such file"
        assert result.stderr.decode() == f"bldsimp: error: {tmp_path / 'no.obj'}: failed: no such file\n"

    def test_no_area_at_all(self, tmp_path: Path) -> None:
        flat = write(tmp_path / "flat.obj", "v 0 0 0\nv 1 0 0\nf 1 2 2\n")
        result = run("compare", flat, "-q")
        assert result.returncode == 1
        assert b"failed" in result.stderr

    @pytest.mark.parametrize(
        ("arguments", "told"),
        [
            (["--tolerances", "auto,-1"], "--tolerances: '-1' is not a length"),
            (["--tolerances", ""], "--tolerances: '' is not a length"),
            (["--csv", "no/folder/o.csv"], "does not exist"),
            (["--csv", "taken.csv"], "exists: give --overwrite"),
            (["--csv", "o.txt", "--json", "o.txt"], "o.txt is also --csv"),
            (["--json", "house.obj", "--overwrite"], "is also a model"),
            (["--plot", "o.pdf"], "a chart cannot be written as '.pdf'"),
            (["what.txt"], "format 'txt' is not known"),
            (["-", "-", "--from", "obj"], "can be read once only"),
            (["--csv", "-", "--json", "-"], "--csv and --json: standard output takes one of them"),
            (["--html", "-"], "--html: '-' is for --csv and --json"),
            (["--plot", "-"], "--plot: '-' is for --csv and --json"),
        ],
    )
    def test_what_is_wrong_before_anything_is_read(
        self, house: Path, tmp_path: Path, arguments: list[str], told: str
    ) -> None:
        write(tmp_path / "taken.csv", "mine")
        before = house.read_bytes()
        one_error(run("compare", "missing.obj", "house.obj", *arguments, cwd=tmp_path), 2, told)
        assert (tmp_path / "taken.csv").read_text() == "mine"
        assert house.read_bytes() == before
        assert names(tmp_path) == ["house.obj", "taken.csv"]

    def test_overwrite_replaces(self, house: Path, tmp_path: Path) -> None:
        target = write(tmp_path / "o.csv", "mine")
        assert run("compare", house, "-q", "--tolerances", "0", "--csv", target, "--overwrite").returncode == 0
        assert target.read_text().splitlines()[0] == HEADER

    def test_the_chart(self, house: Path, tmp_path: Path) -> None:
        pytest.importorskip("matplotlib", reason="the extra 'plots' is not installed")
        assert run("compare", house, "-q", "--tolerances", "auto,1%", "--plot", tmp_path / "o.svg").returncode == 0
        assert b"<svg" in (tmp_path / "o.svg").read_bytes()

    def test_help_tells_what_is_not_compared(self) -> None:
        told = " ".join(run("compare", "--help").stdout.decode().split())
        assert "Geometry alone is compared: textures, colours and normals are not regarded" in told
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


def test_a_wrong_tolerance_is_refused(house: Path) -> None:
    with pytest.raises(UsageError):
        compare_file(house, "obj", "house", ["much"])


def test_the_least_target_is_a_box() -> None:
    assert len(box()[1]) == LEAST_TRIANGLES


@pytest.mark.slow
def test_models_have_no_more_points_than_the_standard_method_leaves(models: Path) -> None:
    for path in ("city/derived_val3dity_fzk_haus.obj", "exact/vcity_tour_part_dieu.obj"):
        comparison = compare_file(models / path, "obj", path, ["auto", "0.1%"])
        assert not comparison.failed
        for text, tolerance in comparison.tolerances.items():
            improved = row(comparison, "improved", text)
            assert improved.points <= row(comparison, "standard", text).points
            assert improved.deviation <= improved.bound <= tolerance
