"""Trace the outlines of facets, and tell which chains bound which facet."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model import Faces, Flags, Indices, Values, cast_indices
from .facets import FacetedSurface


class TracedOutlines:
    """The chains between the patches of a surface, and where each is used.

    A facet of which some faces stay is traced as several patches; without such faces patches are facets.

    Parameters
    ----------
    surface : FacetedSurface
        Its facets are the patches.
    keep : (p,) uint8
        Patches whose faces stay.

    Attributes
    ----------
    chains : _core.Outlines
    point_count, patch_count, chain_count : int
    patch_of_use : int32
        The patch of each use of a chain.
    """

    def __init__(self, surface: FacetedSurface, keep: Flags) -> None:
        self.point_count, self.patch_count = len(surface.points), len(keep)
        self.chains = _core.trace_outlines(surface.faces, self.point_count, surface.halfedges, surface.facets, keep)
        self.chain_count = len(self.chains.use_start) - 1
        self.patch_of_use = self.chains.use_facet
        number = np.arange(self.chain_count, dtype=np.int32)
        self._chain_of_position = np.repeat(number, np.diff(self.chains.chain_start))
        self._chain_of_use = np.repeat(number, np.diff(self.chains.use_start))
        self._chain_by_patch = self._chain_of_use[np.argsort(self.patch_of_use, kind="stable")]
        counts = np.bincount(self.patch_of_use, minlength=self.patch_count)
        self._start_of_patch = cast_indices(np.concatenate([[0], np.cumsum(counts)]))

    def patches_at(self, points: Indices | NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the patches beside the chains that pass some points."""
        marked = np.zeros(self.point_count, bool)
        marked[points] = True
        chain = np.zeros(self.chain_count, bool)
        chain[self._chain_of_position[marked[self.chains.chain_points]]] = True
        return np.unique(self.patch_of_use[chain[self._chain_of_use]])

    def chains_of(self, patch: np.int32) -> Indices:
        """Return the chains of a patch."""
        return self._chain_by_patch[self._start_of_patch[patch] : self._start_of_patch[patch + 1]]

    def points_of(self, patch: np.int32) -> Indices:
        """Return the points of all chains of a patch."""
        start = self.chains.chain_start
        runs = [self.chains.chain_points[start[c] : start[c + 1]] for c in self.chains_of(patch)]
        return np.unique(np.concatenate(runs)) if runs else np.empty(0, np.int32)

    def spread_to_chains(self, of_patch: Values) -> Values:
        """Return the greatest value among the patches beside each chain."""
        if len(self.patch_of_use) == 0:
            return np.zeros(self.chain_count)
        return np.maximum.reduceat(of_patch[self.patch_of_use], self.chains.use_start[:-1])

    def spread_to_patches(self, values: Values, chain: Indices) -> Values:
        """Return the greatest value among the chains of each patch; each value belongs to a chain."""
        of_chain = np.zeros(self.chain_count)
        np.maximum.at(of_chain, chain, values)
        of_patch = np.zeros(self.patch_count)
        np.maximum.at(of_patch, self.patch_of_use, of_chain[self._chain_of_use])
        return of_patch

    def edges(self) -> tuple[Indices, Indices, NDArray[np.int64]]:
        """Return both ends of all edges of chains, chain after chain, and the first edge of each chain."""
        start, points = self.chains.chain_start, self.chains.chain_points
        inside = np.ones(len(points) - 1, bool)
        inside[start[1:-1] - 1] = False
        return points[:-1][inside], points[1:][inside], start[:-1] - np.arange(self.chain_count)


def trace_rings(triangles: Faces) -> list[NDArray[np.int32]]:
    """Trace the closed cycles of the edges that triangles use in one direction only.

    Parameters
    ----------
    triangles : (k, 3) int32
        Consistently oriented.

    Returns
    -------
    list of (n,) int32
        Points of each ring, the triangles on its left, from its least point on; sorted.

    Examples
    --------
    >>> trace_rings(np.array([[0, 1, 2], [0, 2, 3]], np.int32))[0].tolist()
    [0, 1, 2, 3]
    """
    edges = {(int(t[i]), int(t[(i + 1) % 3])) for t in triangles for i in range(3)}
    onward: dict[int, list[int]] = {}
    for a, b in sorted(edges, reverse=True):
        if (b, a) not in edges:
            onward.setdefault(a, []).append(b)
    rings = []
    for first in sorted(onward):
        while onward[first]:
            ring, at = [first], onward[first].pop()
            while at != first:
                ring.append(at)
                at = onward[at].pop()
            rings.append(np.array(ring, np.int32))
    return rings
