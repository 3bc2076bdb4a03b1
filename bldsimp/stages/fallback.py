"""The ladder: every facet is simplified as far as its outline allows, and steps down where it does not.

Thin the chains, triangulate the facets, put them together, and look where they do not fit. There put
dropped points back; where none were dropped, keep the faces around the trouble, then the whole outline,
then all faces of the facet; and again, until all fits.
"""

from __future__ import annotations

from collections import Counter

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model import Faces, Flags, Indices, Points
from ..options import LEAST_GAIN
from ..triangulation import Statistics
from .assembled import Assembled, Cause, Layout, Rung

MOST_SPLITS = 8
"""How often faces around a trouble are cut off a facet before all of its faces stay."""


def climb(
    points: Points, faces: Faces, halfedges: _core.Halfedges, facets: _core.Facets, tolerance: float, pinned: Flags
) -> Assembled:
    """Simplify all facets of a mesh as far as they fit together again.

    Parameters
    ----------
    points, faces
        Welded and oriented.
    halfedges, facets
        As found on these faces.
    tolerance : float
        Model units.
    pinned : (f,) uint8
        Facets whose faces must stay.
    """
    done = _in_passes(_Ladder(points, faces, halfedges, facets, tolerance, pinned))
    hardly = _hardly_thinned(points, faces, facets, done) if tolerance > 0 else np.zeros_like(pinned)
    if hardly.any():
        done = _in_passes(_Ladder(points, faces, halfedges, facets, tolerance, pinned, hardly))
    return done


def _in_passes(ladder: _Ladder) -> Assembled:
    done = ladder.climbed()
    # Where facets vanished, borders were joined or single faces kept, chains may run on through former
    # corners: they are found again, on the result, until nothing more can go.
    while ladder.reshaped():
        ladder = ladder.next_pass()
        again = ladder.climbed()
        if again.point_count() >= done.point_count():
            break
        done = done.followed_by(again)
    return done


def _hardly_thinned(points: Points, faces: Faces, facets: _core.Facets, done: Assembled) -> Flags:
    """Facets that changed where the curved surfaces of a component lost few of their points.

    A curved surface can be cut into facets in many ways, and any cut of the result of a run finds a few more
    points to drop. That is not worth moving the surface once more.
    """
    if not facets.curved.any():
        return np.zeros_like(facets.curved)
    curved = np.flatnonzero(facets.curved[facets.facet_of_face])
    component = _core.find_components(faces, len(points))
    key = np.unique(np.repeat(component[curved].astype(np.int64), 3) * len(points) + faces[curved].reshape(-1))
    owner, point = np.divmod(key, len(points))
    dropped = np.ones(len(points), bool)
    dropped[done.triangles] = False
    few = np.bincount(owner, dropped[point], len(faces)) < LEAST_GAIN * np.bincount(owner, minlength=len(faces))
    hardly = np.zeros_like(facets.curved)
    hardly[facets.facet_of_face[curved[few[component[curved]]]]] = 1
    hardly[done.unchanged != 0] = 0
    return hardly


