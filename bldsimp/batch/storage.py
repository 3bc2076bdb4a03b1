"""Where files are: paths of this machine, or URLs that fsspec knows.

Names beneath a root have ``/`` between. Hidden files and folders are left out, and links to folders are not followed,
so that no walk can go round in circles.
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
from typing import Any, BinaryIO, NamedTuple, Protocol, cast

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


class Entry(NamedTuple):
    """A file that was found.

    Attributes
    ----------
    name : str
        Beneath the root of the walk.
    size : int
        Bytes.
    mtime : int
        Nanoseconds since 1970; 0 where nobody knows.
    refusal : str or None
        Why it cannot be read as a file; nothing was opened.
    """

    name: str
    size: int = 0
    mtime: int = 0
    refusal: str | None = None


class Storage(Protocol):
    """What `batch` wants of a place that holds files; every path is whole."""

    def find(self, root: str, wanted: Callable[[str], bool], skipped: str) -> Iterator[Entry]:
        """Files beneath a root whose names are wanted, in order; nothing beneath another folder, `skipped`."""

    def entry(self, path: str, name: str) -> Entry:
        """One file; refused where it is none."""

    def sizes(self, root: str) -> Callable[[str], int | None]:
        """Tells the size of each file beneath a root by its name; None where there is none."""

    def is_folder(self, path: str) -> bool: ...

    def open(self, path: str) -> BinaryIO:
        """To read it."""

    def reading(self, path: str) -> Any:
        """Context of a file of this machine with the same bytes."""

    def writing(self, path: str) -> Any:
        """Context of a path of this machine; the files that are there at the end appear whole."""

    def clear(self, folder: str) -> None:
        """Remove what processes that were killed left in a folder."""


def is_url(text: str) -> bool:
    """Whether a text has a scheme and ``file`` is not the one."""
    return bool(_SCHEME.match(text)) and not text.startswith("file://")


def local(text: str) -> str:
    """A path without the scheme ``file``."""
    return text.removeprefix("file://")


def whole(text: str) -> str:
    """A path from the top, without the scheme ``file``; a URL as it is."""
    return text if is_url(text) else os.path.abspath(local(text))


def join(root: str, name: str) -> str:
    """The path or URL of a name beneath a root."""
    return f"{root.rstrip('/')}/{name}"


def storage_of(text: str) -> Storage:
    """The storage that a path or URL is in.

    Raises
    ------
    UsageError
        Where fsspec is not installed or does not know the scheme.
    """
    if not is_url(text):
        return Disk()
    try:
        import fsspec

        return Remote(fsspec.core.url_to_fs(text)[0], text.split("://")[0])
    except (ImportError, ValueError) as error:
        raise UsageError(f"{text}: {error}: install bldsimp[dask], and what fsspec names for the scheme") from None


def digest(stream: BinaryIO) -> str:
    """SHA-256 of a stream, in hexadecimal; the memory does not grow with it."""
    total = hashlib.sha256()
    while block := stream.read(1 << 18):
        total.update(block)
    return total.hexdigest()


class Disk:
    """Paths of this machine."""

    def find(self, root: str, wanted: Callable[[str], bool], skipped: str) -> Iterator[Entry]:
        waiting, skipped = [""], os.path.realpath(skipped)
        while waiting:
            folder = waiting.pop()
            try:
                with os.scandir(os.path.join(root, folder)) as found:
                    entries = sorted(found, key=lambda entry: entry.name)
            except OSError as error:
                yield Entry(folder.rstrip("/"), refusal=f"the folder cannot be read: {error.strerror}")
                continue
            folders = []
            for each in entries:
                name = folder + each.name
                if each.name.startswith("."):
                    continue
                if each.is_dir(follow_symlinks=False):
                    if os.path.realpath(each.path) != skipped:
                        folders.append(name + "/")
                elif wanted(name) and not (each.is_symlink() and os.path.isdir(each.path)):
                    yield self.entry(each.path, name)
            waiting += reversed(folders)

    def entry(self, path: str, name: str) -> Entry:
        try:
            found = os.stat(path)
        except OSError as error:
            return Entry(name, refusal=(error.strerror or str(error)).lower())
        if not stat.S_ISREG(found.st_mode):
            return Entry(name, refusal=f"is {_KINDS.get(stat.S_IFMT(found.st_mode), 'no file')}, not a file")
        return Entry(name, found.st_size, found.st_mtime_ns)

    def sizes(self, root: str) -> Callable[[str], int | None]:
        def size(name: str) -> int | None:
            try:
                return os.stat(os.path.join(root, name)).st_size
            except OSError:
                return None

        return size

    def is_folder(self, path: str) -> bool:
        return os.path.isdir(path)

    def open(self, path: str) -> BinaryIO:
        return open(path, "rb")

    @contextmanager
    def reading(self, path: str) -> Iterator[Path]:
        yield Path(path)

    @contextmanager
    def writing(self, path: str) -> Iterator[Path]:
        target = Path(path)
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError(f"{target.parent}: cannot be made: {error.strerror}") from error
        yield target

    def clear(self, folder: str) -> None:
        clear_leftovers(Path(folder))


class Remote:
    """A file system of fsspec's. An object store shows a new object once it is whole; other kinds may not.

    A model's own buffers, libraries and textures are not fetched: GLB and PLY need none.
    """

    def __init__(self, system: Any, scheme: str) -> None:
        self.system = system
        self.scheme = scheme

    def find(self, root: str, wanted: Callable[[str], bool], skipped: str) -> Iterator[Entry]:
        base = self.system._strip_protocol(root).rstrip("/") + "/"
        others = skipped.rstrip("/") + "/" if is_url(skipped) else ""
        beneath = self.system._strip_protocol(others).rstrip("/") + "/" if others.startswith(self.scheme) else base
        for path, information in sorted(self.system.find(base, detail=True).items()):
            name = path.removeprefix(base)
            hidden = any(part.startswith(".") for part in name.split("/"))
            if wanted(name) and not hidden and (beneath == base or not path.startswith(beneath)):
                yield _remote_entry(name, information)

    def entry(self, path: str, name: str) -> Entry:
        try:
            information = self.system.info(path)
        except OSError as error:
            return Entry(name, refusal=(error.strerror or f"no such file: {path}").lower())
        if information["type"] != "file":
            return Entry(name, refusal="is a folder, not a file")
        return _remote_entry(name, information)

    def sizes(self, root: str) -> Callable[[str], int | None]:
        # One listing instead of a question for each file.
        return {entry.name: entry.size for entry in self.find(root, bool, "")}.get

    def is_folder(self, path: str) -> bool:
        return bool(self.system.isdir(path))

    def open(self, path: str) -> BinaryIO:
        return cast(BinaryIO, self.system.open(path, "rb"))

    @contextmanager
    def reading(self, path: str) -> Iterator[Path]:
        with tempfile.TemporaryDirectory(prefix="bldsimp-") as folder:
            here = Path(folder, path.rsplit("/", 1)[1])
            try:
                self.system.get_file(path, str(here))
            except OSError as error:
                raise InputError(f"{path}: cannot be read: {error.strerror or error}") from error
            yield here

    @contextmanager
    def writing(self, path: str) -> Iterator[Path]:
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
        """Nothing: what is not whole does not appear."""


def _remote_entry(name: str, information: dict[str, Any]) -> Entry:
    """An entry of what a file system tells; each names the time in its own way."""
    changed = next(
        (
            information[key]
            for key in ("mtime", "LastModified", "last_modified", "updated", "created")
            if information.get(key) is not None
        ),
        0,
    )
    seconds = changed.timestamp() if hasattr(changed, "timestamp") else changed
    return Entry(name, int(information.get("size") or 0), int(float(seconds) * 1e9) if _is_number(seconds) else 0)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float))
