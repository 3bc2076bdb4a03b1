"""The words in which people read a report, an inspection, and the totals of a batch."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from ..display import format_bytes, sanitize_line
from ..model import MOST_NAMED

if TYPE_CHECKING:
    from ..batch.totals import Totals
    from ..inspection import Inspection
    from ..report import Report

LITTLE_REMOVED = 0.2
"""Where less than this share of the points could be removed, the summary says what may remove more."""

SEE_THROUGH_SPACINGS = 4.0
"""A plane through rounded points and the chains on it stray by fewer than this many spacings."""

FALLBACK_REASONS = {
    "crossing": "rings would cross",
    "mismatch": "areas would differ",
    "clash": "edges would overlap",
    "misfit": "edges would not match the neighbors' edges",
    "pierced": "the facet would intersect another one",
    "little_gain": "a curved surface would lose too few points",
}

DETAILS = {
    "boundary_loop": ("boundary loop", "boundary loops"),
    "detail": ("recess or projection", "recesses or projections"),
    "passage": ("passage", "passages"),
    "step": ("step", "steps"),
}
"""What to call details that went: one, and several."""

REMOVAL_REASONS = {
    "within_tolerance": "within the tolerance of the rest",
    "smaller_than_min_component": "smaller than --min-component, not counted in the deviation",
}

FAILURES = {
    "refused": "is not a readable file (for example a FIFO, a device or a broken link)",
    "input": "cannot be read as a mesh",
    "output": "cannot be written",
    "full": "the disk is full",
    "memory": "needs more memory than it may use",
    "timeout": "takes too long",
    "crash": "its process died",
    "internal": "a bug in bldsimp",
}


def describe_report(report: Report) -> str:
    """Describe a report in a few lines.

    Returns
    -------
    str
        Lines without a newline at the end.
    """
    lines = [_describe_size(report), _describe_surface(report)]
    if report.facets:
        lines.append(_describe_facets(report))
    lines += _describe_removed(report)
    if report.baseline is not None:
        share = report.baseline / max(report.after.points, 1)
        lines.append(
            f"baseline   fast-simplification needs {report.baseline:,} points for the same deviation"
            f" ({share:.1f} times as many)"
        )
    lines += [f"unchanged  {part.name}: {part.reason}" for part in report.unchanged_parts]
    lines += [f"warning    {text}" for text in report.warnings]
    lines += [f"note       {text}" for text in _suggest(report)]
    lines.append(f"seconds    {report.seconds:.2f}")
    return "\n".join(map(sanitize_line, lines))


def _describe_size(report: Report) -> str:
    before, after = report.before, report.after
    text = f"points {before.points:,} -> {after.points:,}, triangles {before.triangles:,} -> {after.triangles:,}"
    if before.bytes is not None and after.bytes is not None:
        text += f", {format_bytes(before.bytes)} -> {format_bytes(after.bytes)}"
    return f"size       {text}"


def _describe_surface(report: Report) -> str:
    """Describe the certified deviation and whether the surface is closed."""
    before, after = ("watertight" if counts.watertight else "open" for counts in (report.before, report.after))
    closed = before if before == after else f"{before} -> {after}"
    rounding = f", including {report.rounding:.3g} from rounding when written" if report.rounding else ""
    textures = "" if report.texels is None else f", textures moved by at most {report.texels:.2g} texels"
    return (
        f"surface    deviation at most {report.deviation:.3g}{rounding}"
        f" (tolerance {report.tolerance:.3g}, diagonal {report.diagonal:.6g}), {closed}{textures}"
    )


def _describe_facets(report: Report) -> str:
    """Describe how many facets are at each level, and why."""
    levels = ", ".join(f"{count:,} {name.replace('_', ' ')}" for name, count in report.facet_levels.items() if count)
    text = f"facets     {report.facets:,}" + (f": {levels}" if levels else "")
    reasons = [
        f"{FALLBACK_REASONS.get(name, name)} ({count:,})" for name, count in report.fallback_reasons.items() if count
    ]
    if reasons:
        text += f"; kept because {', '.join(reasons)}"
    counts = {
        "T-junctions healed": report.healed_t_junctions,
        "details kept between labels": report.details_kept_by_label,
        "points kept where surfaces touch": report.contact_points,
        "faces reversed": report.reversed_faces,
        "degenerate faces removed": report.removed_degenerate_faces,
        "duplicate faces removed": report.removed_duplicate_faces,
    }
    return "; ".join([text, *(f"{count:,} {what}" for what, count in counts.items() if count)])


def _describe_removed(report: Report) -> Iterator[str]:
    """Describe what was removed as a whole, and the parts that had the most of it."""
    for reason, words in REMOVAL_REASONS.items():
        names = Counter(component.part for component in report.removed_components if component.reason == reason)
        count = names.total()
        if not count:
            continue
        named = ", ".join(f"{name} ({own:,})" if own > 1 else name for name, own in names.most_common(MOST_NAMED))
        more = f" and {len(names) - MOST_NAMED:,} more parts" if len(names) > MOST_NAMED else ""
        yield f"removed    {count:,} component{'s' if count > 1 else ''} {words}: {named}{more}"
    kinds = Counter(one.kind for one in report.removed_details)
    if kinds:
        told = [f"{count:,} {DETAILS[kind][count > 1]}" for kind, count in sorted(kinds.items())]
        yield f"details    {', '.join(told)} within the tolerance removed as wholes"


def _suggest(report: Report) -> Iterator[str]:
    """Suggest what you may want to do next."""
    coarse = report.epsilon / 2.0 > report.tolerance > 0.0
    if coarse:
        yield (
            f"the file's coordinates are rounded more coarsely ({report.epsilon / 2.0:.3g}) than the tolerance:"
            f" try --tolerance {SEE_THROUGH_SPACINGS * report.epsilon:.2g}"
        )
    little = report.before.points - report.after.points < LITTLE_REMOVED * report.before.points
    if little and not report.unchanged_parts and not coarse and report.diagonal > 0.0:
        more = max(1e-3 * report.diagonal, 10.0 * report.tolerance)
        yield (
            f"few points could be removed: try a larger tolerance such as --tolerance {more:.1g}"
            f" (moves the surface by up to {more:.1g})"
        )


def describe_inspection(inspection: Inspection) -> str:
    """Describe an inspection: a block of lines for each mesh, and one for all of them."""
    lines = [f"format      {inspection.format}, {inspection.bytes:,} bytes"]
    lines.append(f"diagonal    {inspection.diagonal:.6g}")
    lines.append(f"auto        {inspection.auto_tolerance:.3g}")
    blocks = [(f"mesh        {mesh.name or '(no name)'}", asdict(mesh)) for mesh in inspection.meshes]
    if len(blocks) != 1:
        blocks.append((f"total       {len(inspection.meshes):,} meshes", inspection.total()))
    for head, values in blocks:
        lines.append(head)
        lines += [f"  {key.replace('_', ' '):18s}{_format(value)}" for key, value in values.items() if key != "name"]
    lines += [f"warning     {text}" for text in inspection.warnings]
    return "\n".join(map(sanitize_line, lines))


def _format(value: Any) -> str:
    """Format a value of an inspection."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        return ", ".join(map(_format, value)) or "none"
    if isinstance(value, dict):
        of_faces = ", of faces" if value.get("on") == "faces" else ""
        return (
            f"{value['name']}: {value['reason']}"
            if "reason" in value
            else f"{value['name']} ({value['kind']}{of_faces})"
        )
    return f"{value:,}" if isinstance(value, int) else f"{value:.3g}" if isinstance(value, float) else str(value)


