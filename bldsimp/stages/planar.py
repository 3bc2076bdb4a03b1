"""Merge coplanar faces: keep the chain ends of each outline, and the points that the tolerance needs."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from .. import _core
from ..model import Indices, cast_indices, measure_box
from ..unique_rows import find_unique_rows
from .facets import FacetedSurface, Limits, derive_limits, find_facets
from .fallback import Assembly, simplify_facets
from .orient import orient
from .provenance import ResolvedRows
from .surface import Surface, turn_faces


@dataclass(frozen=True)
class MergedSurface:
    """A surface whose coplanar faces were merged.

    Attributes
    ----------
    surface : Surface
        As it was before; the triangles of `assembly` are over its points.
    facets : Facets
        Of its faces.
    assembly : Assembly
    slack : float
        What rounding may add to a distance; model units.
    turned : int
        Faces whose winding was turned before.
    corners : ResolvedRows or None
        Of the faces of the surface, where they are resolved already.
    """

    surface: Surface
    facets: _core.Facets
    assembly: Assembly
    slack: float
    turned: int = 0
    corners: ResolvedRows | None = None

    def bound_deviation(self, moved: float = 0.0) -> float:
        """Bound how far the surface has moved, where welding had moved it before; model units."""
        moved += float(self.assembly.deviation.max(initial=0.0))
        return moved + self.slack if moved > 0 or not self.assembly.unchanged.all() else 0.0

    def find_parents(self) -> Indices:
        """Return, for each triangle, a face of the surface in its facet."""
        face_of_facet = np.zeros(len(self.assembly.level), np.int32)
        face_of_facet[self.facets.facet_of_face] = np.arange(len(self.surface.faces), dtype=np.int32)
        return face_of_facet[self.assembly.facet_of_triangle]

    def trace_rows(self) -> ResolvedRows:
        """Return the rows of the triangles.

        The triangles of an unchanged facet keep the rows of its faces; any other corner reads the least row that a face
        of its facet reads there.
        """
        assert self.corners is not None
        faces, triangles, facet = self.surface.faces, self.assembly.triangles, self.assembly.facet_of_triangle
        count = len(self.surface.points)
        key = (self.facets.facet_of_face[:, None].astype(np.int64) * count + faces).reshape(-1)
        order = np.lexsort((self.corners.rows.reshape(-1), key))
        sought = facet[:, None].astype(np.int64) * count + triangles
        corner = order[np.searchsorted(key[order], sought)]
        turned, turn = turn_faces(triangles)
        named = np.concatenate([np.column_stack([faces, self.facets.facet_of_face]), np.column_stack([turned, facet])])
        place = find_unique_rows(named)[1]
        face_at = np.full(len(named), -1)
        face_at[place[: len(faces)]] = np.arange(len(faces))
        own = np.where(self.assembly.unchanged[facet] != 0, face_at[place[len(faces) :]], -1)
        corner = np.where((own >= 0)[:, None], 3 * own[:, None] + (np.arange(3) - turn) % 3, corner)
        return ResolvedRows(self.corners.rows.reshape(-1)[corner], self.corners.is_foreign.reshape(-1)[corner])

    def take_result(self) -> Surface:
        """Return the result as a surface for the next stage."""
        facet = self.assembly.facet_of_triangle if self.surface.facet is None else None
        return self.surface.with_faces(self.assembly.triangles, self.find_parents(), facet)


def merge_coplanar(surface: Surface, halfedges: _core.Halfedges, facets: _core.Facets, limits: Limits) -> MergedSurface:
    """Merge the faces of each facet, and drop the points that no facet needs.

    Parameters
    ----------
    surface : Surface
        Oriented; each of its points is used.
    halfedges : Halfedges
    facets : Facets
        Found on its faces, within its labels.
    limits : Limits

    Returns
    -------
    MergedSurface

    Notes
    -----
    Nearly linear in the number of faces. Every point of the result is a point of the surface.

    References
    ----------
    "Morphological recognition optimization of 3D building simplification by Delaunay algorithm", section on the
    simplification model.
    """
    pinned = np.zeros(len(facets.planes), np.uint8)
    pinned[facets.facet_of_face[surface.label < 0]] = 1
    faceted = FacetedSurface(surface.points, surface.faces, surface.decided, halfedges, facets)
    return MergedSurface(surface, facets, simplify_facets(faceted, limits.tolerance, pinned), limits.slack)


def merge_after_collapses(surface: Surface, corners: ResolvedRows, tolerance: float) -> MergedSurface:
    """Merge the coplanar faces of a surface that edge collapses have left.

    Parameters
    ----------
    surface : Surface
        Each of its points is used.
    corners : ResolvedRows
        Of its faces.
    tolerance : float
        Model units.
    """
    limits = derive_limits(measure_box(surface.points), tolerance)
    point_of_row = np.full(int(corners.rows.max(initial=-1)) + 1, -1, np.int32)
    point_of_row[corners.rows] = surface.faces
    every = np.arange(len(surface.faces), dtype=np.int32)
    rows = _core.CornerRows(corners.rows, point_of_row, every, np.empty(0, np.int32))
    faces, halfedges, turned = orient(surface.points, surface.faces, rows, surface.label < 0, limits.width)
    # The second and third corner of a face that was turned have changed places.
    corners = ResolvedRows(corners.rows.copy(), corners.is_foreign.copy())
    for values in (corners.rows, corners.is_foreign):
        values[turned] = values[turned][:, [0, 2, 1]]
    surface = dataclasses.replace(surface, faces=faces)
    facets = find_facets(surface.points, faces, halfedges, surface.label, limits)
    merged = merge_coplanar(surface, halfedges, facets, limits)
    return dataclasses.replace(merged, turned=len(turned), corners=corners)


def map_facets(before: Indices, after: Indices, count: int) -> Indices:
    """Return for each facet before the one after that has most of its faces; -1 where it has none.

    Parameters
    ----------
    before, after : (m,) int32
        The facets of each face.
    count : int
        Of the facets before.
    """
    pairs, faces = np.unique(np.stack([before, after], axis=1), axis=0, return_counts=True)
    order = np.lexsort((-pairs[:, 1], faces))
    facet = np.full(count, -1, np.int32)
    facet[pairs[order, 0]] = pairs[order, 1]
    return cast_indices(facet)
