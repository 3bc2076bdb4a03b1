"""Progress on standard error: a bar on a terminal, and plain lines of a batch elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import ExitStack, contextmanager
from datetime import timedelta
from typing import TYPE_CHECKING, Any, TypeVar

import click

from .. import _core
from ..batch.row import FileRow, escape_name
from ..display import sanitize_line

if TYPE_CHECKING:
    from click._termui_impl import ProgressBar

    from ..batch.inputs import Plan
    from ..batch.totals import Totals

T = TypeVar("T")

LOOK_SECONDS = 0.2
"""Time from one look at the progress to the next."""

LINE_SECONDS = 10.0
"""Time from one plain line to the next."""

FILE_BYTES = 20_000
"""A file takes as long as its own bytes and this many more."""


def run_with_progress(work: Callable[[_core.Progress], T], points: int, *, quiet: bool) -> T:
    """Run some work in a thread, so that the main thread can handle signals.

    Parameters
    ----------
    work : callable
        Gets a `Progress`, which counts the points that are removed.
    points : int
        How many there are.
    quiet : bool
        Show nothing; else, on a terminal, a bar once the first point is removed.
    """
    progress = _core.Progress()
    with ThreadPoolExecutor(1) as pool, ExitStack() as stack:
        future: Future[T] = pool.submit(work, progress)
        bar = None
        while not wait([future], LOOK_SECONDS).done:
            if bar is None and progress.removed > 0 and not quiet and sys.stderr.isatty():
                bar = stack.enter_context(click.progressbar(length=points, label="removing points", file=sys.stderr))
            if bar is not None:
                bar.update(progress.removed - bar.pos)
        return future.result()


@contextmanager
def show_batch_progress(plan: Plan, totals: Totals, *, quiet: bool) -> Iterator[Callable[[FileRow], None]]:
    """Yield a function that shows files, triangles and the time left as rows arrive.

    Parameters
    ----------
    plan : Plan
    totals : Totals
        Has counted each row when it is shown.
    quiet : bool
        Show nothing.
    """
    if quiet:
        yield lambda row: None
        return
    files, length = len(plan.tasks) + len(plan.refused), sum(task.size + FILE_BYTES for task in plan.tasks)
    bar: ProgressBar[Any] | None = None
    start = shown = time.monotonic()
    position = 0

    def describe() -> str:
        failed = f" ({totals.failed:,} failed)" if totals.failed else ""
        return f"{totals.done + totals.failed:,} of {files:,} files{failed}, {totals.triangles[0]:,} triangles"

    def show_row(row: FileRow) -> None:
        nonlocal position, shown
        step = row.input_bytes + FILE_BYTES
        position += step
        if row.failed:
            begin = "" if bar is None else "\r\x1b[K"
            click.echo(begin + sanitize_line(f"failed     {escape_name(row.input)}: {row.error}"), err=True)
        now = time.monotonic()
        if bar is not None:
            bar.update(step)
        elif now - shown > LINE_SECONDS:
            shown = now
            left = (now - start) * (length - position) / position
            click.echo(f"batch      {describe()}, {timedelta(seconds=max(0, round(left)))} left", err=True)

    with ExitStack() as stack:
        if sys.stderr.isatty():
            bar = click.progressbar(
                length=length, file=sys.stderr, show_percent=True, item_show_func=lambda _: describe()
            )
            stack.enter_context(bar)
        yield show_row
