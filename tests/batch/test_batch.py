"""`bldsimp batch` on one machine: what it finds, records, survives and goes on with."""

from __future__ import annotations

import os
import random
import shutil
import signal
import socket
import subprocess
import time
from pathlib import Path

import pytest
from batch_runs import (
    COMMAND,
    find_processes,
    last_error,
    leave_file,
    list_done,
    list_failed,
    make_misbehaving,
    make_terrain,
    read_results,
    read_rows,
    run_batch,
    start_batch,
    wait_for_rows,
    wait_until_empty,
    write_buildings,
)
from shapes import Gltf, fine_box, obj_text, write

from bldsimp import __version__
from bldsimp.cli import main
from bldsimp.io import read

LEAST_MEMORY = ("-j", "2", "--memory", "260M")


@pytest.fixture
def models(tmp_path: Path) -> Path:
    return write_buildings(tmp_path / "models", 12)


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "out"


class TestInputs:
    def test_a_folder_is_mirrored_and_each_file_has_a_row(self, models: Path, out: Path) -> None:
        write(models / "district 0" / "notes.txt", "no model")
        write(models / "district 0" / ".hidden.obj", "no model")
        assert run_batch(models, out, "--to", "glb").returncode == 0
        names = {str(path.relative_to(models).with_suffix("")) for path in models.rglob("building*")}
        assert {name.removesuffix(".glb") for name in read_results(out)} == names
        assert len(read(out / "district 1" / "building_001.glb", "glb").meshes[0].faces) == 12
        for row in read_rows(out / "manifest.jsonl"):
            source, target = models / row["input"], out / row["output"]
            assert (row["input_bytes"], row["output_bytes"]) == (source.stat().st_size, target.stat().st_size)
            assert (row["points_before"], row["points_after"]) == (98, 8)
            assert row["version"] == __version__

    def test_hashes_are_those_of_the_files(self, models: Path, out: Path) -> None:
        run_batch(models, out)
        for row in read_rows(out / "manifest.jsonl"):
            for kind, path in (("input", models / row["input"]), ("output", out / row["output"])):
                told = subprocess.run(["sha256sum", path], capture_output=True, text=True, check=True).stdout
                assert told.split()[0] == row[f"{kind}_sha256"]

    def test_names_that_differ_in_case_alone_are_two(self, tmp_path: Path, out: Path) -> None:
        models = tmp_path / "models"
        models.mkdir()
        for name, size in (("A.obj", 2), ("a.obj", 3)):
            write(models / name, obj_text(*fine_box(size)))
        if len(list(models.iterdir())) == 1:
            pytest.skip("this file system takes them for one")
        assert run_batch(models, out).returncode == 0
        assert sorted(read_results(out)) == ["A.obj", "a.obj"]
        assert b"2 already done" in run_batch(models, out, "--resume").stderr

    def test_a_glob_and_a_name_template(self, models: Path, out: Path) -> None:
        assert run_batch(models / "**" / "*_00[0-4].obj", out, "--name", "{stem}_light.{ext}").returncode == 0
        assert sorted(read_results(out)) == [
            "district 0/building_000_light.obj",
            "district 1/building_004_light.obj",
            "district 2/building_002_light.obj",
        ]

    @pytest.mark.parametrize("end", [b"\n", b"\0"])
    def test_a_list_on_standard_input(self, models: Path, out: Path, end: bytes) -> None:
        names = [b"district 0/building_000.obj", b"./district 1/building_001.ply"]
        result = run_batch("-", out, input=b"".join(name + end for name in names), cwd=models)
        assert result.returncode == 0
        assert sorted(read_results(out)) == ["district 0/building_000.obj", "district 1/building_001.ply"]

    def test_the_folder_of_results_is_no_input(self, models: Path) -> None:
        assert run_batch(models, models / "out", "--to", "ply", "--name", "{stem}_{from}.{ext}").returncode == 0
        assert (
            run_batch(models, models / "out", "--to", "ply", "--name", "{stem}_{from}.{ext}", "--resume").returncode
            == 0
        )
        assert len(list_done(models / "out" / "manifest.jsonl")) == 12

    @pytest.mark.parametrize(
        ("words", "told"),
        [
            (["models", "out", "--to", "glb"], "would both write"),
            (["models", "models"], "is also the folder of the results"),
            (["*.obj", "."], "would be overwritten"),
            (["*.dae", "out"], "there is no such file"),
            (["models", "out", "--name", "{size}.{ext}"], "--name"),
            (["models", "out", "--memory", "20M", "-j", "4"], "too little for 4 jobs"),
            (["models", "out", "--tolerance", "-1"], "--tolerance"),
            (["models", "out", "--verify"], "--resume"),
            (["b.obj", "out", "--timeout", "inf"], "at most 1,000,000 seconds"),
            (["b.obj", "out", "--timeout", "nan"], "at most 1,000,000 seconds"),
            (["b.obj", "out", "--timeout", "0"], "above 0"),
            (["models"], "folder for the results"),
        ],
    )
    def test_wrong_usage_is_found_before_anything_runs(self, words: list[str], told: str, tmp_path: Path) -> None:
        (tmp_path / "models").mkdir()
        for path in ("models/a.obj", "models/a.ply", "b.obj"):
            write(tmp_path / path, "no model")
        before = read_results(tmp_path)
        result = run_batch(*words, cwd=tmp_path)
        assert (result.returncode, len(result.stderr.splitlines())) == (2, 1)
        assert told in last_error(result)
        assert read_results(tmp_path) == before

    def test_what_is_there_is_kept(self, models: Path, out: Path) -> None:
        out.mkdir()
        (out / "district 0").mkdir()
        mine = write(out / "district 0" / "building_000.obj", "mine")
        assert run_batch(models, out).returncode == 2
        assert mine.read_text() == "mine"
        assert run_batch(models, out, "--overwrite").returncode == 0
        assert run_batch(models, out).returncode == 2
        assert len(list_done(out / "manifest.jsonl")) == 12

    def test_the_same_bytes_as_simplify_writes(self, models: Path, out: Path, tmp_path: Path) -> None:
        run_batch(models, out, "--to", "glb", "--tolerance", "1%")
        source = models / "district 1" / "building_001.ply"
        assert main(["simplify", str(source), str(tmp_path / "one.glb"), "--tolerance", "1%", "-q"]) == 0
        assert (tmp_path / "one.glb").read_bytes() == read_results(out)["district 1/building_001.glb"]


