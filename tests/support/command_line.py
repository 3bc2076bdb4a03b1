"""Run the command as a user does, and assert what it says."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

from bldsimp.inspection import count_defects
from bldsimp.io import read

COMMAND = [sys.executable, "-c", "import sys; from bldsimp.cli import main; sys.exit(main())"]


def run_command(*arguments: object, stdin: bytes = b"", **options: Any) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run([*COMMAND, *map(str, arguments)], input=stdin, capture_output=True, timeout=60, **options)


def run_in_shell(redirection: str, words: list[str], folder: Path) -> subprocess.CompletedProcess[bytes]:
    """Run with a stream redirected as only a shell can."""
    script = f'exec "$@" {redirection}'
    return subprocess.run(["sh", "-c", script, "sh", *COMMAND, *words], cwd=folder, capture_output=True, timeout=60)


def assert_box(source: Path | bytes, format_: str) -> None:
    mesh = read(source, format_).meshes[0]
    surface = count_defects(mesh.points, mesh.faces)
    assert (surface.points, surface.triangles, surface.watertight) == (8, 12, True)


def assert_one_error(result: subprocess.CompletedProcess[bytes], code: int, *words: str) -> None:
    lines = result.stderr.decode().splitlines()
    assert len(lines) == 1, lines
    assert lines[0].startswith("bldsimp: error: ")
    assert result.returncode == code
    assert result.stdout == b""
    for text in words:
        assert text in lines[0]


def list_names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())
