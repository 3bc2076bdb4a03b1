"""The same bytes with any number of threads."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = """
import os, sys
if sys.argv[3] == "one":
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
from bldsimp.cli import main
sys.exit(main(["simplify", sys.argv[1], sys.argv[2], "--quiet", *sys.argv[4:]]))
"""


def simplified(source: Path, target: Path, cores: str, *options: str) -> bytes:
    """What the program writes, given one core or all."""
    command = [sys.executable, "-c", PROGRAM, str(source), str(target), cores, *options]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return target.read_bytes()


@pytest.mark.skipif(
    not hasattr(os, "sched_setaffinity") or len(os.sched_getaffinity(0)) < 2,
    reason="needs two cores, and a system on which a process can be kept to one",
)
@pytest.mark.parametrize("options", [(), ("--tolerance", "0.5%")], ids=["auto", "wide"])
@pytest.mark.parametrize("name", ["building_a.obj", "building_b.glb"])
def test_the_number_of_cores_leaves_no_trace(
    name: str, options: tuple[str, ...], data: Path, tmp_path: Path
) -> None:
    suffix = Path(name).suffix
    one = simplified(data / name, tmp_path / f"one{suffix}", "one", *options)
    assert one == simplified(data / name, tmp_path / f"all{suffix}", "all", *options)
