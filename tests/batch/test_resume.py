"""`bldsimp batch --resume`: what it skips, what it does again, and what keeps a second run out."""

from __future__ import annotations

import os
from pathlib import Path

import painted
import pytest
from batch_runs import (
    last_error,
    list_done,
    make_misbehaving,
    read_results,
    read_rows,
    run_batch,
    start_batch,
    wait_for_rows,
    write_buildings,
)
from gltf_cases import textured
from shapes import Gltf, fine_box, obj_text, write

from bldsimp.io import read


@pytest.fixture
def models(tmp_path: Path) -> Path:
    return write_buildings(tmp_path / "models", 12)


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "out"


def painted_obj(folder: Path) -> None:
    """A box with two textures."""
    write(folder / "box.obj", painted.obj())
    write(folder / "m.mtl", "newmtl wall\nmap_Kd wall.png\nnewmtl roof\nmap_Kd roof.png\n")
    for name in ("wall.png", "roof.png"):
        write(folder / name, painted.WALL)


class TestResume:
    def test_what_is_done_is_skipped_and_the_rest_redone(self, models: Path, out: Path) -> None:
        write(models / "bad.obj", "no model")
        assert run_batch(models, out).returncode == 1
        write(models / "bad.obj", obj_text(*fine_box()))
        changed = write(models / "district 0" / "building_000.obj", obj_text(*fine_box(3)))
        touched = models / "district 1" / "building_001.ply"
        os.utime(touched)
        (out / "district 2" / "building_002.obj").unlink()
        write(out / "district 0" / "building_003.ply", "cut off")
        before = read_rows(out / "manifest.jsonl")
        result = run_batch(models, out, "--resume")
        assert result.returncode == 0
        assert b"4 done, 9 already done" in result.stderr
        again = read_rows(out / "manifest.jsonl")[len(before) :]
        assert sorted(row["input"] for row in again) == [
            "bad.obj", str(changed.relative_to(models)), "district 0/building_003.ply", "district 2/building_002.obj",
        ]  # fmt: skip
        assert b"0 done, 13 already done" in run_batch(models, out, "--resume").stderr

    def test_a_buffer_beside_counts_as_the_input(self, tmp_path: Path, out: Path) -> None:
        models = tmp_path / "models"
        models.mkdir()
        document = Gltf()
        document.mesh(document.box(fine=True))
        write(models / "box.gltf", document.gltf("box%20data.bin"))
        buffer = write(models / "box data.bin", bytes(document.data))
        assert run_batch(models, out, "--to", "glb").returncode == 0
        buffer.touch()
        assert b"1 already done" in run_batch(models, out, "--to", "glb", "--resume").stderr
        before = buffer.stat()
        write(buffer, bytes(document.data).replace(b"\0\0\x00@", b"\0\0\x80@"))
        assert buffer.stat().st_size == before.st_size
        assert b"1 done\n" in run_batch(models, out, "--to", "glb", "--resume").stderr

    @pytest.mark.parametrize("format_", ["obj", "gltf"])
    def test_a_texture_counts_as_the_input(self, format_: str, tmp_path: Path, out: Path) -> None:
        models = tmp_path / "models"
        models.mkdir()
        if format_ == "obj":
            painted_obj(models)
            textures = models / "wall.png", models / "roof.png"
        else:
            document = Gltf()
            document.mesh(textured(document), textured(document, shift=5.0))
            document.json["images"] = [{"uri": "brick%20wall.png"}, {"uri": "unused.png"}]
            write(models / "box.gltf", document.gltf())
            textures = models / "brick wall.png", models / "unused.png"
        for texture in textures:
            write(texture, painted.WALL)
        words = (models, out, "--to", "glb")
        assert run_batch(*words).returncode == 0
        assert b"1 already done" in run_batch(*words, "--resume").stderr
        for texture in textures:
            write(texture, painted.ROOF)
            assert b"1 done\n" in run_batch(*words, "--resume").stderr
        assert b"1 already done" in run_batch(*words, "--resume").stderr

    def test_a_changed_texture_that_results_have_copies_of_is_replaced_if_told(self, tmp_path: Path, out: Path) -> None:
        models = tmp_path / "models"
        models.mkdir()
        painted_obj(models)
        assert run_batch(models, out).returncode == 0
        write(models / "wall.png", painted.ROOF)
        assert run_batch(models, out, "--resume").returncode == 1
        assert (out / "wall.png").read_bytes() == painted.WALL
        assert run_batch(models, out, "--resume", "--overwrite").returncode == 0
        assert (out / "wall.png").read_bytes() == painted.ROOF

    def test_other_options_do_all_again(self, models: Path, out: Path) -> None:
        run_batch(models, out)
        assert b"12 already done" in run_batch(models, out, "--resume", "--tolerance", "auto").stderr
        assert b"already" not in run_batch(models, out, "--resume", "--tolerance", "1%").stderr
        assert b"12 already done" in run_batch(models, out, "--resume", "--tolerance", "1%").stderr

    def test_another_format_of_the_same_name_does_all_again(self, models: Path, out: Path) -> None:
        words = (models, out, "--name", "{stem}.mesh", "--to")
        run_batch(*words, "ply")
        assert b"already" not in run_batch(*words, "obj", "--resume").stderr
        assert all(read(out / name, "obj").meshes for name in read_results(out))
        assert b"12 already done" in run_batch(*words, "obj", "--resume").stderr

    def test_verify_finds_what_size_and_time_hide(self, models: Path, out: Path) -> None:
        run_batch(models, out)
        source, target = models / "district 0" / "building_000.obj", out / "district 1" / "building_001.ply"
        times = source.stat()
        write(source, source.read_text().replace("1.0", "1.5"))
        os.utime(source, ns=(times.st_atime_ns, times.st_mtime_ns))
        whole = target.read_bytes()
        write(target, whole[:-1] + bytes([whole[-1] ^ 1]))
        assert b"12 already done" in run_batch(models, out, "--resume").stderr
        assert b"2 done, 10 already done" in run_batch(models, out, "--resume", "--verify").stderr
        assert target.read_bytes() == whole

    def test_a_torn_last_line_is_cut(self, models: Path, out: Path) -> None:
        run_batch(models, out)
        manifest = out / "manifest.jsonl"
        manifest.write_bytes(manifest.read_bytes()[:-30])
        assert b"1 done, 11 already done" in run_batch(models, out, "--resume").stderr
        assert sorted(list_done(manifest)) == sorted(read_results(out))

    def test_a_second_run_keeps_out(self, models: Path, out: Path, tmp_path: Path) -> None:
        slow = make_misbehaving(tmp_path / "site", SECONDS_PER_FILE="1")
        with start_batch(models, out, "-j", "1", env=slow) as first:
            wait_for_rows(out / "manifest.jsonl", 1, first)
            second = run_batch(models, out, "--resume")
            assert first.poll() is None
            first.kill()
        assert second.returncode == 2
        assert "another run writes it" in last_error(second)
