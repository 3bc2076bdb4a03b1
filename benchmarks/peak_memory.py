"""Measure the peak memory of `simplify` above the mesh's own arrays, in a fresh process. Linux only (reads /proc).

usage: peak_memory.py POINTS.npy FACES.npy
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from surface import Surface


def measure_peak(surface: Surface) -> int:
    """Measure the bytes that a fresh process needs at most above the level at which it has loaded the arrays."""
    with tempfile.TemporaryDirectory() as folder:
        paths = [Path(folder) / f"{name}.npy" for name in surface._fields]
        for path, array in zip(paths, surface, strict=True):
            np.save(path, array)
        done = subprocess.run([sys.executable, __file__, *map(str, paths)], capture_output=True, text=True, check=True)
    return int(done.stdout)


def _read_status(name: str) -> int:
    """Read a figure of this process: VmRSS is its memory now, VmHWM its greatest memory."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(name + ":"):
            return int(line.split()[1]) * 1024
    raise RuntimeError(f"/proc/self/status has no {name}")


def _main() -> None:
    import bldsimp

    points, faces = (np.load(path) for path in sys.argv[1:3])
    corner = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    # What the first call of anything loads is no part of the figure.
    bldsimp.simplify((corner, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])))
    level = _read_status("VmRSS")
    simplified = bldsimp.simplify((points, faces))
    assert simplified.report.after.points <= len(points)
    print(max(_read_status("VmHWM") - level, 0))


if __name__ == "__main__":
    _main()
