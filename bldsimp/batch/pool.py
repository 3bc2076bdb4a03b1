"""A pool of processes on this machine that share its memory; a bad file does not stop the others."""

from __future__ import annotations

import dataclasses
import threading
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from queue import SimpleQueue

from ..display import format_bytes
from .memory import LEAST_NEED, divide_memory, estimate_memory
from .row import FileRow, make_failure, make_retry
from .task import Task, WorkOrder, split_into_groups
from .worker import Worker

GROUP_FILES = 64
GROUP_BYTES = 4_000_000
"""A group takes a worker some tenths of a second, thousands of times as long as sending it."""

GROUPS_PER_JOB = 8
"""At the end a worker waits for the others no longer than for such a share of its own time."""


@dataclass(frozen=True)
class Group:
    """Tasks for one worker, and the bytes of memory that are reserved for it."""

    tasks: list[Task]
    memory: int


class Pool:
    """Runs tasks in processes of this machine.

    A thread of this process leads each worker, and does nothing but wait for it.

    Parameters
    ----------
    order : WorkOrder
        Without tasks and memory.
    timeout : float or None
        Seconds for each file.
    jobs : int
        How many processes.
    memory : int
        Bytes that all of them may use together.

    Raises
    ------
    UsageError
        Where the memory is too little for the jobs.
    """

    def __init__(self, order: WorkOrder, timeout: float | None, *, jobs: int, memory: int) -> None:
        self._order = order
        self._timeout = timeout
        self.jobs = jobs
        self.memory, self.share = divide_memory(memory, jobs)
        self._ended: SimpleQueue[FileRow | BaseException | None] = SimpleQueue()
        self._stopping = False
        self._queue = GroupQueue(self.memory, self._is_stopping)
        self._workers: list[Worker] = []

    def run(self, tasks: list[Task]) -> Iterator[FileRow]:
        """Yield the last row of each task, as it ends."""
        possible = []
        for task in tasks:
            least = LEAST_NEED * task.size
            if least <= self.memory:
                possible.append(task)
                continue
            needed, allowed = format_bytes(least), format_bytes(self.memory)
            yield make_failure(
                task, "memory", f"needs at least {needed} of memory but may use {allowed}: give a larger --memory"
            )
        most = min(GROUP_FILES, 1 + len(possible) // (GROUPS_PER_JOB * self.jobs))
        groups = [Group(some, self._reserve(some[0])) for some in split_into_groups(possible, most, GROUP_BYTES)]
        self._queue.fill(groups, self.share)
        running = min(self.jobs, len(groups))
        for _ in range(running):
            threading.Thread(target=self._lead_worker, daemon=True).start()
        while running:
            ended = self._ended.get()
            if isinstance(ended, BaseException):
                raise ended
            if ended is None:
                running -= 1
            else:
                yield ended

    def stop(self) -> None:
        """Let the files that run end, and begin no other.

        A signal handler may call this at any moment, so it takes no lock.
        """
        self._stopping = True

    def kill(self) -> None:
        """End all processes at once."""
        self.stop()
        for worker in self._workers:
            worker.kill()

    def _is_stopping(self) -> bool:
        return self._stopping

    def _reserve(self, largest: Task) -> int:
        """Return the bytes to reserve for a group by its largest file."""
        return min(max(self.share, estimate_memory(largest)), self.memory)

    def _lead_worker(self) -> None:
        """Lead one worker from group to group."""
        worker = Worker()
        self._workers.append(worker)
        try:
            while (group := self._queue.take()) is not None:
                order = dataclasses.replace(self._order, tasks=group.tasks, memory=group.memory)
                for task, row in worker.run(order, self._timeout, self._is_stopping):
                    self._pass_on(task, row)
                self._queue.release(group)
        except BaseException as error:
            self._ended.put(error)
        finally:
            worker.close()
            self._ended.put(None)

    def _pass_on(self, task: Task, row: FileRow) -> None:
        """Pass a row on, or try the file again: with all the memory, where that may have been the reason."""
        retry = make_retry(task, row)
        if retry is None or self._stopping:
            self._ended.put(row)
        else:
            self._queue.add(Group([retry], self.memory if row.kind in ("memory", "crash") else self._reserve(retry)))


class GroupQueue:
    """Groups that wait, and the memory that is free.

    Parameters
    ----------
    memory : int
        Bytes that all groups that run may use together.
    is_stopping : callable
        Tells whether to hand out no other group.
    """

    def __init__(self, memory: int, is_stopping: Callable[[], bool]) -> None:
        self._free = memory
        self._is_stopping = is_stopping
        self._running = 0
        self._changed = threading.Condition()
        # Large files first; small ones do not wait for a large one that does not fit, and second tries come last.
        self._queues: list[deque[Group]] = [deque(), deque(), deque()]

    def fill(self, groups: list[Group], share: int) -> None:
        """Add the first groups; those that need more than their share of the memory go first."""
        for group in groups:
            self._queues[0 if group.memory > share else 1].append(group)

    def add(self, group: Group) -> None:
        """Add a group for a second try."""
        with self._changed:
            self._queues[2].append(group)
            self._changed.notify_all()

    def take(self) -> Group | None:
        """Take the next group that fits; None when none is left, nor can come from the groups that run.

        At its end each group that runs wakes those who wait, also to notice that all is to stop.
        """
        with self._changed:
            while not self._is_stopping():
                for queue in self._queues:
                    if queue and queue[0].memory <= self._free:
                        group = queue.popleft()
                        self._free -= group.memory
                        self._running += 1
                        return group
                if not self._running:
                    break
                self._changed.wait()
            return None

    def release(self, group: Group) -> None:
        """Release the memory of a group that has ended."""
        with self._changed:
            self._free += group.memory
            self._running -= 1
            self._changed.notify_all()
