"""Run the command as a user does, and assert what it says."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

COMMAND = [sys.executable, "-c", "import sys; from bldsimp.cli import main; sys.exit(main())"]


def run_command(*arguments: object, stdin: bytes = b"", **options) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run([*COMMAND, *map(str, arguments)], input=stdin, capture_output=True, timeout=60, **options)


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
