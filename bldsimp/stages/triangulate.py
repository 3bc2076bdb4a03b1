"""Triangulate thinned facets anew, put them together, and find those that do not fit.

The checks return failures; `fallback` decides what more of a facet has to stay then.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model import Faces, Flags, Indices, cast_indices
from ..triangulation import Statistics
from .budget import Spent, allot_tolerance, key_edges
from .facets import FacetedSurface
from .outlines import TracedOutlines
from .surface import GOES, STAYS

_NO_EDGES = np.empty((0, 2), np.int32)


class Cause(IntEnum):
    """Why more of a facet stays; the first four are the kernel's outcomes."""

    NONE = 0
    UNCHANGED = 1
    CROSSING = 2
    MISMATCH = 3
    CLASH = 4
    MISFIT = 5
    LITTLE_GAIN = 6
    PIERCED = 7


@dataclass(frozen=True)
class Failure:
    """A patch that does not fit.

    Attributes
    ----------
    patch : int
    cause : Cause
    culprits : (k,) int32
        Dropped points that may be to blame.
    trouble : (j, 2) int32
        Edges at which it does not fit; a point, where both ends are one.
    """

    patch: np.int32
    cause: Cause
    culprits: Indices
    trouble: Indices


@dataclass
class Fate:
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
    statistics : Statistics
        Of all triangulations so far.
    """

    facet_of_patch: Indices
    keep: Flags
    put_back: Flags
    level: Flags
    cause: Flags
    splits: Flags
    statistics: Statistics

    def lower(self, patches: NDArray[np.integer], level: int, cause: Cause) -> None:
        """Note that the facets of some patches stand on a level at best."""
        facets = np.unique(self.facet_of_patch[patches])
        lower = facets[self.level[facets] < level]
        self.level[lower] = level
        self.cause[lower] = cause


class Attempt:
    """The facets of a surface, triangulated from what is kept of their outlines.

    Parameters
    ----------
    surface : FacetedSurface
        Its facets are the patches.
    tolerance : float
        Model units.
    fate : Fate
    spent : Spent

    Attributes
    ----------
    surface, fate
        As given.
    outlines : TracedOutlines
    budget : Budget
    must : (n,) uint8
        Points that stay.
    dirty : (p,) bool
        Patches to triangulate anew.
    kept : (n,) uint8
        Points that are kept now.
    pieces : _core.Pieces
        The straight lines that replace runs of chains.
    edges : _core.PieceEdges
        How the edges of pieces must be used.
    triangles, patch_of_triangle, unchanged
        The triangles of all patches, and which patches have their own faces.
    """

    pieces: _core.Pieces
    edges: _core.PieceEdges

    def __init__(self, surface: FacetedSurface, tolerance: float, fate: Fate, spent: Spent) -> None:
        self.surface, self.fate = surface, fate
        self.outlines = TracedOutlines(surface, fate.keep)
        self.budget = allot_tolerance(tolerance, surface.facets.planes, fate.facet_of_patch, self.outlines, spent)
        self.must = self.outlines.chains.is_chain_end | fate.put_back | (surface.decided == STAYS).astype(np.uint8)
        self.keep_points_of(fate.keep != 0)
        self.face_start, self.face_order = _core.group_faces(surface.facets)
        self.dirty = np.ones(len(fate.keep), bool)
        self.kept = np.zeros(len(surface.points), np.uint8)
        self.triangles: Faces = np.empty((0, 3), np.int32)
        self.patch_of_triangle: Indices = np.empty(0, np.int32)
        self.unchanged = np.zeros(len(fate.keep), np.uint8)

    def keep_points_of(self, patches: NDArray[np.bool_]) -> None:
        """Keep all points of the faces of some patches."""
        self.must[self.surface.faces[patches[self.surface.facets.facet_of_face]]] = 1

    def faces_of(self, patch: np.int32) -> Indices:
        """Return the faces of a patch."""
        return self.face_order[self.face_start[patch] : self.face_start[patch + 1]]

    def dropped_points_of(self, patch: np.int32) -> Indices:
        """Return the points of a patch's chains that are not kept."""
        points = self.outlines.points_of(patch)
        dropped: Indices = points[self.kept[points] == 0]
        return dropped


def thin_chains(attempt: Attempt) -> None:
    """Thin all chains; patches beside a point whose fate changed must be triangulated anew."""
    points, chains = attempt.surface.points, attempt.outlines.chains
    kept = _core.thin_chains(points, chains, attempt.budget.limit, attempt.must)
    kept[(attempt.surface.decided == GOES) & (attempt.must == 0)] = 0
    attempt.dirty[attempt.outlines.patches_at(np.flatnonzero(kept != attempt.kept))] = True
    attempt.kept = kept
    attempt.pieces = _core.lay_pieces(points, chains, kept)
    attempt.edges = _core.merge_pieces(attempt.pieces, chains)


