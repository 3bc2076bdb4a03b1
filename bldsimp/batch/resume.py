"""Find out what earlier runs have done and what remains."""

from __future__ import annotations

import os
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

from .. import __version__
from ..errors import UsageError
from ..options import Options
from .row import FileRow
from .storage import FileEntry, Storage, hash_stream, open_storage
from .task import Task, encode_options


class ReadFile(NamedTuple):
    """A file that was read: its path from the folder of the input, empty for the input itself."""

    name: str
    size: int
    mtime: int
    sha256: str


class DoneFile(NamedTuple):
    """What the manifest records of a file that is done."""

    formats: tuple[str, str]
    output: str
    output_bytes: int
    output_sha256: str
    read: tuple[ReadFile, ...]


def collect_done(rows: Iterable[FileRow], options: Options) -> dict[str, DoneFile]:
    """Collect the files that this version has done with these options, by name; the last row of a file counts."""
    wanted = (encode_options(options), __version__)
    done: dict[str, DoneFile] = {}
    for row in rows:
        if row.failed or (row.options, row.version) != wanted:
            done.pop(row.input, None)
            continue
        read = (
            ReadFile("", row.input_bytes, row.input_mtime_ns, row.input_sha256 or ""),
            *(ReadFile(each["name"], each["bytes"], each["mtime_ns"], each["sha256"]) for each in row.beside),
        )
        formats = row.format_before, row.format_after
        done[row.input] = DoneFile(formats, row.output, row.output_bytes or 0, row.output_sha256 or "", read)
    return done


def select_remaining(tasks: list[Task], done: dict[str, DoneFile], root: str, *, verify: bool, jobs: int) -> list[Task]:
    """Select the tasks that were never done, whose inputs have changed, or whose output is gone or another one.

    Sizes and times are compared first. A file is hashed only where it has the same size and another time; with
    `verify`, every file is hashed.

    Notes
    -----
    Linear: each task is looked at once, and each file is hashed once.
    """
    outputs = open_storage(root)
    size_of = outputs.list_sizes(root)
    remaining, unsure = [], []
    for task in tasks:
        before = done.get(task.name)
        if (
            before is None
            or (before.formats, before.output) != ((task.from_, task.to), task.output)
            or size_of(task.output) != before.output_bytes
        ):
            remaining.append(task)
            continue
        now = [_look_up(task, read) for read in before.read]
        if [entry.size for entry in now] != [read.size for read in before.read]:
            remaining.append(task)
        elif verify or [entry.mtime for entry in now] != [read.mtime for read in before.read]:
            unsure.append(task)

    def has_changed(task: Task) -> bool:
        before = done[task.name]
        inputs = open_storage(task.source)
        if any(_hash_file(inputs, _path_of(task, read)) != read.sha256 for read in before.read):
            return True
        return verify and _hash_file(outputs, task.target) != before.output_sha256

    with ThreadPoolExecutor(jobs) as pool:
        return remaining + [
            task for task, changed in zip(unsure, pool.map(has_changed, unsure), strict=True) if changed
        ]


def refuse_existing(tasks: list[Task], root: str) -> None:
    """Refuse to write where a file exists.

    Raises
    ------
    UsageError
    """
    size_of = open_storage(root).list_sizes(root)
    existing = [task.target for task in tasks if size_of(task.output) is not None]
    if existing:
        more = f" and {len(existing) - 1:,} more results" if len(existing) > 1 else ""
        raise UsageError(f"{existing[0]}{more}: exists: give --overwrite to replace it")


def _path_of(task: Task, read: ReadFile) -> str:
    return os.path.join(os.path.dirname(task.source), read.name) if read.name else task.source


def _look_up(task: Task, read: ReadFile) -> FileEntry:
    """Look at a file that was read; the input itself was looked at when it was found."""
    if not read.name:
        return FileEntry(task.name, task.size, task.mtime)
    return open_storage(task.source).look_up(_path_of(task, read), read.name)


def _hash_file(storage: Storage, path: str) -> str | None:
    """Return the hash of a file; None where it cannot be read."""
    try:
        with storage.open(path) as stream:
            return hash_stream(stream)
    except OSError:
        return None
