"""The command line, as a process: the mesh that comes out, error lines, exit codes, nothing half-written."""

from __future__ import annotations

import dataclasses
import json
import os
import resource
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
from command_line import COMMAND, assert_box, assert_one_error, list_names, run_command
from shapes import Gltf, box, fine_box, obj_text, open_cone, ply_bytes, write

from bldsimp import Options
from bldsimp.cli import main
from bldsimp.io import read


@pytest.fixture
def house(tmp_path: Path) -> Path:
    return write(tmp_path / "house.obj", obj_text(*fine_box()))


class TestSimplify:
    def test_a_file_into_a_file_with_a_report(self, house: Path, tmp_path: Path) -> None:
        result = run_command("simplify", house, tmp_path / "out.glb", "--report", tmp_path / "report.json")
        assert result.returncode == 0
        assert result.stdout == b""
        assert_box(tmp_path / "out.glb", "glb")
        report = json.loads((tmp_path / "report.json").read_text())
        assert report["schema"] == "bldsimp.report/2"
        assert (report["before"]["points"], report["after"]["points"]) == (98, 8)
        assert (report["before"]["bytes"], report["after"]["bytes"]) == (
            house.stat().st_size, (tmp_path / "out.glb").stat().st_size,
        )  # fmt: skip
        assert report["before"]["watertight"] is report["after"]["watertight"] is True
        assert report["deviation"] <= report["tolerance"]
        assert report["facets"] == sum(report["facet_levels"].values()) == 6
        summary = result.stderr.decode()
        assert "98 -> 8" in summary
        assert "watertight" in summary
        assert list_names(tmp_path) == ["house.obj", "out.glb", "report.json"]

    def test_what_goes_as_a_whole_is_told(self, tmp_path: Path) -> None:
        shapes = {"wall": box(4.0), "panel": box(1.0, 3.5), "speck": box(0.1, 9.0)}
        text, start = "", 1
        for name, (points, faces) in shapes.items():
            text += f"o {name}\n" + obj_text(points, faces, start=start)
            start += len(points)
        source, report = write(tmp_path / "in.obj", text), tmp_path / "report.json"
        options = ["--tolerance", "1.2", "--min-component", "0.2", "--report", report]
        result = run_command("simplify", source, tmp_path / "out.obj", *options)
        assert result.returncode == 0
        assert_box(tmp_path / "out.obj", "obj")
        removed = json.loads(report.read_text())["removed_components"]
        assert [(one["part"], one["triangles"], one["reason"]) for one in removed] == [
            ("speck", 12, "smaller_than_min_component"), ("panel", 12, "within_tolerance"),
        ]  # fmt: skip
        summary = result.stderr.decode()
        assert "removed    1 component within the tolerance of the rest: panel\n" in summary
        assert "removed    1 component smaller than --min-component, not counted in the deviation: speck\n" in summary

    def test_a_hole_closes_unless_the_topology_is_kept(self, tmp_path: Path) -> None:
        points, faces = fine_box()
        source, report = write(tmp_path / "in.obj", obj_text(points, faces[1:])), tmp_path / "report.json"
        for options, closed in ((["--keep-topology"], 0), ([], 1)):
            result = run_command(
                "simplify", source, "-", "--to", "obj", "--tolerance", "0.2", "--report", report, *options
            )
            assert result.returncode == 0
            assert json.loads(report.read_text())["closed_boundary_loops"] == closed
            assert (b"details    1 boundary loop within" in result.stderr) == (closed == 1)
        assert_box(result.stdout, "obj")

    def test_pipes(self, house: Path) -> None:
        result = run_command("simplify", "-", "-", "--from", "obj", "--to", "ply", stdin=house.read_bytes())
        assert result.returncode == 0
        assert_box(result.stdout, "ply")
        assert b"98 -> 8" in result.stderr

    def test_quiet_and_verbose(self, house: Path, tmp_path: Path) -> None:
        assert run_command("simplify", house, tmp_path / "a.ply", "-q").stderr == b""
        plain = run_command("simplify", house, tmp_path / "b.ply").stderr
        verbose = run_command("simplify", house, tmp_path / "c.ply", "-v").stderr
        assert len(verbose.splitlines()) > len(plain.splitlines())

    def test_in_place(self, house: Path, tmp_path: Path) -> None:
        before = house.read_bytes()
        assert_one_error(run_command("simplify", house, house), 2, "exists", "--overwrite")
        assert house.read_bytes() == before
        assert run_command("simplify", house, house, "--overwrite").returncode == 0
        assert_box(house, "obj")
        assert list_names(tmp_path) == ["house.obj"]

    def test_a_gltf_in_place_keeps_its_buffer_name(self, tmp_path: Path) -> None:
        document = Gltf()
        document.mesh(document.box(fine=True))
        write(tmp_path / "walls.bin", bytes(document.data))
        path = write(tmp_path / "house.gltf", document.gltf("walls.bin"))
        assert run_command("simplify", path, path, "--overwrite").returncode == 0
        assert_box(path, "gltf")
        assert list_names(tmp_path) == ["house.gltf", "walls.bin"]

    def test_the_buffer_of_the_input_is_never_replaced_by_another_output(self, tmp_path: Path) -> None:
        document = Gltf()
        document.mesh(document.box(fine=True))
        buffer = write(tmp_path / "out.bin", bytes(document.data))
        path = write(tmp_path / "in.gltf", document.gltf("out.bin"))
        assert run_command("simplify", path, tmp_path / "out.gltf", "--overwrite").returncode == 0
        assert buffer.read_bytes() == document.data
        assert_box(tmp_path / "out.gltf", "gltf")

    @pytest.mark.parametrize("tolerance", ["auto", "0", "1e-6", "0.001%"])
    def test_tolerances(self, house: Path, tmp_path: Path, tolerance: str) -> None:
        result = run_command("simplify", house, tmp_path / "out.obj", "--tolerance", tolerance)
        assert result.returncode == 0
        assert_box(tmp_path / "out.obj", "obj")

    def test_colors_are_kept_unless_they_may_be_crossed(self, tmp_path: Path) -> None:
        text = obj_text(*fine_box()).replace("\nf", " 1 0 0\nf", 1).replace("\nv", " 1 0 0\nv")
        source = write(tmp_path / "red.obj", text)
        run_command("simplify", source, tmp_path / "a.obj")
        assert_box(tmp_path / "a.obj", "obj")
        colors = read(tmp_path / "a.obj", "obj").meshes[0].attributes[0].values
        assert np.array_equal(colors, np.tile([1.0, 0.0, 0.0], (8, 1)))
        result = run_command("simplify", source, tmp_path / "b.obj", "--delimit", "none")
        assert b"removed as requested, from 1 part: colors" in result.stderr
        assert_box(tmp_path / "b.obj", "obj")
        assert not read(tmp_path / "b.obj", "obj").meshes[0].attributes

    def test_few_removed_points_and_coarse_numbers_give_a_hint(self, tmp_path: Path) -> None:
        source = write(tmp_path / "cone.obj", obj_text(*open_cone()))
        assert b"few points could be removed" in run_command("simplify", source, tmp_path / "a.obj").stderr
        points, faces = open_cone()
        source = write(tmp_path / "far.ply", ply_bytes(points + 5_000_000.0, faces))
        assert b"than the tolerance: try --tolerance 2" in run_command("simplify", source, tmp_path / "b.ply").stderr

    def test_same_bytes_twice_and_nothing_more_the_second_time(self, house: Path, tmp_path: Path) -> None:
        for name in ("a.glb", "b.glb"):
            run_command("simplify", house, tmp_path / name)
        assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()
        run_command("simplify", tmp_path / "a.glb", tmp_path / "c.glb")
        assert_box(tmp_path / "c.glb", "glb")

    def test_scripted_formats_without_suffix(self, house: Path, tmp_path: Path) -> None:
        plain = write(tmp_path / "model", house.read_bytes())
        assert run_command("simplify", plain, tmp_path / "light", "--from", "OBJ", "--to", ".ply").returncode == 0
        assert_box(tmp_path / "light", "ply")


