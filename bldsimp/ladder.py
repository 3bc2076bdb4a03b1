"""The ladder: every facet is simplified as far as its outline allows, and steps down where it does not.

Thin the chains, triangulate the facets, put them together, and look where they do not fit; put dropped
points back there, then whole outlines, then the facet's own faces; and again, until all fits.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from . import _core
from .scene import Faces, Points

Indices = NDArray[np.int32]
Flags = NDArray[np.uint8]


class Rung(IntEnum):
    """How much of a facet had to stay."""

    SIMPLIFIED = 0
    POINTS_PUT_BACK = 1
    OUTLINE_PUT_BACK = 2
    FACES_KEPT = 3
    PASSED_ON = 4


class Cause(IntEnum):
    """Why a facet stepped down; the first four are the kernel's outcomes."""

    NONE = 0
    UNCHANGED = 1
    CROSSING = 2
    MISMATCH = 3
    CLASH = 4
    MISFIT = 5


@dataclass
class Assembled:
    """Facets put together again.

    Attributes
    ----------
    triangles : (k, 3) int32
    facet_of_triangle : (k,) int32
    kept : (n,) uint8
        Points that the result uses, or that no chain decided on.
    rung, unchanged : (f,) uint8
        `Rung` of each facet; whether its own faces stayed.
    deviation : (f,) float64
        Certified bound of each facet.
    healed : int
        Edges where two borders were laid on one another.
    causes : Counter
        Facets below the first rung, by `Cause`.
    """

    triangles: Faces
    facet_of_triangle: Indices
    kept: Flags
    rung: Flags
    unchanged: Flags
    deviation: NDArray[np.float64]
    healed: int = 0
    causes: Counter[Cause] = field(default_factory=Counter)


def climb(
    points: Points, faces: Faces, facets: _core.Facets, outlines: _core.Outlines, tolerance: float, pinned: Flags
) -> Assembled:
    """Simplify all facets of a mesh as far as they fit together again.

    Parameters
    ----------
    points, faces
        Welded and oriented.
    facets, outlines
        As found on these faces.
    tolerance : float
        Model units.
    pinned : (f,) uint8
        Facets whose faces must stay.
    """
    ladder = _Ladder(points, faces, facets, outlines, tolerance, pinned)
    while not ladder.settled():
        pass
    return ladder.assembled()


