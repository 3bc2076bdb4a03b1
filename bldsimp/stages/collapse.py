"""Collapse edges and move points, within a wide tolerance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .. import _core
from ..model import Indices, Mesh, measure_box
from ..tolerance import measure_frame
from .removal import Details, count_decimals
from .surface import STAYS, Surface


@dataclass(frozen=True)
class CollapsedSurface:
    """What edge collapses have left of a surface.

    Attributes
    ----------
    surface : Surface
    facet_before, facet_after : (m,) int32
        For each face of the surface before, its facet, and the facet that is left of it or holds some of it.
    deviation : float
        How far the surface has moved at most; model units. 0 where nothing changed.
    changed : bool
    """

    surface: Surface
    facet_before: Indices
    facet_after: Indices
    deviation: float
    changed: bool


def collapse_edges(
    mesh: Mesh, surface: Surface, details: Details, tolerance: float, progress: _core.Progress | None
) -> CollapsedSurface:
    """Collapse edges of a surface, the ones that change it least first, and move points to where their planes meet.

    Parameters
    ----------
    mesh : Mesh
        How its numbers are stored tells how finely points may move.
    surface : Surface
        Its labels are not crossed.
    details : Details
        What is removed and filled.
    tolerance : float
        Model units.
    progress : Progress or None
        Counts the points that are dropped, while they are.

    Notes
    -----
    About O(n log n), on all cores. The topology does not change. No point of either surface, or of its borders, is
    farther than the tolerance from the other. See `_core/collapse`.
    """
    assert surface.facet is not None
    slack = measure_frame(measure_box(surface.points))[2]
    given = np.concatenate([np.arange(len(surface.faces), dtype=np.int32), details.parent])
    left_out = np.concatenate([details.left_out, np.zeros(len(details.parent), np.uint8)])
    pinned = (surface.label < 0).astype(np.uint8)
    found = _core.collapse(
        surface.points,
        np.concatenate([surface.faces, details.caps]),
        surface.label[given],
        pinned[given],
        left_out,
        tolerance - slack,
        count_decimals(mesh, tolerance),
        mesh.single,
        len(details.caps),
        progress,
        (surface.decided == STAYS).astype(np.uint8),
        details.points,
    )
    changed = found.accepted + found.moved > 0 or details.change_anything
    parent = given[found.source]
    facet = surface.facet[parent]
    shown = np.zeros(int(surface.facet.max(initial=-1)) + 1, bool)
    shown[facet] = True
    return CollapsedSurface(
        surface.with_faces(found.triangles, parent, points=found.points),
        surface.facet,
        np.where(shown[surface.facet], surface.facet, facet[found.holder]),
        found.deviation + slack if changed else 0.0,
        changed,
    )
