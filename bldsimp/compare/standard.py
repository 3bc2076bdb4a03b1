"""The article's standard Delaunay method, on the facets and thinned chains that the improved one found."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from .. import _core
from ..model import Faces, Points, Scene
from ..result import MeshResult
from ..triangulation import Statistics
from .surface import Surface, placed_surface


class Conformity(IntEnum):
    """How a facet got its triangles; all but the first have the improved method's, cut where pieces were."""

    DELAUNAY = 0
    KEPT = 1
    STOPPED = 2
    CROSSING = 3
    CLASH = 4


@dataclass(frozen=True)
class StandardResult:
    """What the standard method made of one mesh, in the mesh's own frame.

    Attributes
    ----------
    points : (n, 3) float64
        Welded points of the input, then those made by cutting.
    triangles : (k, 3) int32
        The result over `points`.
    facets : Counter of Conformity
        How facets got their triangles; a facet with faces that were kept counts as several.
    statistics : Statistics
        Of all triangulations.
    """

    points: Points
    triangles: Faces
    facets: Counter[Conformity]
    statistics: Statistics

    @property
    def stopped(self) -> int:
        """Facets that were stopped, since they had more than 50 times their points."""
        return self.facets[Conformity.STOPPED]


@dataclass(frozen=True)
class Standard:
    """What the standard method made of a scene.

    Attributes
    ----------
    surface : Surface
    facets : Counter of Conformity
        As in `StandardResult`, over all meshes.
    statistics : Statistics
    note : str
        What the figures must not be read without; empty where there is nothing.
    """

    surface: Surface
    facets: Counter[Conformity]
    statistics: Statistics
    note: str


def standard_of(outcome: MeshResult) -> StandardResult:
    """Triangulate a simplified mesh once more, by the standard method.

    The points of each facet are triangulated without constraints. A piece of outline that is no edge
    then is cut, for all facets along it, until every piece is an edge by itself. So only the
    triangulation differs from the improved method: facets, chains and kept points are the same.

    Parameters
    ----------
    outcome : MeshResult
        Made with its layout.

    Returns
    -------
    StandardResult

    Notes
    -----
    Edges are used as often as in the improved method's result: a facet whose new triangles would not
    have the same rim keeps the improved method's, cut as its neighbours cut them. The same holds for facets
    that had to keep their faces, and for those that are stopped. Facets that lost no point are triangulated
    anew like all others. Depends on the coordinates alone.

    References
    ----------
    "Morphological recognition optimization of 3D building simplification by Delaunay algorithm", figures
    5 and 6.
    """
    layout = outcome.layout
    if layout is None:
        raise ValueError("the outcome has no layout: simplify keep_layout")
    conformed = _core.conform(
        outcome.points, layout.planes, layout.outlines, layout.segments,
        layout.triangles, layout.piece_of_triangle, layout.keep,
    )  # fmt: skip
    return StandardResult(
        np.concatenate([outcome.points, conformed.made]),
        conformed.triangles,
        Counter(Conformity(int(how)) for how in conformed.facets),
        Statistics(*conformed.statistics),
    )


def standard_surface(scene: Scene, outcomes: list[MeshResult]) -> Standard:
    """What the standard method makes of all instances of all meshes of a scene.

    Parameters
    ----------
    scene : Scene
    outcomes : list of MeshResult
        What the improved method made of each mesh, with its layout.
    """
    results = [standard_of(outcome) for outcome in outcomes]
    facets = sum((result.facets for result in results), Counter[Conformity]())
    return Standard(
        placed_surface(scene, [result.points for result in results], [result.triangles for result in results]),
        facets,
        sum((result.statistics for result in results), Statistics()),
        _note(facets),
    )


def _note(facets: Counter[Conformity]) -> str:
    stopped = facets[Conformity.STOPPED]
    same = sum(facets.values()) - facets[Conformity.DELAUNAY] - stopped
    notes = []
    if stopped:
        notes.append(f"stopped ({stopped} facet{'s' * (stopped > 1)})")
    if same:
        notes.append(f"{same} facet{'s' * (same > 1)} as improved")
    return ", ".join(notes)
