"""Count what a scene contains before it is simplified: sizes, defects, number format."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from . import _core
from .model import Faces, Mesh, Points, Scene, cast_indices
from .options import Tolerance
from .pipeline import simplify_mesh
from .report import UnchangedPart, explain_unchanged
from .tolerance import measure_diagonal, measure_scale, measure_spacing, resolve_tolerance

SCHEMA = "bldsimp.inspection/2"


@dataclass
class Defects:
    """A mesh in numbers, its positions welded exactly.

    Attributes
    ----------
    points : int
        Distinct positions that a face uses.
    triangles : int
    open_edges, nonmanifold_edges : int
        Edges of one face; of more than two. Faces that repeat a point and copies of a face do not count.
    degenerate_faces : int
        Faces without area: a position repeated, or three in one line.
    duplicate_faces : int
        Copies of a face with the same winding, beyond the first.
    watertight : bool
        Every edge belongs to exactly two faces.
    """

    points: int
    triangles: int
    open_edges: int
    nonmanifold_edges: int
    degenerate_faces: int
    duplicate_faces: int
    watertight: bool


@dataclass
class MeshInspection:
    """One mesh of a scene; lengths in its own frame.

    Each attribute has a `name`, a `kind`, and says whether it is `on` ``vertices`` or ``faces``.
    """

    name: str
    parts: int
    instances: int
    points: int
    vertices: int
    triangles: int
    facets: int
    open_edges: int
    nonmanifold_edges: int
    degenerate_faces: int
    duplicate_faces: int
    watertight: bool
    numbers: str
    spacing: float
    attributes: list[dict[str, str]]
    unchanged_parts: list[UnchangedPart]


@dataclass
class Inspection:
    """A whole scene: its meshes, and the tolerance that `auto` means for it; lengths in world space."""

    format: str
    bytes: int
    diagonal: float
    auto_tolerance: float
    meshes: list[MeshInspection] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    schema: str = SCHEMA

    def to_dict(self) -> dict[str, Any]:
        """Convert the inspection to plain values, with the totals over all meshes."""
        values = asdict(self)
        for mesh in values["meshes"]:
            # The name of bldsimp.inspection/1; the next version leaves it out.
            mesh["passed_on"] = mesh["unchanged_parts"]
        return {"schema": values.pop("schema"), "total": self.total(), **values}

    def total(self) -> dict[str, Any]:
        """Sum over the meshes, each counted once."""
        keys = ["parts", "points", "vertices", "triangles", "facets", "open_edges", "nonmanifold_edges"]
        keys += ["degenerate_faces", "duplicate_faces"]
        total: dict[str, Any] = {key: sum(getattr(mesh, key) for mesh in self.meshes) for key in keys}
        total["watertight"] = all(mesh.watertight for mesh in self.meshes)
        return total


def inspect_scene(scene: Scene) -> Inspection:
    """Count what a scene contains.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Inspection
    """
    tolerance = resolve_tolerance(scene, Tolerance())
    meshes = [_inspect_mesh(mesh, tolerance) for mesh in scene.meshes]
    return Inspection(scene.format, scene.size, measure_diagonal(scene), tolerance, meshes, list(scene.warnings))


def count_defects(points: Points, faces: Faces) -> Defects:
    """Count a mesh's points, edges and defects.

    Parameters
    ----------
    points : (n, 3) float64
    faces : (m, 3) int

    Returns
    -------
    Defects

    Notes
    -----
    O(m) with a hash of the positions.
    """
    faces = cast_indices(faces).reshape(-1, 3)
    welded = _core.weld(points, faces, 0.0)
    open_edges, nonmanifold_edges = _core.count_edges(welded.faces, len(welded.points))
    a, b, c = (points[corner] for corner in faces.T)
    with np.errstate(invalid="ignore"):
        flat = ~np.cross(b - a, c - a).any(axis=1)
    return Defects(
        points=len(welded.points),
        triangles=len(faces),
        open_edges=open_edges,
        nonmanifold_edges=nonmanifold_edges,
        degenerate_faces=int(np.count_nonzero(flat)),
        duplicate_faces=welded.duplicate,
        watertight=len(welded.faces) > 0 and open_edges == nonmanifold_edges == 0,
    )


def _inspect_mesh(mesh: Mesh, tolerance: float) -> MeshInspection:
    """Count what a mesh contains; the tolerance for its facets is in world space."""
    local = tolerance / (measure_scale(mesh) or 1.0)
    return MeshInspection(
        name=mesh.name,
        parts=len(mesh.parts),
        instances=len(mesh.transforms),
        vertices=len(np.unique(mesh.faces)),
        facets=len(simplify_mesh(mesh, local).planes),
        numbers=describe_numbers(mesh),
        spacing=measure_spacing(mesh),
        attributes=[
            {"name": one.name, "kind": one.kind, "on": "faces" if one.on_faces else "vertices"}
            for one in mesh.attributes
        ],
        unchanged_parts=[explain_unchanged(part) for part in mesh.parts if part.fixed],
        **vars(count_defects(mesh.points, mesh.faces)),
    )


def describe_numbers(mesh: Mesh) -> str:
    """Describe a mesh's number format: ``single``, ``double`` or the step between decimal numbers."""
    if mesh.single:
        return "single"
    if mesh.rounding:
        return f"steps of {2.0 * mesh.rounding:.3g}"
    return "double"