class _Ladder:
    """The state of a climb. A facet of the input is split into parts when some of its faces are kept."""

    def __init__(
        self,
        points: Points,
        faces: Faces,
        halfedges: _core.Halfedges,
        facets: _core.Facets,
        tolerance: float,
        pinned: Flags,
        hardly: Flags | None = None,
    ) -> None:
        self.points, self.faces, self.halfedges, self.facets = points, faces, halfedges, facets
        self.tolerance, self.pinned = tolerance, pinned
        self.hardly = np.zeros_like(pinned) if hardly is None else hardly
        self.planes = facets.planes
        count = len(self.planes)
        self.rung = np.where(pinned != 0, np.uint8(Rung.PASSED_ON), np.uint8(0))
        self.rung[self.hardly != 0] = Rung.FACES_KEPT
        self.cause = np.where(self.hardly != 0, np.uint8(Cause.LITTLE_GAIN), np.uint8(0))
        self.splits = np.zeros(count, np.uint8)
        self.facet_of_part = np.arange(count, dtype=np.int32)
        self.keep = pinned | self.hardly  # parts whose faces stay
        self.folded = np.zeros(count)  # how far needles of each facet may reach out of it from the pass before
        self.put_back = np.zeros(len(points), np.uint8)
        self.statistics = Statistics()
        # How far edges (as keys, sorted) already are from the outlines of the input.
        self.spent_edges, self.spent = np.empty(0, np.int64), np.empty(0)
        # The bounds of the facets that vanished into them.
        self.vanished = np.empty(0)
        self._begin()

    def climbed(self) -> Assembled:
        """The result, once everything fits."""
        while not self._settled():
            pass
        return self._assembled()

    def reshaped(self) -> bool:
        """Whether the result may have corners that the input's outlines needed and its own do not."""
        return self.edges.healed > 0 or len(self.keep) > len(self.rung)

    def next_pass(self) -> _Ladder:
        """A climb over the result, which counts the deviation that this one spent."""
        turn = np.argmin(self.triangles, axis=1)[:, None]
        faces = np.take_along_axis(self.triangles, (turn + np.arange(3)) % 3, axis=1)
        order = np.lexsort((faces[:, 1], faces[:, 1:].max(axis=1), faces[:, 1:].min(axis=1), faces[:, 0]))
        faces = np.ascontiguousarray(faces[order])
        facet_of_face = self.facet_of_part[self.part_of_triangle[order]]
        halfedges = _core.pair_halfedges(self.points, faces, None, self.tolerance)
        facets = _core.Facets(facet_of_face, self.planes)
        after = _Ladder(self.points, faces, halfedges, facets, self.tolerance, self.pinned, self.hardly)
        np.maximum.at(after.folded, self.facet_of_part, self.folds + self.reach)
        after.spent_edges, after.spent, after.vanished = self._spent_on_edges()
        after._begin()
        return after

    def _spent_on_edges(self) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
        """Edges of the result, how far each is from what it replaces, and the bounds of what vanished there."""
        gone = np.bincount(self.part_of_triangle, minlength=len(self.keep)) == 0
        chain = self.pieces.chain
        bound = np.hypot(self.widths, self._drift(np.ones(len(chain), bool)))
        of_gone = self._greatest_of_chain(np.where(gone, bound, 0.0))
        edges, edge_of_piece = np.unique(self._key(self.pieces.begin, self.pieces.end), return_inverse=True)
        spent, vanished = np.zeros(len(edges)), np.zeros(len(edges))
        np.maximum.at(spent, edge_of_piece, self.pieces.deviation + self.spent_of_chain[chain])
        np.maximum.at(vanished, edge_of_piece, np.maximum(of_gone[chain], self._of_vanished()))
        return edges, spent, vanished

    def _of_vanished(self) -> NDArray[np.float64]:
        """Bound, at each piece, of what vanished there before; 0 where nothing did."""
        before = self.vanished_of_chain[self.pieces.chain]
        return np.where(before > 0, before + self.pieces.deviation, 0.0)

    def _key(self, a: Indices, b: Indices) -> NDArray[np.int64]:
        """One number for an edge."""
        return np.minimum(a, b).astype(np.int64) * len(self.points) + np.maximum(a, b)

    def _greatest_on_chain(self, of_edge: NDArray[np.float64]) -> NDArray[np.float64]:
        """Greatest value that the edges of each chain have from the pass before."""
        start, points = self.outlines.chain_start, self.outlines.chain_points
        chains = len(start) - 1
        if not len(self.spent_edges) or not chains:
            return np.zeros(chains)
        inside = np.ones(len(points) - 1, bool)
        inside[start[1:-1] - 1] = False
        keys = self._key(points[:-1], points[1:])[inside]
        at = np.minimum(np.searchsorted(self.spent_edges, keys), len(self.spent_edges) - 1)
        values = np.where(self.spent_edges[at] == keys, of_edge[at], 0.0)
        return np.maximum.reduceat(values, start[:-1] - np.arange(chains))

    def _drift(self, moved: NDArray[np.bool_]) -> NDArray[np.float64]:
        """How far each part's surface is from the input's within the plane, where pieces moved."""
        chain = self.pieces.chain
        distance = np.where(moved, self.pieces.deviation + self.spent_of_chain[chain], 0.0)
        return self.folds + np.maximum(self.reach, self._greatest_of_part(distance, chain))

    def _begin(self) -> None:
        """Trace the outlines of the parts as they are now."""
        count = len(self.facets.planes)
        self.outlines = _core.trace_outlines(self.faces, len(self.points), self.halfedges, self.facets, self.keep)
        self._index_chains(count)
        self.face_start, self.face_order = _core.group_faces(self.facets)
        planes = self.facets.planes
        self.widths = planes[:, 4] - planes[:, 3] if self.tolerance > 0 else np.zeros(count)
        self.folds = self.folded[self.facet_of_part]
        self.reach = np.zeros(count)
        self.spent_of_chain = self._greatest_on_chain(self.spent)
        self.vanished_of_chain = self._greatest_on_chain(self.vanished)
        left_by_width = np.sqrt(np.maximum(self.tolerance**2 - self.widths**2, 0.0))
        self.allowed = np.maximum(left_by_width - self.folds, 0.0)
        left = -self._greatest_of_chain(-self.allowed) - self.spent_of_chain
        self.limit = np.maximum(np.minimum(left, self.tolerance - self.vanished_of_chain), 0.0)
        self.must = self.outlines.is_corner | self.put_back
        self._keep_points_of(self.keep != 0)
        self.dirty = np.ones(count, bool)
        self.unchanged = np.zeros(count, np.uint8)
        self.triangles = np.empty((0, 3), np.int32)
        self.part_of_triangle = np.empty(0, np.int32)
        self.kept = np.zeros(len(self.points), np.uint8)
        self.cut: list[Indices] = []

    def _index_chains(self, part_count: int) -> None:
        start, use_start = self.outlines.chain_start, self.outlines.use_start
        chains = np.arange(len(use_start) - 1, dtype=np.int32)
        self.use_part = self.outlines.use_facet
        self._chain_of_position = np.repeat(chains, np.diff(start))
        self._chain_of_use = np.repeat(chains, np.diff(use_start))
        self._chain_of_sorted_use = self._chain_of_use[np.argsort(self.use_part, kind="stable")]
        self._use_start = _starts(np.bincount(self.use_part, minlength=part_count))

    def _settled(self) -> bool:
        """One round; true when everything fits."""
        self._thin()
        self.edges = _core.merge_pieces(self.pieces, self.outlines)
        if len(self.edges.clashing):
            self._put_back(self.edges.clashing)
            self._note(self._parts_of_points(self.edges.clashing), Rung.POINTS_PUT_BACK, Cause.CLASH)
            return False
        fits = self._retriangulate() and self._fits_together() and self._hangs_together() and self._stays_apart()
        if self.cut:
            self._split()
        return fits

    def _assembled(self) -> Assembled:
        """The facets of the input again, each with all its parts."""
        count = len(self.rung)
        deviation, unchanged = np.zeros(count), np.ones(count, np.uint8)
        # What did not move in this pass, the pass before has bounded.
        drift = self._drift(self.pieces.farthest >= 0)
        bound = np.where(self.unchanged != 0, 0.0, np.hypot(self.widths, drift))
        bound = np.maximum(bound, self._greatest_of_part(self._of_vanished(), self.pieces.chain))
        np.maximum.at(deviation, self.facet_of_part, bound)
        np.minimum.at(unchanged, self.facet_of_part, self.unchanged)
        below = (self.rung > Rung.SIMPLIFIED) & (self.rung < Rung.PASSED_ON)
        return Assembled(
            triangles=self.triangles,
            facet_of_triangle=self.facet_of_part[self.part_of_triangle],
            kept=self.kept,
            rung=self.rung,
            unchanged=unchanged,
            deviation=deviation,
            healed=self.edges.healed,
            touching=self.outlines.touching,
            causes=Counter(Cause(int(c)) for c in self.cause[below]),
            statistics=self.statistics,
            layout=Layout(
                self.facets.planes, self.outlines, self.pieces, self.keep, self.triangles, self.part_of_triangle
            ),
        )

    def _thin(self) -> None:
        """Thin all chains; parts beside a point whose fate changed must be triangulated anew."""
        kept = _core.thin_chains(self.points, self.outlines, self.limit, self.must)
        self.dirty[self._parts_of_points(np.flatnonzero(kept != self.kept))] = True
        self.kept = kept
        self.pieces = _core.lay_pieces(self.points, self.outlines, kept)

    def _retriangulate(self) -> bool:
        """Triangulate what changed; false when a part had to step down."""
        wanted = np.flatnonzero(self.dirty).astype(np.int32)
        patches = _core.retriangulate(
            self.points, self.faces, self.face_start, self.face_order, self.facets, self.outlines,
            self.pieces, self.kept, self.allowed, wanted, self.keep,
        )  # fmt: skip
        self.statistics += Statistics(*patches.statistics)
        outcomes = patches.outcomes
        self.unchanged[wanted] = outcomes == Cause.UNCHANGED
        self.reach[wanted] = patches.reach
        old = ~self.dirty[self.part_of_triangle]
        self.triangles = np.concatenate([self.triangles[old], patches.triangles])
        self.part_of_triangle = np.concatenate([self.part_of_triangle[old], patches.facet_of_triangle])
        self.dirty[:] = False
        failed = np.flatnonzero(outcomes >= Cause.CROSSING)
        for i in failed:
            part = wanted[i]
            culprits = _of(part, patches.put_back)[:, 0]
            self._step_down(part, Cause(int(outcomes[i])), culprits, _of(part, patches.trouble))
        return len(failed) == 0

    def _fits_together(self) -> bool:
        """Whether every edge is used as it must be; parts that do not fit step down."""
        misfits = _core.find_misfits(self.triangles, self.part_of_triangle, self.edges, self.unchanged, self.outlines)
        for part in np.unique(misfits[:, 0]):
            ends = np.unique(_of(part, misfits))
            self._step_down(part, Cause.MISFIT, ends[:0], np.stack([ends, ends], axis=1))
        return len(misfits) == 0

    def _hangs_together(self) -> bool:
        """Whether no component came apart where a strip closed; strips that held it together step down."""
        if self.edges.healed == 0:
            return True
        count = len(self.keep)
        before = np.zeros(count, np.int32)
        before[self.facets.facet_of_face] = _core.find_components(self.faces, len(self.points))
        after = _core.find_components(self.triangles, len(self.points))
        pairs = np.unique(np.stack([self.part_of_triangle, after], axis=1), axis=0)
        of_component = np.unique(np.stack([before[pairs[:, 0]], pairs[:, 1]], axis=1), axis=0)[:, 0]
        parted = of_component[1:][of_component[1:] == of_component[:-1]]
        if len(parted) == 0:
            return True
        suspects = np.isin(before, parted) & (self.keep == 0)
        # A strip has vanished, or parted itself where it was narrow.
        strips = suspects & (np.bincount(pairs[:, 0], minlength=count) != 1)
        chain, farthest = self.pieces.chain[self.edges.healed_pieces], self.pieces.farthest[self.edges.healed_pieces]
        for part in np.flatnonzero(strips if strips.any() else suspects).astype(np.int32):
            culprits = np.unique(farthest[np.isin(chain, self._chains_of(part)) & (farthest >= 0)])
            self._step_down(part, Cause.MISFIT, culprits, np.empty((0, 2), np.int32))
        return False

    def _stays_apart(self) -> bool:
        """Whether no facets pass through one another that did not before; those that do step down."""
        changed = self.unchanged[self.part_of_triangle] == 0
        crossing = _core.find_crossings(self.points, self.triangles, changed.astype(np.uint8))
        crossing = crossing[~self._crossed_before(self.part_of_triangle[crossing])]
        triangles = np.unique(crossing)
        triangles = triangles[changed[triangles]]
        parts = self.part_of_triangle[triangles]
        for part in np.unique(parts):
            own = self.triangles[triangles[parts == part]]
            edges = self._key(own, np.roll(own, -1, axis=1))
            on_edge = np.isin(self._key(self.pieces.begin, self.pieces.end), edges) & (self.pieces.farthest >= 0)
            corners = np.unique(own)
            self._step_down(
                part, Cause.PIERCED, np.unique(self.pieces.farthest[on_edge]), np.stack([corners, corners], axis=1)
            )
        return len(triangles) == 0

    def _crossed_before(self, parts: Indices) -> NDArray[np.bool_]:
        """Whether faces of both parts of each pair passed through one another."""
        if not len(parts):
            return np.zeros(0, bool)
        suspects = np.zeros(len(self.keep), np.uint8)
        suspects[parts] = 1
        faces = np.flatnonzero(suspects[self.facets.facet_of_face])
        before = self.facets.facet_of_face[faces][_core.find_crossings(self.points, self.faces[faces])]
        return np.isin(self._key(*parts.T), self._key(*before.T))

    def _step_down(self, part: np.int32, cause: Cause, culprits: Indices, trouble: Indices) -> None:
        """Keep more of a part: the least that may help and was not tried yet."""
        culprits = culprits[self.kept[culprits] == 0]
        chains = self._chain_points_of(part)
        dropped = chains[self.kept[chains] == 0]
        self.dirty[part] = True
        if len(culprits):
            rung = Rung.POINTS_PUT_BACK
            self._put_back(culprits)
        elif len(trouble) and self.splits[self.facet_of_part[part]] < MOST_SPLITS:
            rung = Rung.SOME_FACES_KEPT
            self.splits[self.facet_of_part[part]] += 1
            own = self.face_order[self.face_start[part] : self.face_start[part + 1]]
            self.cut.append(own[_touch(self.faces[own], trouble)])
        elif len(dropped):
            rung = Rung.OUTLINE_PUT_BACK
            self._put_back(dropped)
        else:
            rung = Rung.FACES_KEPT
            self.keep[part] = 1
            self._keep_points_of(np.arange(len(self.keep)) == part)
        self._note(np.array([part]), rung, cause)

    def _split(self) -> None:
        """Make each face that was cut off a part of its own, which stays, and start again."""
        cut = np.unique(np.concatenate(self.cut)).astype(np.int32)
        owners = self.facet_of_part[self.facets.facet_of_face[cut]]
        self.facets = _core.split_off(self.facets, cut)
        self.facet_of_part = np.concatenate([self.facet_of_part, owners])
        self.keep = np.concatenate([self.keep, np.ones(len(cut), np.uint8)])
        self._begin()

    def _put_back(self, points: Indices) -> None:
        self.must[points] = self.put_back[points] = 1

    def _note(self, parts: NDArray[np.int32] | NDArray[np.int64], rung: Rung, cause: Cause) -> None:
        facets = np.unique(self.facet_of_part[parts])
        lower = facets[self.rung[facets] < rung]
        self.rung[lower] = rung
        self.cause[lower] = cause

    def _keep_points_of(self, parts: NDArray[np.bool_]) -> None:
        self.must[self.faces[parts[self.facets.facet_of_face]]] = 1

    def _parts_of_points(self, points: Indices | NDArray[np.int64]) -> NDArray[np.int64]:
        """Parts beside the chains that pass these points."""
        marked = np.zeros(len(self.points), bool)
        marked[points] = True
        chain = np.zeros(len(self.outlines.use_start) - 1, bool)
        chain[self._chain_of_position[marked[self.outlines.chain_points]]] = True
        return np.unique(self.use_part[chain[self._chain_of_use]])

    def _chains_of(self, part: np.int32) -> Indices:
        return self._chain_of_sorted_use[self._use_start[part] : self._use_start[part + 1]]

    def _chain_points_of(self, part: np.int32) -> Indices:
        """Points of all chains of a part."""
        start = self.outlines.chain_start
        runs = [self.outlines.chain_points[start[c] : start[c + 1]] for c in self._chains_of(part)]
        return np.unique(np.concatenate(runs)) if runs else np.empty(0, np.int32)

    def _greatest_of_chain(self, of_part: NDArray[np.float64]) -> NDArray[np.float64]:
        """Greatest value among the parts of each chain."""
        if len(self.use_part) == 0:
            return np.zeros(len(self.outlines.use_start) - 1)
        return np.maximum.reduceat(of_part[self.use_part], self.outlines.use_start[:-1])

    def _greatest_of_part(self, values: NDArray[np.float64], chain: Indices) -> NDArray[np.float64]:
        """Greatest value among the chains of each part, given values that each belong to a chain."""
        of_chain = np.zeros(len(self.outlines.use_start) - 1)
        np.maximum.at(of_chain, chain, values)
        of_part = np.zeros(len(self.facets.planes))
        np.maximum.at(of_part, self.use_part, of_chain[self._chain_of_use])
        return of_part


def _starts(counts: NDArray[np.int64]) -> Indices:
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)


def _of(part: np.int32, rows: Indices) -> Indices:
    """What follows the part in the rows that belong to it; `rows` are sorted."""
    low, high = np.searchsorted(rows[:, 0], [part, part + 1])
    return rows[low:high, 1:]


def _touch(faces: Faces, edges: Indices) -> NDArray[np.bool_]:
    """Faces that have both ends of an edge; of an edge with equal ends, that point."""
    both = [np.isin(faces, edge).sum(axis=1) == (2 if edge[0] != edge[1] else 1) for edge in edges]
    touched: NDArray[np.bool_] = np.any(both, axis=0)
    return touched
