"""Compare two models as the eye does: the same views of both, pixel by pixel and window by window."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from picture import Camera, Style

from textured.draw import draw, place_cameras
from textured.model import Floats, Model

WINDOW = 16
"""Side of the windows within which the difference is local; pixels."""

SIZE = 240
"""Side of a view; pixels."""

MEAN = 0.01
"""Greatest mean difference that the eye does not see."""

LOCAL = 0.01
"""Greatest difference within a window that the eye does not see: a texture shifted by two texels exceeds it."""


@dataclass(frozen=True)
class Difference:
    """Differences of color as shares of the whole range.

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


@dataclass(frozen=True)
class Views:
    """A model seen from all sides.

    Attributes
    ----------
    cameras : list of Camera and Style
    pictures : list of (size, size, 3) float64
    """

    cameras: list[tuple[Camera, Style]]
    pictures: list[Floats]

    @classmethod
    def draw(cls, model: Model, like: Views | None = None) -> Views:
        """Draw a model, through the cameras of another one's views, or those that fit it."""
        chosen = like.cameras if like else place_cameras(model, SIZE)
        return cls(chosen, [draw(model, camera, style) for camera, style in chosen])


def compare_views(before: Views, after: Views) -> Difference:
    """Compare views through the same cameras."""
    total, seen = 0.0, 0
    worst = (-1.0, 0, 0, 0)
    for number, (first, second) in enumerate(zip(before.pictures, after.pictures, strict=True)):
        apart = np.abs(first - second).mean(axis=2)
        shown = np.any((first != 1.0) | (second != 1.0), axis=2)
        total, seen = total + float(apart[shown].sum()), seen + int(shown.sum())
        means = find_windows(apart)
        row, column = np.unravel_index(int(np.argmax(means)), means.shape)
        worst = max(worst, (float(means[row, column]), number, int(column), int(row)))
    return Difference(total / max(seen, 1), *worst)


def find_windows(values: Floats) -> Floats:
    """Return the means over all windows."""
    sums = np.pad(values, ((1, 0), (1, 0))).cumsum(axis=0).cumsum(axis=1)
    found = sums[WINDOW:, WINDOW:] - sums[:-WINDOW, WINDOW:] - sums[WINDOW:, :-WINDOW] + sums[:-WINDOW, :-WINDOW]
    return np.asarray(found / WINDOW**2)
