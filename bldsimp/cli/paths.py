"""Paths and formats of a command, checked before anything is read."""

from __future__ import annotations

import os
import stat
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

from ..errors import InputError, OutputError, UsageError

FORMATS = ("obj", "ply", "off", "stl", "glb", "gltf")
"""Read and written; what else is read is trimesh's to say."""


@dataclass(frozen=True)
class Endpoint:
    """Where to read or write; `path` is None for a pipe."""

    path: Path | None
    format: str

    def data(self) -> Path | bytes:
        """What to read: the path, or all of standard input.

        Raises
        ------
        InputError
            Standard input is closed or cannot be read.
        """
        return standard_input() if self.path is None else self.path


def standard_input() -> bytes:
    """All of standard input.

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


def endpoint_in(text: str, format_: str | None) -> Endpoint:
    """What IN means.

    Raises
    ------
    UsageError
        IN is a directory, or its format is unknown.
    """
    path = None if text == "-" else Path(text)
    if path is not None and os.path.isdir(path):
        raise UsageError(f"{path}: is a directory: give a file")
    return Endpoint(path, check_format(_format(path, format_, "IN", "--from"), text))


def endpoint_out(text: str, format_: str | None, overwrite: bool) -> Endpoint:
    """What OUT means.

    Raises
    ------
    UsageError
        OUT exists and may not be replaced, its folder is missing, or its format is unknown.
    """
    path = None if text == "-" else Path(text)
    found = _format(path, format_, "OUT", "--to")
    if found not in FORMATS:
        raise UsageError(f"{text}: format '{found}' cannot be written: use one of {', '.join(FORMATS)}")
    if path is not None:
        check_output(path, "OUT", overwrite)
    return Endpoint(path, found)


def check_output(path: Path, name: str, overwrite: bool) -> None:
    """Refuse a file that cannot be meant.

    Raises
    ------
    UsageError
    """
    if os.path.isdir(path):
        raise UsageError(f"{path}: is a directory: {name} must be a file")
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


def check_open(stream: TextIO | None, name: str) -> None:
    """Refuse to work for a stream that is closed.

    Raises
    ------
    OutputError
    """
    if stream is None:
        raise OutputError(f"{name} is closed: there is nowhere to write to")


def check_format(given: str, name: str = "--from") -> str:
    """A format to read, in lower case and without a dot.

    Raises
    ------
    UsageError
        It is unknown.
    """
    found = plain_format(given)
    if found not in FORMATS and found not in _others():
        raise UsageError(f"{name}: format '{found}' is not known: use one of {', '.join(FORMATS)}")
    return found


def plain_format(given: str) -> str:
    """A format's name in lower case and without a dot."""
    return given.lower().lstrip(".")


def _format(path: Path | None, given: str | None, name: str, option: str) -> str:
    """The format that an option or a suffix names."""
    if given:
        return plain_format(given)
    if path is None:
        raise UsageError(f"{name} is a pipe: say its format with {option}")
    suffix = path.suffix.lower().lstrip(".")
    if not suffix:
        raise UsageError(f"{path}: has no suffix: say its format with {option}")
    return suffix


def _others() -> set[str]:
    """Formats that only trimesh reads."""
    import trimesh

    return set(trimesh.exchange.load.mesh_formats())
