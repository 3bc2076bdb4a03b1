"""How far a batch is: a bar on a terminal, else plain lines."""

from __future__ import annotations

import sys
import time
from contextlib import ExitStack
from types import TracebackType
from typing import TYPE_CHECKING, Any

import click

from ..batch.inputs import Plan
from ..batch.row import Row, escaped
from ..report import one_line

if TYPE_CHECKING:
    from click._termui_impl import ProgressBar

EVERY = 10.0
"""Seconds from one plain line to the next."""

FILE_BYTES = 20_000
"""A file takes as long as so many bytes of it, and the bytes that it has."""


class BatchProgress:
    """Shows rows as they end: files, triangles and time left.

    Parameters
    ----------
    plan : Plan
    quiet : bool
        Show nothing.
    """

    def __init__(self, plan: Plan, *, quiet: bool) -> None:
        self._quiet = quiet
        self._files = len(plan.tasks) + len(plan.refused)
        self._length = sum(task.size + FILE_BYTES for task in plan.tasks)
        self._ended = self._failed = self._triangles = self._position = 0
        self._stack = ExitStack()
        self._bar: ProgressBar[Any] | None = None
        self._start = self._told = time.monotonic()

    def __enter__(self) -> BatchProgress:
        if not self._quiet and sys.stderr.isatty():
            self._bar = self._stack.enter_context(
                click.progressbar(
                    length=self._length, file=sys.stderr, show_percent=True, item_show_func=lambda _: self._words()
                )
            )
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.close()

    def tell(self, row: Row) -> None:
        """Show a row."""
        self._ended += 1
        self._failed += row.failed
        self._triangles += row.triangles_before or 0
        step = row.input_bytes + FILE_BYTES
        self._position += step
        if self._quiet:
            return
        if row.failed:
            start = "\r\x1b[K" if self._bar is not None else ""
            click.echo(start + one_line(f"failed     {escaped(row.input)}: {row.error}"), err=True)
        now = time.monotonic()
        if self._bar is not None:
            self._bar.update(step)
        elif now - self._told > EVERY:
            self._told = now
            left = (now - self._start) * (self._length - self._position) / self._position
            click.echo(f"batch      {self._words()}, {_duration(left)} left", err=True)

    def _words(self) -> str:
        failed = f" ({self._failed:,} failed)" if self._failed else ""
        return f"{self._ended:,} of {self._files:,} files{failed}, {self._triangles:,} triangles"


def _duration(seconds: float) -> str:
    """A time for people."""
    minutes, rest = divmod(max(0, round(seconds)), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}"
