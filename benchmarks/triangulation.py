"""Time the triangulation core beside Triangle and SciPy: random points, polygons with holes, cocircular grids.

usage: python benchmarks/triangulation.py [--runs R] [--quick]
needs: pip install "bldsimp[bench]"; SciPy is measured where it is installed

All programs go from NumPy arrays to NumPy arrays on the same input in the same run, in turns; a time is the
least and the median of the runs. Triangle gets a point inside each hole, which bldsimp does not need. Points
without segments are triangulated to their convex hull. Printed as Markdown; `ratio` is Triangle's least time
over ours, so that more than 1 means faster than Triangle. A peer whose number of triangles differs is named.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import triangle
from numpy.typing import NDArray
from table import Timing, format_table, format_time, time_in_turns

import bldsimp

try:
    from scipy.spatial import Delaunay
except ImportError:
    Delaunay = None

Points = NDArray[np.float64]
LEAST_SECONDS = 0.02
"""A timed job repeats its call until it takes about this long, so that the clock is fine enough."""


MOST_FOR_SCIPY = 100_000
"""Points; a million take SciPy a quarter of a minute."""


@dataclass
class Case:
    """One input: points, ring segments, and a point inside each hole."""

    name: str
    points: Points
    segments: NDArray[np.int32] = field(default_factory=lambda: np.empty((0, 2), np.int32))
    holes: list[tuple[float, float]] = field(default_factory=list)

    def run_ours(self) -> int:
        """Count the triangles of bldsimp."""
        return len(bldsimp.triangulate(self.points, self.segments, carve=len(self.segments) > 0).triangles)

    def run_triangle(self) -> int:
        """Count the triangles of Triangle."""
        given: dict[str, Any] = {"vertices": self.points}
        if len(self.segments):
            given["segments"] = self.segments
        if self.holes:
            given["holes"] = self.holes
        return len(triangle.triangulate(given, "pQ" if len(self.segments) else "Q")["triangles"])

    def run_scipy(self) -> int:
        """Count the triangles of SciPy, which knows no segments."""
        return len(Delaunay(self.points).simplices)


def make_star(rng: np.random.Generator, center: tuple[float, float], count: int, least: float, most: float) -> Points:
    """Make points of a ring around a center, their distance at random."""
    angle = np.arange(count) * (2 * np.pi / count)
    arm = rng.uniform(least, most, (count, 1))
    ring: Points = np.array(center) + arm * np.c_[np.cos(angle), np.sin(angle)]
    return ring


def make_polygon(outer: int, holes: int, corners: int) -> Case:
    """Make a star with star-shaped holes in a circle around its middle."""
    rng = np.random.default_rng(outer)
    centers = [(6 * np.cos(a), 6 * np.sin(a)) for a in np.arange(holes) * (2 * np.pi / max(holes, 1))]
    outlines = [make_star(rng, (0, 0), outer, 10, 13), *(make_star(rng, c, corners, 1, 1.3) for c in centers)]
    starts = np.cumsum([0, *map(len, outlines)])
    segments = [
        first + np.c_[np.arange(len(ring)), (np.arange(len(ring)) + 1) % len(ring)]
        for first, ring in zip(starts[:-1], outlines, strict=True)
    ]
    name = f"polygon, {holes} holes" if holes else "polygon"
    return Case(name, np.concatenate(outlines), np.concatenate(segments).astype(np.int32), centers)


def make_cases(quick: bool) -> list[Case]:
    """Make the inputs, by kind of use."""
    rng = np.random.default_rng(1)
    side = np.arange(100 if quick else 300, dtype=float)
    grid = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    sizes = (10_000, 100_000) if quick else (10_000, 100_000, 1_000_000)
    return [
        make_polygon(12, 0, 0),
        make_polygon(36, 8, 12),
        make_polygon(9_904, 8, 12),
        *(Case("random points", rng.random((n, 2))) for n in sizes),
        Case("grid, all ties", grid),
    ]


def repeat(job: Callable[[], int], times: int) -> Callable[[], None]:
    """Repeat a job so many times."""

    def run() -> None:
        for _ in range(times):
            job()

    return run


def measure(case: Case, runs: int) -> list[object]:
    """Measure one row of the table."""
    jobs = {"ours": case.run_ours, "triangle": case.run_triangle}
    if Delaunay is not None and not len(case.segments) and len(case.points) <= MOST_FOR_SCIPY:
        jobs["scipy"] = case.run_scipy
    counts = {name: job() for name, job in jobs.items()}
    once = time_in_turns(1, **jobs)
    times = {name: max(1, round(LEAST_SECONDS / once[name].least)) for name in jobs}
    total = time_in_turns(runs, **{name: repeat(job, times[name]) for name, job in jobs.items()})
    timing = {name: Timing([s / times[name] for s in total[name].seconds]) for name in jobs}
    ratio = f"{timing['triangle'].least / timing['ours'].least:.2f} x"
    scipy = str(timing["scipy"]) if "scipy" in timing else ""
    differing = ", ".join(f"{name}: {count:,}" for name, count in counts.items() if count != counts["ours"])
    return [
        case.name, len(case.points), counts["ours"], timing["ours"],
        format_time(timing["ours"].least / len(case.points)), timing["triangle"], ratio, scipy, differing,
    ]  # fmt: skip


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--quick", action="store_true", help="no input above 100,000 points")
    args = parser.parse_args()
    header = [
        "input",
        "points",
        "triangles",
        "ours",
        "per point",
        "Triangle",
        "ratio",
        "SciPy",
        "other counts",
    ]
    print(format_table(header, [measure(case, args.runs) for case in make_cases(args.quick)]))


if __name__ == "__main__":
    main()
