"""Allot the tolerance: how far the plane of a facet, its chains and its needles may stray.

The chains of a facet may use the share of the tolerance that its width leaves: squares add up. Each pass over a result
starts from the deviation that earlier passes have used.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model import Indices, Values
from .outlines import TracedOutlines

EdgeKeys = NDArray[np.int64]


def key_edges(a: Indices, b: Indices, point_count: int) -> EdgeKeys:
    """Return one number for each edge, whichever end is named first."""
    return np.minimum(a, b).astype(np.int64) * point_count + np.maximum(a, b)


@dataclass(frozen=True)
class Spent:
    """What the passes before have spent; lengths in model units.

    Attributes
    ----------
    edges : (e,) int64
        Keys of edges that replaced others, ascending.
    distance : (e,) float64
        How far each is from the outlines of the input.
    vanished : (e,) float64
        The bounds of facets that vanished into it; 0 where none did.
    folded : (f,) float64
        How far needles of each facet may reach out of it.
    """

    edges: EdgeKeys
    distance: Values
    vanished: Values
    folded: Values

    def at_chains(self, outlines: TracedOutlines) -> tuple[Values, Values]:
        """Return the greatest `distance` and `vanished` of the edges of each chain."""
        if not len(self.edges) or not outlines.chain_count:
            return np.zeros(outlines.chain_count), np.zeros(outlines.chain_count)
        a, b, first = outlines.edges()
        keys = key_edges(a, b, outlines.point_count)
        at = np.minimum(np.searchsorted(self.edges, keys), len(self.edges) - 1)
        known = self.edges[at] == keys
        distance, vanished = (np.where(known, of_edge[at], 0.0) for of_edge in (self.distance, self.vanished))
        return np.maximum.reduceat(distance, first), np.maximum.reduceat(vanished, first)


@dataclass
class Budget:
    """What patches and chains may use, and what they have used; lengths in model units.

    Attributes
    ----------
    width, fold, allowed : (p,) float64
        For each patch: width of its plane, how far its needles reach out, what is left for its chains.
    limit : (c,) float64
        How far each chain may be thinned.
    spent, vanished : (c,) float64
        `Spent` at each chain.
    reach : (p,) float64
        How far the new triangles of each patch reach out of its outline.
    """

    width: Values
    fold: Values
    allowed: Values
    limit: Values
    spent: Values
    vanished: Values
    reach: Values

    def drift(self, outlines: TracedOutlines, pieces: _core.Pieces, moved: NDArray[np.bool_]) -> Values:
        """Return how far each patch is from the input's surface within its plane, where pieces moved."""
        chain = pieces.chain
        distance = np.where(moved, pieces.deviation + self.spent[chain], 0.0)
        return self.fold + np.maximum(self.reach, outlines.spread_to_patches(distance, chain))

    def bound_vanished(self, pieces: _core.Pieces) -> Values:
        """Return the bound, at each piece, of what vanished there before; 0 where nothing did."""
        before = self.vanished[pieces.chain]
        return np.where(before > 0, before + pieces.deviation, 0.0)


def allot_tolerance(
    tolerance: float, planes: Values, facet_of_patch: Indices, outlines: TracedOutlines, spent: Spent
) -> Budget:
    """Allot a tolerance to patches and chains.

    Parameters
    ----------
    tolerance : float
        Model units.
    planes : (p, 5) float64
        Of each patch.
    facet_of_patch : (p,) int32
    outlines : TracedOutlines
    spent : Spent
    """
    width = planes[:, 4] - planes[:, 3] if tolerance > 0 else np.zeros(len(planes))
    fold = spent.folded[facet_of_patch]
    distance, vanished = spent.at_chains(outlines)
    allowed = np.maximum(np.sqrt(np.maximum(tolerance**2 - width**2, 0.0)) - fold, 0.0)
    least_allowed = -outlines.spread_to_chains(-allowed)
    limit = np.maximum(np.minimum(least_allowed - distance, tolerance - vanished), 0.0)
    return Budget(width, fold, allowed, limit, distance, vanished, np.zeros(len(planes)))
