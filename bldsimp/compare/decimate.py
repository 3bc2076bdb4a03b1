"""General decimators: the fewest points that one needs within a deviation, and its deviation at as many points.

They take a number of triangles, not a deviation, so that it has to be searched for.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model import Faces, Points
from .measure import Judge
from .surface import Surface, welded

STEPS = 14
"""So often the target is bisected, geometrically."""

LEAST_TRIANGLES = 12
"""Where the bisection starts: a box."""

STEPS_TO_POINTS = 16
"""So often a target is guessed for a number of points, at most."""

Arrays = tuple[Points, NDArray[Any]]


class Refused(Exception):
    """A tool does not take the input; says why."""


@dataclass(frozen=True)
class Found:
    """A surface that a decimator made.

    Attributes
    ----------
    surface : Surface
        Model units, world space.
    deviation : float
        Measured both ways.
    seconds : float
        Of the one run that made it; the search is not counted.
    """

    surface: Surface
    deviation: float
    seconds: float


@dataclass
class Run:
    """What is known of one run: its `deviation` is a lower bound until it is `exact`."""

    points: int
    seconds: float
    deviation: float = 0.0
    exact: bool = False


class Decimator:
    """One way to decimate one original; its runs are remembered, so that limits can share them.

    Parameters
    ----------
    judge : Judge
        Knows the original.
    decimate : callable
        Takes points about the middle of the original's box, faces, and a target, and gives points and
        faces. The greater the target, the more triangles stay.
    start : Surface, optional
        What is decimated, where it is not the original itself.
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
        start: Surface | None = None,
        most: int | None = None,
        aimed: bool = True,
    ) -> None:
        start = start or judge.original
        self.judge = judge
        self._decimate = decimate
        self._points, self._faces = start.points - judge.origin, start.faces
        self._most = len(start.faces) if most is None else most
        self._by_length = most is not None
        self._least = min(LEAST_TRIANGLES, self._most)
        self._aimed = aimed
        self._runs: dict[int, Run] = {}
        self._latest: tuple[int, Surface] | None = None

    def fewest_points(self, limit: float) -> Found | None:
        """The least result within a deviation, by bisection; None where there is none.

        Parameters
        ----------
        limit : float
            Model units.

        Notes
        -----
        The deviation does not quite rise as the target falls, so that a lesser result may exist.
        """
        if not self._aimed:
            return self._found(self._most) if self._is_within(self._most, limit) else None
        low, high, best = self._least, self._most, None
        for _ in range(STEPS):
            if high - low <= 1:
                break
            target = math.isqrt(low * high)
            if self._is_within(target, limit):
                high = best = target
            else:
                low = target
        return None if best is None else self._found(best)

    def at_points(self, points: int) -> Found:
        """The least result that has at least so many points."""
        low, high = (self._least, self._run(self._least).points), (self._most, len(self._points))
        if low[1] >= points:
            return self._found(low[0])
        for step in range(STEPS_TO_POINTS):
            if high[0] - low[0] <= 1 or high[1] == points:
                break
            # Lines do where points go with the target; where they stay the same for long, only halving gets on.
            halve = self._by_length or step % 2 == 1
            share = (points - low[1]) / max(high[1] - low[1], 1)
            guess = math.isqrt(low[0] * high[0]) if halve else low[0] + round(share * (high[0] - low[0]))
            target = min(max(guess, low[0] + 1), high[0] - 1)
            found = self._run(target).points
            low, high = ((target, found), high) if found < points else (low, (target, found))
        return self._found(high[0])

    def _is_within(self, target: int, limit: float) -> bool:
        run = self._run(target)
        if not run.exact and run.deviation <= limit:
            run.deviation = self.judge.farthest(self._surface(target), limit)
            run.exact = run.deviation <= limit
        return run.deviation <= limit

    def _found(self, target: int) -> Found:
        run = self._run(target)
        surface = self._surface(target)
        if not run.exact:
            run.deviation, run.exact = self.judge.deviation(surface), True
        return Found(surface, run.deviation, run.seconds)

    def _run(self, target: int) -> Run:
        if target not in self._runs:
            surface, seconds = self._make(target)
            self._runs[target] = Run(len(surface.points), seconds)
            self._latest = target, surface
        return self._runs[target]

    def _surface(self, target: int) -> Surface:
        """The result of a run: only the latest is kept, the others are made again."""
        if self._latest is None or self._latest[0] != target:
            self._latest = target, self._make(target)[0]
        return self._latest[1]

    def _make(self, target: int) -> tuple[Surface, float]:
        start = time.perf_counter()
        points, faces = self._decimate(self._points, self._faces, target)
        seconds = time.perf_counter() - start
        corners = np.asarray(faces, np.int32).reshape(-1, 3)
        return welded(np.asarray(points, np.float64) + self.judge.origin, corners), seconds


@dataclass(frozen=True)
class FastSimplification:
    """Decimates with fast-simplification, with these of its options."""

    preserve_border: bool = False
    lossless: bool = False

    def __call__(self, points: Points, faces: Faces, target: int) -> Arrays:
        """Points and faces that are left; `lossless` does not regard the target."""
        from fast_simplification import simplify

        found, cells = simplify(
            points, faces, target_count=target, preserve_border=self.preserve_border, lossless=self.lossless
        )
        return found, cells