def describe_totals(totals: Totals) -> str:
    """Describe the totals of a batch.

    Returns
    -------
    str
        Lines without a newline at the end.
    """
    lines = [
        f"files      {totals.done:,} done"
        + (f" ({totals.warned:,} with warnings)" if totals.warned else "")
        + (f", {totals.failed:,} failed" if totals.failed else "")
        + (f", {totals.skipped:,} already done" if totals.skipped else "")
    ]
    if totals.done:
        sizes = [f"{name} {before:,} -> {after:,}" for name, (before, after) in
                 (("points", totals.points), ("triangles", totals.triangles))]  # fmt: skip
        lines.append(f"size       {', '.join(sizes)}, {' -> '.join(map(format_bytes, totals.bytes))}")
        slowest = ", ".join(f"{name} ({seconds:.2f})" for seconds, name in sorted(totals.slowest, reverse=True))
        lines.append(f"seconds    {totals.seconds:,.1f} for all files; slowest: {slowest}")
    for kind, named in sorted(totals.named.items(), key=lambda item: (-totals.errors[item[0]], item[0])):
        lines.append(f"failed     {totals.errors[kind]:,} x {FAILURES.get(kind, kind)}:")
        lines += [f"           {name}: {error}" for name, error in named]
        if totals.errors[kind] > len(named):
            lines.append(f"           and {totals.errors[kind] - len(named):,} more")
    return "\n".join(map(sanitize_line, lines))
