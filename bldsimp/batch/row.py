"""One row of the manifest: what became of a file."""

from __future__ import annotations

import json
import os
import re
from dataclasses import dataclass, field
from typing import Any

from .task import Task

DONE, FAILED = "done", "failed"

KINDS = {
    "refused": "no file that can be read: a FIFO, a device, a link that leads nowhere",
    "input": "cannot be read as a mesh",
    "output": "cannot be written",
    "full": "the disk is full",
    "memory": "needs more memory than it may use",
    "timeout": "takes too long",
    "crash": "its process died",
    "internal": "a bug in bldsimp",
}
"""What a file may fail by, in words."""


@dataclass
class Row:
    """What became of a file; docs/batch.md describes the fields.

    Attributes
    ----------
    input, output : str
        Names beneath the roots; in the manifest as `escaped` writes them.
    format_before, format_after : str
        Of the input and of the result.
    status : str
        ``done`` or ``failed``.
    kind : str or None
        One of `KINDS` where it failed.
    error : str or None
        One line.
    beside : list of dict
        ``name``, ``bytes``, ``mtime_ns`` and ``sha256`` of what the input names, see `Scene.beside`.
    """

    input: str
    output: str
    status: str = FAILED
    kind: str | None = None
    error: str | None = None
    format_before: str = ""
    format_after: str = ""
    input_bytes: int = 0
    input_mtime_ns: int = 0
    input_sha256: str | None = None
    beside: list[dict[str, Any]] = field(default_factory=list)
    output_bytes: int | None = None
    output_sha256: str | None = None
    points_before: int | None = None
    points_after: int | None = None
    triangles_before: int | None = None
    triangles_after: int | None = None
    tolerance: float | None = None
    deviation: float | None = None
    texels: float | None = None
    seconds: float = 0.0
    attempts: int = 1
    warnings: list[str] = field(default_factory=list)
    options: str = "{}"
    version: str = ""

    @property
    def failed(self) -> bool:
        """Whether there is no output."""
        return self.status != DONE

    def to_line(self) -> bytes:
        """The row as one line of JSON, in UTF-8 that every reader takes."""
        values = vars(self) | {
            "input": escaped(self.input),
            "output": escaped(self.output),
            "error": self.error and _readable(self.error),
            "beside": [each | {"name": escaped(each["name"])} for each in self.beside],
            "warnings": [_readable(text) for text in self.warnings],
        }
        text = json.dumps(values, allow_nan=False, separators=(",", ":"), ensure_ascii=False)
        return text.encode("utf-8") + b"\n"

    @classmethod
    def from_line(cls, line: bytes) -> Row:
        """The row that a line holds.

        Raises
        ------
        ValueError
            Where it holds none.
        """
        values = json.loads(line)
        try:
            row = cls(**{name: value for name, value in values.items() if name in cls.__dataclass_fields__})
            row.input, row.output = unescaped(row.input), unescaped(row.output)
            row.beside = [each | {"name": unescaped(each["name"])} for each in row.beside]
        except (TypeError, AttributeError, KeyError):
            raise ValueError("not a row") from None
        return row


def failure(task: Task, kind: str, error: str) -> Row:
    """The row of a file that failed."""
    return Row(
        task.name,
        task.output,
        FAILED,
        kind,
        error,
        task.from_,
        task.to,
        input_bytes=task.size,
        input_mtime_ns=task.mtime,
        attempts=2 if task.again else 1,
    )


def escaped(name: str) -> str:
    """A file's name as text: bytes that are no UTF-8 as ``%FF``, and the percent sign itself as ``%25``."""
    if name.isascii() and "%" not in name:
        return name
    text = os.fsencode(name).replace(b"%", b"%25").decode("utf-8", "surrogateescape")
    return "".join(f"%{ord(letter) - 0xDC00:02X}" if "\udc80" <= letter <= "\udcff" else letter for letter in text)


def unescaped(text: str) -> str:
    """The name that `escaped` wrote."""
    if "%" not in text:
        return text
    return os.fsdecode(re.sub(rb"%([0-9A-F]{2})", lambda found: bytes([int(found[1], 16)]), text.encode("utf-8")))


def _readable(text: str) -> str:
    """A message; what is no UTF-8 in a name that it tells is only shown."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")
