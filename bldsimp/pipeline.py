"""The pipeline: from a mesh to the fewest points that keep its surface."""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from . import _core
from .assembled import Layout
from .dropped import Dropped, spare
from .ladder import climb
from .looks import Charted, Looks, Surface, followed, left
from .options import (
    AUTO_DIAGONAL,
    DEFAULTS,
    MOVED_SHARE,
    NEEDLE_DIAGONAL,
    SPARE_SHARE,
    STAGED_DIAGONAL,
    WIDTH_SHARE,
    Options,
)
from .report import Counts
from .scene import LARGEST_COORDINATE, Faces, Flags, Indices, Light, Mesh, Points
from .triangulation import Statistics


@dataclass
class Outcome:
    """What became of one mesh; lengths in its own frame.

    Attributes
    ----------
    light : Light
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

    light: Light
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

    def followed_by(self, second: Outcome) -> Outcome:
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


def _facet_after(first: Outcome, second: Outcome) -> Indices:
    """Facet of the second run that has the most triangles of each facet of the first, -1 where none is left."""
    facet_of_row = first.facet_of_light[second.source]
    pairs, count = np.unique(np.stack([facet_of_row, second.facet_of_face], axis=1), axis=0, return_counts=True)
    order = np.lexsort((-pairs[:, 1], count))
    facet = np.full(len(first.rung), -1, np.int32)
    facet[pairs[order, 0]] = pairs[order, 1]
    return facet


def simplify_mesh(
    mesh: Mesh,
    tolerance: float,
    options: Options = DEFAULTS,
    *,
    with_layout: bool = False,
    progress: _core.Progress | None = None,
) -> Outcome:
    """Simplify one mesh.

    Parameters
    ----------
    mesh : Mesh
    tolerance : float
        How far any point of the surface may move; model units of the mesh's own frame.
    options : Options
        `weld` (model units of the mesh's own frame) and `delimit`.
    with_layout : bool
        Keep what another triangulation of the same facets needs.
    progress : Progress, optional
        Counts points that a wide tolerance drops, while it does.

    Returns
    -------
    Outcome

    Notes
    -----
    Nearly linear in the number of faces. The result depends on the coordinates alone: every stage works
    on points and faces in lexicographic order.

    A wide tolerance is spent by collapses on what facets leave without loss. What they leave is made of facets
    again, so that its triangles are as well shaped as any.
    """
    fine = AUTO_DIAGONAL * _frame(mesh.box)[1]
    if tolerance <= STAGED_DIAGONAL / AUTO_DIAGONAL * fine:
        return _lossless(mesh, tolerance, options, with_layout=with_layout)
    first = _lossless(mesh, fine, options)
    second = _collapsed(left(mesh, first.light), first, tolerance - first.deviation - fine, options, progress)
    done = first.followed_by(second)
    welded = dataclasses.replace(options, weld=0.0)
    return done.followed_by(_lossless(left(mesh, done.light), fine, welded, with_layout=with_layout))


def _lossless(mesh: Mesh, tolerance: float, options: Options, *, with_layout: bool = False) -> Outcome:
    """Facets, outlines, triangulation: what needs no wide tolerance."""
    passed_on = _passed_on(mesh)
    looks = Looks(mesh, options)
    welded, moved = _welded(mesh, passed_on, options.weld, looks.layers())
    points = welded.points
    part = mesh.part_of_face[welded.source]
    pinned = passed_on[part]

    origin, diagonal, slack = _frame(mesh.box)
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
    owners = _owners(facets.facet_of_face, part, label, len(assembled.rung))
    light, facet_of_light, foreign = _in_rows(
        mesh, assembled.triangles, assembled.facet_of_triangle, assembled.kept, surface, owners, passed_on
    )
    if moved > 0:
        light.faces, away = _at_their_points(mesh, light, welded)
        foreign = np.union1d(foreign, away).astype(np.int32)
    chart_of_facet, texels = np.zeros(len(assembled.rung), np.int32), 0.0
    if charted is not None:
        chart_of_facet[facets.facet_of_face] = charted.of_face
        texels = float(charted.texels[chart_of_facet[assembled.unchanged == 0]].max(initial=0.0))
    looks.follow(light, mesh.points, foreign, chart_of_facet[facet_of_light], charted)
    moved += float(assembled.deviation.max(initial=0.0))
    return Outcome(
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
        before=_counts(len(points), len(mesh.faces), halfedges.open_edges, halfedges.nonmanifold_edges),
        after=_counted(assembled.triangles, points, light),
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


def _collapsed(
    mesh: Mesh, first: Outcome, tolerance: float, options: Options, progress: _core.Progress | None
) -> Outcome:
    """Edges collapsed, on a mesh that is what facets left; facets are those of the outcome that it is left of."""
    passed_on = _passed_on(mesh)
    looks = Looks(mesh, options)
    welded = _core.weld(mesh.points, mesh.faces, 0.0, looks.layers())
    points, faces, part = welded.points, welded.faces, mesh.part_of_face[welded.source]
    rows = _core.Rows(mesh.faces, welded.point_of_row, welded.source, welded.class_of_row)
    slack = _frame(mesh.box)[2]
    pinned, within = passed_on[part].astype(np.uint8), tolerance - slack
    surface = Surface(points, faces, _core.pair_halfedges(points, faces, rows, 0.0), rows, welded.source, part)
    label, charted = _charted(looks, surface, pinned != 0)
    # What a picture is on would be missed, however near the rest is.
    stays = pinned | looks.textured()[part]
    needless, dropped = spare(points, faces, part, stays, within)
    decimals = _NONE_MOVES if mesh.quantized else _decimals(tolerance)
    lids, beside, closed = _lids(points, faces, label, pinned, needless, within, options)
    given = np.concatenate([np.arange(len(faces), dtype=np.int32), beside])
    left_out = np.concatenate([needless, np.zeros_like(beside, np.uint8)])
    closed_faces = np.concatenate([faces, lids])
    found = _core.collapse(
        points, closed_faces, label[given], pinned[given], left_out, within, decimals, mesh.single, len(lids), progress
    )
    changed = found.accepted + found.moved > 0 or len(dropped) > 0 or closed > 0
    # A facet may lie on several charts, so that its rows are sought in each by itself.
    patches, patch_of_face = np.unique(
        np.stack([first.facet_of_light[welded.source], label], axis=1), axis=0, return_inverse=True
    )
    patch_of_face = patch_of_face.reshape(-1).astype(np.int32)
    facet_of_patch = np.ascontiguousarray(patches[:, 0])
    facet_of_face = facet_of_patch[patch_of_face]
    patch = patch_of_face[given[found.source]]
    facet = facet_of_patch[patch]
    kept = np.zeros(len(points), np.uint8)
    kept[found.triangles] = 1
    owners = _owners(patch_of_face, part, label, len(patches))
    light, patch_of_light, foreign = _in_rows(mesh, found.triangles, patch, kept, surface, owners, passed_on)
    facet_of_light = facet_of_patch[patch_of_light]
    if found.moved:
        light.points = _moved(mesh.points, welded.point_of_row, found.points)
    looks.follow(light, mesh.points, foreign, owners.group_of_facet[patch_of_light], charted)
    shown = np.zeros(len(first.rung), bool)
    shown[facet] = True
    return Outcome(
        light=light,
        points=found.points,
        triangles=found.triangles,
        facet_of_triangle=facet,
        facet_of_light=facet_of_light,
        facet_of_face=np.where(shown[facet_of_face], facet_of_face, facet[found.holder]),
        source=welded.source,
        planes=first.planes,
        rung=first.rung,
        unchanged=np.full_like(first.unchanged, not changed),
        before=first.after,
        after=_counted(found.triangles, points, light),
        deviation=found.deviation + slack if changed else 0.0,
        texels=float(charted.texels.max(initial=0.0)) if charted is not None and changed else 0.0,
        dropped=dropped,
        closed=closed,
    )


def _lids(
    points: Points, faces: Faces, part: Indices, pinned: Flags, left_out: Flags, tolerance: float, options: Options
) -> tuple[Faces, Indices, int]:
    """Faces that close boundary loops within a tolerance, each with a face beside it, and how many loops they close."""
    if not options.allow_close:
        return np.empty((0, 3), np.int32), np.empty(0, np.int32), 0
    left = np.flatnonzero(left_out == 0).astype(np.int32)
    found = _core.find_lids(points, faces[left], part[left], pinned[left], SPARE_SHARE * tolerance)
    return found.faces, left[found.beside], found.closed


_NONE_MOVES = -1


def _decimals(tolerance: float) -> int:
    """Decimals of a coordinate that are worth storing at a tolerance."""
    return max(0, math.ceil(-math.log10(MOVED_SHARE * tolerance)))


def _moved(points: Points, point_of_row: Indices, moved: Points) -> Points:
    """Rows at where their points have moved to; those that no face uses stay."""
    return np.where((point_of_row >= 0)[:, None], moved[point_of_row], points)


def _passed_on(mesh: Mesh) -> NDArray[np.bool_]:
    return np.array([bool(part.fixed) for part in mesh.parts], bool)


def _charted(looks: Looks, surface: Surface, pinned: NDArray[np.bool_]) -> tuple[Indices, Charted | None]:
    """What no collapse may cross: labels, cut into charts where something is interpolated."""
    label = looks.labels(surface, pinned, 0.0)
    order = np.argsort(label, kind="stable").astype(np.int32)
    start = np.searchsorted(label[order], np.arange(label.min(initial=0), label.max(initial=0) + 2)).astype(np.int32)
    charted = looks.charts(surface, start, order)
    return (label, None) if charted is None else (charted.of_face, charted)


@dataclass
class _Owners:
    """What faces and facets belong to; a group is what no facet may leave."""

    facet_of_face: Indices
    part_of_facet: Indices
    group_of_facet: Indices


def _owners(facet_of_face: Indices, part: Indices, group: Indices, count: int) -> _Owners:
    part_of_facet, group_of_facet = np.zeros(count, np.int32), np.zeros(count, np.int32)
    part_of_facet[facet_of_face] = part
    group_of_facet[facet_of_face] = group
    return _Owners(facet_of_face, part_of_facet, group_of_facet)


def _welded(
    mesh: Mesh, passed_on: NDArray[np.bool_], distance: float, layers: Indices | None
) -> tuple[_core.Welded, float]:
    """A mesh with near points joined, and how far that moved one; corners of parts that are passed on stay."""
    welded = _core.weld(mesh.points, mesh.faces, distance, layers)
    if welded.moved == 0.0 or not passed_on.any():
        return welded, welded.moved
    stays = np.zeros(len(mesh.points), bool)
    stays[mesh.faces[passed_on[mesh.part_of_face]]] = True
    used = welded.point_of_row >= 0
    at = np.where(used[:, None], welded.points[welded.point_of_row], mesh.points)
    rows, targets = _nearest_staying(mesh.points, welded.point_of_row, stays)
    at[rows] = mesh.points[targets]
    at[stays] = mesh.points[stays]
    moved = float(np.sqrt(((at - mesh.points)[used] ** 2).sum(axis=1).max()))
    # What is where it shall be is welded exactly: points are in lexicographic order again.
    return _core.weld(at, mesh.faces, 0.0, layers), moved


def _nearest_staying(points: Points, cluster: Indices, stays: NDArray[np.bool_]) -> tuple[Indices, Indices]:
    """Rows that share a cluster with rows that stay, and the nearest of those; ties go by coordinates."""
    staying, moving = np.flatnonzero(stays), np.flatnonzero(~stays & (cluster >= 0))
    staying = staying[np.argsort(cluster[staying], kind="stable")]
    first = np.searchsorted(cluster[staying], cluster[moving])
    count = np.searchsorted(cluster[staying], cluster[moving], side="right") - first
    row = np.repeat(moving, count)
    within = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
    target = staying[np.repeat(first, count) + within]
    gap = points[target] - points[row]
    order = np.lexsort((*points[target].T[::-1], (gap**2).sum(axis=1), row))
    nearest = order[np.unique(row[order], return_index=True)[1]]
    return row[nearest].astype(np.int32), target[nearest].astype(np.int32)


def _at_their_points(mesh: Mesh, light: Light, welded: _core.Welded) -> tuple[Faces, NDArray[np.int64]]:
    """Corners by rows that lie where the welded points are, and which corners got other rows by that.

    Rows of the same part are taken where it has one there.
    """
    point = welded.point_of_row.astype(np.int64)
    there = (point >= 0) & (mesh.points == welded.points[point]).all(axis=1)
    stored = there[mesh.faces]
    rows, key = mesh.faces[stored], mesh.part_of_face.astype(np.int64) * len(welded.points)
    faces, away = light.faces.copy(), ~there[light.faces]
    wanted = point[faces[away]]
    part_key = np.repeat(light.part_of_face.astype(np.int64) * len(welded.points), away.sum(axis=1))
    anywhere, _ = _looked_up(point[rows], rows, wanted)
    own, found = _looked_up(point[rows] + np.repeat(key, stored.sum(axis=1)), rows, wanted + part_key)
    faces[away] = np.where(found, own, anywhere)
    return faces, np.flatnonzero(away)


def _looked_up(
    keys: NDArray[np.int64], values: Indices, wanted: NDArray[np.int64]
) -> tuple[Indices, NDArray[np.bool_]]:
    """The least value of each wanted key, and whether there is one."""
    order = np.lexsort((values, keys))
    place = np.minimum(np.searchsorted(keys[order], wanted), len(keys) - 1)
    return values[order][place], keys[order][place] == wanted


def counted(mesh: Mesh, options: Options) -> Counts:
    """A mesh in numbers, as `simplify_mesh` counts before it does anything."""
    welded, _ = _welded(mesh, _passed_on(mesh), options.weld, Looks(mesh, options).layers())
    count = len(welded.points)
    return _counts(count, len(mesh.faces), *_core.count_edges(welded.faces, count))


def _counted(triangles: Faces, points: Points, light: Light) -> Counts:
    used = int(np.count_nonzero(np.bincount(triangles.reshape(-1))))
    return _counts(used, len(light.faces), *_core.count_edges(triangles, len(points)))


def _counts(points: int, triangles: int, open_edges: int, nonmanifold_edges: int) -> Counts:
    return Counts(
        points=points,
        triangles=triangles,
        watertight=triangles > 0 and open_edges == nonmanifold_edges == 0,
        open_edges=open_edges,
        nonmanifold_edges=nonmanifold_edges,
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


def _frame(box: Points) -> tuple[tuple[float, float, float], float, float]:
    """Middle and diagonal of a box, and how far rounding blurs a distance there."""
    if not np.isfinite(box).all():
        return (0.0, 0.0, 0.0), 0.0, 0.0
    low, high = box
    x, y, z = (float(v) for v in low + (high - low) / 2)
    return (x, y, z), math.dist(low, high), 2 * float(np.spacing(np.abs(box).max()))


def _in_rows(
    mesh: Mesh,
    triangles: Faces,
    facet: Indices,
    kept: Flags,
    surface: Surface,
    owners: _Owners,
    passed_on: NDArray[np.bool_],
) -> tuple[Light, Indices, Indices]:
    """The result in rows of the mesh, its facets, and the corners whose rows are those of another group.

    Parts that are passed on keep their faces to the letter.
    """
    found, foreign = _core.find_rows(
        triangles, facet, surface.faces, surface.rows, owners.facet_of_face, owners.group_of_facet,
        owners.part_of_facet, kept,
    )  # fmt: skip
    face_of_facet = np.zeros(len(owners.part_of_facet), np.int32)
    face_of_facet[owners.facet_of_face] = surface.source
    row = np.arange(len(mesh.points), dtype=np.int32)
    part = owners.part_of_facet[facet]
    if not passed_on.any():
        return Light(mesh.points, found, part, row, face_of_facet[facet]), facet, foreign
    fresh = ~passed_on[part]
    place = np.cumsum(fresh) - 1
    foreign = foreign[fresh[foreign // 3]]
    foreign = (3 * place[foreign // 3] + foreign % 3).astype(np.int32)
    untouched = passed_on[mesh.part_of_face]
    facet_of_input = np.full(len(mesh.faces), -1, np.int32)
    facet_of_input[surface.source] = owners.facet_of_face
    light = Light(
        mesh.points,
        np.concatenate([found[fresh], mesh.faces[untouched]]),
        np.concatenate([part[fresh], mesh.part_of_face[untouched]]),
        row,
        np.concatenate([face_of_facet[facet[fresh]], np.flatnonzero(untouched).astype(np.int32)]),
    )
    return light, np.concatenate([facet[fresh], facet_of_input[untouched]]), foreign
