"""Write files that appear whole, together, or not at all."""

from __future__ import annotations

import contextlib
import hashlib
import os
import platform
import re
import secrets
import shutil
import time
from functools import lru_cache
from pathlib import Path
from typing import BinaryIO

from ..errors import OutputError

_LEFTOVER = re.compile(r"\.bldsimp-([0-9a-f]{8})-([0-9]+)-[0-9a-f]{8}\.tmp")
"""Names the machine and the process that write a file, and a number of the file."""

ABANDONED_SECONDS = 3600.0
"""A file that did not change for so long is no longer being written, whoever has its process's number now."""


def replace_files(files: dict[Path, bytes]) -> None:
    """Write files next to their targets, then move all into place; the last one last.

    Parameters
    ----------
    files : dict of Path to bytes
        A target that is no regular file (a pipe, a device) is written to directly.

    Raises
    ------
    OutputError
        If one cannot be written; what was there before is then untouched, and nothing is left over.
    """
    temporary: dict[Path, Path] = {}
    where = Path()
    try:
        for path, data in files.items():
            where = path
            if path.exists() and not path.is_file():
                # By its own name: what /dev/stdout or /dev/fd/3 lead to need not have one.
                path.write_bytes(data)
                continue
            target = Path(os.path.realpath(path))
            temporary_path = target.with_name(f".bldsimp-{_machine()}-{os.getpid()}-{secrets.token_hex(4)}.tmp")
            temporary[temporary_path] = target
            with open(temporary_path, "xb") as stream:
                stream.write(data)
            if target.exists():
                shutil.copymode(target, temporary_path)
        for temporary_path, target in list(temporary.items()):
            where = target
            os.replace(temporary_path, target)
            del temporary[temporary_path]
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OutputError(f"{where}: cannot be written: {error.strerror or error}") from None
    finally:
        for temporary_path in temporary:
            # A folder that takes no file may not release one either; the error that led here says why.
            with contextlib.suppress(OSError):
                temporary_path.unlink()


def write_stream(stream: BinaryIO, data: bytes) -> None:
    """Write all data to a stream: an unbuffered pipe takes only as much at a time as it has room for.

    Raises
    ------
    OutputError
        If the stream cannot be written.
    """
    rest = memoryview(data)
    try:
        while len(rest):
            rest = rest[stream.write(rest) :]
        stream.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OutputError(f"standard output cannot be written: {error.strerror}") from None


def clear_leftovers(folder: Path) -> None:
    """Remove files that processes left in a folder when they were killed; on Linux and macOS.

    Files that a process still writes stay. The processes of another machine are unknown: there, the file's age decides.
    """
    with contextlib.suppress(FileNotFoundError), os.scandir(folder) as entries:
        for entry in entries:
            with contextlib.suppress(FileNotFoundError):
                found = _LEFTOVER.fullmatch(entry.name)
                if found is not None and not _is_written(found[1], int(found[2]), entry.stat().st_mtime):
                    os.unlink(entry.path)


def _is_written(machine: str, process: int, changed: float) -> bool:
    """Tell whether the process may still put its file in place."""
    if time.time() - changed > ABANDONED_SECONDS:
        return False
    if machine != _machine():
        return True
    try:
        os.kill(process, 0)
        # A process that has ended keeps its number until its parent asks how it ended.
        with contextlib.suppress(FileNotFoundError):
            return Path(f"/proc/{process}/stat").read_bytes().rpartition(b")")[2].split()[0] not in (b"Z", b"X")
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        return True
    return True


@lru_cache(maxsize=1)
def _machine() -> str:
    """Return a hash of the machine, or of the container, that numbers the processes."""
    name = platform.node()
    with contextlib.suppress(OSError):
        name += os.readlink("/proc/self/ns/pid")
    return hashlib.sha256(name.encode("utf-8", "surrogateescape")).hexdigest()[:8]