class _Ladder:
    def __init__(
        self,
        points: Points,
        faces: Faces,
        facets: _core.Facets,
        outlines: _core.Outlines,
        tolerance: float,
        pinned: Flags,
    ) -> None:
        self.points, self.faces, self.facets, self.outlines = points, faces, facets, outlines
        self.use_facet = outlines.use_facet
        count = len(facets.planes)
        self._index_chains(count)
        self.face_order = np.argsort(facets.facet_of_face, kind="stable").astype(np.int32)
        self.face_start = _starts(np.bincount(facets.facet_of_face, minlength=count))
        self.widths = facets.planes[:, 4] - facets.planes[:, 3] if tolerance > 0 else np.zeros(count)
        self.limit = np.sqrt(np.maximum(tolerance**2 - self._greatest_of_chain(self.widths) ** 2, 0.0))
        self.rung = np.where(pinned != 0, np.uint8(Rung.PASSED_ON), np.uint8(0))
        self.cause = np.zeros(count, np.uint8)
        self.must = outlines.is_corner.copy()
        self._keep_all_points(pinned != 0)
        self.dirty = np.ones(count, bool)
        self.unchanged = np.zeros(count, np.uint8)
        self.triangles = np.empty((0, 3), np.int32)
        self.facet_of_triangle = np.empty(0, np.int32)
        self.kept = np.zeros(len(points), np.uint8)

    def _index_chains(self, facet_count: int) -> None:
        start, use_start, facet = self.outlines.chain_start, self.outlines.use_start, self.use_facet
        chains = np.arange(len(use_start) - 1, dtype=np.int32)
        self._chain_of_position = np.repeat(chains, np.diff(start))
        self._chain_of_use = np.repeat(chains, np.diff(use_start))
        self._chain_of_sorted_use = self._chain_of_use[np.argsort(facet, kind="stable")]
        self._use_start = _starts(np.bincount(facet, minlength=facet_count))

    def settled(self) -> bool:
        """One round; true when everything fits."""
        self._thin()
        self.edges = _core.merge_pieces(self.pieces, self.outlines)
        if len(self.edges.clashing):
            self.must[self.edges.clashing] = 1
            self._note(self._facets_of_points(self.edges.clashing), Rung.POINTS_PUT_BACK, Cause.CLASH)
            return False
        if self._retriangulate():
            return False
        misfits = _core.find_misfits(
            self.triangles, self.facet_of_triangle, self.edges, self.unchanged, self.outlines
        )
        for facet in misfits:
            self._step_down(int(facet), Cause.MISFIT, np.empty(0, np.int32))
        return len(misfits) == 0

    def assembled(self) -> Assembled:
        changed = self.unchanged == 0
        drift = self._greatest_of_facet(self.pieces.deviation, self.pieces.chain)
        deviation = np.where(changed, np.hypot(self.widths, drift), 0.0)
        causes = Counter(Cause(int(c)) for c in self.cause[(self.rung > 0) & (self.rung < Rung.PASSED_ON)])
        return Assembled(
            self.triangles, self.facet_of_triangle, self.kept, self.rung, self.unchanged, deviation,
            self.edges.healed, causes,
        )  # fmt: skip

    def _thin(self) -> None:
        """Thin all chains; facets beside a point whose fate changed must be triangulated anew."""
        kept = _core.thin_chains(self.points, self.outlines, self.limit, self.must)
        self.dirty[self._facets_of_points(np.flatnonzero(kept != self.kept))] = True
        self.kept = kept
        self.pieces = _core.lay_pieces(self.points, self.outlines, kept)

    def _retriangulate(self) -> bool:
        """Triangulate what changed; true when a facet had to step down."""
        wanted = np.flatnonzero(self.dirty).astype(np.int32)
        keep = (self.rung >= Rung.FACES_KEPT).astype(np.uint8)
        patches = _core.retriangulate(
            self.points, self.faces, self.face_start, self.face_order, self.facets, self.outlines,
            self.pieces, self.kept, wanted, keep,
        )  # fmt: skip
        outcomes = patches.outcomes
        self.unchanged[wanted] = outcomes == Cause.UNCHANGED
        old = ~self.dirty[self.facet_of_triangle]
        self.triangles = np.concatenate([self.triangles[old], patches.triangles])
        self.facet_of_triangle = np.concatenate([self.facet_of_triangle[old], patches.facet_of_triangle])
        self.dirty[:] = False
        failed = np.flatnonzero(outcomes >= Cause.CROSSING)
        culprits = patches.put_back
        for i in failed:
            facet = int(wanted[i])
            low, high = np.searchsorted(culprits[:, 0], [facet, facet + 1])
            self._step_down(facet, Cause(int(outcomes[i])), culprits[low:high, 1])
        return len(failed) > 0

    def _step_down(self, facet: int, cause: Cause, culprits: Indices) -> None:
        """Put back dropped points that may be the cause; where there are none, go one rung down."""
        culprits = culprits[self.kept[culprits] == 0]
        chains = self._chains_of_facet(facet)
        dropped = chains[self.kept[chains] == 0]
        self.dirty[facet] = True
        if len(culprits):
            self.must[culprits] = 1
            self._note(np.array([facet]), Rung.POINTS_PUT_BACK, cause)
        elif len(dropped):
            self.must[dropped] = 1
            self._note(np.array([facet]), Rung.OUTLINE_PUT_BACK, cause)
        else:
            self._note(np.array([facet]), Rung.FACES_KEPT, cause)
            chosen = np.zeros(len(self.rung), bool)
            chosen[facet] = True
            self._keep_all_points(chosen)

    def _note(self, facets: Indices | NDArray[np.int64], rung: Rung, cause: Cause) -> None:
        lower = facets[self.rung[facets] < rung]
        self.rung[lower] = rung
        self.cause[lower] = cause

    def _keep_all_points(self, chosen: NDArray[np.bool_]) -> None:
        self.must[self.faces[chosen[self.facets.facet_of_face]]] = 1

    def _facets_of_points(self, points: Indices | NDArray[np.int64]) -> NDArray[np.int64]:
        """Facets beside the chains that pass these points."""
        marked = np.zeros(len(self.points), bool)
        marked[points] = True
        chain = np.zeros(len(self.outlines.use_start) - 1, bool)
        chain[self._chain_of_position[marked[self.outlines.chain_points]]] = True
        return np.unique(self.use_facet[chain[self._chain_of_use]])

    def _chains_of_facet(self, facet: int) -> Indices:
        """Points of all chains of a facet."""
        low, high = self._use_start[facet], self._use_start[facet + 1]
        start = self.outlines.chain_start
        runs = [self.outlines.chain_points[start[c] : start[c + 1]] for c in self._chain_of_sorted_use[low:high]]
        return np.unique(np.concatenate(runs)) if runs else np.empty(0, np.int32)

    def _greatest_of_chain(self, of_facet: NDArray[np.float64]) -> NDArray[np.float64]:
        """Greatest value among the facets of each chain."""
        if len(self.use_facet) == 0:
            return np.zeros(len(self.outlines.use_start) - 1)
        return np.maximum.reduceat(of_facet[self.use_facet], self.outlines.use_start[:-1])

    def _greatest_of_facet(self, values: NDArray[np.float64], chain: Indices) -> NDArray[np.float64]:
        """Greatest value among the chains of each facet, given values that each belong to a chain."""
        of_chain = np.zeros(len(self.outlines.use_start) - 1)
        np.maximum.at(of_chain, chain, values)
        of_facet = np.zeros(len(self.rung))
        np.maximum.at(of_facet, self.use_facet, of_chain[self._chain_of_use])
        return of_facet


def _starts(counts: NDArray[np.int64]) -> Indices:
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
