"""Simplify facets, and keep more of those that do not fit together.

Thin the chains, triangulate the facets, put them together, and look where they do not fit. There put dropped points
back; where none were dropped, keep the faces around the trouble, then the whole outline, then all faces of the facet;
and again, until all fits.
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model import Faces, Flags, Indices, Values, cast_indices
from ..options import LEAST_GAIN
from ..triangulation import Statistics
from .budget import Spent, key_edges
from .facets import FacetedSurface
from .surface import sort_faces
from .triangulate import Attempt, Cause, Failure, Fate, thin_chains, try_facets

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
    layout : Attempt
        The last triangulation, patch by patch.
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
    layout: Attempt

    def count_points(self) -> int:
        """Count the points that the result uses."""
        return len(np.unique(self.triangles))

    def compose(self, second: Assembly) -> Assembly:
        """Return what two passes did together, of which the second worked on the result of this one."""
        return dataclasses.replace(
            second,
            level=np.maximum(self.level, second.level),
            unchanged=self.unchanged & second.unchanged,
            deviation=np.maximum(self.deviation, second.deviation),
            healed=self.healed + second.healed,
            causes=self.causes | second.causes,
            statistics=self.statistics + second.statistics,
        )


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
        attempt = _simplify_once(surface, tolerance, pinned, hardly, spent)
        again = _assemble(attempt)
        if done is not None and again.count_points() >= done.count_points():
            return done
        done = again if done is None else done.compose(again)
        if not (attempt.edges.healed > 0 or len(attempt.fate.keep) > len(pinned)):
            return done
        spent = _spend(attempt)
        surface = _take_result(attempt, surface.facets.planes, tolerance)


def _simplify_once(surface: FacetedSurface, tolerance: float, pinned: Flags, hardly: Flags, spent: Spent) -> Attempt:
    """Try until everything fits."""
    level = np.where(pinned != 0, np.uint8(Level.PASSED_ON), np.uint8(Level.SIMPLIFIED))
    level[hardly != 0] = Level.FACES_KEPT
    cause = np.where(hardly != 0, np.uint8(Cause.LITTLE_GAIN), np.uint8(Cause.NONE))
    patch, put_back = np.arange(len(pinned), dtype=np.int32), np.zeros(len(surface.points), np.uint8)
    fate = Fate(patch, pinned | hardly, put_back, level, cause, np.zeros_like(level), Statistics())
    attempt = Attempt(surface, tolerance, fate, spent)
    while failures := _try_once(attempt):
        cut = [own for failure in failures if (own := _keep_more(attempt, failure)) is not None]
        if cut:
            surface = _split_off(attempt, cast_indices(np.unique(np.concatenate(cut))))
            attempt = Attempt(surface, tolerance, fate, spent)
    return attempt


def _try_once(attempt: Attempt) -> list[Failure]:
    """Thin, triangulate and check; return the failures of the first step that has any."""
    thin_chains(attempt)
    while len(clashing := attempt.edges.clashing):
        _put_back(attempt, clashing)
        attempt.fate.lower(attempt.outlines.patches_at(clashing), Level.POINTS_PUT_BACK, Cause.CLASH)
        thin_chains(attempt)
    return next((failures for failures in try_facets(attempt) if failures), [])


def _keep_more(attempt: Attempt, failure: Failure) -> Indices | None:
    """Keep more of a patch: the least that may help and was not tried yet. Return faces that are to be split off."""
    patch, fate = failure.patch, attempt.fate
    facet = fate.facet_of_patch[patch]
    culprits = failure.culprits[attempt.kept[failure.culprits] == 0]
    dropped = attempt.dropped_points_of(patch)
    attempt.dirty[patch] = True
    cut = None
    if len(culprits):
        level = Level.POINTS_PUT_BACK
        _put_back(attempt, culprits)
    elif len(failure.trouble) and fate.splits[facet] < MOST_SPLITS:
        level = Level.SOME_FACES_KEPT
        fate.splits[facet] += 1
        own = attempt.faces_of(patch)
        cut = own[_touch(attempt.surface.faces[own], failure.trouble)]
    elif len(dropped):
        level = Level.OUTLINE_PUT_BACK
        _put_back(attempt, dropped)
    else:
        level = Level.FACES_KEPT
        fate.keep[patch] = 1
        attempt.keep_points_of(np.arange(len(fate.keep)) == patch)
    fate.lower(np.array([patch]), level, failure.cause)
    return cut


def _put_back(attempt: Attempt, points: Indices) -> None:
    """Keep points that were dropped."""
    attempt.must[points] = attempt.fate.put_back[points] = 1


def _split_off(attempt: Attempt, cut: Indices) -> FacetedSurface:
    """Make each of some faces a patch of its own, which stays."""
    surface, fate = attempt.surface, attempt.fate
    owners = fate.facet_of_patch[surface.facets.facet_of_face[cut]]
    fate.facet_of_patch = np.concatenate([fate.facet_of_patch, owners])
    fate.keep = np.concatenate([fate.keep, np.ones(len(cut), np.uint8)])
    return dataclasses.replace(surface, facets=_core.split_off(surface.facets, cut))


def _assemble(attempt: Attempt) -> Assembly:
    """Put the facets of the surface together, each with all its patches."""
    fate, budget, pieces, outlines = attempt.fate, attempt.budget, attempt.pieces, attempt.outlines
    deviation, unchanged = np.zeros(len(fate.level)), np.ones_like(fate.level)
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
        statistics=fate.statistics,
        layout=attempt,
    )


def _spend(attempt: Attempt) -> Spent:
    """Return how far edges and facets of the result are from what they replace."""
    fate, budget, pieces, outlines = attempt.fate, attempt.budget, attempt.pieces, attempt.outlines
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


def _take_result(attempt: Attempt, planes: Values, tolerance: float) -> FacetedSurface:
    """Return the result of a pass as the surface of the next, with the facets of the first."""
    faces, order = sort_faces(attempt.triangles)
    facets = _core.Facets(attempt.fate.facet_of_patch[attempt.patch_of_triangle[order]], planes)
    halfedges = _core.pair_halfedges(attempt.surface.points, faces, None, tolerance)
    return dataclasses.replace(attempt.surface, faces=faces, halfedges=halfedges, facets=facets)


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