class TestWrongUsage:
    """Exit code 2, before anything is read: IN need not even exist."""

    @pytest.mark.parametrize(
        ("arguments", "told"),
        [
            (["none.obj", "out.obj", "--tolerance", "-1"], "--tolerance"),
            (["none.obj", "out.obj", "--tolerance", "nan"], "--tolerance"),
            (["none.obj", "out.obj", "--tolerance", "inf%"], "--tolerance"),
            (["none.obj", "out.obj", "--tolerance", "much"], "--tolerance"),
            (["none.obj", "out.obj", "--weld", "-0.1"], "--weld"),
            (["none.obj", "out.obj", "--min-component", "-0.1"], "--min-component"),
            (["none.obj", "out.obj", "--min-component", "inf"], "--min-component"),
            (["none.obj", "out.obj", "--min-component", "1%"], "--min-component"),
            (["none.obj", "out.obj", "--normals", "pretty"], "pretty"),
            (["none.obj", "out.obj", "--no-such-option"], "--no-such-option"),
            (["none.obj", "out.obj", "-q", "-v"], "exclude"),
            (["none.obj"], "OUT"),
            (["none.obj", "out.docx"], "docx"),
            (["none.docx", "out.obj"], "docx"),
            (["none.obj", "out"], "suffix"),
            (["none.obj", "-"], "--to"),
            (["-", "out.obj"], "--from"),
            (["none.obj", "missing/out.obj"], "folder"),
            (["none.obj", "folder.obj"], "directory"),
            (["folder.obj", "out.obj"], "directory"),
            (["none.obj", "there.obj"], "--overwrite"),
            (["none.obj", "out.obj", "--report", "missing/r.json"], "folder"),
            (["none.obj", "out.obj", "--report", "out.obj"], "--report"),
            (["none.obj", "out.obj", "--report", "out.mtl"], "--report"),
            (["none.gltf", "out.obj", "--report", "none.bin"], "--report"),
            (["none.obj", "-", "--to", "obj", "--report", "-"], "standard output, too"),
            (["none.obj", "loop.obj"], "symbolic links"),
            (["none.obj", "out.obj", "--report", "loop.obj"], "symbolic links"),
            (["none.obj", "there.obj/out.obj"], "folder"),
            (["none.obj", "o" * 300 + ".obj"], "too long"),
            (["none.obj", "out\n\x1b[2J.docx"], "out  [2J.docx"),
        ],
    )
    def test_is_told_in_one_line(
        self, tmp_path: Path, monkeypatch, capfdbinary, arguments: list[str], told: str
    ) -> None:
        monkeypatch.chdir(tmp_path)
        (tmp_path / "folder.obj").mkdir()
        write(tmp_path / "there.obj", "old")
        (tmp_path / "loop.obj").symlink_to("loop.obj")
        code = main(["simplify", *arguments])
        assert_one_error(subprocess.CompletedProcess([], code, *capfdbinary.readouterr()), 2, told)
        assert (tmp_path / "there.obj").read_bytes() == b"old"
        assert list_names(tmp_path) == ["folder.obj", "loop.obj", "there.obj"]


