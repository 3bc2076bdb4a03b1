"""Define the report of a run; docs/report.md describes its schema, and `cli.summary` formats it for people."""

from __future__ import annotations

import json
import warnings
from dataclasses import asdict, dataclass, field
from typing import Any

from .model import Part

SCHEMA = "bldsimp.report/2"
"""Name and version of the JSON; the number rises when a field is removed or changes its meaning."""

OLD_NAMES = {
    "rungs": "facet_levels",
    "reasons": "fallback_reasons",
    "healed": "healed_t_junctions",
    "touching": "contact_points",
    "closed": "closed_boundary_loops",
    "turned": "reversed_faces",
    "degenerate": "removed_degenerate_faces",
    "duplicate": "removed_duplicate_faces",
    "dropped": "removed_components",
    "passed_on": "unchanged_parts",
}
"""Keys of ``bldsimp.report/1`` and the names that they have now. Deprecated: the next version leaves them out."""

_OLD_REASONS = {"smaller_than_min_component": "smaller_than_min_part"}


def _alias(old: str, name: str) -> Any:
    """Make a deprecated attribute that reads and writes another one."""

    def warn() -> None:
        warnings.warn(f"{old} is deprecated: use {name}", DeprecationWarning, stacklevel=3)

    def read(report: Report) -> Any:
        warn()
        return getattr(report, name)

    def write(report: Report, value: Any) -> None:
        warn()
        setattr(report, name, value)

    return property(read, write)


@dataclass
class Counts:
    """A scene in numbers; each mesh counts once, however often it is instanced.

    Attributes
    ----------
    points : int
        Distinct positions that a face uses.
    vertices : int
        Distinct positions with normal and attributes that a face uses.
    triangles : int
    watertight : bool
        Exactly two faces use every edge.
    open_edges, nonmanifold_edges : int
        Edges that one face uses; that more than two faces use.
    bytes : int or None
        Size of the file and of its separate buffers; None where nothing was read or written.
    """

    points: int = 0
    vertices: int = 0
    triangles: int = 0
    watertight: bool = False
    open_edges: int = 0
    nonmanifold_edges: int = 0
    bytes: int | None = None


@dataclass
class UnchangedPart:
    """A part that was copied without a change, and why."""

    name: str
    reason: str


def explain_unchanged(part: Part) -> UnchangedPart:
    """Say why a part is copied without a change: it has data that cannot be updated."""
    return UnchangedPart(part.name, f"cannot update {', '.join(part.fixed)}")


@dataclass
class RemovedComponent:
    """A component that was removed as a whole.

    Attributes
    ----------
    part : str
        Name of the part that most of its triangles belong to.
    triangles : int
        How many triangles it had when it was removed.
    box : list of list of float
        Least and greatest coordinates, (2, 3), world space; of an instanced mesh, at its first instance.
    reason : str
        ``within_tolerance`` of the rest, or ``smaller_than_min_component``.
    """

    part: str
    triangles: int
    box: list[list[float]]
    reason: str


@dataclass(frozen=True)
class RemovedDetail:
    """A detail that a wide tolerance removed as a whole.

    Attributes
    ----------
    part : str
        Name of the part that it was on.
    triangles : int
        How many were removed.
    box : list of list of float
        Least and greatest coordinates, (2, 3), world space; of an instanced mesh, at its first instance.
    kind : str
        ``detail`` (a recess, a sill, a chimney), ``passage``, ``boundary_loop`` or ``step``.
    """

    part: str
    triangles: int
    box: list[list[float]]
    kind: str


@dataclass
class Report:
    """What a run did. Lengths are model units in world space.

    Attributes
    ----------
    tolerance : float
    deviation : float
        Certified bound of the distance between input and output surface, both ways. It includes `rounding`, and
        leaves out components that are smaller than `Options.min_component`.
    diagonal : float
        Of the box of all points that a face uses.
    epsilon : float
        Spacing of the numbers that the input went through (single precision, even where its numbers
        are written as decimals now).
    rounding : float
        Greatest distance by which writing moved a point.
    before, after : Counts
    texels : float or None
        Certified bound of how far a texture has moved on its wall, along u or v; None where nothing is textured.
    facets : int
    facet_levels : dict of str to int
        Facets at each level of the fallback, the best level first.
    fallback_reasons : dict of str to int
        Why facets are not at the best level.
    healed_t_junctions : int
    contact_points : int
        Points kept only because surfaces touch there inside of facets.
    closed_boundary_loops : int
        Loops of open edges as small as a wide tolerance.
    details_kept_by_label : int
        Details that stay because the facets around them have several labels.
    reversed_faces : int
        Faces whose winding was reversed.
    removed_degenerate_faces, removed_duplicate_faces : int
        Faces removed because they repeat a point; because they copy another face.
    removed_components : list of RemovedComponent
    removed_details : list of RemovedDetail
    unchanged_parts : list of UnchangedPart
    baseline : int or None
        Points that fast-simplification needs for the same deviation; None where not asked for, or
        where it does not get there (`warnings` says so).
    seconds : float
    warnings : list of str

    Examples
    --------
    >>> import bldsimp
    >>> square = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]]
    >>> report = bldsimp.simplify((square, [[0, 1, 4], [1, 3, 4], [1, 2, 3]])).report
    >>> report.facets, report.after.points, report.deviation <= report.tolerance
    (1, 4, True)
    """

    tolerance: float
    diagonal: float
    before: Counts = field(default_factory=Counts)
    after: Counts = field(default_factory=Counts)
    deviation: float = 0.0
    epsilon: float = 0.0
    rounding: float = 0.0
    texels: float | None = None
    facets: int = 0
    facet_levels: dict[str, int] = field(default_factory=dict)
    fallback_reasons: dict[str, int] = field(default_factory=dict)
    healed_t_junctions: int = 0
    contact_points: int = 0
    closed_boundary_loops: int = 0
    details_kept_by_label: int = 0
    reversed_faces: int = 0
    removed_degenerate_faces: int = 0
    removed_duplicate_faces: int = 0
    removed_components: list[RemovedComponent] = field(default_factory=list)
    removed_details: list[RemovedDetail] = field(default_factory=list)
    unchanged_parts: list[UnchangedPart] = field(default_factory=list)
    baseline: int | None = None
    seconds: float = 0.0
    warnings: list[str] = field(default_factory=list)
    schema: str = SCHEMA

    def to_dict(self) -> dict[str, Any]:
        """Convert the report to plain values, in the order of docs/report.md; deprecated names come last."""
        values = asdict(self)
        old = {name: values[new] for name, new in OLD_NAMES.items()}
        old["dropped"] = [
            each | {"reason": _OLD_REASONS.get(each["reason"], each["reason"])} for each in old["dropped"]
        ]
        return {"schema": values.pop("schema"), **values, **old}

    def to_json(self) -> str:
        """Convert the report to JSON text that ends with a newline."""
        return json.dumps(self.to_dict(), indent=2, allow_nan=False) + "\n"


for _old, _new in OLD_NAMES.items():
    setattr(Report, _old, _alias(_old, _new))
