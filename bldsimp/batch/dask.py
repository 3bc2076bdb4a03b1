"""Many machines: groups of files as tasks of Dask distributed, on any cluster that Dask runs on."""

from __future__ import annotations

import dataclasses
import queue
from collections import deque
from collections.abc import Iterator
from typing import Any

from ..errors import InputError, UsageError
from .row import FileRow, make_failure, make_retry
from .task import Task, WorkOrder, split_into_groups
from .worker import Worker

GROUP_FILES = 250
GROUP_BYTES = 250_000_000
"""A group takes some seconds, a thousand times as long as the scheduler needs for it."""

AHEAD = 2
"""Groups for each thread of the cluster, one of them waiting; the scheduler never has more."""

CONNECT_SECONDS = 20

_idle: queue.LifoQueue[Worker] = queue.LifoQueue()
"""Idle workers in a process of Dask: in the end as many as it has threads."""


def simplify_group(order: WorkOrder, timeout: float | None) -> list[FileRow]:
    """Simplify a group of files on the cluster; return a row for each file.

    As on one machine, a separate process takes the files, so that Dask's own process outlives each of them.
    """
    try:
        worker = _idle.get_nowait()
    except queue.Empty:
        worker = Worker()
    try:
        return [row for _, row in worker.run(order, timeout, bool)]
    finally:
        _idle.put(worker)


class DaskPool:
    """Runs tasks on a cluster.

    Parameters
    ----------
    scheduler : str
        Address, such as ``tcp://head:8786``.
    order : WorkOrder
        Without tasks; its memory is the limit for each file.
    timeout : float or None
        Seconds for each file.

    Raises
    ------
    UsageError
        Where Dask is not installed.
    InputError
        Where the scheduler does not answer.
    """

    def __init__(self, scheduler: str, order: WorkOrder, timeout: float | None) -> None:
        try:
            import distributed
        except ImportError:
            raise UsageError("--scheduler needs Dask: install bldsimp[dask]") from None
        self.scheduler = scheduler
        self._order = order
        self._timeout = timeout
        self._stopping = False
        self._groups: dict[Any, list[Task]] = {}
        try:
            self._client = distributed.Client(scheduler, timeout=CONNECT_SECONDS, set_as_default=False)
        except (OSError, ValueError) as error:
            raise InputError(f"{scheduler}: the scheduler does not answer: {error}") from None
        self._ended = distributed.as_completed(loop=self._client.loop)

    def run(self, tasks: list[Task]) -> Iterator[FileRow]:
        """Yield the last row of each task, as its group ends."""
        waiting = deque(split_into_groups(tasks, GROUP_FILES, GROUP_BYTES))
        while waiting or self._groups:
            while waiting and not self._stopping and len(self._groups) < self._count_places():
                self._submit(waiting.popleft())
            if not self._groups:
                break
            future = next(self._ended)
            group = self._groups.pop(future.key)
            for task, row in zip(group, self._collect_rows(future, group), strict=True):
                retry = make_retry(task, row)
                if retry is None or self._stopping:
                    yield row
                else:
                    waiting.append([retry])
        self._client.close()

    def stop(self) -> None:
        """Let the groups that the cluster has end, and give it no other."""
        self._stopping = True

    def kill(self) -> None:
        """Leave the cluster, which then drops its groups."""
        self._stopping = True
        self._client.close()

    def _submit(self, group: list[Task]) -> None:
        order = dataclasses.replace(self._order, tasks=group)
        future = self._client.submit(simplify_group, order, self._timeout, pure=False)
        self._groups[future.key] = group
        self._ended.add(future)

    def _make_error(self) -> InputError:
        return InputError(f"{self.scheduler}: the scheduler is gone: start another one, then use --resume")

    def _count_places(self) -> int:
        """Count the groups that the cluster may have at a time."""
        try:
            threads: dict[str, int] = self._client.nthreads()
        except OSError:
            raise self._make_error() from None
        return max(1, AHEAD * sum(threads.values()))

    def _collect_rows(self, future: Any, group: list[Task]) -> list[FileRow]:
        """Return the rows of a group that has ended, in whatever way."""
        from distributed import KilledWorker

        if future.status in ("cancelled", "lost"):
            raise self._make_error()
        error = future.exception() if future.status == "error" else None
        if isinstance(error, KilledWorker):
            return [make_failure(task, "crash", "the processes of Dask that had it died") for task in group]
        rows: list[FileRow] = future.result()
        return rows
