"""The pipeline: from a mesh to the fewest points that keep its surface."""

from __future__ import annotations

import dataclasses

from . import _core
from .model import Mesh
from .options import AUTO_DIAGONAL, DEFAULTS, STAGED_DIAGONAL, Options
from .report import Counts
from .result import MeshResult, counts
from .stages.attributes import Looks, left
from .stages.collapse import collapsed
from .stages.planar import lossless
from .stages.weld import weld
from .tolerance import frame


def simplify_mesh(
    mesh: Mesh,
    tolerance: float,
    options: Options = DEFAULTS,
    *,
    with_layout: bool = False,
    progress: _core.Progress | None = None,
) -> MeshResult:
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
    MeshResult

    Notes
    -----
    Nearly linear in the number of faces. The result depends on the coordinates alone: every stage works
    on points and faces in lexicographic order.

    A wide tolerance is spent by collapses on what facets leave without loss. What they leave is made of facets
    again, so that its triangles are as well shaped as any.
    """
    fine = AUTO_DIAGONAL * frame(mesh.box)[1]
    if tolerance <= STAGED_DIAGONAL / AUTO_DIAGONAL * fine:
        return lossless(mesh, tolerance, options, with_layout=with_layout)
    first = lossless(mesh, fine, options, with_layout=with_layout)
    rest = tolerance - first.deviation - fine
    # Where nothing has area, or welding has used the tolerance up, there is nothing to collapse.
    if not len(first.rung) or rest <= fine:
        return first
    second = collapsed(left(mesh, first.light), first, rest, options, progress)
    done = first.followed_by(second)
    welded = dataclasses.replace(options, weld=0.0)
    return done.followed_by(lossless(left(mesh, done.light), fine, welded, with_layout=with_layout))


def counted(mesh: Mesh, options: Options) -> Counts:
    """A mesh in numbers, as `simplify_mesh` counts before it does anything."""
    welded, _ = weld(mesh, options.weld, Looks(mesh, options).layers())
    count = len(welded.points)
    return counts(count, len(mesh.faces), *_core.count_edges(welded.faces, count))
