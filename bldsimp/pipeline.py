"""The pipeline: from a mesh to the fewest points that keep its surface."""

from __future__ import annotations

import dataclasses
import hashlib
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from .errors import InternalError
from .model import Flags, Indices, Mesh, measure_box
from .options import AUTO_DIAGONAL, DEFAULTS, STAGED_DIAGONAL, Options
from .result import MeshResult, StageResults, compose_result, resolve_corners
from .stages.attributes import KeptAttributes, label_surface
from .stages.collapse import collapse_edges
from .stages.facets import derive_limits
from .stages.orient import orient
from .stages.planar import merge_after_collapses, merge_coplanar
from .stages.removal import remove_details
from .stages.surface import FREE, GOES, STAYS
from .stages.weld import WeldedMesh, weld
from .tolerance import measure_frame


@dataclass(frozen=True)
class DecidedPoints:
    """Points of a mesh that the caller keeps or drops, for example on borders that meshes share.

    Attributes
    ----------
    rows : (k,) int32
        Rows of the mesh's points.
    stays : (k,) bool
        Whether the point stays at its place; one that does not is dropped from its chain, unless its facets need it.
    """

    rows: Indices
    stays: NDArray[np.bool_]


def simplify_mesh(
    mesh: Mesh,
    tolerance: float,
    options: Options = DEFAULTS,
    *,
    welded: WeldedMesh | None = None,
    decided: DecidedPoints | None = None,
    keep_layout: bool = False,
    progress: _core.Progress | None = None,
) -> MeshResult:
    """Simplify one mesh.

    Parameters
    ----------
    mesh : Mesh
    tolerance : float
        How far any point of the surface may move; model units of the mesh's own frame.
    options : Options
        `weld` (model units of the mesh's own frame), `delimit` and what else the stages name.
    welded : WeldedMesh, optional
        The mesh as `weld_mesh` gives it, if that was called before.
    decided : DecidedPoints, optional
        Points that the caller keeps or drops.
    keep_layout : bool
        Keep what another triangulation of the same facets needs.
    progress : Progress, optional
        Counts points that a wide tolerance drops, while it does.

    Returns
    -------
    MeshResult

    Raises
    ------
    InternalError
        Where an invariant of a kernel is broken; names the stage. With the environment variable BLDSIMP_DUMP the
        mesh is written to the folder that it names.

    Notes
    -----
    Nearly linear in the number of faces. The result depends on the coordinates alone: every stage works
    on points and faces in lexicographic order.

    With a wide tolerance coplanar faces are merged first. Edges of the rest collapse within the tolerance, and
    coplanar faces are merged again, so that triangles are well shaped.
    """
    try:
        attributes = KeptAttributes(mesh, options)
        welded = weld_mesh(mesh, options) if welded is None else welded
        box = measure_box(welded.points)
        # The tolerance that loses no visible detail.
        exact = AUTO_DIAGONAL * measure_frame(box)[1]
        wide = tolerance > STAGED_DIAGONAL / AUTO_DIAGONAL * exact
        limits = derive_limits(box, exact if wide else tolerance, welded.moved)
        pinned = mesh.passed_on[mesh.part_of_face[welded.source]]
        faces, halfedges, turned = orient(welded.points, welded.faces, welded.rows, pinned, limits.width)
        welded = dataclasses.replace(welded, faces=faces)
        surface, facets, charts = label_surface(
            attributes, welded, halfedges, _flag_points(welded, decided), limits, across_facets=wide
        )
        given = StageResults(welded, halfedges, len(turned), charts)
        given.merged.append(merge_coplanar(surface, halfedges, facets, limits))
        left = tolerance - given.deviation - exact
        # Where nothing has area, or welding has used the tolerance up, there is nothing to collapse.
        if wide and len(welded.faces) and left > exact:
            surface = given.merged[0].take_result().without_copies(attributes.find_layers())
            given.details = remove_details(mesh, welded, surface, attributes.find_textured_parts(), left, options)
            given.collapsed = collapse_edges(mesh, surface, given.details, left, progress)
            corners = resolve_corners(mesh, given)
            given.merged.append(merge_after_collapses(given.collapsed.surface, corners, exact))
        return compose_result(mesh, attributes, given, keep_layout=keep_layout)
    except _core.KernelError as error:
        advice = _dump_input(mesh, tolerance, options)
        raise InternalError(f"{error}: a bug in bldsimp, {advice}") from error


def _dump_input(mesh: Mesh, tolerance: float, options: Options) -> str:
    """Write the input of a failing run to the folder that BLDSIMP_DUMP names; say where, or how to get it."""
    folder = os.environ.get("BLDSIMP_DUMP")
    if not folder:
        return "please report it; BLDSIMP_DUMP=FOLDER writes the failing mesh to a folder"
    path = Path(folder, f"bldsimp-{hashlib.sha256(mesh.points.tobytes() + mesh.faces.tobytes()).hexdigest()[:12]}.npz")
    path.parent.mkdir(parents=True, exist_ok=True)
    arrays: dict[str, Any] = {one.name: one.values for one in mesh.attributes}
    arrays |= {"points": mesh.points, "faces": mesh.faces, "part_of_face": mesh.part_of_face}
    arrays |= {"parts": [part.name for part in mesh.parts], "tolerance": tolerance, "options": repr(options)}
    np.savez(path, **arrays)
    return f"please report it with {path}"


def weld_mesh(mesh: Mesh, options: Options, chosen: Indices | None = None) -> WeldedMesh:
    """Weld a mesh, or some of its faces, as `simplify_mesh` does; `options.weld` in the mesh's own frame."""
    return weld(mesh, options.weld, KeptAttributes(mesh, options).find_layers(), chosen)


def _flag_points(welded: WeldedMesh, decided: DecidedPoints | None) -> Flags:
    """Return a flag for each welded point: `FREE`, `STAYS` or `GOES`."""
    flags = np.full(len(welded.points), FREE, np.uint8)
    if decided is not None:
        points = welded.point_of_row[decided.rows]
        flags[points[~decided.stays]] = GOES
        flags[points[decided.stays]] = STAYS
    return flags