class TestFailure:
    """Exit code 1, and nothing written."""

    @pytest.mark.parametrize(
        ("name", "content", "told"),
        [
            ("none.obj", None, "no such file"),
            ("empty.obj", "", "empty"),
            ("points.obj", "v 0 0 0\n", "no faces"),
            ("cut.glb", b"glTF\x02\x00\x00\x00\xff\x00\x00\x00\x00\x00\x00\x00JSON", "truncated"),
            ("far.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "line 4"),
            ("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "not finite"),
        ],
    )
    def test_unreadable_input(self, tmp_path: Path, name: str, content: str | bytes | None, told: str) -> None:
        if content is not None:
            write(tmp_path / name, content)
        before = list_names(tmp_path)
        report = ["--report", tmp_path / "r.json"]
        assert_one_error(run_command("simplify", tmp_path / name, tmp_path / "out.glb", *report), 1, name, told)
        assert list_names(tmp_path) == before

    def test_a_face_without_area_is_no_result(self, tmp_path: Path) -> None:
        source = write(tmp_path / "in.obj", "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n")
        result = run_command("simplify", source, tmp_path / "out.obj")
        assert result.returncode == 1
        assert list_names(tmp_path) == ["in.obj"]

    def test_a_full_disk(self, house: Path, tmp_path: Path) -> None:
        old = write(tmp_path / "out.obj", "old")

        def limit() -> None:
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))

        assert_one_error(
            run_command("simplify", house, old, "--overwrite", preexec_fn=limit), 1, "out.obj", "cannot be written"
        )
        assert old.read_bytes() == b"old"
        assert list_names(tmp_path) == ["house.obj", "out.obj"]

    @pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
    def test_a_full_device_and_a_full_pipe(self, house: Path) -> None:
        assert_one_error(run_command("simplify", house, "/dev/full", "--to", "obj"), 1, "No space left")
        with open("/dev/full", "wb") as full:
            result = subprocess.run(
                [*COMMAND, "simplify", house, "-", "--to", "ply"], stdout=full, stderr=subprocess.PIPE
            )
        assert result.returncode == 1
        assert b"No space left" in result.stderr
        assert b"Traceback" not in result.stderr

    def test_a_reader_that_leaves(self, tmp_path: Path) -> None:
        points, faces = open_cone(20_000)
        points[:-1, 2] = np.random.default_rng(0).random(20_000)
        source = write(tmp_path / "big.obj", obj_text(points, faces))
        process = subprocess.Popen(
            [*COMMAND, "simplify", source, "-", "--to", "off"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
        )
        assert process.stdout is not None
        process.stdout.read(10)
        process.stdout.close()
        assert process.stderr is not None
        told = process.stderr.read()
        assert process.wait(timeout=60) == 1
        assert b"Traceback" not in told
        assert b"Exception" not in told

    @pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
    def test_an_interruption_leaves_no_file(self, tmp_path: Path, number: int, code: int) -> None:
        pipe = tmp_path / "in.obj"
        os.mkfifo(pipe)
        process = subprocess.Popen([*COMMAND, "simplify", pipe, tmp_path / "out.obj"], stderr=subprocess.PIPE)
        with open(pipe, "wb") as stream:  # opens once the program reads
            stream.write(obj_text(*fine_box()).encode())
            stream.flush()
            time.sleep(0.1)
            process.send_signal(number)
            time.sleep(0.1)
        assert process.wait(timeout=60) == code
        assert process.stderr is not None
        assert b"Traceback" not in process.stderr.read()
        assert list_names(tmp_path) == ["in.obj"]


class TestInspect:
    def test_as_text(self, house: Path) -> None:
        result = run_command("inspect", house)
        assert result.returncode == 0
        assert result.stderr == b""
        words = {line[2:20].strip(): line[20:] for line in result.stdout.decode().splitlines() if line.startswith("  ")}
        expected = {"points": "98", "triangles": "192", "facets": "6", "open edges": "0", "watertight": "yes"}
        assert {key: words[key] for key in expected} == expected

    def test_what_a_file_carries_is_told(self, tmp_path: Path) -> None:
        text = obj_text(*fine_box()).replace("\nf", " 1 0 0\nf", 1).replace("\nv", " 1 0 0\nv")
        source = write(tmp_path / "red.obj", text)
        assert b"attributes        COLOR_0 (color)" in run_command("inspect", source).stdout
        found = json.loads(run_command("inspect", source, "--json").stdout)["meshes"][0]
        assert found["attributes"] == [{"name": "COLOR_0", "kind": "color", "on": "vertices"}]
        assert found["unchanged_parts"] == []

    def test_as_json_counts_defects(self, tmp_path: Path) -> None:
        points, faces = box()
        points = np.vstack([points, points[:1]])
        faces = np.vstack([faces[1:], faces[-1:], [[0, 8, 1]]])
        result = run_command("inspect", write(tmp_path / "in.ply", ply_bytes(points, faces)), "--json")
        found = json.loads(result.stdout)
        assert found["schema"] == "bldsimp.inspection/2"
        total = found["total"]
        assert total["duplicate_faces"] == 1
        assert total["degenerate_faces"] == 1
        assert total["open_edges"] > 0
        assert total["watertight"] is False
        assert found["meshes"][0]["numbers"] == "single"
        assert found["auto_tolerance"] == pytest.approx(min(16 * 2.0**-22, 1e-6 * np.sqrt(12.0)))

    def test_standard_input_and_errors(self, house: Path, tmp_path: Path) -> None:
        assert b"triangles" in run_command("inspect", "-", "--from", "obj", stdin=house.read_bytes()).stdout
        assert_one_error(run_command("inspect", "-"), 2, "--from")
        assert_one_error(run_command("inspect", tmp_path), 2, "directory")
        assert_one_error(run_command("inspect", tmp_path / "none.ply"), 1, "no such file")


@pytest.mark.parametrize(
    ("words", "kind"),
    [
        ("simplify ", "file"),
        ("simplify in.obj ", "file"),
        ("simplify in.obj out.obj --report ", "file"),
        ("inspect ", "file"),
        ("batch ", "file"),
        ("batch --manifest ", "file"),
        ("compare a.obj ", "file"),
        ("compare a.obj --html ", "file"),
        ("sim", "plain"),
        ("simplify --norm", "plain"),
    ],
)
def test_a_shell_completes_files_commands_and_options(words: str, kind: str) -> None:
    words = f"bldsimp {words}"
    variables = {"COMP_WORDS": words, "COMP_CWORD": str(len(words.split(" ")) - 1)}
    result = run_command(env=os.environ | variables | {"_BLDSIMP_COMPLETE": "bash_complete"})
    assert result.returncode == 0
    assert {line.split(",")[0] for line in result.stdout.decode().splitlines()} == {kind}


def test_a_shell_gets_the_script_that_completes() -> None:
    result = run_command(env=os.environ | {"_BLDSIMP_COMPLETE": "bash_source"})
    assert b"complete -o nosort -F _bldsimp_completion bldsimp" in result.stdout


def test_the_old_name_of_min_component_still_works(tmp_path: Path) -> None:
    text = obj_text(*box(4.0)) + obj_text(*box(0.1, 9.0), start=9)
    source = write(tmp_path / "in.obj", text)
    result = run_command("simplify", source, tmp_path / "out.obj", "--min-part", "0.2")
    assert b"--min-part is deprecated: use --min-component" in result.stderr
    assert_box(tmp_path / "out.obj", "obj")
    assert b"--min-part" not in run_command("simplify", "--help").stdout


def test_the_old_name_of_its_field_still_works() -> None:
    with pytest.warns(DeprecationWarning, match="use min_component"):
        options = Options(min_part=0.2)
    assert options == Options(min_component=0.2)
    assert options.min_part == 0.2
    assert dataclasses.replace(options, min_component=1.0) == Options(min_component=1.0)


def test_version_and_help() -> None:
    assert run_command("--version").stdout.startswith(b"bldsimp 0.")
    for command in ([], ["simplify"], ["inspect"], ["batch"], ["compare"]):
        result = run_command(*command, "--help")
        assert result.returncode == 0
        assert b"Usage" in result.stdout
