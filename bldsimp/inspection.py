"""What is in a scene before anything is done: counts, defects, number format."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .model import Faces, Mesh, Scene
from .options import Tolerance
from .pipeline import simplify_mesh
from .report import PassedOn, one_line, passed_on
from .tolerance import diagonal, resolve_tolerance, scale, spacing
from .unique_rows import find_unique_rows

SCHEMA = "bldsimp.inspection/1"


@dataclass
class Surface:
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
class Carried:
    """What a mesh carries beside its surface: an attribute, its kind, whether ``vertices`` or ``faces`` have it."""

    name: str
    kind: str
    on: str


@dataclass
class MeshInspection:
    """One mesh of a scene; lengths in its own frame."""

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
    attributes: list[Carried]
    passed_on: list[PassedOn]


@dataclass
class Inspection:
    """A whole scene: its meshes, and what `auto` would do to it; lengths in world space."""

    format: str
    bytes: int
    diagonal: float
    auto_tolerance: float
    meshes: list[MeshInspection] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    schema: str = SCHEMA

    def to_dict(self) -> dict[str, Any]:
        """Plain values, with the totals over all meshes."""
        values = asdict(self)
        return {"schema": values.pop("schema"), "total": self.total(), **values}

    def total(self) -> dict[str, Any]:
        """Sums over the meshes, each counted once."""
        keys = ["parts", "points", "vertices", "triangles", "facets", "open_edges", "nonmanifold_edges"]
        keys += ["degenerate_faces", "duplicate_faces"]
        total: dict[str, Any] = {key: sum(getattr(mesh, key) for mesh in self.meshes) for key in keys}
        total["watertight"] = all(mesh.watertight for mesh in self.meshes)
        return total


def inspect_scene(scene: Scene) -> Inspection:
    """Look at a scene.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Inspection
    """
    tolerance = resolve_tolerance(scene, Tolerance())
    meshes = [_inspect_mesh(mesh, tolerance) for mesh in scene.meshes]
    return Inspection(scene.format, scene.size, diagonal(scene), tolerance, meshes, list(scene.warnings))


def surface_of(points: NDArray[np.float64], faces: Faces) -> Surface:
    """Count a mesh's points, edges and defects.

    Parameters
    ----------
    points : (n, 3) float64
    faces : (m, 3) int

    Returns
    -------
    Surface

    Notes
    -----
    O(m log m).
    """
    if not len(faces):
        return Surface(0, 0, 0, 0, 0, 0, False)
    used, compact = np.unique(faces, return_inverse=True)
    own = points[used]
    first, position = find_unique_rows(own)
    welded = position[compact.reshape(-1)].reshape(-1, 3)
    a, b, c = welded.T
    proper = (a != b) & (b != c) & (a != c)
    u, v = own[first[b]] - own[first[a]], own[first[c]] - own[first[a]]
    flat = ~np.cross(u, v).any(axis=1)
    single = _first_copies(welded[proper])
    counts = _edge_counts(welded[proper][single], len(first))
    return Surface(
        points=len(first),
        triangles=len(faces),
        open_edges=int((counts == 1).sum()),
        nonmanifold_edges=int((counts > 2).sum()),
        degenerate_faces=int((flat | ~proper).sum()),
        duplicate_faces=int(proper.sum() - len(single)),
        watertight=bool(len(counts)) and bool(np.all(counts == 2)),
    )


def _first_copies(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """Faces that are no copies, turned or not, of an earlier one with the same winding."""
    turn = np.argmin(faces, axis=1)[:, None] if len(faces) else np.zeros((0, 1), int)
    cyclic = np.take_along_axis(faces, (turn + np.arange(3)) % 3, axis=1)
    return find_unique_rows(cyclic)[0]


def _edge_counts(faces: NDArray[np.int64], points: int) -> NDArray[np.int64]:
    """Number of faces at each edge."""
    following = np.roll(faces, -1, axis=1)
    key = np.minimum(faces, following) * np.int64(points) + np.maximum(faces, following)
    key = np.sort(key.reshape(-1))
    starts = np.flatnonzero(np.concatenate([[True], np.diff(key) != 0])) if len(key) else np.zeros(0, int)
    return np.diff(np.append(starts, len(key)))


def _inspect_mesh(mesh: Mesh, tolerance: float) -> MeshInspection:
    surface = surface_of(mesh.points, mesh.faces)
    return MeshInspection(
        name=mesh.name,
        parts=len(mesh.parts),
        instances=len(mesh.transforms),
        points=surface.points,
        vertices=len(np.unique(mesh.faces)),
        triangles=surface.triangles,
        facets=_facets(mesh, tolerance),
        open_edges=surface.open_edges,
        nonmanifold_edges=surface.nonmanifold_edges,
        degenerate_faces=surface.degenerate_faces,
        duplicate_faces=surface.duplicate_faces,
        watertight=surface.watertight,
        numbers=number_words(mesh),
        spacing=spacing(mesh),
        attributes=[Carried(one.name, one.kind, "faces" if one.on_faces else "vertices") for one in mesh.attributes],
        passed_on=[passed_on(part) for part in mesh.parts if part.fixed],
    )


def number_words(mesh: Mesh) -> str:
    """A mesh's number format for people."""
    if mesh.single:
        return "single"
    if mesh.rounding:
        return f"steps of {2.0 * mesh.rounding:.3g}"
    return "double"


def _facets(mesh: Mesh, tolerance: float) -> int:
    """Number of facets at a tolerance in world space."""
    local = tolerance / (scale(mesh) or 1.0)
    return len(simplify_mesh(mesh, local).planes)


def inspection_text(inspection: Inspection) -> str:
    """An inspection in lines for people."""
    total = inspection.total()
    lines = [f"format      {inspection.format}, {inspection.bytes:,} bytes"]
    lines.append(f"diagonal    {inspection.diagonal:.6g}")
    lines.append(f"auto        {inspection.auto_tolerance:.3g}")
    entries = [(f"mesh        {mesh.name or '(no name)'}", asdict(mesh)) for mesh in inspection.meshes]
    if len(entries) != 1:
        entries.append((f"total       {len(inspection.meshes):,} meshes", total))
    for head, values in entries:
        lines.append(head)
        lines += [f"  {key.replace('_', ' '):18s}{_shown(value)}" for key, value in values.items() if key != "name"]
    lines += [f"warning     {text}" for text in inspection.warnings]
    return "\n".join(map(one_line, lines))


def _in_words(entry: dict[str, str]) -> str:
    """An attribute, or a part that is passed on, for people."""
    if "reason" in entry:
        return f"{entry['name']}: {entry['reason']}"
    return f"{entry['name']} ({entry['kind']}{', of faces' if entry['on'] == 'faces' else ''})"


def _shown(value: Any) -> str:
    """A value for people."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        return ", ".join(_in_words(each) for each in value) or "none"
    return f"{value:,}" if isinstance(value, int) else f"{value:.3g}" if isinstance(value, float) else str(value)
