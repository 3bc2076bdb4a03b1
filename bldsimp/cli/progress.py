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


class BatchProgress:
    """Shows files, triangles and the time left as rows arrive.

    Parameters
    ----------
    plan : Plan
    totals : Totals
        Has counted each row when it is shown.
    quiet : bool
        Show nothing.
    """

    def __init__(self, plan: Plan, totals: Totals, *, quiet: bool) -> None:
        self._totals, self._quiet = totals, quiet
        self._files = len(plan.tasks) + len(plan.refused)
        self._length = sum(task.size + FILE_BYTES for task in plan.tasks)
        self._position = 0
        self._bar: ProgressBar[Any] | None = None
        self._start = self._shown = time.monotonic()

    @contextmanager
    def show(self) -> Iterator[Callable[[FileRow], None]]:
        """Yield the function that shows a row."""
        with ExitStack() as stack:
            if not self._quiet and sys.stderr.isatty():
                bar: ProgressBar[Any] = click.progressbar(
                    length=self._length, file=sys.stderr, show_percent=True, item_show_func=lambda _: self._describe()
                )
                self._bar = stack.enter_context(bar)
            yield self._show_row

    def _show_row(self, row: FileRow) -> None:
        step = row.input_bytes + FILE_BYTES
        self._position += step
        if self._quiet:
            return
        if row.failed:
            start = "\r\x1b[K" if self._bar is not None else ""
            click.echo(start + sanitize_line(f"failed     {escape_name(row.input)}: {row.error}"), err=True)
        now = time.monotonic()
        if self._bar is not None:
            self._bar.update(step)
        elif now - self._shown > LINE_SECONDS:
            self._shown = now
            left = (now - self._start) * (self._length - self._position) / self._position
            click.echo(f"batch      {self._describe()}, {timedelta(seconds=max(0, round(left)))} left", err=True)

    def _describe(self) -> str:
        totals = self._totals
        failed = f" ({totals.failed:,} failed)" if totals.failed else ""
        return f"{totals.done + totals.failed:,} of {self._files:,} files{failed}, {totals.triangles[0]:,} triangles"
