"""What tests of `batch` share: folders of small buildings, runs as processes, and workers that misbehave."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from command_line import COMMAND
from shapes import fine_box, obj_text, ply_bytes, write

PATIENCE = 120.0
"""Seconds after which what is waited for does not come any more, on however busy a machine."""

MISBEHAVING = """
import os, signal, time
import bldsimp.job

good = bldsimp.job.simplify_file

def simplify_file(source, *arguments, **options):
    name = os.path.basename(source)
    if "hangs" in name:
        time.sleep(1000)
    if "crashes" in name:
        os.kill(os.getpid(), signal.SIGSEGV)
    if "killed" in name:
        os.kill(os.getpid(), signal.SIGKILL)
    if "aborts" in name:
        os.write(2, b"terminate called after throwing an instance of 'std::bad_alloc'\\n  what():  std::bad_alloc\\n")
        os.abort()
    if "grows" in name:
        held = [bytearray(10_000_000) for _ in range(100_000)]
    time.sleep(float(os.environ.get("SECONDS_PER_FILE", 0)))
    return good(source, *arguments, **options)

bldsimp.job.simplify_file = simplify_file
"""


def write_buildings(folder: Path, count: int) -> Path:
    """Boxes of different sizes in two levels of folders, as OBJ and PLY in turns."""
    points, faces = fine_box(4)
    for i in range(count):
        district = folder / f"district {i % 3}"
        district.mkdir(parents=True, exist_ok=True)
        if i % 2:
            write(district / f"building_{i:03}.ply", ply_bytes(points * (1 + i), faces))
        else:
            write(district / f"building_{i:03}.obj", obj_text(points * (1 + i), faces))
    return folder


def run_batch(*arguments: object, cwd: Path | None = None, **options: Any) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        [*COMMAND, "batch", *map(str, arguments)], capture_output=True, timeout=PATIENCE, cwd=cwd, **options
    )


@contextmanager
def start_batch(*arguments: object, **options: Any) -> Iterator[subprocess.Popen[bytes]]:
    """A run that goes on meanwhile; one that would go on for ever is killed, so that whoever waits for it fails."""
    words = [*COMMAND, "batch", *map(str, arguments)]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options) as process:
        watch = threading.Timer(PATIENCE, process.kill)
        watch.start()
        try:
            yield process
        except BaseException:
            process.kill()
            raise
        finally:
            process.wait()
            watch.cancel()


def make_misbehaving(folder: Path, more: str = "", **variables: str) -> dict[str, str]:
    """Environment of a run whose workers hang, crash or grow over files of such names."""
    folder.mkdir(exist_ok=True)
    (folder / "sitecustomize.py").write_text(MISBEHAVING + more)
    return os.environ | {"PYTHONPATH": str(folder)} | variables


DIES = """
import os, sys
from pathlib import Path
from bldsimp.io.atomic import replace_files

os.replace = lambda *_: os._exit(9)
replace_files({Path(sys.argv[1], "result.obj"): b"half"})
"""


def leave_file(folder: Path) -> Path:
    """What a process leaves in a folder that is killed before it puts a file in place."""
    before = set(folder.iterdir())
    assert subprocess.run([sys.executable, "-c", DIES, folder], check=False).returncode == 9
    (left,) = set(folder.iterdir()) - before
    return left


def wait_for_rows(manifest: Path, count: int, process: subprocess.Popen[bytes]) -> None:
    """Wait until a run has recorded so many files."""
    while (recorded := manifest.read_bytes().count(b"\n") if manifest.exists() else 0) < count:
        if process.poll() is not None:
            raise AssertionError(f"ended with {recorded} of {count} rows: {process.communicate()[1].decode()}")
        time.sleep(0.02)


def wait_until_empty(folder: Path) -> None:
    """Wait until no process works in a folder any more."""
    end = time.monotonic() + PATIENCE
    while (left := find_processes(folder)) and time.monotonic() < end:
        time.sleep(0.02)
    assert left == []


def find_processes(folder: Path) -> list[str]:
    """Processes whose working directory is a folder."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if os.readlink(process / "cwd") == str(folder):
                found.append(process.name)
        except OSError:
            continue
    return found


def read_rows(manifest: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in manifest.read_bytes().splitlines()]


def list_done(manifest: Path) -> list[str]:
    """Names of the files that are done, once for each row that says so."""
    return [row["input"] for row in read_rows(manifest) if row["status"] == "done"]


def list_failed(manifest: Path) -> dict[str, dict[str, Any]]:
    return {row["input"]: row for row in read_rows(manifest) if row["status"] == "failed"}


def read_results(folder: Path) -> dict[str, bytes]:
    """All files of a folder of results but the manifest, hidden ones too."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and path.name not in ("manifest.jsonl", ".manifest.jsonl.lock")
    }


def make_terrain(side: int) -> bytes:
    """A rough surface as binary PLY: it takes some fifty times as much memory as it has bytes."""
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    points = np.stack([x.ravel(), y.ravel(), np.random.default_rng(0).normal(size=x.size)], axis=1).astype("<f4")
    corner = np.arange(side * side).reshape(side, side)
    a, b, c, d = (part.ravel() for part in (corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]))
    faces = np.zeros(2 * len(a), [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"] = 3
    faces["corners"] = np.vstack([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    head = ply_bytes(points[:0], []).decode().replace("vertex 0", f"vertex {len(points)}")
    return head.replace("face 0", f"face {len(faces)}").encode() + points.tobytes() + faces.tobytes()


def last_error(result: subprocess.CompletedProcess[bytes]) -> str:
    return result.stderr.decode(errors="surrogateescape").splitlines()[-1]
