"""Judge wide tolerances from outside: the program's own command writes a file, and a script of your own measures it.

usage: python benchmarks/tolerance.py JUDGE.py [CSV] [--tolerance RELATIVE ...] [--noisy TRIANGLES ...]
needs: pip install bldsimp, and what JUDGE.py needs; Linux or macOS (reads the memory of the command)

JUDGE.py is called with the original, the result and --json, and prints JSON: `before` and `after` with points,
boundary_edges, nonmanifold_edges, edges_with_clashing_winding, components and volume; and deviation, rim (how far open
edges of the result are from those of the original) and diagonal, in model units.

CSV is that of `anchors.py`; its rows at 1e-4 or more are taken unless others are asked for. Then come blocks whose
points have a noise of 1 cm, at 5 cm: the one among the models, and over-sampled ones of the sizes asked for. Everything
is printed as Markdown.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from anchors import Anchor, read_anchors
from oversample import add_noise, oversample, simplify_model
from surface import Surface, find_models
from table import format_table

WIDE = 1e-4
"""Relative tolerance from which on a row is measured."""

MEAN = 0.7
"""The geometric mean of the ratios to the best peer over the buildings, at most."""

NO_BUILDING = {"pmp_fandisk.off": 1.2}
"""Models that are left out of the mean, with the ratio that each may have; a building may have 1."""

NOISE, NOISY_TOLERANCE = 0.01, 0.05
"""Model units: what points of the noisy blocks are moved by, and the tolerance there."""

VOLUME = 1e-4
"""Relative change of a closed block's volume, at most."""

NOISY_MODEL, BASE = "noisy/oversampled_10k_noise1cm.ply", "exact/oversampled_minimal.ply"
NOISY_SIZES = (100_000, 1_000_000)

MEBIBYTE = 2**20


@dataclass(frozen=True)
class Limits:
    """The most points and seconds of a noisy block; 0 where nothing is promised."""

    points: int = 0
    seconds: float = 0.0


NOISY_LIMITS = {NOISY_MODEL: Limits(points=800), 100_000: Limits(points=900), 1_000_000: Limits(seconds=15.0)}


@dataclass
class Judged:
    """One run of the command, and what the judge found; lengths in model units."""

    found: dict[str, Any]
    seconds: float
    memory: int

    @property
    def points(self) -> int:
        """Points of the result."""
        return int(self.found["after"]["points"])

    @property
    def deviation(self) -> float:
        """How far the surfaces are from each other."""
        return float(self.found["deviation"])

    @property
    def rim(self) -> float:
        """How far open edges are from those of the original."""
        return float(self.found["rim"])

    @property
    def stays_closed(self) -> bool:
        """Whether the result is closed if the original is."""
        return is_closed(self.found["after"]) or not is_closed(self.found["before"])

    @property
    def edges(self) -> str:
        """Whether the surface is closed, before and after."""
        words = {True: "closed", False: "open"}
        return " -> ".join(words[is_closed(self.found[when])] for when in ("before", "after"))

    @property
    def volume(self) -> float:
        """Relative change of the volume."""
        before, after = (float(self.found[when]["volume"]) for when in ("before", "after"))
        return abs(after / before - 1.0)


def is_closed(topology: dict[str, int]) -> bool:
    """Return whether every edge is used once each way."""
    names = ("boundary_edges", "nonmanifold_edges", "edges_with_clashing_winding")
    return not any(topology[name] for name in names)


def judge_model(script: Path, model: Path, tolerance: str) -> Judged:
    """Simplify a model with the command, and have the script measure what it wrote.

    Raises
    ------
    SystemExit
        Where one of them fails; it has said why.
    """
    with tempfile.TemporaryDirectory() as folder:
        simplified = Path(folder) / "simplified.ply"
        code = "import sys; from bldsimp.cli import main; sys.exit(main())"
        command = [sys.executable, "-c", code, "simplify", str(model), str(simplified), "--tolerance", tolerance]
        seconds, memory = time_command([*command, "--delimit", "none", "--quiet"])
        measure = [sys.executable, str(script), str(model), str(simplified), "--json"]
        done = subprocess.run(measure, stdout=subprocess.PIPE, text=True)
        if done.returncode:
            raise SystemExit(f"{script} failed on {model}")
        return Judged(json.loads(done.stdout), seconds, memory)


def time_command(command: Sequence[str]) -> tuple[float, int]:
    """Measure seconds and peak memory, in bytes, of a command.

    Raises
    ------
    SystemExit
        Where it fails.
    """
    start = time.perf_counter()
    process = subprocess.Popen(command)
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"failed: {' '.join(command)}")
    return seconds, usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024)


HEADER = (
    "model", "tolerance", "before", "points", "best peer", "ratio", "deviation / tolerance", "rim / tolerance", "edges",
    "components", "seconds", "few enough", "near enough", "stays closed",
)  # fmt: skip


def build_row(anchor: Anchor, judged: Judged) -> list[object]:
    """Build a row of the table of models."""
    tolerance = anchor.relative * float(judged.found["diagonal"])
    most = int(anchor.best_points * find_allowance(anchor))
    components = " -> ".join(f"{judged.found[when]['components']:,}" for when in ("before", "after"))
    return [
        anchor.model, f"{anchor.relative:g}", anchor.points, judged.points,
        f"{anchor.best_points:,} ({anchor.best_peer})", judged.points / anchor.best_points,
        judged.deviation / tolerance, judged.rim / tolerance, judged.edges, components, judged.seconds,
        format_verdict(judged.points <= most), format_verdict(judged.deviation <= tolerance),
        format_verdict(judged.stays_closed),
    ]  # fmt: skip


