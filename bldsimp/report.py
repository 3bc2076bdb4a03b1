"""What a run did, for people and for programs: the schema is described in docs/report.md."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import asdict, dataclass, field
from typing import Any

from .model import MOST_NAMED, Part

SCHEMA = "bldsimp.report/1"
"""Name and version of the JSON; the number rises when a field changes its meaning or goes."""

LITTLE_DROPPED = 0.2
"""Where less than this share of the points could go, the summary says what may drop more."""

SEE_THROUGH_SPACINGS = 4.0
"""A plane through rounded points and the chains on it stray by fewer than this many spacings."""

REASONS = {
    "crossing": "rings would cross",
    "mismatch": "areas would differ",
    "clash": "edges would be laid on one another",
    "misfit": "edges would not match their neighbours",
    "pierced": "it would pass through another facet",
    "little_gain": "a curved surface would lose too few points",
}
"""Why a facet steps down, in words."""

DROPPED = {
    "within_tolerance": "within the tolerance of what remains",
    "smaller_than_min_part": "smaller than asked for, which the deviation does not count",
}
"""Why a component went, in words."""


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
        Every edge is used by exactly two faces.
    open_edges, nonmanifold_edges : int
        Edges that one face uses; that more than two faces use.
    bytes : int or None
        Size of the file and of the buffers beside it; None where nothing was read or written.
    """

    points: int = 0
    vertices: int = 0
    triangles: int = 0
    watertight: bool = False
    open_edges: int = 0
    nonmanifold_edges: int = 0
    bytes: int | None = None


@dataclass
class PassedOn:
    """A part that was left untouched, and why."""

    name: str
    reason: str


def passed_on(part: Part) -> PassedOn:
    """Why a part is left untouched."""
    return PassedOn(part.name, f"carries {', '.join(part.fixed)}")


@dataclass
class DroppedPart:
    """A component that went as a whole.

    Attributes
    ----------
    part : str
        Name of the part that most of its triangles belong to.
    triangles : int
        That it had by then.
    box : list of list of float
        Least and greatest coordinates, (2, 3); of an instanced mesh, in the place of its first instance.
    reason : str
        ``within_tolerance`` of what remains, or ``smaller_than_min_part``.
    """

    part: str
    triangles: int
    box: list[list[float]]
    reason: str


