"""The shell examples do what their first lines say."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import trimesh

SCRIPT = Path(__file__).resolve().parents[1] / "examples" / "simplify_folder.sh"
CUBE = trimesh.creation.box().subdivide()


def run(*arguments: object) -> subprocess.CompletedProcess[str]:
    """Run the folder script with this interpreter's bldsimp first on PATH."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    command = ["sh", str(SCRIPT), *map(str, arguments)]
    return subprocess.run(
        command, env={**os.environ, "PATH": path}, capture_output=True, text=True, check=False
    )


def test_every_obj_becomes_a_glb_and_a_bad_one_does_not_stop_the_rest(tmp_path: Path) -> None:
    source, target = tmp_path / "many models", tmp_path / "light"
    source.mkdir()
    for name in ("a", "c"):
        CUBE.export(source / f"{name}.obj")
    (source / "b.obj").write_text("v 0 0 0\n", encoding="ascii")
    done = run(source, target, "-q")
    assert done.returncode == 1
    assert "b.obj" in done.stderr
    assert sorted(path.name for path in target.iterdir()) == ["a.glb", "c.glb"]
    assert all(len(trimesh.load_mesh(path).vertices) == 8 for path in target.iterdir())


def test_a_folder_of_good_files_ends_well_and_options_are_passed_on(tmp_path: Path) -> None:
    CUBE.export(tmp_path / "a.obj")
    assert run(tmp_path, tmp_path, "-q").returncode == 0
    assert run(tmp_path, tmp_path, "-q").returncode == 1
    assert run(tmp_path, tmp_path, "-q", "--overwrite").returncode == 0


def test_a_folder_without_models_is_an_error(tmp_path: Path) -> None:
    done = run(tmp_path, tmp_path / "out")
    assert done.returncode == 1
    assert "no OBJ files" in done.stderr
