"""The measure: how far two surfaces are from each other, and what became of the borders.

Distances are exact, point to triangle, in double precision, from all points of each surface and from
samples spread over it by area, to the other one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model import Faces, Points
from .surface import Surface

SAMPLES = 20_000
"""So many points are spread over a surface by area, beside its own points."""

SEED = 1

ALONG_EDGES = np.linspace(0.0, 1.0, 5)
"""Where an open edge is looked at, from its one end to the other."""

NOISE_SPACINGS = 16.0
"""Samples lie so many spacings of double precision off their surface at most, at its largest coordinate; a
surface was up to 8.3 from itself on real models. That is taken off, so that equal surfaces are 0 apart."""


class Judge:
    """Measures surfaces against one original, whose tree and samples are made once.

    Parameters
    ----------
    original : Surface

    Attributes
    ----------
    original : Surface
    origin : (3,) float64
        Middle of the original's box: all distances are taken about it.
    diagonal : float
        Model units.
    blur : float
        What single precision blurs about the origin: it is not held against decimators, most of
        whose results are stored so.
    """

    def __init__(self, original: Surface) -> None:
        low, high = original.points.min(axis=0), original.points.max(axis=0)
        self.original = original
        self.origin: Points = low + (high - low) / 2.0
        self.diagonal = float(np.linalg.norm(high - low))
        local = original.points - self.origin
        self.blur = 2.0 * float(np.spacing(np.float32(np.abs(local).max())))
        self._noise = noise(local)
        self._tree = _core.FaceTree(local, original.faces)
        self._queries = queries(local, original.faces)
        self._rim = open_edges(original.faces)
        self._rim_tree = _tree_of_edges(local, self._rim)

    @property
    def has_border(self) -> bool:
        """Whether the original has an open edge."""
        return len(self._rim) > 0

    def deviation(self, surface: Surface) -> float:
        """Greatest distance between the surface and the original, both ways; model units."""
        return self.farthest(surface, np.inf)

    def farthest(self, surface: Surface, limit: float) -> float:
        """Like `deviation`, but some distance beyond `limit` as soon as there is one.

        Parameters
        ----------
        surface : Surface
        limit : float
            Model units.

        Returns
        -------
        float
            The deviation where it is at most `limit`, else a lower bound of it that is greater than
            `limit`. Infinite where the surface has no faces.
        """
        if not len(surface.faces):
            return float("inf")
        local, allowed = surface.points - self.origin, limit + self._noise
        # The original's tree is there already: what left the surface far behind shows soonest there.
        found = self._tree.farthest(queries(local, surface.faces), allowed)
        if found <= allowed:
            found = max(found, _core.FaceTree(local, surface.faces).farthest(self._queries, allowed))
        if found > allowed:
            # Less the noise, it might come out as the limit itself.
            return max(found - self._noise, float(np.nextafter(limit, np.inf)))
        return min(max(found - self._noise, 0.0), limit)

    def borders_made(self, surface: Surface, moved: float) -> int:
        """Open edges of a surface that lie on no open edge of the original: where it was torn.

        Parameters
        ----------
        surface : Surface
        moved : float
            How far an edge may have moved and still be the same; model units.
        """
        rim = open_edges(surface.faces)
        if not len(rim) or not len(self._rim):
            return len(rim)
        a, b = (surface.points[ends] - self.origin for ends in rim.T)
        along = a[:, None] + (b - a)[:, None] * ALONG_EDGES[:, None]
        away = self._rim_tree.distances(np.ascontiguousarray(along.reshape(-1, 3)))
        beyond = away.reshape(len(rim), -1).max(axis=1) > moved + self._noise
        return int(beyond.sum())


def noise(points: Points) -> float:
    """How far a surface can come out from itself by rounding alone, in the frame of its points."""
    return NOISE_SPACINGS * float(np.spacing(np.abs(points).max()))


def is_watertight(surface: Surface) -> bool:
    """Whether every edge belongs to exactly two faces."""
    open_, nonmanifold = _core.count_edges(surface.faces, len(surface.points))
    return bool(len(surface.faces)) and open_ == nonmanifold == 0


def open_edges(faces: Faces) -> NDArray[np.int32]:
    """Edges that belong to one face, by their ends; (k, 2)."""
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    key = ends[:, 0].astype(np.int64) << 32 | ends[:, 1]
    single, count = np.unique(key, return_counts=True)
    single = single[count == 1]
    return np.stack([single >> 32, single & 0xFFFFFFFF], axis=1).astype(np.int32)


def queries(points: Points, faces: Faces) -> Points:
    """All points of a surface, then its samples."""
    return np.concatenate([points, samples(points, faces)])


def samples(points: Points, faces: Faces) -> Points:
    """Points spread over a surface by area, the same every time; none where it has no area."""
    random = np.random.default_rng(SEED)
    a, b, c = (points[faces[:, i]] for i in range(3))
    area = np.cumsum(np.linalg.norm(np.cross(b - a, c - a), axis=1))
    if not len(area) or area[-1] == 0.0:
        return np.empty((0, 3))
    place, folded = random.random(SAMPLES), random.random((SAMPLES, 2))
    # A sample of the parallelogram over a face is folded back into it.
    folded = np.abs(folded - (folded.sum(axis=1) > 1.0)[:, None])
    # Samples of one face follow each other: their nearest faces are near each other, too.
    order = np.argsort(place, kind="stable")
    face = np.minimum(np.searchsorted(area, place[order] * area[-1]), len(faces) - 1)
    s, t = folded[order].T[:, :, None]
    return np.asarray(a[face] + s * (b - a)[face] + t * (c - a)[face])


def _tree_of_edges(points: Points, edges: NDArray[np.int32]) -> _core.FaceTree:
    """Edges as faces without area."""
    return _core.FaceTree(points, np.ascontiguousarray(edges[:, [0, 1, 1]]))
