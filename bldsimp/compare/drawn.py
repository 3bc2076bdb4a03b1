"""What a page draws of a surface: few enough triangles for any machine, and where their colours are measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import Faces, Flags, Points
from .surface import Surface

TRIANGLES = 200_000
"""A surface with more is thinned before it is drawn: ten times as many stutter on a small machine."""

BORDERS = 1.5
"""So many times as many triangles may stay for the sake of open borders."""

SAMPLES = 40_000
"""About so many points inside large triangles are coloured beside their corners."""

FINEST = 255
"""A triangle's sides are cut into at most so many parts; it is stored in a byte."""


@dataclass(frozen=True)
class Drawn:
    """Triangles as they are drawn.

    Attributes
    ----------
    points : (n, 3) float64
        Model units; each is a point of the surface that is drawn.
    faces : (m, 3) int32
    parts : (m,) uint8
        So many parts the sides of each triangle are cut into where it is coloured; 1 is its corners alone.
    thinned : bool
        Whether these are fewer triangles than the surface has.
    """

    points: Points
    faces: Faces
    parts: Flags
    thinned: bool

    def samples(self) -> Points:
        """Where colours are measured: the points, then the lattice of each triangle that is cut.

        The lattice of a triangle a, b, c in k parts has the rows ``a + (i (b - a) + j (c - a)) / k``,
        j from 0 to k, and within them i from 0 to k - j.
        """
        cut = np.flatnonzero(self.parts > 1)
        sizes = lattice_sizes(self.parts[cut])
        starts = np.cumsum(sizes) - sizes
        found = np.empty((int(sizes.sum()), 3))
        for k in np.unique(self.parts[cut]).tolist():
            own = np.flatnonzero(self.parts[cut] == k)
            corners = self.points[self.faces[cut[own]]]
            rows = starts[own][:, None] + np.arange(int(lattice_sizes(np.array([k]))[0]))
            found[rows] = np.einsum("sc,mcd->msd", lattice(k), corners)
        return np.concatenate([self.points, found])


def lattice(k: int) -> NDArray[np.float64]:
    """Shares of the corners in each point of a lattice with k parts a side, (s, 3)."""
    j, i = np.nonzero(np.add.outer(np.arange(k + 1), np.arange(k + 1)) <= k)
    return np.stack([k - i - j, i, j], axis=1) / k


def lattice_sizes(parts: NDArray[np.integer]) -> NDArray[np.int64]:
    """Points in lattices."""
    k = parts.astype(np.int64)
    return (k + 1) * (k + 2) // 2


def drawn(surface: Surface, triangles: int = TRIANGLES, samples: int = SAMPLES) -> Drawn:
    """Choose what is drawn of a surface.

    Parameters
    ----------
    surface : Surface
    triangles : int
        More than these are thinned by fast-simplification. Each point is then moved back to the nearest of
        the surface's points that it stands for, so that colours are true wherever they are measured.
    samples : int
        Points inside triangles, at most. Where the surface is thinned there are none: they would not lie on it.

    Returns
    -------
    Drawn
    """
    if len(surface.faces) > triangles:
        points, faces = thinned(surface, triangles)
        return Drawn(points, faces, np.ones(len(faces), np.uint8), True)
    return Drawn(surface.points, surface.faces, parts_within(surface, samples), False)


def thinned(surface: Surface, triangles: int) -> tuple[Points, Faces]:
    """About so many triangles between some of a surface's own points."""
    from fast_simplification import simplify

    middle = (surface.points.min(axis=0) + surface.points.max(axis=0)) / 2.0
    local = surface.points - middle
    # Borders stay where they are, unless a surface is nearly all borders.
    for stays in (True, False):
        moved, faces, collapses = simplify(
            local, surface.faces, target_count=triangles, return_collapses=True, preserve_border=stays
        )
        if len(faces) <= BORDERS * triangles:
            break
    into = np.arange(len(local))
    into[collapses[:, 1]] = collapses[:, 0]
    while not np.array_equal(into, into[into]):
        into = into[into]
    # Its points are those that are left and used, in their old order.
    corners = into[surface.faces]
    a, b, c = corners.T
    left = np.unique(corners[(a != b) & (b != c) & (a != c)])
    place = np.full(len(local), -1)
    place[left] = np.arange(len(left))
    members = np.flatnonzero(place[into] >= 0)
    stands_for = place[into[members]]
    far = np.linalg.norm(local[members] - moved[stands_for], axis=1)
    order = np.lexsort((far, stands_for))
    nearest = members[order[np.unique(stands_for[order], return_index=True)[1]]]
    return surface.points[nearest], np.ascontiguousarray(faces, np.int32)


def parts_within(surface: Surface, samples: int) -> Flags:
    """Parts a side, such that lattices hold at most so many points.

    Half of them go to all triangles alike, since what was swallowed may be small; with the others the
    parts of large triangles become about equally long.
    """
    corners = surface.points[surface.faces]
    longest = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(axis=1)
    least = 1
    while least < FINEST and len(longest) * int(lattice_sizes(np.array([least + 1]))[0]) <= samples / 2:
        least += 1
    best = np.full(len(longest), least, np.uint8)
    high = float(longest.max(initial=0.0))
    low = high / FINEST
    for _ in range(24):
        step = np.sqrt(low * high)
        if not low < step < high:
            break
        parts = np.clip(np.ceil(longest / step), least, FINEST).astype(np.uint8)
        if lattice_sizes(parts[parts > 1]).sum() <= samples:
            high, best = step, parts
        else:
            low = step
    return best
