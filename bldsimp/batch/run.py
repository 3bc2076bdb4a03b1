"""Run a batch from its plan to its end: each row goes from the pool to the manifest."""

from __future__ import annotations

import os
from collections.abc import Callable
from itertools import chain
from typing import TYPE_CHECKING

from .. import __version__
from ..errors import OutputError
from ..options import Options
from .inputs import Plan
from .row import FileRow
from .storage import open_storage
from .task import encode_options
from .totals import Totals

if TYPE_CHECKING:
    from .dask import DaskPool
    from .manifest import Manifest
    from .pool import Pool


def run_batch(
    plan: Plan,
    options: Options,
    pool: Pool | DaskPool,
    manifest: Manifest,
    totals: Totals,
    show: Callable[[FileRow], None],
) -> None:
    """Run a plan and record it.

    Parameters
    ----------
    plan : Plan
    options : Options
        Those that the pool works with.
    pool : Pool or DaskPool
    manifest : Manifest
        Gets each row before it is shown.
    totals : Totals
        Counts the rows.
    show : callable
        Shows a row.

    Raises
    ------
    OutputError
        Where the disk is full: every file that ended is recorded, and no other one was begun.
    """
    full: FileRow | None = None
    died, made_with = False, encode_options(options)
    try:
        for row in chain(plan.refused, pool.run(plan.tasks)):
            row.options, row.version = made_with, __version__
            manifest.append(row)
            totals.add(row)
            show(row)
            died = died or row.attempts > 1 or row.kind in ("timeout", "crash")
            if row.kind == "full" and full is None:
                full = row
                pool.stop()
    except BaseException:
        died = True
        pool.kill()
        raise
    finally:
        if died:
            remove_leftovers(plan)
    if full is not None:
        raise OutputError(f"{full.error}: make room, then use --resume")


def remove_leftovers(plan: Plan) -> None:
    """Remove what killed processes left next to the outputs."""
    for folder in {os.path.dirname(task.target) for task in plan.tasks}:
        open_storage(folder).clear(folder)