class TestPoison:
    def test_bad_files_cost_no_other(self, models: Path, out: Path) -> None:
        house = write(models / "house.obj", obj_text(*fine_box()))
        document = Gltf()
        document.mesh(document.box())
        write(models / "cut.glb", document.glb()[:-40])
        with open(models / "sparse.obj", "wb") as stream:
            stream.truncate(2_000_000_000)
        os.mkfifo(models / "pipe.obj")
        os.symlink("loop.obj", models / "loop.obj")
        os.symlink(models, models / "round")
        with socket.socket(socket.AF_UNIX) as server:
            server.bind(str(models / "socket.ply"))
        write(models / "large.ply", make_terrain(400))
        os.link(house, models / "two\nlines.obj")
        os.link(house, os.fsencode(models) + b"/latin\xe9%.obj")
        result = run_batch(models, out, *LEAST_MEMORY)
        assert result.returncode == 1
        bad = list_failed(out / "manifest.jsonl")
        assert {name: row["kind"] for name, row in bad.items()} == {
            "cut.glb": "input",
            "sparse.obj": "memory",
            "pipe.obj": "refused",
            "loop.obj": "refused",
            "socket.ply": "refused",
            "large.ply": "memory",
        }
        assert {name for name, row in bad.items() if row["attempts"] == 2} == {"cut.glb", "large.ply"}
        for name in bad:
            assert f"failed     {name}: " in result.stderr.decode(errors="surrogateescape")
        good = list_done(out / "manifest.jsonl")
        assert len(good) == 12 + 3
        assert {"two\nlines.obj", "latin%E9%25.obj"} <= set(good)
        for name in (b"two\nlines.obj", b"latin\xe9%.obj"):
            assert os.path.getsize(os.fsencode(out) + b"/" + name) > 0
        resumed = run_batch(models, out, *LEAST_MEMORY, "--resume")
        assert b"15 already done" in resumed.stderr

    def test_a_sparse_file_that_would_fit_is_not_read(self, tmp_path: Path, out: Path) -> None:
        with open(tmp_path / "sparse.stl", "wb") as stream:
            stream.truncate(60_000_000)
        assert run_batch(tmp_path / "sparse.stl", out, cwd=tmp_path).returncode == 1
        row = list_failed(out / "manifest.jsonl")["sparse.stl"]
        assert row["kind"] == "input"
        assert "all zero" in row["error"]

    def test_a_file_and_a_folder_without_permission(self, models: Path, out: Path) -> None:
        secret, closed = models / "district 0" / "building_000.obj", models / "district 1"
        secret.chmod(0)
        closed.chmod(0)
        # An administrator may read everything, unless that is given up.
        without = ["setpriv", "--bounding-set", "-dac_override,-dac_read_search"] if os.access(secret, os.R_OK) else []
        if without and not shutil.which("setpriv"):
            pytest.skip("this user may read everything")
        result = subprocess.run(
            [*without, *COMMAND, "batch", models, out], capture_output=True, timeout=60, check=False
        )
        closed.chmod(0o700)
        assert result.returncode == 1
        bad = list_failed(out / "manifest.jsonl")
        assert {name: row["kind"] for name, row in bad.items()} == {
            "district 0/building_000.obj": "input", "district 1": "refused",
        }  # fmt: skip
        assert all("ermission denied" in row["error"] for row in bad.values())
        assert len(list_done(out / "manifest.jsonl")) == 7

    @pytest.mark.slow
    def test_files_that_hang_crash_or_grow_cost_themselves_alone(self, models: Path, out: Path, tmp_path: Path) -> None:
        for name in ("hangs", "crashes", "grows", "killed", "aborts"):
            shutil.copy(models / "district 0" / "building_000.obj", models / "district 0" / f"{name}.obj")
        result = run_batch(models, out, *LEAST_MEMORY, "--timeout", "3", env=make_misbehaving(tmp_path / "site"))
        assert result.returncode == 1
        bad = list_failed(out / "manifest.jsonl")
        assert {row["input"]: row["kind"] for row in bad.values()} == {
            "district 0/hangs.obj": "timeout", "district 0/crashes.obj": "crash", "district 0/grows.obj": "memory",
            "district 0/killed.obj": "crash", "district 0/aborts.obj": "memory",
        }  # fmt: skip
        assert all(row["attempts"] == 2 for row in bad.values())
        assert "SIGSEGV" in bad["district 0/crashes.obj"]["error"]
        # As the system does it where the machine runs out of memory.
        assert "SIGKILL): out of memory?" in bad["district 0/killed.obj"]["error"]
        assert len(list_done(out / "manifest.jsonl")) == len(read_results(out)) == 12

    def test_a_full_disk(self, models: Path, tmp_path: Path) -> None:
        out = tmp_path / "small"
        out.mkdir()
        mount = ["mount", "-t", "tmpfs", "-o", "size=32k", "tmpfs", str(out)]
        if shutil.which("mount") is None or subprocess.run(mount, capture_output=True, check=False).returncode:
            pytest.skip("no tmpfs may be mounted here")
        try:
            result = run_batch(models, out)
            assert result.returncode == 1
            assert "No space left on device" in last_error(result)
            assert "--resume" in last_error(result)
            for name in list_done(out / "manifest.jsonl"):
                assert len(read(out / name, Path(name).suffix[1:]).meshes[0].faces) == 12
            assert not [name for name in read_results(out) if name.endswith(".tmp")]
            subprocess.run(["mount", "-o", "remount,size=4m", str(out)], check=True)
            assert run_batch(models, out, "--resume").returncode == 0
            assert sorted(list_done(out / "manifest.jsonl")) == sorted(read_results(out))
        finally:
            subprocess.run(["umount", str(out)], check=True)


