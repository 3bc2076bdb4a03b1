"""A pool of processes on this machine: memory is shared out, and a bad file costs no other."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from queue import SimpleQueue

from ..options import Options
from ..report import size_in_words
from .engine import once_more
from .groups import groups_of
from .memory import least_need, likely_need, share_of
from .row import Row, failure
from .task import Order, Task
from .worker import Worker

GROUP_FILES = 64
GROUP_BYTES = 4_000_000
"""A group takes a worker some tenths of a second, thousands of times as long as to send it."""

GROUPS_PER_JOB = 8
"""At the end a worker waits for the others no longer than for a share of its own time like this."""


@dataclass(frozen=True)
class Group:
    """Tasks that one worker takes, and the bytes of memory that are kept for it."""

    tasks: list[Task]
    memory: int


class Pool:
    """Runs tasks in processes of this machine.

    Each worker is led by a thread of this process, which does nothing but wait for it.

    Parameters
    ----------
    options : Options
    overwrite : bool
        See `Order`.
    jobs : int
        How many processes.
    memory : int
        Bytes that all of them may take together.
    timeout : float or None
        Seconds for each file.

    Raises
    ------
    UsageError
        Where the memory is too little for the jobs.
    """

    def __init__(self, options: Options, *, overwrite: bool, jobs: int, memory: int, timeout: float | None) -> None:
        self.options = options
        self.overwrite = overwrite
        self.jobs = jobs
        self.timeout = timeout
        self.memory, self.share = share_of(memory, jobs)
        self._ended: SimpleQueue[Row | BaseException | None] = SimpleQueue()
        self._stopping = False
        self._line = _Line(self.memory, lambda: self._stopping)
        self._workers: list[Worker] = []

    def run(self, tasks: list[Task]) -> Iterator[Row]:
        """The last row of each task, as it ends."""
        possible = []
        for task in tasks:
            if least_need(task) <= self.memory:
                possible.append(task)
                continue
            wanted, there = size_in_words(least_need(task)), size_in_words(self.memory)
            yield failure(task, "memory", f"needs {wanted} of memory at least, and may use {there}: give --memory more")
        most = min(GROUP_FILES, 1 + len(possible) // (GROUPS_PER_JOB * self.jobs))
        groups = [Group(some, self._memory_for(some[0])) for some in groups_of(possible, most, GROUP_BYTES)]
        self._line.fill(groups, self.share)
        leaders = [threading.Thread(target=self._lead, daemon=True) for _ in range(min(self.jobs, len(groups)))]
        for leader in leaders:
            leader.start()
        running = len(leaders)
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

        A signal may call this in the middle of anything, so that no lock may be taken.
        """
        self._stopping = True

    def kill(self) -> None:
        """End all processes at once."""
        self.stop()
        for worker in self._workers:
            worker.kill()

    def _memory_for(self, largest: Task) -> int:
        return min(max(self.share, likely_need(largest)), self.memory)

    def _lead(self) -> None:
        """Lead one worker from group to group."""
        worker = Worker()
        self._workers.append(worker)
        try:
            while (group := self._line.take()) is not None:
                order = Order(group.tasks, self.options, self.overwrite, group.memory)
                for task, row in worker.run(order, self.timeout, lambda: self._stopping):
                    self._tell(task, row)
                self._line.give_back(group)
        except BaseException as error:
            self._ended.put(error)
        finally:
            worker.close()
            self._ended.put(None)

    def _tell(self, task: Task, row: Row) -> None:
        """Pass a row on, or have the file tried once more: with all the memory, where that may have been the reason."""
        again = once_more(task, row)
        if again is None or self._stopping:
            self._ended.put(row)
        else:
            self._line.add(Group([again], self.memory if row.kind in ("memory", "crash") else self._memory_for(again)))


class _Line:
    """Groups that wait, and the memory that is free."""

    def __init__(self, memory: int, stopping: Callable[[], bool]) -> None:
        self._free = memory
        self._stopping = stopping
        self._running = 0
        self._changed = threading.Condition()
        # Large files first; small ones do not wait for a large one that does not fit, and second tries come last.
        self._queues: list[deque[Group]] = [deque(), deque(), deque()]

    def fill(self, groups: list[Group], share: int) -> None:
        for group in groups:
            self._queues[0 if group.memory > share else 1].append(group)

    def add(self, group: Group) -> None:
        with self._changed:
            self._queues[2].append(group)
            self._changed.notify_all()

    def take(self) -> Group | None:
        """The next group that fits; None when none is left, nor can come from those that run.

        Who waits is woken by those that run, at the end of each, also to see that all is to stop.
        """
        with self._changed:
            while not self._stopping():
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

    def give_back(self, group: Group) -> None:
        with self._changed:
            self._free += group.memory
            self._running -= 1
            self._changed.notify_all()
