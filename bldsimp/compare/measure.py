"""Measure how far two surfaces are from each other, and which borders are new.

Distances are exact, point to triangle, in double precision: from all points of each surface, and from
samples spread over it by area, to the other surface. A certified bound then shows whether some point between
the samples is farther.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model import Faces, Indices, Points
from .placement import PlacedSurface

SAMPLES = 20_000
"""Number of samples spread over a surface by area, in addition to its own points."""

SEED = 1

ALONG_EDGES = np.linspace(0.0, 1.0, 5)
"""Where an open edge is probed, from its one end to the other."""

NOISE_SPACINGS = 16.0
"""Samples lie at most so many spacings of double precision off their surface, at its largest coordinate; a
surface was up to 8.3 from itself on real models. That is taken off, so that equal surfaces are 0 apart."""

PRECISION = 1e-3
"""Share of the deviation to which it is certified: a few cells for each face suffice."""

LEAST_PRECISION = 1e-12
"""Precision of a deviation that is next to nothing, as a share of the largest coordinate: roundings of a certificate
are less."""


class Judge:
    """Measures surfaces against one original, whose tree and samples are made once.

    Parameters
    ----------
    original : PlacedSurface

    Attributes
    ----------
    original : PlacedSurface
    origin : (3,) float64
        Middle of the original's box: all distances are taken about it.
    diagonal : float
        Model units.
    blur : float
        Rounding of single precision about the origin, model units: it is not held against decimators, most of
        which store their results so.
    tree : FaceTree
        Of the original, about the origin.
    noise : float
        Rounding of double precision about the origin, model units: distances up to this count as none.
    least_precision : float
        Model units.
    has_border : bool
        Whether the original has an open edge.
    """

    def __init__(self, original: PlacedSurface) -> None:
        low, high = original.points.min(axis=0), original.points.max(axis=0)
        self.original = original
        self.origin: Points = low + (high - low) / 2.0
        self.diagonal = float(np.linalg.norm(high - low))
        local = original.points - self.origin
        self.blur = 2.0 * float(np.spacing(np.float32(np.abs(local).max())))
        self.noise = NOISE_SPACINGS * float(np.spacing(np.abs(local).max()))
        self.least_precision = LEAST_PRECISION * float(np.abs(local).max())
        self.tree = _core.FaceTree(local, original.faces)
        self._local = local
        self._queries = collect_queries(local, original.faces)
        self._rim = find_open_edges(original)
        self.has_border = len(self._rim) > 0
        # Edges as faces without area.
        self._rim_tree = _core.FaceTree(local, np.ascontiguousarray(self._rim[:, [0, 1, 1]]))

    def measure_deviation(self, surface: PlacedSurface) -> float:
        """Return the greatest distance between the surface and the original, both ways; model units.

        It is too small by a thousandth at most.
        """
        return self.measure_within(surface, np.inf)

    def measure_within(self, surface: PlacedSurface, limit: float) -> float:
        """Measure like `measure_deviation`, but stop at the first distance beyond `limit`.

        Parameters
        ----------
        surface : PlacedSurface
        limit : float
            Model units.

        Returns
        -------
        float
            The deviation, too small by a thousandth at most, where it is at most `limit`; else a lower bound of it
            that is greater than `limit`. Infinite where the surface has no faces.
        """
        if not len(surface.faces):
            return float("inf")
        local, allowed = surface.points - self.origin, limit + self.noise
        # The original's tree is there already: a surface that is far off shows soonest there.
        found = self.tree.farthest(collect_queries(local, surface.faces), allowed)
        if found <= allowed:
            tree = _core.FaceTree(local, surface.faces)
            found = max(found, tree.farthest(self._queries, allowed))
        if found <= allowed:
            found = self._certify(local, surface.faces, tree, found)
        if found > allowed:
            # Less the noise, it might come out as the limit itself.
            return max(found - self.noise, float(np.nextafter(limit, np.inf)))
        return min(max(found - self.noise, 0.0), limit)

    def _certify(self, points: Points, faces: Faces, tree: _core.FaceTree, found: float) -> float:
        """Return what samples found, or more where some point between them is farther, but for the precision."""
        precision = max(PRECISION * found, self.least_precision)
        there = self.tree.bound(points, faces, precision, found).distance
        back = tree.bound(self._local, self.original.faces, precision, found).distance
        return max(found, max(there, back) - precision)

    def count_new_borders(self, surface: PlacedSurface, moved: float) -> int:
        """Count the open edges of a surface that lie on no open edge of the original: where it was torn.

        Parameters
        ----------
        surface : PlacedSurface
        moved : float
            How far an edge may have moved and still be the same; model units.
        """
        rim = find_open_edges(surface)
        if not len(rim) or not len(self._rim):
            return len(rim)
        a, b = (surface.points[ends] - self.origin for ends in rim.T)
        along = a[:, None] + (b - a)[:, None] * ALONG_EDGES[:, None]
        away = self._rim_tree.distances(np.ascontiguousarray(along.reshape(-1, 3)))
        beyond = away.reshape(len(rim), -1).max(axis=1) > moved + self.noise
        return int(beyond.sum())


def is_watertight(surface: PlacedSurface) -> bool:
    """Return whether every edge belongs to exactly two faces."""
    return len(surface.faces) > 0 and _core.count_edges(surface.faces, len(surface.points)) == (0, 0)


def find_open_edges(surface: PlacedSurface) -> Indices:
    """Return the edges that belong to one face, by their ends; (k, 2) int32."""
    halfedges = _core.pair_halfedges(surface.points, surface.faces, None, 0.0)
    alone = halfedges.twin < 0
    # Edges of more faces than two, or of two that are turned against each other, have no twins either.
    alone[halfedges.group_members] = False
    ends = np.stack([surface.faces, np.roll(surface.faces, -1, axis=1)], axis=2).reshape(-1, 2)
    return ends[alone]


def collect_queries(points: Points, faces: Faces) -> Points:
    """Join all points of a surface and its samples."""
    return np.concatenate([points, sample_surface(points, faces)])


def sample_surface(points: Points, faces: Faces) -> NDArray[np.float64]:
    """Spread samples over a surface by area, the same every time; none where it has no area."""
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