def find_allowance(anchor: Anchor) -> float:
    """Return how many times the points of the best peer may remain."""
    return NO_BUILDING.get(Path(anchor.model).name, 1.0)


def format_verdict(met: bool) -> str:
    """Write PASS or FAIL."""
    return "PASS" if met else "FAIL"


def format_means(ratios: Sequence[tuple[Anchor, float]]) -> str:
    """Write the geometric means over the buildings, at each tolerance and in all."""
    buildings = [(anchor.relative, ratio) for anchor, ratio in ratios if Path(anchor.model).name not in NO_BUILDING]
    lines = []
    for relative in sorted({relative for relative, _ in buildings}):
        mean = find_geometric_mean([ratio for own, ratio in buildings if own == relative])
        lines.append(f"- at {relative:g}: {mean:.3f}")
    mean = find_geometric_mean([ratio for _, ratio in buildings])
    lines.append(f"- in all: {mean:.3f}, at most {MEAN}: {format_verdict(mean <= MEAN)}")
    return "Points beside the best peer's, geometric mean over the buildings:\n\n" + "\n".join(lines)


def find_geometric_mean(ratios: Sequence[float]) -> float:
    """Return the geometric mean of at least one ratio."""
    return math.exp(math.fsum(map(math.log, ratios)) / len(ratios))


NOISY_HEADER = (
    "noisy block", "triangles", "before", "points", "deviation / tolerance", "edges", "volume off by", "seconds",
    "peak memory", "few enough", "near enough", "stays closed", "volume kept", "fast enough",
)  # fmt: skip


def build_noisy_row(name: str, judged: Judged, limits: Limits) -> list[object]:
    """Build a row of the table of noisy blocks."""
    before = judged.found["before"]
    return [
        name, before["triangles"], before["points"], judged.points, judged.deviation / NOISY_TOLERANCE, judged.edges,
        judged.volume, judged.seconds, f"{judged.memory / MEBIBYTE:.0f} MiB",
        check_limit(judged.points, limits.points), format_verdict(judged.deviation <= NOISY_TOLERANCE),
        format_verdict(judged.stays_closed), check_limit(judged.volume, VOLUME),
        check_limit(judged.seconds, limits.seconds),
    ]  # fmt: skip


def check_limit(found: float, limit: float) -> str:
    """Write the verdict with its limit; nothing where there is no limit."""
    return f"{format_verdict(found <= limit)} ({limit:g})" if limit else ""


def build_noisy_rows(script: Path, folder: Path, sizes: Sequence[int]) -> list[list[object]]:
    """Build the rows of the noisy block among the models, and of those made here."""
    judged = judge_model(script, folder / NOISY_MODEL, str(NOISY_TOLERANCE))
    rows = [build_noisy_row(NOISY_MODEL, judged, NOISY_LIMITS[NOISY_MODEL])]
    base = simplify_model(folder / BASE)
    for size in sizes:
        with tempfile.TemporaryDirectory() as scratch:
            path = Path(scratch) / "block.ply"
            path.write_bytes(write_ply(add_noise(oversample(base, size), NOISE)))
            judged = judge_model(script, path, str(NOISY_TOLERANCE))
            rows.append(build_noisy_row(f"made, {size:,}", judged, NOISY_LIMITS.get(size, Limits())))
    return rows


def write_ply(surface: Surface) -> bytes:
    """Write a binary PLY file in double precision."""
    faces = np.empty(len(surface.faces), [("size", "u1"), ("corners", "<i4", 3)])
    faces["size"], faces["corners"] = 3, surface.faces
    axes = "".join(f"property double {axis}\n" for axis in "xyz")
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(surface.points)}\n{axes}"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    return header.encode() + surface.points.astype("<f8").tobytes() + faces.tobytes()


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("judge", type=Path, metavar="JUDGE.py")
    parser.add_argument("csv", nargs="?", type=Path, metavar="CSV", help="default: beside the models' folder")
    parser.add_argument("--tolerance", type=float, nargs="+", metavar="RELATIVE", help="default: 1e-4 and more")
    parser.add_argument("--noisy", type=int, nargs="*", default=NOISY_SIZES, metavar="TRIANGLES")
    args = parser.parse_args()
    folder = find_models()
    anchors = read_anchors(args.csv or folder.parent / "anchors.csv")
    chosen = [one for one in anchors if (one.relative in args.tolerance if args.tolerance else one.relative >= WIDE)]
    judged = [judge_model(args.judge, folder / anchor.model, f"{100 * anchor.relative:.12g}%") for anchor in chosen]
    rows = [build_row(anchor, one) for anchor, one in zip(chosen, judged, strict=True)]
    print(f"{format_table(HEADER, rows)}\n")
    print(format_means([(anchor, one.points / anchor.best_points) for anchor, one in zip(chosen, judged, strict=True)]))
    print(f"\nThe noisy blocks, at {NOISY_TOLERANCE}:\n")
    print(format_table(NOISY_HEADER, build_noisy_rows(args.judge, folder, args.noisy)))


if __name__ == "__main__":
    main()
