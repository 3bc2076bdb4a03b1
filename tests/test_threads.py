"""The same bytes with any number of threads."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from shapes import Gltf

PROGRAM = """
import os, sys
if sys.argv[3] == "one":
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
from bldsimp.cli import main
sys.exit(main(["simplify", sys.argv[1], sys.argv[2], "--quiet", *sys.argv[4:]]))
"""


def simplify(source: Path, target: Path, cores: str, *options: str) -> bytes:
    """What the program writes, given one core or all."""
    command = [sys.executable, "-c", PROGRAM, str(source), str(target), cores, *options]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return target.read_bytes()


NEEDS_TWO = pytest.mark.skipif(
    not hasattr(os, "sched_setaffinity") or len(os.sched_getaffinity(0)) < 2,
    reason="needs two cores, and a system on which a process can be kept to one",
)


@NEEDS_TWO
@pytest.mark.parametrize("options", [(), ("--tolerance", "0.5%")], ids=["auto", "wide"])
@pytest.mark.parametrize("name", ["building_a.obj", "building_b.glb"])
def test_the_number_of_cores_leaves_no_trace(name: str, options: tuple[str, ...], data: Path, tmp_path: Path) -> None:
    suffix = Path(name).suffix
    one = simplify(data / name, tmp_path / f"one{suffix}", "one", *options)
    assert one == simplify(data / name, tmp_path / f"all{suffix}", "all", *options)


@NEEDS_TWO
@pytest.mark.parametrize("bend", [0.0, 0.3])
def test_the_number_of_cores_leaves_no_trace_on_textures(bend: float, tmp_path: Path) -> None:
    """Walls of so many faces that every loop is shared out; the maps of some bend."""
    x, y = np.meshgrid(np.arange(301.0), np.arange(301.0), indexing="ij")
    points = np.stack([x, y, 5.0 * np.abs(x % 20 - 10)], axis=-1).reshape(-1, 3)
    uv = np.stack([x / 300 + bend * np.sin(y / 40) / 300, y / 300], axis=-1).reshape(-1, 2)
    a = (301 * np.arange(300)[:, None] + np.arange(300)).reshape(-1)
    faces = np.concatenate([np.stack([a, a + 301, a + 302], axis=1), np.stack([a, a + 302, a + 1], axis=1)])
    document = Gltf()
    attributes = {"POSITION": document.accessor(points), "TEXCOORD_0": document.accessor(uv)}
    document.mesh({"attributes": attributes, "indices": document.accessor(faces.reshape(-1), "u4")})
    source = tmp_path / "in.glb"
    source.write_bytes(document.glb())
    one = simplify(source, tmp_path / "one.glb", "one")
    assert one == simplify(source, tmp_path / "all.glb", "all")
    assert len(one) < source.stat().st_size / 5
