"""Search a general decimator for the fewest points within a deviation, or for its deviation at as many points.

Decimators take a number of triangles, not a deviation, so it has to be searched for.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model import Faces, Points, Scene, cast_indices
from .measure import Judge
from .placement import PlacedSurface, place_scene, weld_surface

STEPS = 14
"""Steps of the geometric bisection of the target."""

LEAST_TRIANGLES = 12
"""Where the bisection starts: a box."""

STEPS_TO_POINTS = 16
"""At most so many targets are tried for a number of points."""

Arrays = tuple[Points, NDArray[Any]]


class RefusalError(Exception):
    """A tool does not take the input; says why."""


@dataclass(frozen=True)
class Decimation:
    """A result of a decimator.

    Attributes
    ----------
    surface : PlacedSurface
        Model units, world space.
    deviation : float
        Measured both ways, model units.
    seconds : float
        Of the one run that made it; the search is not counted.
    """

    surface: PlacedSurface
    deviation: float
    seconds: float


@dataclass
class Run:
    """One run of a decimator: its `deviation` is a lower bound until it is `exact`."""

    points: int
    seconds: float
    deviation: float = 0.0
    exact: bool = False


class Decimator:
    """One way to decimate one original; it remembers its runs, so that several limits can share them.

    Parameters
    ----------
    judge : Judge
        Knows the original.
    decimate : callable
        Takes points about the middle of the original's box, faces, and a target; returns points and
        faces. The greater the target, the more triangles remain.
    most : int, optional
        The greatest target, of a tool that is limited by a length and takes the diagonal by the target for it;
        the number of faces where left out.
    aimed : bool
        Whether the target matters; else there is one result.
    """

    def __init__(
        self,
        judge: Judge,
        decimate: Callable[[Points, Faces, int], Arrays],
        most: int | None = None,
        aimed: bool = True,
    ) -> None:
        self.judge = judge
        self._decimate = decimate
        self._points, self._faces = judge.original.points - judge.origin, judge.original.faces
        self._most = len(self._faces) if most is None else most
        self._by_length = most is not None
        self._least = min(LEAST_TRIANGLES, self._most)
        self._aimed = aimed
        self._runs: dict[int, Run] = {}
        self._latest: tuple[int, PlacedSurface] | None = None

    def find_fewest_points(self, limit: float) -> Decimation | None:
        """Bisect for the least result within a deviation; None where there is none.

        Parameters
        ----------
        limit : float
            Model units.

        Notes
        -----
        The deviation does not quite rise as the target falls, so a lesser result may exist.
        """
        if not self._aimed:
            return self._finish(self._most) if self._is_within(self._most, limit) else None
        low, high, best = self._least, self._most, None
        for _ in range(STEPS):
            if high - low <= 1:
                break
            target = math.isqrt(low * high)
            if self._is_within(target, limit):
                high = best = target
            else:
                low = target
        return None if best is None else self._finish(best)

    def find_point_count(self, points: int) -> Decimation:
        """Search for the least result that has at least so many points."""
        low, high = (self._least, self._run(self._least).points), (self._most, len(self._points))
        if low[1] >= points:
            return self._finish(low[0])
        for step in range(STEPS_TO_POINTS):
            if high[0] - low[0] <= 1 or high[1] == points:
                break
            # Interpolation serves where points rise with the target; on long plateaus only halving advances.
            halve = self._by_length or step % 2 == 1
            share = (points - low[1]) / max(high[1] - low[1], 1)
            guess = math.isqrt(low[0] * high[0]) if halve else low[0] + round(share * (high[0] - low[0]))
            target = min(max(guess, low[0] + 1), high[0] - 1)
            count = self._run(target).points
            low, high = ((target, count), high) if count < points else (low, (target, count))
        return self._finish(high[0])

    def _is_within(self, target: int, limit: float) -> bool:
        run = self._run(target)
        if not run.exact and run.deviation <= limit:
            run.deviation = self.judge.measure_within(self._load_surface(target), limit)
            run.exact = run.deviation <= limit
        return run.deviation <= limit

    def _finish(self, target: int) -> Decimation:
        run = self._run(target)
        surface = self._load_surface(target)
        if not run.exact:
            run.deviation, run.exact = self.judge.measure_deviation(surface), True
        return Decimation(surface, run.deviation, run.seconds)

    def _run(self, target: int) -> Run:
        if target not in self._runs:
            surface, seconds = self._make(target)
            self._runs[target] = Run(len(surface.points), seconds)
            self._latest = target, surface
        return self._runs[target]

    def _load_surface(self, target: int) -> PlacedSurface:
        """Return the result of a run: only the latest is kept, the others are made again."""
        if self._latest is None or self._latest[0] != target:
            self._latest = target, self._make(target)[0]
        return self._latest[1]

    def _make(self, target: int) -> tuple[PlacedSurface, float]:
        start = time.perf_counter()
        points, faces = self._decimate(self._points, self._faces, target)
        seconds = time.perf_counter() - start
        corners = cast_indices(faces).reshape(-1, 3)
        return weld_surface(np.asarray(points, np.float64) + self.judge.origin, corners), seconds


@dataclass(frozen=True)
class FastSimplification:
    """Decimates with fast-simplification, with these of its options."""

    preserve_border: bool = False
    lossless: bool = False

    def __call__(self, points: Points, faces: Faces, target: int) -> Arrays:
        """Return the remaining points and faces; `lossless` ignores the target."""
        from fast_simplification import simplify

        found, cells = simplify(
            points, faces, target_count=target, preserve_border=self.preserve_border, lossless=self.lossless
        )
        return found, cells


def count_baseline_points(scene: Scene, deviation: float, warnings: list[str]) -> int | None:
    """Count the points that fast-simplification needs to stay within a deviation.

    Parameters
    ----------
    scene : Scene
        Of each mesh the first instance counts.
    deviation : float
        Model units, in world space.
    warnings : list of str
        Gets a line where the deviation cannot be reached.

    Returns
    -------
    int or None
        None where fast-simplification cannot remove a triangle without exceeding the deviation.

    Notes
    -----
    The target number of triangles is bisected geometrically. A result counts if no point and no sample
    of either surface lies farther from the other than the deviation and the rounding of single precision: so
    the figure favors the baseline.
    """
    once = [dataclasses.replace(mesh, transforms=mesh.transforms[:1]) for mesh in scene.meshes]
    judge = Judge(place_scene(dataclasses.replace(scene, meshes=once)))
    found = Decimator(judge, FastSimplification()).find_fewest_points(deviation + judge.blur)
    if found is None:
        warnings.append("fast-simplification removes nothing within the same deviation")
    return None if found is None else len(found.surface.points)
