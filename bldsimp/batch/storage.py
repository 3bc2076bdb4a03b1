"""Where files are: paths of this machine, or URLs that fsspec knows.

Names below a root have ``/`` between folders. Hidden files and folders are left out, and links to folders are not
followed, so that no walk can run in circles.
"""

from __future__ import annotations

import hashlib
import os
import re
import stat
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple, TypeAlias, cast

from ..errors import InputError, OutputError, UsageError
from ..io.atomic import clear_leftovers

_SCHEME = re.compile(r"[a-zA-Z][a-zA-Z0-9+.-]+://")

_KINDS = {
    stat.S_IFIFO: "a FIFO",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFDIR: "a folder",
}

_TIMES = ("mtime", "LastModified", "last_modified", "updated", "created")
"""What the file systems of fsspec call the time of the last change."""


class FileEntry(NamedTuple):
    """A file that was found.

    Attributes
    ----------
    name : str
        Below the root of the walk.
    size : int
        Bytes.
    mtime : int
        Nanoseconds since 1970; 0 where it is not known.
    refusal : str or None
        Why it cannot be read as a file; nothing was opened.
    """

    name: str
    size: int = 0
    mtime: int = 0
    refusal: str | None = None


def is_url(text: str) -> bool:
    """Tell whether a text has a scheme other than ``file``."""
    return bool(_SCHEME.match(text)) and not text.startswith("file://")


def strip_scheme(text: str) -> str:
    """Remove the scheme ``file`` from a path."""
    return text.removeprefix("file://")


def make_absolute(text: str) -> str:
    """Make a path absolute, without the scheme ``file``; a URL stays as it is."""
    return text if is_url(text) else os.path.abspath(strip_scheme(text))


def join_path(root: str, name: str) -> str:
    """Join the path or URL of a folder and a name below it."""
    return f"{root.rstrip('/')}/{name}"


def open_storage(text: str) -> Storage:
    """Open the storage that a path or URL is in.

    Raises
    ------
    UsageError
        Where fsspec is not installed or does not know the scheme.
    """
    if not is_url(text):
        return LocalStorage()
    try:
        import fsspec

        return RemoteStorage(fsspec.core.url_to_fs(text)[0], text.split("://")[0])
    except (ImportError, ValueError) as error:
        raise UsageError(f"{text}: {error}: install bldsimp[dask], and the package that fsspec names") from None


def hash_stream(stream: BinaryIO) -> str:
    """Return the SHA-256 of a stream, in hexadecimal; the memory does not grow with it."""
    total = hashlib.sha256()
    while block := stream.read(1 << 18):
        total.update(block)
    return total.hexdigest()


class LocalStorage:
    """Paths of this machine; every path is absolute."""

    def find(self, root: str, is_wanted: Callable[[str], bool], skipped: str) -> Iterator[FileEntry]:
        """Find the files below a root whose names are wanted, in order, but none below the folder `skipped`."""
        waiting, skipped = [""], os.path.realpath(skipped)
        while waiting:
            folder = waiting.pop()
            try:
                with os.scandir(os.path.join(root, folder)) as found:
                    entries = sorted(found, key=lambda entry: entry.name)
            except OSError as error:
                yield FileEntry(folder.rstrip("/"), refusal=f"the folder cannot be read: {error.strerror}")
                continue
            folders = []
            for each in entries:
                name = folder + each.name
                if each.name.startswith("."):
                    continue
                if each.is_dir(follow_symlinks=False):
                    if os.path.realpath(each.path) != skipped:
                        folders.append(name + "/")
                elif is_wanted(name) and not (each.is_symlink() and os.path.isdir(each.path)):
                    yield self.look_up(each.path, name)
            waiting += reversed(folders)

    def look_up(self, path: str, name: str) -> FileEntry:
        """Look at one file; what is not a file is refused."""
        try:
            found = os.stat(path)
        except OSError as error:
            return FileEntry(name, refusal=(error.strerror or str(error)).lower())
        if not stat.S_ISREG(found.st_mode):
            return FileEntry(name, refusal=f"is {_KINDS.get(stat.S_IFMT(found.st_mode), 'something else')}, not a file")
        return FileEntry(name, found.st_size, found.st_mtime_ns)

    def list_sizes(self, root: str) -> Callable[[str], int | None]:
        """Return a function that gives the size of a file below a root by its name; None where there is none."""

        def find_size(name: str) -> int | None:
            entry = self.look_up(os.path.join(root, name), name)
            return None if entry.refusal else entry.size

        return find_size

    def is_folder(self, path: str) -> bool:
        """Tell whether a path is a folder."""
        return os.path.isdir(path)

    def open(self, path: str) -> BinaryIO:
        """Open a file to read it."""
        return open(path, "rb")

    @contextmanager
    def fetch(self, path: str) -> Iterator[Path]:
        """Yield the path of a file of this machine with the same bytes."""
        yield Path(path)

    @contextmanager
    def store(self, path: str) -> Iterator[Path]:
        """Yield a path of this machine to write to; the files that are there at the end appear whole."""
        target = Path(path)
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError(f"{target.parent}: cannot be made: {error.strerror}") from error
        yield target

    def clear(self, folder: str) -> None:
        """Remove what killed processes left in a folder."""
        clear_leftovers(Path(folder))


