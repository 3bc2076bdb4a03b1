"""Compose the result of one mesh, and count it."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from . import _core
from .model import Faces, Flags, Indices, Mesh, Points, SimplifiedMesh, Values
from .report import Counts
from .stages.attributes import AttributeCharts, KeptAttributes
from .stages.collapse import CollapsedSurface
from .stages.planar import MergedSurface, map_facets
from .stages.provenance import ResolvedRows, convert_to_rows, place_rows, resolve_rows
from .stages.removal import Details, Dropped
from .stages.triangulate import Attempt, Cause
from .stages.weld import WeldedMesh
from .triangulation import Statistics


@dataclass
class MeshResult:
    """The result of one mesh, with counts and bound; lengths in its own frame.

    Attributes
    ----------
    mesh : SimplifiedMesh
        The result in rows of the mesh.
    points : (n, 3) float64
        Distinct points, of which the result uses some.
    triangles : (k, 3) int32
        The result over `points`, without unchanged parts.
    facet_of_triangle, facet_of_face : int32
        Facets of the result's triangles, and of the welded faces of the input; -1 for a face of whose facet nothing
        is left.
    source : (m,) int32
        Input face of each welded face.
    planes : (f, 5) float64
        Normal of each facet, and the least and greatest height of its points along it.
    level : (f,) uint8
        `Level` of each facet.
    before, after : Counts
    deviation : float
        Certified bound, both ways.
    texels : float
        How far a texture has moved on its wall at most, along u or v.
    changes : dict of str to int
        How much of each kind changed, by the names of `Report`.
    reasons : dict of str to int
        Why facets were not simplified.
    dropped : list of Dropped
    statistics : Statistics
        Of all triangulations.
    layout : Attempt or None
        What was triangulated last, where asked for.
    """

    mesh: SimplifiedMesh
    points: Points
    triangles: Faces
    facet_of_triangle: Indices
    facet_of_face: Indices
    source: Indices
    planes: Values
    level: Flags
    before: Counts
    after: Counts
    deviation: float = 0.0
    texels: float = 0.0
    changes: dict[str, int] = field(default_factory=dict)
    reasons: dict[str, int] = field(default_factory=dict)
    dropped: list[Dropped] = field(default_factory=list)
    statistics: Statistics = field(default_factory=Statistics)
    layout: Attempt | None = None


@dataclass
class StageResults:
    """The results of the stages for one mesh.

    Attributes
    ----------
    welded : WeldedMesh
    halfedges : Halfedges
        Of it.
    turned : int
        Faces of it whose winding was turned.
    charts : AttributeCharts or None
    merged : list of MergedSurface
        The first of the welded mesh; the second, at a wide tolerance, of what edge collapses have left.
    details : Details or None
    collapsed : CollapsedSurface or None
    """

    welded: WeldedMesh
    halfedges: _core.Halfedges
    turned: int
    charts: AttributeCharts | None
    merged: list[MergedSurface] = field(default_factory=list)
    details: Details | None = None
    collapsed: CollapsedSurface | None = None

    @property
    def deviation(self) -> float:
        """Certified bound of how far the surface has moved; model units."""
        first, *rest = self.merged
        collapsed = 0.0 if self.collapsed is None else self.collapsed.deviation
        return first.bound_deviation(self.welded.moved) + collapsed + sum(one.bound_deviation() for one in rest)


def compose_result(
    mesh: Mesh, attributes: KeptAttributes, given: StageResults, *, keep_layout: bool = False
) -> MeshResult:
    """Convert a result to rows of the mesh, with the attributes of its corners, and count it.

    Parameters
    ----------
    mesh : Mesh
    attributes : KeptAttributes
        Of the mesh.
    given : StageResults
    keep_layout : bool
        Keep what was triangulated last.
    """
    welded, first, last = given.welded, given.merged[0], given.merged[-1]
    surface, assembly, parent = last.surface, last.assembly, last.find_parents()
    corners = resolve_corners(mesh, given) if last.corners is None else last.trace_rows()
    result, label, foreign = convert_to_rows(
        mesh, welded, corners, surface.source[parent], surface.label[parent], first.surface.label
    )
    if given.collapsed is not None:
        result.points = place_rows(mesh.points, welded, surface)
    attributes.update_values(result, mesh.points, foreign, label, given.charts)
    facet_of_facet, level = _trace_facets(given)
    halfedges, reasons = given.halfedges, sum((one.assembly.causes for one in given.merged), Counter[Cause]())
    dropped = [] if given.details is None else given.details.dropped
    return MeshResult(
        mesh=result,
        points=surface.points,
        triangles=assembly.triangles,
        facet_of_triangle=assembly.facet_of_triangle,
        facet_of_face=facet_of_facet[first.facets.facet_of_face],
        source=welded.source,
        planes=last.facets.planes,
        level=level,
        before=count_surface(len(welded.points), len(mesh.faces), (halfedges.open_edges, halfedges.nonmanifold_edges)),
        after=count_surface(
            assembly.count_points(), len(result.faces), _core.count_edges(assembly.triangles, len(surface.points))
        ),
        deviation=given.deviation,
        texels=_bound_texels(given, attributes),
        changes={
            "removed_degenerate_faces": welded.degenerate,
            "removed_duplicate_faces": welded.duplicate,
            "reversed_faces": given.turned + sum(one.turned for one in given.merged),
            "healed_t_junctions": sum(one.assembly.healed for one in given.merged),
            "contact_points": assembly.touching,
            "closed_boundary_loops": sum(one.reason == "boundary_loop" for one in dropped),
            "details_kept_by_label": 0 if given.details is None else given.details.kept_by_label,
        },
        reasons={cause.name.lower(): count for cause, count in reasons.items()},
        dropped=dropped,
        statistics=sum((one.assembly.statistics for one in given.merged), Statistics()),
        layout=assembly.layout if keep_layout else None,
    )


def resolve_corners(mesh: Mesh, given: StageResults) -> ResolvedRows:
    """Find the rows that the corners of a surface read: of what edge collapses have left, else of the result."""
    welded, first, collapsed = given.welded, given.merged[0], given.collapsed
    unchanged = first.assembly.unchanged
    if collapsed is None:
        triangles, facet = first.assembly.triangles, first.assembly.facet_of_triangle
    else:
        assert collapsed.surface.facet is not None
        triangles, facet = collapsed.surface.origin[collapsed.surface.faces], collapsed.surface.facet
        unchanged = np.zeros_like(unchanged) if collapsed.changed else unchanged
    facet_of_face, label = first.facets.facet_of_face, first.surface.label
    return resolve_rows(mesh, welded, triangles, facet, facet_of_face=facet_of_face, label=label, unchanged=unchanged)


def _trace_facets(given: StageResults) -> tuple[Indices, Flags]:
    """Return, for each facet found first, the one of the result that has most of it, and the level of those.

    -1 stands for a facet of which nothing is left.
    """
    level = given.merged[0].assembly.level
    if given.collapsed is None:
        return np.arange(len(level), dtype=np.int32), level
    collapsed, last = given.collapsed, given.merged[-1]
    assert collapsed.surface.facet is not None
    held = map_facets(collapsed.facet_before, collapsed.facet_after, len(level))
    shown = map_facets(collapsed.surface.facet, last.facets.facet_of_face, len(level))
    facet = np.where(held >= 0, shown[held], np.int32(-1))
    joined = last.assembly.level.copy()
    np.maximum.at(joined, facet[facet >= 0], level[facet >= 0])
    return facet, joined


def _bound_texels(given: StageResults, attributes: KeptAttributes) -> float:
    """Bound how far a texture has moved on its wall, along u or v; texels."""
    charts, welded = given.charts, given.welded
    if charts is None:
        return 0.0
    shift = attributes.bound_weld_shift(welded, charts) if welded.moved > 0 else 0.0
    if given.collapsed is not None and given.collapsed.changed:
        return float(charts.texels.max(initial=0.0)) + shift
    first = given.merged[0]
    changed = first.assembly.unchanged[first.facets.facet_of_face] == 0
    return float(charts.texels[charts.of_face[changed]].max(initial=0.0)) + shift


def count_surface(points: int, triangles: int, edges: tuple[int, int]) -> Counts:
    """Count what a surface has; vertices and bytes are the writer's.

    Parameters
    ----------
    points, triangles : int
    edges : (int, int)
        Edges of one face, and of more than two.
    """
    closed = triangles > 0 and edges == (0, 0)
    return Counts(
        points=points, triangles=triangles, watertight=closed, open_edges=edges[0], nonmanifold_edges=edges[1]
    )