class TestStops:
    def test_a_killed_run_leaves_no_process(self, models: Path, out: Path, tmp_path: Path) -> None:
        slow = make_misbehaving(tmp_path / "site", SECONDS_PER_FILE="100")
        with start_batch(models, out, "-j", "2", env=slow, cwd=tmp_path) as killed:
            while len(find_processes(tmp_path)) < 3:
                assert killed.poll() is None
                time.sleep(0.02)
            killed.kill()
        wait_until_empty(tmp_path)

    @pytest.mark.slow
    def test_a_run_that_is_killed_and_resumed_has_the_results_of_a_whole_one(self, tmp_path: Path, out: Path) -> None:
        models = write_buildings(tmp_path / "models", 60)
        whole = tmp_path / "whole"
        assert run_batch(models, whole).returncode == 0
        slow = make_misbehaving(tmp_path / "site", SECONDS_PER_FILE="0.02")
        moment, recorded = random.Random(6), []
        for _ in range(3):
            with start_batch(models, out, "--resume", env=slow, cwd=tmp_path) as killed:
                wait_for_rows(out / "manifest.jsonl", len(recorded) + 2, killed)
                time.sleep(moment.uniform(0, 0.2))
                killed.kill()
            recorded = list_done(out / "manifest.jsonl")
            assert 0 < len(recorded) < 60
            wait_until_empty(tmp_path)
        leave_file(out / "district 0")
        assert run_batch(models, out, "--resume").returncode == 0
        assert read_results(out) == read_results(whole)
        names = list_done(out / "manifest.jsonl")
        assert len(names) == len(set(names)) == 60
        assert names[: len(recorded)] == recorded

    def test_ctrl_c_once_finishes_what_is_running(self, models: Path, out: Path, tmp_path: Path) -> None:
        slow = make_misbehaving(tmp_path / "site", SECONDS_PER_FILE="0.5")
        with start_batch(models, out, "-j", "2", env=slow) as process:
            wait_for_rows(out / "manifest.jsonl", 2, process)
            process.send_signal(signal.SIGINT)
            stderr = process.communicate()[1]
        assert process.returncode == 130
        assert b"finishing the files that are running" in stderr
        names = list_done(out / "manifest.jsonl")
        assert 2 <= len(names) < 12
        assert sorted(names) == sorted(read_results(out))
        assert run_batch(models, out, "--resume").returncode == 0
        assert sorted(list_done(out / "manifest.jsonl")) == sorted(read_results(out))

    def test_ctrl_c_twice_stops_now(self, models: Path, out: Path, tmp_path: Path) -> None:
        shutil.copy(models / "district 0" / "building_000.obj", models / "hangs.obj")
        with start_batch(models, out, "-j", "2", env=make_misbehaving(tmp_path / "site"), cwd=tmp_path) as process:
            wait_for_rows(out / "manifest.jsonl", 2, process)
            process.send_signal(signal.SIGINT)
            assert process.stderr is not None
            assert any(b"again to stop now" in line for line in process.stderr)
            process.send_signal(signal.SIGINT)
            process.communicate()
        assert process.returncode == 130
        wait_until_empty(tmp_path)
        names = [str(path.relative_to(models)) for path in models.rglob("*.*")]
        # What ended in that moment may not be recorded yet, but it is whole, and nothing else is there.
        assert set(list_done(out / "manifest.jsonl")) <= read_results(out).keys() <= set(names)


class TestSummary:
    def test_totals_slowest_files_and_errors_by_kind(self, models: Path, out: Path) -> None:
        write(models / "bad.obj", "no model")
        os.mkfifo(models / "pipe.obj")
        run_batch(models, out)
        write(models / "bad.obj", "still none")
        run_batch(models, out, "--resume")
        result = run_batch("--summary", out / "manifest.jsonl")
        assert (result.returncode, result.stderr) == (0, b"")
        told = result.stdout.decode()
        assert "12 done, 2 failed" in told
        assert "triangles 2,304 -> 144" in told
        assert "slowest: " in told
        assert "1 x cannot be read as a mesh" in told
        assert "pipe.obj: is a FIFO" in told

    def test_a_manifest_that_is_not_there(self, out: Path) -> None:
        result = run_batch("--summary", out / "manifest.jsonl")
        assert result.returncode == 1
        assert "No such file" in last_error(result)
