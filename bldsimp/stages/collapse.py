"""Edges collapsed and points moved, within a wide tolerance."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model import Faces, Flags, Indices, Mesh, Points
from ..options import MOVED_SHARE, SPARE_SHARE, Options
from ..result import MeshResult, counts_of
from ..tolerance import frame
from .attributes import Charted, Looks, Surface
from .provenance import in_rows, owners_of
from .removal import spare

_NONE_MOVES = -1


def collapsed(
    mesh: Mesh, first: MeshResult, tolerance: float, options: Options, progress: _core.Progress | None
) -> MeshResult:
    """Edges collapsed, on a mesh that is what facets left.

    Parameters
    ----------
    mesh : Mesh
    first : MeshResult
        That the mesh is left of; facets are those of it.
    tolerance : float
        Model units of the mesh's own frame.
    options : Options
    progress : Progress or None
    """
    looks = Looks(mesh, options)
    welded = _core.weld(mesh.points, mesh.faces, 0.0, looks.layers())
    points, faces, part = welded.points, welded.faces, mesh.part_of_face[welded.source]
    rows = _core.Rows(mesh.faces, welded.point_of_row, welded.source, welded.class_of_row)
    slack = frame(mesh.box)[2]
    pinned, within = mesh.passed_on[part].astype(np.uint8), tolerance - slack
    surface = Surface(points, faces, _core.pair_halfedges(points, faces, rows, 0.0), rows, welded.source, part)
    label, charted = _charted(looks, surface, pinned != 0)
    # What a picture is on would be missed, however near the rest is.
    stays = pinned | looks.textured()[part]
    one_sided = np.array([one.one_sided for one in mesh.parts], np.uint8)[part]
    needless, dropped = spare(points, faces, part, stays, one_sided, within)
    decimals = _NONE_MOVES if mesh.quantized else _decimals(tolerance)
    lids, beside, closed = _lids(points, faces, label, pinned, needless, within, options)
    given = np.concatenate([np.arange(len(faces), dtype=np.int32), beside])
    left_out = np.concatenate([needless, np.zeros_like(beside, np.uint8)])
    found = _core.collapse(
        points, np.concatenate([faces, lids]), label[given], pinned[given], left_out, within, decimals, mesh.single,
        len(lids), progress,
    )  # fmt: skip
    changed = found.accepted + found.moved > 0 or len(dropped) > 0 or closed > 0
    facet_of_face = first.facet_of_light[welded.source]
    patch_of_face, facet_of_patch = _patches(facet_of_face, label)
    patch = patch_of_face[given[found.source]]
    facet = facet_of_patch[patch]
    kept = np.zeros(len(points), np.uint8)
    kept[found.triangles] = 1
    owners = owners_of(patch_of_face, part, label, len(facet_of_patch))
    untouched = np.full(len(facet_of_patch), not changed, np.uint8)
    light, patch_of_light, foreign = in_rows(mesh, found.triangles, patch, untouched, kept, surface, owners)
    if found.moved:
        light.points = _moved(mesh.points, welded.point_of_row, found.points)
    looks.follow(light, mesh.points, foreign, owners.group_of_facet[patch_of_light], charted)
    shown = np.zeros(len(first.rung), bool)
    shown[facet] = True
    return MeshResult(
        light=light,
        points=found.points,
        triangles=found.triangles,
        facet_of_triangle=facet,
        facet_of_light=np.where(patch_of_light < 0, np.int32(-1), facet_of_patch[patch_of_light]),
        facet_of_face=np.where(shown[facet_of_face], facet_of_face, facet[found.holder]),
        source=welded.source,
        planes=first.planes,
        rung=first.rung,
        unchanged=np.full_like(first.unchanged, not changed),
        before=first.after,
        after=counts_of(found.triangles, points, light),
        deviation=found.deviation + slack if changed else 0.0,
        texels=float(charted.texels.max(initial=0.0)) if charted is not None and changed else 0.0,
        dropped=dropped,
        closed=closed,
    )


def _charted(looks: Looks, surface: Surface, pinned: NDArray[np.bool_]) -> tuple[Indices, Charted | None]:
    """What no collapse may cross: labels, cut into charts where something is interpolated."""
    label = looks.labels(surface, pinned, 0.0)
    order = np.argsort(label, kind="stable").astype(np.int32)
    start = np.searchsorted(label[order], np.arange(label.min(initial=0), label.max(initial=0) + 2)).astype(np.int32)
    charted = looks.charts(surface, start, order)
    return (label, None) if charted is None else (charted.of_face, charted)


def _patches(facet_of_face: Indices, label: Indices) -> tuple[Indices, Indices]:
    """The patch of each face, and the facet of each patch: a facet may lie on several charts, with rows of each."""
    patches, patch_of_face = np.unique(np.stack([facet_of_face, label], axis=1), axis=0, return_inverse=True)
    return patch_of_face.reshape(-1).astype(np.int32), np.ascontiguousarray(patches[:, 0])


def _lids(
    points: Points, faces: Faces, part: Indices, pinned: Flags, left_out: Flags, tolerance: float, options: Options
) -> tuple[Faces, Indices, int]:
    """Faces that close boundary loops within a tolerance, each with a face beside it, and how many loops they close."""
    if not options.allow_close:
        return np.empty((0, 3), np.int32), np.empty(0, np.int32), 0
    left = np.flatnonzero(left_out == 0).astype(np.int32)
    found = _core.find_lids(points, faces[left], part[left], pinned[left], SPARE_SHARE * tolerance)
    return found.faces, left[found.beside], found.closed


def _decimals(tolerance: float) -> int:
    """Decimals of a coordinate that are worth storing at a tolerance."""
    return max(0, math.ceil(-math.log10(MOVED_SHARE * tolerance)))


def _moved(points: Points, point_of_row: Indices, moved: Points) -> Points:
    """Rows at where their points have moved to; those that no face uses stay."""
    return np.where((point_of_row >= 0)[:, None], moved[point_of_row], points)
