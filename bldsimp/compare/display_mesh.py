"""Choose the triangles that a page draws of a surface, and the samples where it measures their colors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import Faces, Flags, Points, cast_indices
from .placement import PlacedSurface

TRIANGLES = 200_000
"""A surface with more is thinned before it is drawn: ten times as many stutter on a small machine."""

BORDERS = 1.5
"""Up to so many times as many triangles may remain for the sake of open borders."""

SAMPLES = 40_000
"""About so many samples inside large triangles get a color, in addition to the corners."""

FINEST = 255
"""The sides of a triangle are cut into at most so many steps; a byte stores the number."""


@dataclass(frozen=True)
class DisplayMesh:
    """Triangles as a page draws them.

    Attributes
    ----------
    points : (n, 3) float64
        Model units; each is a point of the surface that is drawn.
    faces : (m, 3) int32
    steps : (m,) uint8
        The sides of each triangle are cut into so many steps for its colors; 1 means its corners alone.
    thinned : bool
        Whether these are fewer triangles than the surface has.
    """

    points: Points
    faces: Faces
    steps: Flags
    thinned: bool

    def place_samples(self) -> Points:
        """Return the places where colors are measured: the points, then the lattice of each triangle that is cut.

        The lattice of a triangle a, b, c in k steps has the rows ``a + (i (b - a) + j (c - a)) / k``,
        j from 0 to k, and within them i from 0 to k - j.
        """
        cut = np.flatnonzero(self.steps > 1)
        sizes = count_lattice(self.steps[cut])
        starts = np.cumsum(sizes) - sizes
        found = np.empty((int(sizes.sum()), 3))
        for k in np.unique(self.steps[cut]).tolist():
            own = np.flatnonzero(self.steps[cut] == k)
            shares = weigh_lattice(k)
            rows = starts[own][:, None] + np.arange(len(shares))
            found[rows] = np.einsum("sc,mcd->msd", shares, self.points[self.faces[cut[own]]])
        return np.concatenate([self.points, found])


def weigh_lattice(k: int) -> NDArray[np.float64]:
    """Return the weights of the three corners in each sample of a lattice with k steps a side, (s, 3)."""
    j, i = np.nonzero(np.add.outer(np.arange(k + 1), np.arange(k + 1)) <= k)
    return np.stack([k - i - j, i, j], axis=1) / k


def count_lattice(steps: NDArray[np.integer]) -> NDArray[np.int64]:
    """Count the samples of lattices."""
    k = steps.astype(np.int64)
    return (k + 1) * (k + 2) // 2


def choose_display(surface: PlacedSurface, triangles: int = TRIANGLES, samples: int = SAMPLES) -> DisplayMesh:
    """Choose the triangles and samples to draw of a surface.

    Parameters
    ----------
    surface : PlacedSurface
    triangles : int
        Surfaces with more are thinned by fast-simplification. Each point is then moved back to the nearest of
        the surface's points that it stands for, so that colors are true wherever they are measured.
    samples : int
        Greatest number inside triangles. A thinned surface has none: they would not lie on the whole one.

    Returns
    -------
    DisplayMesh
    """
    if len(surface.faces) > triangles:
        points, faces = thin_surface(surface, triangles)
        return DisplayMesh(points, faces, np.ones(len(faces), np.uint8), True)
    return DisplayMesh(surface.points, surface.faces, choose_steps(surface, samples), False)


def thin_surface(surface: PlacedSurface, triangles: int) -> tuple[Points, Faces]:
    """Connect some of a surface's own points by about so many triangles."""
    from fast_simplification import simplify

    middle = (surface.points.min(axis=0) + surface.points.max(axis=0)) / 2.0
    local = surface.points - middle
    # Borders stay where they are, unless a surface is nearly all borders.
    for fixed in (True, False):
        moved, faces, collapses = simplify(
            local, surface.faces, target_count=triangles, return_collapses=True, preserve_border=fixed
        )
        if len(faces) <= BORDERS * triangles:
            break
    into = np.arange(len(local))
    into[collapses[:, 1]] = collapses[:, 0]
    while not np.array_equal(into, into[into]):
        into = into[into]
    # Its points are those that remain and are used, in their old order.
    corners = into[surface.faces]
    a, b, c = corners.T
    kept = np.unique(corners[(a != b) & (b != c) & (a != c)])
    place = np.full(len(local), -1)
    place[kept] = np.arange(len(kept))
    members = np.flatnonzero(place[into] >= 0)
    stands_for = place[into[members]]
    far = np.linalg.norm(local[members] - moved[stands_for], axis=1)
    order = np.lexsort((far, stands_for))
    nearest = members[order[np.unique(stands_for[order], return_index=True)[1]]]
    return surface.points[nearest], cast_indices(faces)


def choose_steps(surface: PlacedSurface, samples: int) -> Flags:
    """Choose the steps of each triangle's sides so that all lattices together have at most so many samples.

    Half of the samples go to all triangles alike, since removed details may be small; the others go by the square
    of the longest side, so that the steps of large triangles become about equally long.
    """
    corners = surface.points[surface.faces]
    longest = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(axis=1)
    square = (longest / longest.max()) ** 2
    share = samples * (0.5 / len(square) + 0.5 * square / square.sum())
    # The most steps k with (k + 1) (k + 2) / 2 samples.
    steps = np.floor((np.sqrt(8.0 * share + 1.0) - 3.0) / 2.0)
    return np.asarray(np.clip(steps, 1, FINEST), np.uint8)
