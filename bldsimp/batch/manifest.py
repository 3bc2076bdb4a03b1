"""The manifest: one row for each file that ended, which one process appends, and enough to resume from.

On this machine it is a file of JSON Lines. Most storage behind a URL cannot append; there it consists of numbered parts
(``manifest.jsonl.000001`` ...), each of which appears whole.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from typing import TypeAlias

from filelock import FileLock, Timeout

from ..errors import InputError, OutputError, UsageError
from .row import FileRow
from .storage import RemoteStorage, is_url, open_storage, strip_scheme

SYNC_SECONDS = 5.0
"""A row is on the disk, or behind the URL, after this long at the latest."""


def open_manifest(text: str, *, resume: bool, overwrite: bool) -> Manifest:
    """Open the manifest at a path or URL to append to it.

    Raises
    ------
    UsageError
        Where it has rows and is neither to be resumed nor to be replaced, or another run writes it.
    OutputError
        Where it cannot be written.
    """
    manifest: Manifest = RemoteManifest(text) if is_url(text) else LocalManifest(strip_scheme(text))
    if not resume and not manifest.empty:
        if not overwrite:
            manifest.close()
            raise UsageError(f"{text}: exists: give --resume to continue it, or --overwrite to start again")
        manifest.clear()
    return manifest


def read_manifest(text: str) -> Iterator[FileRow]:
    """Read the rows of a manifest; it need not be writable.

    Raises
    ------
    InputError
        Where it cannot be read.
    """
    if is_url(text):
        yield from RemoteManifest(text).rows()
        return
    try:
        with open(strip_scheme(text), "rb") as stream:
            for line in stream:
                yield from _parse_row(line)
    except OSError as error:
        raise InputError(f"{text}: cannot be read: {error.strerror}") from None


class LocalManifest:
    """A file of this machine. While it is open, a lock keeps other runs out; it ends with the process."""

    def __init__(self, path: str) -> None:
        self.path = path
        folder, name = os.path.split(path)
        try:
            os.makedirs(folder or ".", exist_ok=True)
            self._lock = FileLock(os.path.join(folder, f".{name}.lock"))
            self._lock.acquire(blocking=False)
            self._file = open(path, "ab+", buffering=0)  # noqa: SIM115  # `close` closes it
        except Timeout:
            raise UsageError(f"{path}: another run writes it: wait for it, or give another --manifest") from None
        except OSError as error:
            raise OutputError(f"{path}: cannot be written: {error.strerror}") from None
        self._end = os.fstat(self._file.fileno()).st_size
        self._synced = time.monotonic()

    @property
    def empty(self) -> bool:
        """Whether no earlier run has left a row."""
        return self._end == 0

    def clear(self) -> None:
        """Remove the rows of earlier runs."""
        self._cut(0)

    def rows(self) -> Iterator[FileRow]:
        """Yield the rows of earlier runs, and cut off a torn last line; read them all before you append."""
        end = 0
        with open(self.path, "rb") as stream:
            for line in stream:
                if line.endswith(b"\n"):
                    end += len(line)
                    yield from _parse_row(line)
        self._cut(end)

    def append(self, row: FileRow) -> None:
        """Append a row; where there is no room for all of it, none of it stays."""
        line = row.to_line()
        try:
            written = self._file.write(line)
            if written != len(line):
                self._file.write(line[written:])
            if time.monotonic() - self._synced > SYNC_SECONDS:
                self._sync()
        except OSError as error:
            self._cut(self._end)
            raise OutputError(
                f"{self.path}: cannot be written: {error.strerror}: make room, then use --resume"
            ) from error
        self._end += len(line)

    def close(self) -> None:
        """Write all rows to the disk, and let other runs in."""
        if not self._file.closed:
            self._sync()
            self._file.close()
            self._lock.release()

    def _sync(self) -> None:
        os.fsync(self._file.fileno())
        self._synced = time.monotonic()

    def _cut(self, end: int) -> None:
        self._file.truncate(end)
        self._end = end


class RemoteManifest:
    """Numbered objects behind a URL, with the methods of `LocalManifest`."""

    def __init__(self, url: str) -> None:
        self.url = url
        storage = open_storage(url)
        assert isinstance(storage, RemoteStorage)
        self._system = storage.system
        self._lines: list[bytes] = []
        self._written = time.monotonic()
        self._parts = sorted(self._system.glob(url + ".[0-9]*"))
        self._next = 1 + int(self._parts[-1].rpartition(".")[2] if self._parts else 0)

    @property
    def empty(self) -> bool:
        """Whether no earlier run has left a row."""
        return not self._parts

    def clear(self) -> None:
        """Remove the rows of earlier runs."""
        for part in self._parts:
            self._system.rm_file(part)
        self._parts, self._next = [], 1

    def rows(self) -> Iterator[FileRow]:
        """Yield the rows of earlier runs."""
        for part in self._parts:
            with self._system.open(part, "rb") as stream:
                for line in stream:
                    yield from _parse_row(line)

    def append(self, row: FileRow) -> None:
        """Append a row to the part that is written next."""
        self._lines.append(row.to_line())
        if time.monotonic() - self._written > SYNC_SECONDS:
            self.close()

    def close(self) -> None:
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


Manifest: TypeAlias = LocalManifest | RemoteManifest


def _parse_row(line: bytes) -> Iterator[FileRow]:
    """Yield the row of a line, if it is one: damage that a crash of the machine left does not lose other rows."""
    try:
        yield FileRow.from_line(line)
    except ValueError:
        return
