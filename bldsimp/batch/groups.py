"""Files that a worker takes together, so that small ones do not wait for messages."""

from __future__ import annotations

from collections.abc import Iterator

from .task import Task


def groups_of(tasks: list[Task], most_files: int, most_bytes: int) -> Iterator[list[Task]]:
    """Tasks in groups, the largest files first, so that no large one is left for the end.

    A group is full with `most_files`, or with `most_bytes` of them; a file may be larger by itself.
    """
    some: list[Task] = []
    size = 0
    for task in sorted(tasks, key=lambda task: (-task.size, task.name)):
        if some and (len(some) == most_files or size + task.size > most_bytes):
            yield some
            some, size = [], 0
        some.append(task)
        size += task.size
    if some:
        yield some
