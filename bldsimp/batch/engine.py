"""What runs tasks, whatever it is made of."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Protocol

from .row import Row
from .task import Task


class Engine(Protocol):
    """Runs tasks; each that fails is tried once more by itself."""

    def run(self, tasks: list[Task]) -> Iterator[Row]:
        """The last row of each task, as it ends."""

    def stop(self) -> None:
        """Let what runs end, and begin nothing more; safe in a signal's handler."""

    def kill(self) -> None:
        """End everything at once."""


def once_more(task: Task, row: Row) -> Task | None:
    """The task for its second try; None where it has ended.

    A full disk is none of the file's fault: trying goes on once there is room.
    """
    if not row.failed or row.kind in ("refused", "full") or task.again:
        return None
    return dataclasses.replace(task, again=True)
