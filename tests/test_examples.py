"""The shell examples do what their first lines say."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
import trimesh
from conftest import ROOT

EXAMPLES = ROOT / "examples"
CUBE = trimesh.creation.box().subdivide()

# Stands in for a bldsimp with a bug: the real one runs, and what it says or writes is then spoilt.
SPOILER = """#!{python}
import json, pathlib, sys
from bldsimp.cli import main
code = main(sys.argv[1:])
if code == 0 and sys.argv[1] == "simplify" and "bad" in sys.argv[-1]:
    path = pathlib.Path(sys.argv[sys.argv.index("--report") + 1])
    report = json.loads(path.read_text())
    {spoil}
    path.write_text(json.dumps(report))
sys.exit(code)
"""


def run(
    script: str, *arguments: object, first_on_path: Path | None = None, **options
) -> subprocess.CompletedProcess[str]:
    """Run an example with this interpreter's bldsimp first on PATH."""
    folders = [str(first_on_path)] * (first_on_path is not None)
    path = os.pathsep.join([*folders, str(Path(sys.executable).parent), os.environ["PATH"]])
    command = ["sh", str(EXAMPLES / script), *map(str, arguments)]
    environment = {**os.environ, "PATH": path, **options.pop("env", {})}
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False, **options)


def split_cells(table: str) -> list[list[str]]:
    """Rows of a table by words."""
    return [line.split() for line in table.splitlines()]


def is_aligned(table: str) -> bool:
    """Whether the last column of full rows ends in one place."""
    return len({len(line) for line in table.splitlines() if not line.endswith("failed")}) == 1


class TestSimplifyFolder:
    SCRIPT = "simplify_folder.sh"

    def test_every_obj_becomes_a_glb_and_a_bad_one_does_not_stop_the_rest(self, tmp_path: Path) -> None:
        source, target = tmp_path / "many models", tmp_path / "light ones"
        source.mkdir()
        for name in ("a.obj", "c d.OBJ"):
            CUBE.export(source / name, file_type="obj")
        (source / "b.obj").write_text("v 0 0 0\n", encoding="ascii")
        done = run(self.SCRIPT, source, target, "-q")
        assert done.returncode == 1
        assert "b.obj" in done.stderr
        assert sorted(path.name for path in target.iterdir()) == ["a.glb", "c d.glb"]
        assert all(len(trimesh.load_mesh(path).vertices) == 8 for path in target.iterdir())
        head, first, second, third, total = split_cells(done.stdout)
        assert head[:5] == ["file", "points", "left", "triangles", "left"]
        assert first[:5] == ["a.obj", "26", "8", "48", "12"]
        assert first[6] == "yes"
        assert second == ["b.obj", "failed"]
        assert third[:6] == ["c", "d.OBJ", "26", "8", "48", "12"]
        assert total[:5] == ["all", "52", "16", "96", "24"]
        assert is_aligned(done.stdout)

    def test_a_folder_of_good_files_ends_well_and_options_are_passed_on(self, tmp_path: Path) -> None:
        CUBE.export(tmp_path / "a.obj")
        assert run(self.SCRIPT, tmp_path, tmp_path, "-q").returncode == 0
        again = run(self.SCRIPT, tmp_path, tmp_path, "-q")
        assert again.returncode == 1
        assert ["a.obj", "failed"] in split_cells(again.stdout)
        assert run(self.SCRIPT, tmp_path, tmp_path, "-q", "--overwrite").returncode == 0

    def test_a_folder_without_models_is_an_error(self, tmp_path: Path) -> None:
        done = run(self.SCRIPT, tmp_path, tmp_path / "out")
        assert done.returncode == 1
        assert "no OBJ files" in done.stderr
        assert done.stdout == ""


