"""A batch from its plan to its end: rows go from the engine to the manifest."""

from __future__ import annotations

import os
from collections.abc import Callable
from itertools import chain

from .. import __version__
from ..errors import OutputError
from ..options import Options
from .engine import Engine
from .inputs import Plan
from .manifest import Manifest
from .row import Row
from .storage import storage_of
from .summary import Totals
from .task import recipe


def run_batch(
    plan: Plan, options: Options, engine: Engine, manifest: Manifest, totals: Totals, tell: Callable[[Row], None]
) -> None:
    """Run a plan and record it.

    Parameters
    ----------
    plan : Plan
    options : Options
        Those that the engine works with.
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
    died, made_with = False, recipe(options)
    try:
        for row in chain(plan.refused, engine.run(plan.tasks)):
            row.options, row.version = made_with, __version__
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
    """Remove what processes that were killed have left beside the outputs."""
    for folder in {os.path.dirname(task.target) for task in plan.tasks}:
        storage_of(folder).clear(folder)
