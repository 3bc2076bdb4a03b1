"""Paths and formats of a command, checked before anything is read."""

from __future__ import annotations

import os
import stat
import sys
from dataclasses import dataclass
from pathlib import Path

from ..errors import InputError, OutputError, UsageError


@dataclass(frozen=True)
class Endpoint:
    """Where to read or write; `path` is None for a pipe."""

    path: Path | None
    format: str

    def get_source(self) -> Path | bytes:
        """Return what to read: the path, or all of standard input.

        Raises
        ------
        InputError
            Standard input is closed or cannot be read.
        """
        return read_standard_input() if self.path is None else self.path


def read_standard_input() -> bytes:
    """Read all of standard input.

    Raises
    ------
    InputError
        It is closed or cannot be read.
    """
    if sys.stdin is None:
        raise InputError("standard input is closed: give a file, or a pipe")
    try:
        return sys.stdin.buffer.read()
    except OSError as error:
        raise InputError(f"standard input: cannot be read: {error.strerror}") from None


def find_input(text: str, format_: str | None) -> Endpoint:
    """Find the file and the format that IN stands for.

    Raises
    ------
    UsageError
        Its format is unknown.
    """
    path = None if text == "-" else Path(text)
    return Endpoint(path, check_format(_find_format(path, format_, "IN", "--from"), text))


def find_output(text: str, format_: str | None, overwrite: bool) -> Endpoint:
    """Find the file and the format that OUT stands for.

    Raises
    ------
    UsageError
        OUT exists and may not be replaced, its folder is missing, or its format is unknown.
    """
    from ..io import SUFFIXES

    path = None if text == "-" else Path(text)
    found = _find_format(path, format_, "OUT", "--to")
    if found not in SUFFIXES:
        raise UsageError(f"{text}: cannot write format '{found}': use one of {', '.join(SUFFIXES)}")
    if path is not None:
        check_output(path, "OUT", overwrite)
    return Endpoint(path, found)


def check_output(path: Path, name: str, overwrite: bool) -> None:
    """Refuse a file that exists or whose folder does not.

    Raises
    ------
    UsageError
    """
    if not os.path.isdir(path.parent):
        raise UsageError(f"{path}: the folder '{path.parent}' does not exist: make it first")
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return
    except OSError as error:
        raise UsageError(f"{path}: cannot be {name}: {error.strerror}") from None
    if stat.S_ISREG(mode) and not overwrite:
        raise UsageError(f"{path}: exists: give --overwrite to replace it")


def check_standard_output() -> None:
    """Refuse to work where standard output is closed.

    Raises
    ------
    OutputError
    """
    if sys.stdout is None:
        raise OutputError("standard output is closed: nothing can be written to it")


def check_format(given: str, name: str = "--from") -> str:
    """Return a format to read, in lower case and without a dot.

    Raises
    ------
    UsageError
        It is unknown.
    """
    from ..io import SUFFIXES

    found = normalize_format(given)
    if found not in SUFFIXES and found not in _list_trimesh_formats():
        raise UsageError(f"{name}: format '{found}' is not known: use one of {', '.join(SUFFIXES)}")
    return found


def normalize_format(given: str) -> str:
    """Return a format's name in lower case and without a dot."""
    return given.lower().lstrip(".")


def _find_format(path: Path | None, given: str | None, name: str, option: str) -> str:
    """Find the format that an option or a suffix names."""
    if given:
        return normalize_format(given)
    if path is None:
        raise UsageError(f"{name} is a pipe: give its format with {option}")
    if not path.suffix:
        raise UsageError(f"{path}: has no suffix: give its format with {option}")
    return normalize_format(path.suffix)


def _list_trimesh_formats() -> set[str]:
    """List the formats that only trimesh reads."""
    import trimesh

    return set(trimesh.exchange.load.mesh_formats())
