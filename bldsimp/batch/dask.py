"""Many machines: groups of files as tasks of Dask distributed, on any cluster that Dask runs on."""

from __future__ import annotations

import dataclasses
import queue
from collections import deque
from collections.abc import Iterator
from typing import Any

from ..errors import InputError, UsageError
from ..options import Options
from .engine import once_more
from .groups import groups_of
from .row import Row, failure
from .task import Order, Task
from .worker import Worker

GROUP_FILES = 250
GROUP_BYTES = 250_000_000
"""A group takes some seconds, a thousand times as long as the scheduler takes for it."""

AHEAD = 2
"""Groups for each thread of the cluster, one of them waiting; the scheduler never holds more."""

CONNECT_SECONDS = 20

_idle: queue.LifoQueue[Worker] = queue.LifoQueue()
"""Workers that have nothing to do, in a process of Dask's: in the end as many as it has threads."""


def simplify_group(order: Order, timeout: float | None) -> list[Row]:
    """What the cluster does for each group: a row for each file.

    As on one machine, files are given to a process of their own, so that Dask's outlives any of them.
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
    options, overwrite
        See `Order`.
    memory : int or None
        Bytes for each file.
    timeout : float or None
        Seconds for each file.

    Raises
    ------
    UsageError
        Where Dask is not installed.
    InputError
        Where the scheduler does not answer.
    """

    def __init__(
        self, scheduler: str, options: Options, *, overwrite: bool, memory: int | None, timeout: float | None
    ) -> None:
        try:
            import distributed
        except ImportError:
            raise UsageError("--scheduler wants Dask: install bldsimp[dask]") from None
        self.scheduler = scheduler
        self._order = Order([], options, overwrite, memory)
        self._timeout = timeout
        self._stopping = False
        self._groups: dict[Any, list[Task]] = {}
        try:
            self._client = distributed.Client(scheduler, timeout=CONNECT_SECONDS, set_as_default=False)
        except (OSError, ValueError) as error:
            raise InputError(f"{scheduler}: the scheduler does not answer: {error}") from None
        self._ended = distributed.as_completed(loop=self._client.loop)

    def run(self, tasks: list[Task]) -> Iterator[Row]:
        """The last row of each task, as its group ends."""
        waiting = deque(groups_of(tasks, GROUP_FILES, GROUP_BYTES))
        while waiting or self._groups:
            while waiting and not self._stopping and len(self._groups) < self._room():
                self._submit(waiting.popleft())
            if not self._groups:
                break
            future = next(self._ended)
            group = self._groups.pop(future.key)
            for task, row in zip(group, self._rows(future, group), strict=True):
                again = once_more(task, row)
                if again is None or self._stopping:
                    yield row
                else:
                    waiting.append([again])
        self._client.close()

    def stop(self) -> None:
        """Let the groups that the cluster has end, and give it no other."""
        self._stopping = True

    def kill(self) -> None:
        """Leave the cluster, which drops what it was given."""
        self._stopping = True
        self._client.close()

    def _submit(self, group: list[Task]) -> None:
        order = dataclasses.replace(self._order, tasks=group)
        future = self._client.submit(simplify_group, order, self._timeout, pure=False)
        self._groups[future.key] = group
        self._ended.add(future)

    def _room(self) -> int:
        threads: dict[str, int] = self._client.nthreads()
        return max(1, AHEAD * sum(threads.values()))

    def _rows(self, future: Any, group: list[Task]) -> list[Row]:
        """The rows of a group that has ended, however it did."""
        from distributed import KilledWorker

        if future.status in ("cancelled", "lost"):
            raise InputError(f"{self.scheduler}: the scheduler is gone: start one, then --resume")
        error = future.exception() if future.status == "error" else None
        if isinstance(error, KilledWorker):
            return [failure(task, "crash", "the processes of Dask that had it died") for task in group]
        rows: list[Row] = future.result()
        return rows