class RemoteStorage:
    """A file system of fsspec, with the methods of `LocalStorage`.

    An object store shows a new object once it is whole; other kinds may not. The buffers, libraries and textures of a
    model are not fetched: GLB and PLY need none.
    """

    def __init__(self, system: Any, scheme: str) -> None:
        self.system = system
        self.scheme = scheme

    def find(self, root: str, is_wanted: Callable[[str], bool], skipped: str) -> Iterator[FileEntry]:
        """Find the files below a root whose names are wanted, in order, but none below the folder `skipped`."""
        base = self.system._strip_protocol(root).rstrip("/") + "/"
        other = skipped.startswith(self.scheme + "://") and self.system._strip_protocol(skipped).rstrip("/") + "/"
        for path, information in sorted(self.system.find(base, detail=True).items()):
            name = path.removeprefix(base)
            hidden = any(part.startswith(".") for part in name.split("/"))
            if is_wanted(name) and not hidden and not (other and other != base and path.startswith(other)):
                yield _make_entry(name, information)

    def look_up(self, path: str, name: str) -> FileEntry:
        """Look at one file; what is not a file is refused."""
        try:
            information = self.system.info(path)
        except OSError as error:
            return FileEntry(name, refusal=(error.strerror or f"no such file: {path}").lower())
        if information["type"] != "file":
            return FileEntry(name, refusal="is a folder, not a file")
        return _make_entry(name, information)

    def list_sizes(self, root: str) -> Callable[[str], int | None]:
        """Return a function that gives the size of a file below a root by its name, from a single listing."""
        return {entry.name: entry.size for entry in self.find(root, bool, "")}.get

    def is_folder(self, path: str) -> bool:
        """Tell whether a URL is a folder."""
        return bool(self.system.isdir(path))

    def open(self, path: str) -> BinaryIO:
        """Open a file to read it."""
        return cast(BinaryIO, self.system.open(path, "rb"))

    @contextmanager
    def fetch(self, path: str) -> Iterator[Path]:
        """Yield the path of a copy on this machine."""
        with tempfile.TemporaryDirectory(prefix="bldsimp-") as folder:
            here = Path(folder, path.rsplit("/", 1)[1])
            try:
                self.system.get_file(path, str(here))
            except OSError as error:
                raise InputError(f"{path}: cannot be read: {error.strerror or error}") from error
            yield here

    @contextmanager
    def store(self, path: str) -> Iterator[Path]:
        """Yield a path of this machine to write to; the files that are there at the end are copied to the URL."""
        root, name = path.rsplit("/", 1)
        with tempfile.TemporaryDirectory(prefix="bldsimp-") as folder:
            yield Path(folder, name)
            # The file itself last, as on a disk.
            made = sorted(os.listdir(folder), key=lambda each: (each == name, each))
            try:
                self.system.makedirs(root, exist_ok=True)
                for each in made:
                    self.system.put_file(os.path.join(folder, each), f"{root}/{each}")
            except OSError as error:
                raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from error

    def clear(self, folder: str) -> None:
        """Do nothing: files that are not whole do not appear."""


Storage: TypeAlias = LocalStorage | RemoteStorage


def _make_entry(name: str, information: dict[str, Any]) -> FileEntry:
    """Make an entry from the information of a file system."""
    changed = next((information[key] for key in _TIMES if information.get(key) is not None), 0)
    seconds = changed.timestamp() if hasattr(changed, "timestamp") else changed
    mtime = int(float(seconds) * 1e9) if isinstance(seconds, (int, float)) else 0
    return FileEntry(name, int(information.get("size") or 0), mtime)
