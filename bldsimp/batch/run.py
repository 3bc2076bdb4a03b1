"""Run a batch from its plan to its end: skip what is done, and pass each row from the pool to the manifest."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from itertools import chain

from .. import __version__
from ..errors import OutputError
from ..options import Options
from .dask import DaskPool
from .inputs import Plan
from .manifest import Manifest
from .memory import choose_jobs, measure_free_memory
from .pool import Pool
from .resume import collect_done, refuse_existing, select_remaining
from .row import FileRow
from .storage import open_storage
from .task import WorkOrder, encode_options
from .totals import Totals


@dataclass(frozen=True)
class RunSettings:
    """How a batch runs, apart from the options for each file; `docs/batch.md` describes each."""

    overwrite: bool
    resume: bool
    verify: bool
    jobs: int | None
    memory: int | None
    timeout: float
    scheduler: str | None


def skip_done(plan: Plan, log: Manifest, root: str, options: Options, settings: RunSettings, totals: Totals) -> None:
    """Remove from a plan what is done already; without a manifest, refuse to replace results."""
    if not log.empty:
        done, count = collect_done(log.rows(), options), len(plan.tasks)
        jobs = settings.jobs or _count_cores()
        plan.tasks = select_remaining(plan.tasks, done, root, verify=settings.verify, jobs=jobs)
        totals.skipped = count - len(plan.tasks)
        remove_leftovers(plan)
    elif not settings.overwrite:
        refuse_existing(plan.tasks, root)


def make_pool(options: Options, settings: RunSettings) -> Pool | DaskPool:
    """Make the pool that runs the tasks."""
    if settings.scheduler is not None:
        order = WorkOrder([], options, settings.overwrite, settings.memory)
        return DaskPool(settings.scheduler, order, settings.timeout)
    memory = settings.memory or measure_free_memory()
    jobs = settings.jobs or choose_jobs(memory, _count_cores())
    return Pool(WorkOrder([], options, settings.overwrite), settings.timeout, jobs=jobs, memory=memory)


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


def _count_cores() -> int:
    """Count the cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
