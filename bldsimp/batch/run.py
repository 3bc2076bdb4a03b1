"""A batch from its plan to its end: rows go from the engine to the manifest."""

from __future__ import annotations

from collections.abc import Callable
from itertools import chain

from ..errors import OutputError
from .engine import Engine
from .inputs import Plan
from .manifest import Manifest
from .row import Row
from .storage import storage_of
from .summary import Totals


def run_batch(
    plan: Plan, engine: Engine, manifest: Manifest, totals: Totals, tell: Callable[[Row], None]
) -> None:
    """Run a plan and record it.

    Parameters
    ----------
    plan : Plan
    engine : Engine
    manifest : Manifest
        Each row is in it before it is told.
    totals : Totals
        Counts the rows.
    tell : callable
        Shows a row.

    Raises
    ------
    OutputError
        Where the disk is full: what has ended is recorded, and nothing more was begun.
    """
    full: Row | None = None
    died = False
    try:
        for row in chain(plan.refused, engine.run(plan.tasks)):
            manifest.append(row)
            totals.add(row)
            tell(row)
            died = died or row.attempts > 1 or row.kind in ("timeout", "crash")
            if row.kind == "full" and full is None:
                full = row
                engine.stop()
    except BaseException:
        died = True
        engine.kill()
        raise
    finally:
        if died:
            clear(plan)
    if full is not None:
        raise OutputError(f"{full.error}: make room, then --resume")


def clear(plan: Plan) -> None:
    """Remove what processes that were killed have left beside the outputs; none may be running."""
    for folder in {task.target.rpartition("/")[0] or "." for task in plan.tasks}:
        storage_of(folder).clear(folder)
