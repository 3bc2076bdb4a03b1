"""How far two models differ to the eye: the same views of both, compared pixel by pixel and window by window."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from textured.draw import cameras, draw
from textured.model import Floats, Model

WINDOW = 16
"""Side of the windows within which the difference is local; pixels."""

SIZE = 240
"""Side of a view; pixels."""


@dataclass(frozen=True)
class Difference:
    """Differences of colour as shares of the whole range.

    Attributes
    ----------
    mean : float
        Over all pixels, of all views, on which either model is seen.
    local : float
        The greatest mean over a window of 16 x 16 pixels.
    view, column, row : int
        Where that window is: which view, and its upper left pixel.
    """

    mean: float
    local: float
    view: int
    column: int
    row: int


def difference(before: Model, after: Model, size: int = SIZE) -> Difference:
    """Compare eight views of two models, through cameras that fit the first."""
    total, seen = 0.0, 0
    worst = (-1.0, 0, 0, 0)
    for number, (camera, style) in enumerate(cameras(before, size)):
        first, second = (draw(model, camera, style) for model in (before, after))
        apart = np.abs(first - second).mean(axis=2)
        shown = np.any((first != style.paper) | (second != style.paper), axis=2)
        total, seen = total + float(apart[shown].sum()), seen + int(shown.sum())
        means = windows(apart)
        row, column = np.unravel_index(int(np.argmax(means)), means.shape)
        worst = max(worst, (float(means[row, column]), number, int(column), int(row)))
    return Difference(total / max(seen, 1), *worst)


def windows(values: Floats) -> Floats:
    """Means over all windows."""
    sums = np.pad(values, ((1, 0), (1, 0))).cumsum(axis=0).cumsum(axis=1)
    found = sums[WINDOW:, WINDOW:] - sums[:-WINDOW, WINDOW:] - sums[WINDOW:, :-WINDOW] + sums[:-WINDOW, :-WINDOW]
    return np.asarray(found / WINDOW**2)