class TestSweepTolerances:
    SCRIPT = "sweep_tolerances.sh"

    def test_a_row_and_a_file_per_tolerance(self, tmp_path: Path) -> None:
        model = tmp_path / "my house.obj"
        CUBE.export(model)
        done = run(self.SCRIPT, model, "0", "auto", "0.1%", "0.02", cwd=tmp_path)
        assert done.returncode == 0
        head, *rows = split_cells(done.stdout)
        assert " ".join(head) == "tolerance model units points of input triangles deviation kB seconds"
        assert [row[0] for row in rows] == ["0", "auto", "0.1%", "0.02"]
        assert [row[2:5] for row in rows] == [["8", "30.8%", "12"]] * 4
        assert float(rows[2][1]) == pytest.approx(0.001 * 3**0.5, rel=1e-2)
        assert rows[3][1] == "0.02"
        made = sorted(path.name for path in (tmp_path / "my house_sweep").iterdir())
        assert made == [f"my house_{label}.glb" for label in ("0.02", "0.1pct", "0", "auto")]
        assert is_aligned(done.stdout)

    def test_a_wrong_tolerance_has_its_row_and_a_second_run_writes_anew(self, tmp_path: Path) -> None:
        CUBE.export(tmp_path / "a.obj")
        for _ in range(2):
            done = run(self.SCRIPT, tmp_path / "a.obj", "x", "auto", env={"OUT": str(tmp_path / "o")})
            assert done.returncode == 1
            assert "'x' is not a length" in done.stderr
            assert split_cells(done.stdout)[1] == ["x", "failed"]
            assert [path.name for path in (tmp_path / "o").iterdir()] == ["a_auto.glb"]

    def test_without_tolerances_it_takes_its_own(self, tmp_path: Path) -> None:
        CUBE.export(tmp_path / "a.obj")
        done = run(self.SCRIPT, "a.obj", cwd=tmp_path)
        assert [row[0] for row in split_cells(done.stdout)[1:]] == ["auto", "0.01%", "0.1%", "0.5%", "1%"]
        assert run(self.SCRIPT).returncode == 2


class TestStopWhenWorse:
    SCRIPT = "stop_when_worse.sh"

    def write_models(self, folder: Path) -> list[Path]:
        """Three boxes; the middle one has a name that the spoiler knows, with spaces."""
        paths = [folder / name for name in ("first one.obj", "bad one.obj", "last.obj")]
        for path in paths:
            CUBE.export(path)
        return paths

    def write_spoiler(self, folder: Path, spoil: str) -> Path:
        """A folder with a bldsimp that spoils what it says or writes of the bad one."""
        command = folder / "bin" / "bldsimp"
        command.parent.mkdir()
        command.write_text(SPOILER.format(python=sys.executable, spoil=spoil), encoding="utf-8")
        command.chmod(0o755)
        return command.parent

    def test_good_files_are_all_done(self, tmp_path: Path) -> None:
        done = run(self.SCRIPT, "auto", tmp_path / "light", *self.write_models(tmp_path))
        assert (done.returncode, done.stderr) == (0, "")
        assert len(done.stdout.splitlines()) == 3
        assert "first one.obj: 26 points -> 8, within " in done.stdout
        assert len(list((tmp_path / "light").iterdir())) == 3

    @pytest.mark.parametrize(
        ("spoil", "told"),
        [
            ("report['before']['points'] = 7", "7 points became 8"),
            ("report['deviation'] = 1e9", "may have moved by 1e+09, more than"),
            (
                "import trimesh; mesh = trimesh.load_mesh(sys.argv[-1]); mesh.update_faces(range(1, 12));"
                " mesh.export(sys.argv[-1])",
                "no longer watertight",
            ),
        ],
    )
    def test_it_stops_at_the_first_that_is_worse(self, tmp_path: Path, spoil: str, told: str) -> None:
        folder = self.write_spoiler(tmp_path, spoil)
        done = run(self.SCRIPT, "auto", tmp_path / "light", *self.write_models(tmp_path), first_on_path=folder)
        assert done.returncode == 3
        assert "bad one.obj came out worse: " in done.stderr
        assert told in done.stderr
        made = sorted(path.name for path in (tmp_path / "light").iterdir())
        assert made == ["bad one.glb", "first one.glb"]

    def test_rounding_that_is_more_than_allowed_counts(self, tmp_path: Path) -> None:
        (tmp_path / "a.obj").write_text(
            "v 0.1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", encoding="ascii"
        )  # 0.1 is no single-precision number
        done = run(self.SCRIPT, "0", tmp_path, tmp_path / "a.obj")
        assert done.returncode == 3
        assert "more than 0" in done.stderr

    def test_an_unreadable_file_stops_it_with_the_exit_code_of_bldsimp(self, tmp_path: Path) -> None:
        first, _, last = self.write_models(tmp_path)
        done = run(self.SCRIPT, "auto", tmp_path / "light", first, tmp_path / "not there.obj", last)
        assert done.returncode == 1
        assert "not there.obj" in done.stderr
        assert [path.name for path in (tmp_path / "light").iterdir()] == ["first one.glb"]
        assert run(self.SCRIPT, "x", tmp_path / "light", first).returncode == 2


@pytest.mark.parametrize("script", sorted(path.name for path in EXAMPLES.glob("*.sh")))
def test_examples_are_plain_shell_and_tell_their_usage(script: str) -> None:
    text = (EXAMPLES / script).read_text(encoding="utf-8")
    assert text.startswith("#!/bin/sh\n# ")
    assert "[[" not in text
    subprocess.run(["sh", "-n", EXAMPLES / script], check=True)