def triangulate_patches(attempt: Attempt) -> list[Failure]:
    """Triangulate the patches that changed."""
    surface, wanted = attempt.surface, cast_indices(np.flatnonzero(attempt.dirty))
    made = _core.retriangulate(
        surface.points,
        surface.faces,
        attempt.face_start,
        attempt.face_order,
        surface.facets,
        attempt.outlines.chains,
        attempt.pieces,
        attempt.kept,
        attempt.budget.allowed,
        wanted,
        attempt.fate.keep,
    )
    attempt.fate.statistics += Statistics(*made.statistics)
    outcomes = made.outcomes
    attempt.unchanged[wanted] = outcomes == Cause.UNCHANGED
    attempt.budget.reach[wanted] = made.reach
    old = ~attempt.dirty[attempt.patch_of_triangle]
    attempt.triangles = np.concatenate([attempt.triangles[old], made.triangles])
    attempt.patch_of_triangle = np.concatenate([attempt.patch_of_triangle[old], made.facet_of_triangle])
    attempt.dirty[:] = False
    failed = outcomes >= Cause.CROSSING
    return [
        Failure(patch, Cause(int(outcome)), _rows_of(patch, made.put_back)[:, 0], _rows_of(patch, made.trouble))
        for patch, outcome in zip(wanted[failed], outcomes[failed], strict=True)
    ]


def find_misfits(attempt: Attempt) -> list[Failure]:
    """Find patches whose edges are not used as they must be."""
    misfits = _core.find_misfits(
        attempt.triangles, attempt.patch_of_triangle, attempt.edges, attempt.unchanged, attempt.outlines.chains
    )
    ends = ((patch, np.unique(_rows_of(patch, misfits))) for patch in np.unique(misfits[:, 0]))
    return [Failure(patch, Cause.MISFIT, own[:0], _as_edges(own)) for patch, own in ends]


def find_split_components(attempt: Attempt) -> list[Failure]:
    """Find strips that held a component together and closed, so that it came apart."""
    if attempt.edges.healed == 0:
        return []
    surface, keep = attempt.surface, attempt.fate.keep
    before = np.zeros(len(keep), np.int32)
    before[surface.facets.facet_of_face] = _core.find_components(surface.faces, len(surface.points))
    after = _core.find_components(attempt.triangles, len(surface.points))
    pairs = np.unique(np.stack([attempt.patch_of_triangle, after], axis=1), axis=0)
    of_component = np.unique(np.stack([before[pairs[:, 0]], pairs[:, 1]], axis=1), axis=0)[:, 0]
    parted = of_component[1:][of_component[1:] == of_component[:-1]]
    if len(parted) == 0:
        return []
    suspects = np.isin(before, parted) & (keep == 0)
    # A strip has vanished, or parted itself where it was narrow.
    strips = suspects & (np.bincount(pairs[:, 0], minlength=len(keep)) != 1)
    healed = attempt.edges.healed_pieces
    chain, farthest = attempt.pieces.chain[healed], attempt.pieces.farthest[healed]
    failures = []
    for patch in cast_indices(np.flatnonzero(strips if strips.any() else suspects)):
        culprits = np.unique(farthest[np.isin(chain, attempt.outlines.chains_of(patch)) & (farthest >= 0)])
        failures.append(Failure(patch, Cause.MISFIT, culprits, _NO_EDGES))
    return failures


def find_new_crossings(attempt: Attempt) -> list[Failure]:
    """Find patches that pass through another, where those two did not before."""
    points = attempt.surface.points
    changed = attempt.unchanged[attempt.patch_of_triangle] == 0
    crossing = _core.find_crossings(points, attempt.triangles, changed.astype(np.uint8))
    crossing = crossing[~_crossed_before(attempt, attempt.patch_of_triangle[crossing])]
    triangles = np.unique(crossing)
    triangles = triangles[changed[triangles]]
    patches = attempt.patch_of_triangle[triangles]
    pieces = attempt.pieces
    failures = []
    for patch in np.unique(patches):
        own = attempt.triangles[triangles[patches == patch]]
        edges = key_edges(own, np.roll(own, -1, axis=1), len(points))
        on_edge = np.isin(key_edges(pieces.begin, pieces.end, len(points)), edges) & (pieces.farthest >= 0)
        culprits = np.unique(pieces.farthest[on_edge])
        failures.append(Failure(patch, Cause.PIERCED, culprits, _as_edges(np.unique(own))))
    return failures


def try_facets(attempt: Attempt) -> Iterator[list[Failure]]:
    """Triangulate and put together; yield the failures of each step, after which the next needs none."""
    yield triangulate_patches(attempt)
    yield find_misfits(attempt)
    yield find_split_components(attempt)
    yield find_new_crossings(attempt)


def _crossed_before(attempt: Attempt, pairs: Indices) -> NDArray[np.bool_]:
    """Tell whether faces of both patches of each pair passed through one another."""
    if not len(pairs):
        return np.zeros(0, bool)
    surface, count = attempt.surface, len(attempt.surface.points)
    faces = np.flatnonzero(np.isin(surface.facets.facet_of_face, pairs))
    before = surface.facets.facet_of_face[faces][_core.find_crossings(surface.points, surface.faces[faces])]
    return np.isin(key_edges(pairs[:, 0], pairs[:, 1], count), key_edges(before[:, 0], before[:, 1], count))


def _as_edges(points: Indices) -> Indices:
    """Return points as edges of no length."""
    return np.stack([points, points], axis=1)


def _rows_of(patch: np.int32, rows: Indices) -> Indices:
    """Return what follows the patch in the rows that belong to it; `rows` are sorted."""
    low, high = np.searchsorted(rows[:, 0], [patch, patch + 1])
    return rows[low:high, 1:]
