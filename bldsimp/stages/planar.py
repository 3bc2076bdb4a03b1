"""Facets, outlines, triangulation: what needs no wide tolerance."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model import LARGEST_COORDINATE, Faces, Indices, Mesh
from ..options import NEEDLE_DIAGONAL, WIDTH_SHARE, Options
from ..result import MeshResult, counts, counts_of
from ..tolerance import frame
from .attributes import Looks, Surface
from .fallback import climb
from .provenance import in_rows, owners_of
from .weld import at_their_points, weld


def lossless(mesh: Mesh, tolerance: float, options: Options, *, with_layout: bool = False) -> MeshResult:
    """Facets, outlines, triangulation: what needs no wide tolerance."""
    looks = Looks(mesh, options)
    welded, moved = weld(mesh, options.weld, looks.layers())
    points = welded.points
    part = mesh.part_of_face[welded.source]
    pinned = mesh.passed_on[part]

    origin, diagonal, slack = frame(mesh.box)
    # Squares of it must not leave the range of double precision.
    within = min(tolerance - slack - moved, 1e3 * LARGEST_COORDINATE) if tolerance > 2 * slack + moved else 0.0
    width, needle = WIDTH_SHARE * within, min(within, NEEDLE_DIAGONAL * diagonal)
    rows = _core.Rows(mesh.faces, welded.point_of_row, welded.source, welded.class_of_row)
    faces, halfedges, turned = _oriented(welded, rows, pinned, width)
    surface = Surface(points, faces, halfedges, rows, welded.source, part)

    def find(label: Indices) -> _core.Facets:
        fold = math.sqrt(within**2 - width**2)
        return _core.find_facets(points, faces, halfedges, label, origin, width, needle, fold)

    label = looks.labels(surface, pinned, needle)
    facets = find(label)
    charted = looks.charts(surface, *_core.group_faces(facets))
    if charted is not None and len(charted.maps) > len(facets.planes):
        label = np.where(pinned, np.int32(-1), charted.of_face)
        facets = find(label)
    frozen = np.zeros(len(facets.planes), np.uint8)
    frozen[facets.facet_of_face[pinned]] = 1
    assembled = climb(points, faces, halfedges, facets, within, frozen)
    owners = owners_of(facets.facet_of_face, part, label, len(assembled.rung))
    light, facet_of_light, foreign = in_rows(
        mesh, assembled.triangles, assembled.facet_of_triangle, assembled.unchanged, assembled.kept, surface, owners
    )
    if moved > 0:
        light.faces, away = at_their_points(mesh, light, welded, label, owners.group_of_facet[facet_of_light])
        foreign = np.union1d(foreign, away).astype(np.int32)
    # The last is that of faces without a facet, which are passed on.
    chart_of_facet, texels = np.zeros(len(assembled.rung) + 1, np.int32), 0.0
    if charted is not None:
        chart_of_facet[facets.facet_of_face] = charted.of_face
        texels = float(charted.texels[chart_of_facet[:-1][assembled.unchanged == 0]].max(initial=0.0))
        if moved > 0:
            texels += looks.carried_along(surface, welded.point_of_row, charted)
    looks.follow(light, mesh.points, foreign, chart_of_facet[facet_of_light], charted)
    moved += float(assembled.deviation.max(initial=0.0))
    return MeshResult(
        light=light,
        points=points,
        triangles=assembled.triangles,
        facet_of_triangle=assembled.facet_of_triangle,
        facet_of_light=facet_of_light,
        facet_of_face=facets.facet_of_face,
        source=welded.source,
        planes=facets.planes,
        rung=assembled.rung,
        unchanged=assembled.unchanged,
        before=counts(len(points), len(mesh.faces), halfedges.open_edges, halfedges.nonmanifold_edges),
        after=counts_of(assembled.triangles, points, light),
        deviation=moved + slack if moved > 0 or not assembled.unchanged.all() else 0.0,
        texels=texels,
        degenerate=welded.degenerate,
        duplicate=welded.duplicate,
        turned=turned,
        healed=assembled.healed,
        touching=assembled.touching,
        reasons={cause.name.lower(): count for cause, count in assembled.causes.items()},
        statistics=assembled.statistics,
        layout=assembled.layout if with_layout else None,
    )


def _oriented(
    welded: _core.Welded, rows: _core.Rows, pinned: NDArray[np.bool_], width: float
) -> tuple[Faces, _core.Halfedges, int]:
    """Faces and halfedges with consistent, outward winding, and how many faces that turned."""
    points, faces = welded.points, welded.faces
    halfedges = _core.pair_halfedges(points, faces, rows, width)
    turned = _core.find_turned(points, faces, halfedges, rows, pinned.astype(np.uint8))
    if len(turned):
        faces = faces.copy()
        faces[turned] = faces[turned][:, [0, 2, 1]]
        halfedges = _core.pair_halfedges(points, faces, rows, width)
    return faces, halfedges, len(turned)
