"""What earlier runs have done and need not be done again."""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

from .. import __version__
from ..errors import UsageError
from ..options import Options
from .row import Row
from .storage import Storage, digest, storage_of
from .task import Task, recipe


class Finished(NamedTuple):
    """What a row tells of a file that is done."""

    output: str
    input_bytes: int
    input_mtime_ns: int
    input_sha256: str
    output_bytes: int
    output_sha256: str


def finished(rows: Iterable[Row], options: Options) -> dict[str, Finished]:
    """Files that this version has done with these options, by name; the last row of a file counts."""
    wanted = (recipe(options), __version__)
    found: dict[str, Finished] = {}
    for row in rows:
        if row.failed or (row.options, row.version) != wanted:
            found.pop(row.input, None)
        else:
            found[row.input] = Finished(
                row.output,
                row.input_bytes,
                row.input_mtime_ns,
                row.input_sha256 or "",
                row.output_bytes or 0,
                row.output_sha256 or "",
            )
    return found


def unfinished(tasks: list[Task], done: dict[str, Finished], root: str, *, verify: bool, jobs: int) -> list[Task]:
    """Tasks that are to be done: never done, their input changed since, or their output is gone or another.

    Sizes and times are compared first. Only an input of the same size and another time is hashed, or
    everything where `verify` says so.

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
            or (before.output, before.input_bytes) != (task.output, task.size)
            or size_of(task.output) != before.output_bytes
        ):
            left.append(task)
        elif verify or before.input_mtime_ns != task.mtime:
            unsure.append(task)

    def changed(task: Task) -> bool:
        before = done[task.name]
        if _digest(storage_of(task.source), task.source) != before.input_sha256:
            return True
        return verify and _digest(outputs, task.target) != before.output_sha256

    with ThreadPoolExecutor(jobs) as pool:
        left += [task for task, differs in zip(unsure, pool.map(changed, unsure), strict=True) if differs]
    return left


def _digest(storage: Storage, path: str) -> str | None:
    """The hash of a file; None where it cannot be read."""
    try:
        with storage.open(path) as stream:
            return digest(stream)
    except OSError:
        return None


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
