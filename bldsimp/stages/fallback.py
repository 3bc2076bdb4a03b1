"""Simplify facets, and keep more of those that do not fit together.

Thin the chains, triangulate the facets, put them together, and look where they do not fit. There put dropped points
back; where none were dropped, keep the faces around the trouble, then the whole outline, then all faces of the facet;
and again, until all fits.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model import Faces, Flags, Indices, Values, cast_indices
from ..options import LEAST_GAIN
from ..triangulation import Statistics
from .budget import Spent, allot_tolerance, key_edges
from .facets import FacetedSurface
from .outlines import trace_outlines
from .surface import STAYS, sort_faces
from .triangulate import Attempt, Cause, Failure, thin_chains, try_facets

MOST_SPLITS = 8
"""How often faces around a trouble are split off a facet before all of its faces stay."""


class Level(IntEnum):
    """How much of its input a facet keeps."""

    SIMPLIFIED = 0
    POINTS_PUT_BACK = 1
    SOME_FACES_KEPT = 2
    OUTLINE_PUT_BACK = 3
    FACES_KEPT = 4
    PASSED_ON = 5


@dataclass(frozen=True)
class Layout:
    """The last triangulation, patch by patch.

    Attributes
    ----------
    planes : (p, 5) float64
        Of each patch.
    outlines : _core.Outlines
    pieces : _core.Pieces
        Of the thinned chains.
    keep : (p,) uint8
        Patches whose faces stayed.
    triangles : (k, 3) int32
    patch_of_triangle : (k,) int32
    """

    planes: Values
    outlines: _core.Outlines
    pieces: _core.Pieces
    keep: Flags
    triangles: Faces
    patch_of_triangle: Indices


@dataclass
class Assembly:
    """Facets put together again.

    Attributes
    ----------
    triangles : (k, 3) int32
    facet_of_triangle : (k,) int32
    level, unchanged : (f,) uint8
        `Level` of each facet; whether its own faces stayed.
    deviation : (f,) float64
        Certified bound of each facet.
    healed : int
        Edges where two borders were laid on one another.
    touching : int
        Points that stay only since sheets meet there inside of facets.
    causes : Counter
        Facets that were not simplified, by `Cause`.
    statistics : Statistics
        Of all triangulations on the way.
    layout : Layout
    """

    triangles: Faces
    facet_of_triangle: Indices
    level: Flags
    unchanged: Flags
    deviation: Values
    healed: int
    touching: int
    causes: Counter[Cause]
    statistics: Statistics
    layout: Layout

    def count_points(self) -> int:
        """Count the points that the result uses."""
        return len(np.unique(self.triangles))

    def compose(self, second: Assembly) -> Assembly:
        """Return what two passes did together, of which the second worked on the result of this one."""
        return Assembly(
            triangles=second.triangles,
            facet_of_triangle=second.facet_of_triangle,
            level=np.maximum(self.level, second.level),
            unchanged=self.unchanged & second.unchanged,
            deviation=np.maximum(self.deviation, second.deviation),
            healed=self.healed + second.healed,
            touching=second.touching,
            causes=self.causes | second.causes,
            statistics=self.statistics + second.statistics,
            layout=second.layout,
        )


@dataclass
class _Fate:
    """The facets and points that must stay, as far as known.

    Attributes
    ----------
    facet_of_patch : (p,) int32
    keep : (p,) uint8
        Patches whose faces stay.
    put_back : (n,) uint8
        Points that were put back.
    level, cause, splits : (f,) uint8
        Of each facet: how much of it stays, why, and how often it was split.
    """

    facet_of_patch: Indices
    keep: Flags
    put_back: Flags
    level: Flags
    cause: Flags
    splits: Flags = field(init=False)

    def __post_init__(self) -> None:
        self.splits = np.zeros(len(self.level), np.uint8)

    def lower(self, patches: NDArray[np.integer], level: Level, cause: Cause) -> None:
        """Note that the facets of some patches stand on a level at best."""
        facets = np.unique(self.facet_of_patch[patches])
        lower = facets[self.level[facets] < level]
        self.level[lower] = level
        self.cause[lower] = cause


def simplify_facets(surface: FacetedSurface, tolerance: float, pinned: Flags) -> Assembly:
    """Simplify all facets of a surface as far as they fit together again.

    Parameters
    ----------
    surface : FacetedSurface
    tolerance : float
        Model units.
    pinned : (f,) uint8
        Facets whose faces must stay.

    Returns
    -------
    Assembly
    """
    done = _simplify_in_passes(surface, tolerance, pinned, np.zeros_like(pinned))
    hardly = _find_little_gain(surface, done) if tolerance > 0 else np.zeros_like(pinned)
    return _simplify_in_passes(surface, tolerance, pinned, hardly) if hardly.any() else done


def _simplify_in_passes(surface: FacetedSurface, tolerance: float, pinned: Flags, hardly: Flags) -> Assembly:
    """Simplify again and again: where facets vanished, borders were joined or faces kept, chains may run on.

    They are found anew on the result, until nothing more can go.
    """
    spent = Spent(np.empty(0, np.int64), np.empty(0), np.empty(0), np.zeros(len(pinned)))
    done = None
    while True:
        fate, attempt, statistics = _simplify_once(surface, tolerance, pinned, hardly, spent)
        again = _assemble(attempt, fate, statistics)
        if done is not None and again.count_points() >= done.count_points():
            return done
        done = again if done is None else done.compose(again)
        if not (attempt.edges.healed > 0 or len(fate.keep) > len(fate.level)):
            return done
        spent = _spend(attempt, fate)
        surface = _take_result(attempt, fate, surface.facets.planes, tolerance)


def _simplify_once(
    surface: FacetedSurface, tolerance: float, pinned: Flags, hardly: Flags, spent: Spent
) -> tuple[_Fate, Attempt, Statistics]:
    """Try until everything fits."""
    level = np.where(pinned != 0, np.uint8(Level.PASSED_ON), np.uint8(Level.SIMPLIFIED))
    level[hardly != 0] = Level.FACES_KEPT
    cause = np.where(hardly != 0, np.uint8(Cause.LITTLE_GAIN), np.uint8(Cause.NONE))
    fate = _Fate(
        np.arange(len(pinned), dtype=np.int32), pinned | hardly, np.zeros(len(surface.points), np.uint8), level, cause
    )
    attempt = _start(surface, tolerance, fate, spent)
    statistics = Statistics()
    while True:
        failures = _try_once(attempt, fate)
        if not failures:
            return fate, attempt, statistics + attempt.statistics
        cut = [own for failure in failures if (own := _keep_more(attempt, fate, failure)) is not None]
        if cut:
            surface = _split_off(attempt, fate, cast_indices(np.unique(np.concatenate(cut))))
            statistics += attempt.statistics
            attempt = _start(surface, tolerance, fate, spent)


def _start(surface: FacetedSurface, tolerance: float, fate: _Fate, spent: Spent) -> Attempt:
    """Trace the outlines of the patches as they are now."""
    count = len(surface.points)
    outlines = trace_outlines(surface.faces, count, surface.halfedges, surface.facets, fate.keep)
    budget = allot_tolerance(
        tolerance,
        surface.facets.planes,
        spent.folded[fate.facet_of_patch],
        outlines,
        spent.at_chains(outlines, count),
    )
    must = outlines.chains.is_chain_end | fate.put_back | (surface.decided == STAYS).astype(np.uint8)
    attempt = Attempt(surface, outlines, budget, fate.keep, must)
    _keep_points_of(attempt, fate.keep != 0)
    return attempt


def _try_once(attempt: Attempt, fate: _Fate) -> list[Failure]:
    """Thin, triangulate and check; return the failures of the first step that has any."""
    thin_chains(attempt)
    while len(clashing := attempt.edges.clashing):
        _put_back(attempt, fate, clashing)
        fate.lower(attempt.patches_at(clashing), Level.POINTS_PUT_BACK, Cause.CLASH)
        thin_chains(attempt)
    return next((failures for failures in try_facets(attempt) if failures), [])


def _keep_more(attempt: Attempt, fate: _Fate, failure: Failure) -> Indices | None:
    """Keep more of a patch: the least that may help and was not tried yet. Return faces that are to be split off."""
    patch = failure.patch
    facet = fate.facet_of_patch[patch]
    culprits = failure.culprits[attempt.kept[failure.culprits] == 0]
    dropped = attempt.dropped_points_of(patch)
    attempt.dirty[patch] = True
    cut = None
    if len(culprits):
        level = Level.POINTS_PUT_BACK
        _put_back(attempt, fate, culprits)
    elif len(failure.trouble) and fate.splits[facet] < MOST_SPLITS:
        level = Level.SOME_FACES_KEPT
        fate.splits[facet] += 1
        own = attempt.faces_of(patch)
        cut = own[_touch(attempt.surface.faces[own], failure.trouble)]
    elif len(dropped):
        level = Level.OUTLINE_PUT_BACK
        _put_back(attempt, fate, dropped)
    else:
        level = Level.FACES_KEPT
        fate.keep[patch] = 1
        _keep_points_of(attempt, np.arange(len(fate.keep)) == patch)
    fate.lower(np.array([patch]), level, failure.cause)
    return cut


def _put_back(attempt: Attempt, fate: _Fate, points: Indices) -> None:
    """Keep points that were dropped."""
    attempt.must[points] = fate.put_back[points] = 1


def _keep_points_of(attempt: Attempt, patches: NDArray[np.bool_]) -> None:
    """Keep all points of the faces of some patches."""
    surface = attempt.surface
    attempt.must[surface.faces[patches[surface.facets.facet_of_face]]] = 1


def _split_off(attempt: Attempt, fate: _Fate, cut: Indices) -> FacetedSurface:
    """Make each of some faces a patch of its own, which stays."""
    surface = attempt.surface
    owners = fate.facet_of_patch[surface.facets.facet_of_face[cut]]
    fate.facet_of_patch = np.concatenate([fate.facet_of_patch, owners])
    fate.keep = np.concatenate([fate.keep, np.ones(len(cut), np.uint8)])
    facets = _core.split_off(surface.facets, cut)
    return FacetedSurface(surface.points, surface.faces, surface.decided, surface.halfedges, facets)


def _assemble(attempt: Attempt, fate: _Fate, statistics: Statistics) -> Assembly:
    """Put the facets of the surface together, each with all its patches."""
    count = len(fate.level)
    deviation, unchanged = np.zeros(count), np.ones(count, np.uint8)
    budget, pieces, outlines = attempt.budget, attempt.pieces, attempt.outlines
    # What did not move in this pass, the pass before has bounded.
    drift = budget.drift(outlines, pieces, pieces.farthest >= 0)
    bound = np.where(attempt.unchanged != 0, 0.0, np.hypot(budget.width, drift))
    bound = np.maximum(bound, outlines.spread_to_patches(budget.bound_vanished(pieces), pieces.chain))
    np.maximum.at(deviation, fate.facet_of_patch, bound)
    np.minimum.at(unchanged, fate.facet_of_patch, attempt.unchanged)
    below = (fate.level > Level.SIMPLIFIED) & (fate.level < Level.PASSED_ON)
    return Assembly(
        triangles=attempt.triangles,
        facet_of_triangle=fate.facet_of_patch[attempt.patch_of_triangle],
        level=fate.level,
        unchanged=unchanged,
        deviation=deviation,
        healed=attempt.edges.healed,
        touching=outlines.chains.touching,
        causes=Counter(Cause(int(cause)) for cause in fate.cause[below]),
        statistics=statistics,
        layout=Layout(
            attempt.surface.facets.planes,
            outlines.chains,
            pieces,
            fate.keep,
            attempt.triangles,
            attempt.patch_of_triangle,
        ),
    )


def _spend(attempt: Attempt, fate: _Fate) -> Spent:
    """Return how far edges and facets of the result are from what they replace."""
    budget, pieces, outlines = attempt.budget, attempt.pieces, attempt.outlines
    chain = pieces.chain
    gone = np.bincount(attempt.patch_of_triangle, minlength=len(fate.keep)) == 0
    bound = np.hypot(budget.width, budget.drift(outlines, pieces, np.ones(len(chain), bool)))
    of_gone = outlines.spread_to_chains(np.where(gone, bound, 0.0))
    keys = key_edges(pieces.begin, pieces.end, len(attempt.surface.points))
    edges, edge_of_piece = np.unique(keys, return_inverse=True)
    distance, vanished, folded = np.zeros(len(edges)), np.zeros(len(edges)), np.zeros(len(fate.level))
    np.maximum.at(distance, edge_of_piece, pieces.deviation + budget.spent[chain])
    np.maximum.at(vanished, edge_of_piece, np.maximum(of_gone[chain], budget.bound_vanished(pieces)))
    np.maximum.at(folded, fate.facet_of_patch, budget.fold + budget.reach)
    return Spent(edges, distance, vanished, folded)


def _take_result(attempt: Attempt, fate: _Fate, planes: Values, tolerance: float) -> FacetedSurface:
    """Return the result of a pass as the surface of the next, with the facets of the first."""
    faces, order = sort_faces(attempt.triangles)
    facets = _core.Facets(fate.facet_of_patch[attempt.patch_of_triangle[order]], planes)
    points = attempt.surface.points
    halfedges = _core.pair_halfedges(points, faces, None, tolerance)
    return FacetedSurface(points, faces, attempt.surface.decided, halfedges, facets)


def _find_little_gain(surface: FacetedSurface, done: Assembly) -> Flags:
    """Find facets that changed where the curved surfaces of a component lost few of their points.

    A curved surface can be cut into facets in many ways, and any cut of the result of a run finds a few more
    points to drop. That is not worth moving the surface once more.
    """
    facets, count = surface.facets, len(surface.points)
    hardly = np.zeros_like(facets.curved)
    if not facets.curved.any():
        return hardly
    curved = np.flatnonzero(facets.curved[facets.facet_of_face])
    component = _core.find_components(surface.faces, count)
    corners = surface.faces[curved].reshape(-1)
    key = np.unique(np.repeat(component[curved].astype(np.int64), 3) * count + corners)
    owner, point = np.divmod(key, count)
    dropped = np.ones(count, bool)
    dropped[done.triangles] = False
    face_count = len(surface.faces)
    few = np.bincount(owner, dropped[point], face_count) < LEAST_GAIN * np.bincount(owner, minlength=face_count)
    hardly[facets.facet_of_face[curved[few[component[curved]]]]] = 1
    hardly[done.unchanged != 0] = 0
    return hardly


def _touch(faces: Faces, edges: Indices) -> NDArray[np.bool_]:
    """Find faces that have both ends of an edge; of an edge with equal ends, that point."""
    both = [np.isin(faces, edge).sum(axis=1) == (2 if edge[0] != edge[1] else 1) for edge in edges]
    touched: NDArray[np.bool_] = np.any(both, axis=0)
    return touched
