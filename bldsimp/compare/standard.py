"""Triangulate by the article's standard Delaunay method, on the facets and thinned chains of the improved one."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from .. import _core
from ..model import Faces, Points, Scene
from ..result import MeshResult
from ..triangulation import Statistics
from .placement import PlacedSurface, place_meshes


class Conformity(IntEnum):
    """How a facet got its triangles; all but the first have the improved method's, cut where pieces were cut."""

    DELAUNAY = 0
    KEPT = 1
    STOPPED = 2
    CROSSING = 3
    CLASH = 4


@dataclass(frozen=True)
class StandardMesh:
    """The result of the standard method for one mesh, in the mesh's own frame.

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


@dataclass(frozen=True)
class StandardSurface:
    """The result of the standard method for a scene.

    Attributes
    ----------
    surface : PlacedSurface
    statistics : Statistics
    note : str
        A caution about the figures; empty where none is needed.
    """

    surface: PlacedSurface
    statistics: Statistics
    note: str


def triangulate_standard(result: MeshResult) -> StandardMesh:
    """Triangulate a simplified mesh once more, by the standard method.

    The points of each facet are triangulated without constraints. A piece of outline that is no edge
    then is cut, for all facets along it, until every piece is an edge by itself. So only the
    triangulation differs from the improved method: facets, chains and kept points are the same.

    Parameters
    ----------
    result : MeshResult
        Of the improved method, made with its layout.

    Returns
    -------
    StandardMesh

    Notes
    -----
    Edges are used as often as in the improved method's result: a facet whose new triangles would not
    have the same rim keeps the improved method's, cut as its neighbors cut them. The same holds for facets
    that had to keep their faces, and for those that are stopped. Facets that lost no point are triangulated
    anew like all others. Depends on the coordinates alone.

    References
    ----------
    "Morphological recognition optimization of 3D building simplification by Delaunay algorithm", figures
    5 and 6.
    """
    layout = result.layout
    if layout is None:
        raise ValueError("the result has no layout: simplify keep_layout=True")
    conformed = _core.conform(
        result.points, layout.surface.facets.planes, layout.outlines.chains, layout.pieces,
        layout.triangles, layout.patch_of_triangle, layout.fate.keep,
    )  # fmt: skip
    points = np.concatenate([result.points, conformed.made])
    facets = Counter(Conformity(int(how)) for how in conformed.facets)
    return StandardMesh(points, conformed.triangles, facets, Statistics(*conformed.statistics))


def build_standard_surface(scene: Scene, results: list[MeshResult]) -> StandardSurface:
    """Join the standard method's results for all instances of all meshes of a scene.

    Parameters
    ----------
    scene : Scene
    results : list of MeshResult
        Of the improved method for each mesh, with its layout.
    """
    made = [triangulate_standard(result) for result in results]
    surface = place_meshes(scene, [mesh.points for mesh in made], [mesh.triangles for mesh in made])
    facets = sum((mesh.facets for mesh in made), Counter[Conformity]())
    return StandardSurface(surface, sum((mesh.statistics for mesh in made), Statistics()), _write_note(facets))


def _write_note(facets: Counter[Conformity]) -> str:
    stopped = facets[Conformity.STOPPED]
    same = sum(facets.values()) - facets[Conformity.DELAUNAY] - stopped
    notes = []
    if stopped:
        notes.append(f"stopped ({stopped} facet{'s' * (stopped > 1)})")
    if same:
        notes.append(f"{same} facet{'s' * (same > 1)} as improved")
    return ", ".join(notes)
