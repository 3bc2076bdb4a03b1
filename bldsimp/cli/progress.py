"""What takes long: shown on a terminal, and left at once on a signal."""

from __future__ import annotations

import sys
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import ExitStack
from typing import TypeVar

import click

from .._core import Progress

T = TypeVar("T")

EVERY = 0.2
"""Seconds from one look at the progress to the next."""


def watched(work: Callable[[Progress], T], points: int, *, quiet: bool) -> T:
    """Do some work beside the main thread, which alone can answer signals meanwhile.

    Parameters
    ----------
    work : callable
        Given a `Progress`, which counts points that are gone.
    points : int
        How many there are.
    quiet : bool
        Show nothing; else, on a terminal, a bar once the first point is gone.
    """
    progress = Progress()
    with ThreadPoolExecutor(1) as pool, ExitStack() as stack:
        future: Future[T] = pool.submit(work, progress)
        bar = None
        while not wait([future], EVERY).done:
            if bar is None and progress.gone > 0 and not quiet and sys.stderr.isatty():
                bar = stack.enter_context(click.progressbar(length=points, label="points gone", file=sys.stderr))
            if bar is not None:
                bar.update(progress.gone - bar.pos)
        return future.result()
