"""The manifest: one row for each file that ended, appended by one process alone, and enough to go on from.

On this machine it is a file of JSON Lines. Most storage behind a URL cannot append; there it is a row of numbered parts
(``manifest.jsonl.000001`` ...), each of which appears whole.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from itertools import chain
from typing import Protocol

from ..errors import InputError, OutputError, UsageError
from .row import Row
from .storage import Remote, is_url, local, storage_of

SYNC_SECONDS = 5.0
"""A row stands on the disk, or behind the URL, after this long at the latest."""


class Manifest(Protocol):
    """Where rows go."""

    @property
    def empty(self) -> bool:
        """Whether no earlier run has left a row."""

    def clear(self) -> None:
        """Forget what earlier runs have left."""

    def rows(self) -> Iterator[Row]:
        """Rows of earlier runs; to be read to the end before anything is appended."""

    def append(self, row: Row) -> None: ...

    def close(self) -> None: ...


def open_manifest(text: str, *, resume: bool, overwrite: bool) -> Manifest:
    """The manifest at a path or URL.

    Raises
    ------
    UsageError
        Where it holds rows and is neither to be resumed nor to be replaced, or another run writes it.
    OutputError
        Where it cannot be written.
    """
    kind = Parts if is_url(text) else Lines
    manifest = kind(local(text))
    if not resume and not manifest.empty:
        if not overwrite:
            manifest.close()
            raise UsageError(f"{text}: exists: give --resume to go on with it, or --overwrite to start anew")
        manifest.clear()
    return manifest


def read_manifest(text: str) -> Iterator[Row]:
    """The rows of a manifest that nobody need be able to write.

    Raises
    ------
    InputError
        Where it cannot be read.
    """
    if is_url(text):
        return Parts(text).rows()
    try:
        stream = open(local(text), "rb")  # noqa: SIM115
    except OSError as error:
        raise InputError(f"{text}: cannot be read: {error.strerror}") from None
    return chain.from_iterable(map(_row, stream))


class Lines:
    """A file of this machine, locked while it is open."""

    def __init__(self, path: str) -> None:
        self.path = path
        try:
            os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
            self._file = open(path, "ab+", buffering=0)  # noqa: SIM115
        except OSError as error:
            raise OutputError(f"{path}: cannot be written: {error.strerror}") from None
        _lock(self._file.fileno(), path)
        self._end = os.fstat(self._file.fileno()).st_size
        self._synced = time.monotonic()

    @property
    def empty(self) -> bool:
        return self._end == 0

    def clear(self) -> None:
        self._file.truncate(0)
        self._end = 0

    def rows(self) -> Iterator[Row]:
        """Rows of earlier runs; what was torn off a last line is cut."""
        self._file.seek(0)
        end = 0
        # The descriptor is the lock, and stays; the buffer is for reading alone.
        with open(os.dup(self._file.fileno()), "rb") as stream:
            for line in stream:
                if line.endswith(b"\n"):
                    end += len(line)
                    yield from _row(line)
        self._cut(end)

    def append(self, row: Row) -> None:
        """Add a row; where there is no room for all of it, none of it stays."""
        line = row.to_line()
        try:
            written = self._file.write(line)
            if written != len(line):
                self._file.write(line[written:])
            if time.monotonic() - self._synced > SYNC_SECONDS:
                self._sync()
        except OSError as error:
            self._cut(self._end)
            raise OutputError(f"{self.path}: cannot be written: {error.strerror}: make room, then --resume") from error
        self._end += len(line)

    def close(self) -> None:
        if not self._file.closed:
            self._sync()
            self._file.close()

    def _sync(self) -> None:
        os.fsync(self._file.fileno())
        self._synced = time.monotonic()

    def _cut(self, end: int) -> None:
        self._file.truncate(end)
        self._end = end


class Parts:
    """Numbered objects behind a URL."""

    def __init__(self, url: str) -> None:
        self.url = url
        storage = storage_of(url)
        assert isinstance(storage, Remote)
        self._system = storage.system
        self._lines: list[bytes] = []
        self._written = time.monotonic()
        self._parts = sorted(self._system.glob(url + ".[0-9]*"))
        self._next = 1 + int(self._parts[-1].rpartition(".")[2] if self._parts else 0)

    @property
    def empty(self) -> bool:
        return not self._parts

    def clear(self) -> None:
        for part in self._parts:
            self._system.rm_file(part)
        self._parts, self._next = [], 1

    def rows(self) -> Iterator[Row]:
        for part in self._parts:
            with self._system.open(part, "rb") as stream:
                for line in stream:
                    yield from _row(line)

    def append(self, row: Row) -> None:
        """Add a row to the part that is to be written next."""
        self._lines.append(row.to_line())
        if time.monotonic() - self._written > SYNC_SECONDS:
            self._write()

    def close(self) -> None:
        self._write()

    def _write(self) -> None:
        """Write the part, if it has rows."""
        self._written = time.monotonic()
        if not self._lines:
            return
        part = f"{self.url}.{self._next:06}"
        try:
            self._system.makedirs(part.rsplit("/", 1)[0], exist_ok=True)
            self._system.pipe_file(part, b"".join(self._lines))
        except OSError as error:
            raise OutputError(f"{part}: cannot be written: {error.strerror or error}") from error
        self._lines, self._next = [], self._next + 1


def _row(line: bytes) -> Iterator[Row]:
    """The row of a line, if it holds one: what a crash of the machine left in between costs no other."""
    try:
        yield Row.from_line(line)
    except ValueError:
        return


def _lock(descriptor: int, path: str) -> None:
    """Keep other runs out; the system takes the lock back however this one ends.

    Raises
    ------
    UsageError
    """
    import fcntl

    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise UsageError(f"{path}: another run writes it: wait for it, or give another --manifest") from None
    except OSError:
        # A file system without locks.
        return
