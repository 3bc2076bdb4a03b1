"""Files that appear whole, together, or not at all."""

from __future__ import annotations

import contextlib
import os
import re
import secrets
import shutil
from pathlib import Path

from ..errors import OutputError

_TOKEN_BYTES = 4
_LEFTOVER = re.compile(rf"\..+\.[0-9a-f]{{{2 * _TOKEN_BYTES}}}\.tmp", re.DOTALL)


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
            beside = target.with_name(f".{target.name}.{secrets.token_hex(_TOKEN_BYTES)}.tmp")
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
    """Remove what processes that were killed while they wrote have left in a folder."""
    with contextlib.suppress(FileNotFoundError), os.scandir(folder) as entries:
        for entry in entries:
            if _LEFTOVER.fullmatch(entry.name):
                with contextlib.suppress(FileNotFoundError):
                    os.unlink(entry.path)
