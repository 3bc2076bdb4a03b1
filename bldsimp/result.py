"""What became of one mesh, counted."""

from __future__ import annotations

import dataclasses
from collections import Counter
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from . import _core
from .model import Faces, Indices, Points, SimplifiedMesh
from .report import Counts
from .stages.assembled import Layout
from .stages.attributes import followed
from .stages.removal import Dropped
from .triangulation import Statistics


@dataclass
class MeshResult:
    """What became of one mesh; lengths in its own frame.

    Attributes
    ----------
    light : SimplifiedMesh
    points : (n, 3) float64
        Welded points of the input, in lexicographic order.
    triangles : (k, 3) int32
        The result over `points`.
    facet_of_triangle, facet_of_light, facet_of_face : int32
        Facets of the result's triangles over `points`, of those in rows of the mesh, and of the welded faces
        of the input; -1 for a face of whose facet nothing is left.
    source : (m,) int32
        Input face of each welded face.
    planes : (f, 5) float64
        Normal of each facet, and the least and greatest height of its points along it.
    rung, unchanged : (f,) uint8
        `Rung` of each facet; whether its own faces stayed.
    deviation : float
        Certified bound, both ways.
    texels : float
        How far a texture has moved on its wall at most, along u or v.
    before, after : Counts
    degenerate, duplicate : int
        Faces dropped since they repeat a point, or copy another face.
    turned, healed : int
        Faces whose winding was turned; T-junctions that closed.
    touching : int
        Points that stay only since sheets meet there inside of facets.
    reasons : dict of str to int
        Why facets stand below the first rung.
    dropped : list of Dropped
    closed : int
        Boundary loops that were closed.
    statistics : Statistics
        Of all triangulations.
    layout : Layout or None
        What the last round triangulated, where asked for.
    """

    light: SimplifiedMesh
    points: Points
    triangles: Faces
    facet_of_triangle: Indices
    facet_of_light: Indices
    facet_of_face: Indices
    source: Indices
    planes: NDArray[np.float64]
    rung: NDArray[np.uint8]
    unchanged: NDArray[np.uint8]
    before: Counts
    after: Counts
    deviation: float = 0.0
    texels: float = 0.0
    degenerate: int = 0
    duplicate: int = 0
    turned: int = 0
    healed: int = 0
    touching: int = 0
    reasons: dict[str, int] = field(default_factory=dict)
    dropped: list[Dropped] = field(default_factory=list)
    closed: int = 0
    statistics: Statistics = field(default_factory=Statistics)
    layout: Layout | None = None

    def followed_by(self, second: MeshResult) -> MeshResult:
        """What two runs did together, of which the second worked on the result of the first."""
        facet = _facet_after(self, second)
        rung = second.rung.copy()
        told = facet >= 0
        np.maximum.at(rung, facet[told], self.rung[told])
        return dataclasses.replace(
            second,
            light=followed(self.light, second.light),
            facet_of_face=facet[self.facet_of_face],
            source=self.source,
            rung=rung,
            before=self.before,
            deviation=self.deviation + second.deviation,
            texels=self.texels + second.texels,
            degenerate=self.degenerate,
            duplicate=self.duplicate,
            turned=self.turned + second.turned,
            healed=self.healed + second.healed,
            reasons=dict(Counter(self.reasons) + Counter(second.reasons)),
            dropped=self.dropped + second.dropped,
            closed=self.closed + second.closed,
            statistics=self.statistics + second.statistics,
        )


def _facet_after(first: MeshResult, second: MeshResult) -> Indices:
    """Facet of the second run that has the most triangles of each facet of the first, -1 where none is left."""
    facet_of_row = first.facet_of_light[second.source]
    pairs, count = np.unique(np.stack([facet_of_row, second.facet_of_face], axis=1), axis=0, return_counts=True)
    order = np.lexsort((-pairs[:, 1], count))
    facet = np.full(len(first.rung), -1, np.int32)
    facet[pairs[order, 0]] = pairs[order, 1]
    return facet


def counts_of(triangles: Faces, points: Points, light: SimplifiedMesh) -> Counts:
    """A result in numbers."""
    used = int(np.count_nonzero(np.bincount(triangles.reshape(-1))))
    return counts(used, len(light.faces), *_core.count_edges(triangles, len(points)))


def counts(points: int, triangles: int, open_edges: int, nonmanifold_edges: int) -> Counts:
    """What a mesh has, as the report tells it; vertices and bytes are the writer's."""
    return Counts(
        points=points,
        triangles=triangles,
        watertight=triangles > 0 and open_edges == nonmanifold_edges == 0,
        open_edges=open_edges,
        nonmanifold_edges=nonmanifold_edges,
    )