@dataclass
class Report:
    """What a run did. Lengths are model units in world space.

    Attributes
    ----------
    tolerance : float
    deviation : float
        Certified bound of the distance between input and output surface, both ways, with `rounding`, and
        without what is smaller than `min_part`.
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
    rungs : dict of str to int
        Facets on each rung of the ladder, best rung first.
    reasons : dict of str to int
        Why facets stand below the first rung.
    healed : int
        T-junctions that closed.
    touching : int
        Points that stay only since sheets meet there inside of facets.
    closed : int
        Boundary loops that closed, where that was allowed.
    turned : int
        Faces whose winding was turned.
    degenerate, duplicate : int
        Faces left out, since they repeat a point; since they copy another face.
    dropped : list of DroppedPart
    passed_on : list of PassedOn
    baseline : int or None
        Points that fast-simplification needs for the same deviation; None where not asked, or
        where it does not get there (`warnings` says so).
    seconds : float
    warnings : list of str
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
    rungs: dict[str, int] = field(default_factory=dict)
    reasons: dict[str, int] = field(default_factory=dict)
    healed: int = 0
    touching: int = 0
    closed: int = 0
    turned: int = 0
    degenerate: int = 0
    duplicate: int = 0
    dropped: list[DroppedPart] = field(default_factory=list)
    passed_on: list[PassedOn] = field(default_factory=list)
    baseline: int | None = None
    seconds: float = 0.0
    warnings: list[str] = field(default_factory=list)
    schema: str = SCHEMA

    def to_dict(self) -> dict[str, Any]:
        """The report as plain values, in the order of docs/report.md."""
        values = asdict(self)
        return {"schema": values.pop("schema"), **values}

    def to_json(self) -> str:
        """The report as JSON text, ending in a newline."""
        return json.dumps(self.to_dict(), indent=2, allow_nan=False) + "\n"


def one_line(text: str) -> str:
    """Text of unknown origin as a terminal can only show it: a space for each control character or line break."""
    plain = text.encode("utf-8", "replace").decode("utf-8")
    return "".join(letter if letter.isprintable() else " " for letter in plain)


def summary(report: Report) -> str:
    """Tell a report in a few lines for a person.

    Returns
    -------
    str
        Lines without a newline at the end.
    """
    lines = [_change(report), _surface(report)]
    if report.facets:
        lines.append(_facets(report))
    lines += _dropped(report)
    if report.baseline is not None:
        share = report.baseline / max(report.after.points, 1)
        lines.append(
            f"baseline   fast-simplification needs {report.baseline:,} points for the same deviation"
            f" ({share:.1f} times as many)"
        )
    lines += [f"passed on  {part.name}: {part.reason}" for part in report.passed_on]
    lines += [f"warning    {text}" for text in report.warnings]
    lines += [f"note       {text}" for text in _notes(report)]
    lines.append(f"seconds    {report.seconds:.2f}")
    return "\n".join(map(one_line, lines))


def _change(report: Report) -> str:
    """Points, triangles and bytes, before and after."""
    before, after = report.before, report.after
    pairs = [("points", before.points, after.points), ("triangles", before.triangles, after.triangles)]
    text = ", ".join(f"{name} {a:,} -> {b:,}" for name, a, b in pairs)
    if before.bytes is not None and after.bytes is not None:
        text += f", {size_in_words(before.bytes)} -> {size_in_words(after.bytes)}"
    return f"size       {text}"


def _surface(report: Report) -> str:
    """The certified deviation and whether the surface is closed."""
    words = {True: "watertight", False: "open"}
    before, after = words[report.before.watertight], words[report.after.watertight]
    closed = before if before == after else f"{before} -> {after}"
    written = f", of which {report.rounding:.3g} is rounding on writing" if report.rounding else ""
    textures = "" if report.texels is None else f", textures moved by at most {report.texels:.2g} texels"
    return (
        f"surface    deviation at most {report.deviation:.3g}{written}"
        f" (tolerance {report.tolerance:.3g}, diagonal {report.diagonal:.6g}), {closed}{textures}"
    )


def _facets(report: Report) -> str:
    """How many facets stand on which rung, and why."""
    rungs = ", ".join(f"{count:,} {name.replace('_', ' ')}" for name, count in report.rungs.items() if count)
    text = f"facets     {report.facets:,}" + (f": {rungs}" if rungs else "")
    reasons = ", ".join(f"{REASONS.get(name, name)} ({count:,})" for name, count in report.reasons.items() if count)
    if reasons:
        text += f"; kept because: {reasons}"
    extra = [f"{report.healed:,} T-junctions healed"] if report.healed else []
    extra += [f"{report.closed:,} boundary loops closed"] if report.closed else []
    extra += [f"{report.touching:,} points kept where sheets meet"] if report.touching else []
    extra += [f"{report.turned:,} faces turned"] if report.turned else []
    extra += [f"{report.degenerate:,} faces that repeat a point left out"] if report.degenerate else []
    extra += [f"{report.duplicate:,} copies of faces left out"] if report.duplicate else []
    return "; ".join([text, *extra])


def _dropped(report: Report) -> list[str]:
    """What went as a whole, and the parts that had the most of it."""
    lines = []
    for reason, words in DROPPED.items():
        names = Counter(part.part for part in report.dropped if part.reason == reason)
        if not names:
            continue
        named = ", ".join(f"{name} ({count:,})" if count > 1 else name for name, count in names.most_common(MOST_NAMED))
        more = f" and {len(names) - MOST_NAMED:,} more parts" if len(names) > MOST_NAMED else ""
        count = names.total()
        lines.append(f"dropped    {count:,} component{'s' if count > 1 else ''} {words}: {named}{more}")
    return lines


def _notes(report: Report) -> list[str]:
    """What a user may want to do next."""
    notes = []
    coarse = report.epsilon / 2.0 > report.tolerance > 0.0
    through = SEE_THROUGH_SPACINGS * report.epsilon
    if coarse:
        notes.append(
            f"the file's own rounding ({report.epsilon / 2.0:.3g}) is coarser than the tolerance;"
            f" --tolerance {through:.2g} may see through it"
        )
    dropped = report.before.points - report.after.points
    little = dropped < LITTLE_DROPPED * report.before.points
    if little and not report.passed_on and not coarse and report.diagonal > 0.0:
        more = max(1e-3 * report.diagonal, 10.0 * report.tolerance)
        notes.append(
            f"little could be dropped: a larger tolerance, say --tolerance {more:.1g}, may drop more,"
            " and may move the surface so far"
        )
    return notes


def size_in_words(count: int) -> str:
    """Bytes for people."""
    for unit, step in (("GB", 1_000_000_000), ("MB", 1_000_000), ("kB", 1_000)):
        if count >= step:
            return f"{count / step:.3g} {unit}"
    return f"{count} B"
