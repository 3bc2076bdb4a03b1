"""What earlier runs have done and need not be done again."""

from __future__ import annotations

import os
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

from .. import __version__
from ..errors import UsageError
from ..options import Options
from .row import Row
from .storage import Entry, Storage, digest, storage_of
from .task import Task, recipe


class Seen(NamedTuple):
    """A file that was read: its path from the folder of the input, empty for the input itself."""

    name: str
    size: int
    mtime: int
    sha256: str


class Finished(NamedTuple):
    """What a row tells of a file that is done."""

    formats: tuple[str, str]
    output: str
    output_bytes: int
    output_sha256: str
    read: tuple[Seen, ...]


def finished(rows: Iterable[Row], options: Options) -> dict[str, Finished]:
    """Files that this version has done with these options, by name; the last row of a file counts."""
    wanted = (recipe(options), __version__)
    found: dict[str, Finished] = {}
    for row in rows:
        if row.failed or (row.options, row.version) != wanted:
            found.pop(row.input, None)
            continue
        read = (
            Seen("", row.input_bytes, row.input_mtime_ns, row.input_sha256 or ""),
            *(Seen(each["name"], each["bytes"], each["mtime_ns"], each["sha256"]) for each in row.beside),
        )
        formats = row.format_before, row.format_after
        found[row.input] = Finished(formats, row.output, row.output_bytes or 0, row.output_sha256 or "", read)
    return found


def unfinished(tasks: list[Task], done: dict[str, Finished], root: str, *, verify: bool, jobs: int) -> list[Task]:
    """Tasks that are to be done: never done, what they read has changed since, or their output is gone or another.

    Sizes and times are compared first. Only what has the same size and another time is hashed, or everything
    where `verify` says so.

    Notes
    -----
    Linear: each task is looked at once, and what is hashed is hashed once.
    """
    outputs = storage_of(root)
    size_of = outputs.sizes(root)
    left, unsure = [], []
    for task in tasks:
        before = done.get(task.name)
        if (
            before is None
            or (before.formats, before.output) != ((task.from_, task.to), task.output)
            or size_of(task.output) != before.output_bytes
        ):
            left.append(task)
            continue
        now = [_now(task, seen) for seen in before.read]
        if any(entry.size != seen.size for entry, seen in zip(now, before.read, strict=True)):
            left.append(task)
        elif verify or any(entry.mtime != seen.mtime for entry, seen in zip(now, before.read, strict=True)):
            unsure.append(task)

    def changed(task: Task) -> bool:
        before = done[task.name]
        inputs = storage_of(task.source)
        if any(_digest(inputs, _path(task, seen)) != seen.sha256 for seen in before.read):
            return True
        return verify and _digest(outputs, task.target) != before.output_sha256

    with ThreadPoolExecutor(jobs) as pool:
        left += [task for task, differs in zip(unsure, pool.map(changed, unsure), strict=True) if differs]
    return left


def check_new(tasks: list[Task], root: str) -> None:
    """Refuse to write where something is.

    Raises
    ------
    UsageError
    """
    size_of = storage_of(root).sizes(root)
    there = [task.target for task in tasks if size_of(task.output) is not None]
    if there:
        more = f" and {len(there) - 1:,} more results" if len(there) > 1 else ""
        raise UsageError(f"{there[0]}{more}: exists: give --overwrite to replace what is there")


def _path(task: Task, seen: Seen) -> str:
    return os.path.join(os.path.dirname(task.source), seen.name) if seen.name else task.source


def _now(task: Task, seen: Seen) -> Entry:
    """What is there now of a file that was read; the input itself was looked at when it was found."""
    if not seen.name:
        return Entry(task.name, task.size, task.mtime)
    return storage_of(task.source).entry(_path(task, seen), seen.name)


def _digest(storage: Storage, path: str) -> str | None:
    """The hash of a file; None where it cannot be read."""
    try:
        with storage.open(path) as stream:
            return digest(stream)
    except OSError:
        return None
