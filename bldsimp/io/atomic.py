"""Files that appear whole, together, or not at all."""

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

from ..errors import OutputError

_LEFTOVER = re.compile(r"\.bldsimp-([0-9a-f]{8})-([0-9]+)-[0-9a-f]{8}\.tmp")
"""Machine and process that write a file, and what tells its files apart."""

ABANDONED_SECONDS = 3600.0
"""A file that nobody has written to for so long is no longer being written, whoever has its process's number now."""


def replace_files(files: dict[Path, bytes]) -> None:
    """Write files beside their targets, then move all into place; the last one last.

    Parameters
    ----------
    files : dict of Path to bytes
        A target that is no regular file (a pipe, a device) is written to directly.

    Raises
    ------
    OutputError
        Where one cannot be written; what was there before is then untouched, and nothing is left over.
    """
    temporary: dict[Path, Path] = {}
    where = Path()
    try:
        for path, data in files.items():
            where = path
            if path.exists() and not path.is_file():
                # By its own name: what /dev/stdout or /dev/fd/3 lead to need not have one.
                with open(path, "wb") as stream:
                    stream.write(data)
                continue
            target = Path(os.path.realpath(path))
            beside = target.with_name(f".bldsimp-{_machine()}-{os.getpid()}-{secrets.token_hex(4)}.tmp")
            temporary[beside] = target
            with open(beside, "xb") as stream:
                stream.write(data)
            if target.exists():
                shutil.copymode(target, beside)
        for beside, target in list(temporary.items()):
            where = target
            os.replace(beside, target)
            del temporary[beside]
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OutputError(f"{where}: cannot be written: {error.strerror or error}") from None
    finally:
        for beside in temporary:
            # A folder that takes no file may not let one go either; the error that led here says why.
            with contextlib.suppress(OSError):
                beside.unlink()


def clear_leftovers(folder: Path) -> None:
    """Remove what processes that were killed while they wrote have left in a folder; on Linux and macOS.

    What a process still writes stays. Of another machine nobody knows which run: there, time has to tell.
    """
    with contextlib.suppress(FileNotFoundError), os.scandir(folder) as entries:
        for entry in entries:
            with contextlib.suppress(FileNotFoundError):
                found = _LEFTOVER.fullmatch(entry.name)
                if found is not None and not _is_written(found[1], int(found[2]), entry.stat().st_mtime):
                    os.unlink(entry.path)


def _is_written(machine: str, process: int, changed: float) -> bool:
    """Whether the process may still be about to put its file in place."""
    if time.time() - changed > ABANDONED_SECONDS:
        return False
    if machine != _machine():
        return True
    try:
        os.kill(process, 0)
        # One that has ended may still have its number, until whoever started it asks how it ended.
        with contextlib.suppress(FileNotFoundError):
            return Path(f"/proc/{process}/stat").read_bytes().rpartition(b")")[2].split()[0] not in (b"Z", b"X")
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        return True
    return True


@lru_cache(maxsize=1)
def _machine() -> str:
    """Stands for what numbers the processes: this machine, or the container that this one is in."""
    name = platform.node()
    with contextlib.suppress(OSError):
        name += os.readlink("/proc/self/ns/pid")
    return hashlib.sha256(name.encode("utf-8", "surrogateescape")).hexdigest()[:8]
