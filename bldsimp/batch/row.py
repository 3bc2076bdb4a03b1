"""One row of the manifest: the result of one file."""

from __future__ import annotations

import dataclasses
import json
import os
import re
from dataclasses import dataclass, field
from typing import Any

from .task import Task

DONE, FAILED = "done", "failed"


@dataclass
class FileRow:
    """The result of one file; docs/batch.md describes the fields.

    Attributes
    ----------
    input, output : str
        Names below the roots; the manifest has them as `escape_name` writes them.
    format_before, format_after : str
        Of the input and of the result.
    status : str
        ``done`` or ``failed``.
    kind : str or None
        Why it failed: one word of those in docs/batch.md.
    error : str or None
        One line.
    beside : list of dict
        ``name``, ``bytes``, ``mtime_ns`` and ``sha256`` of each file that the input names, see `Scene.beside`.
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
        """Encode the row as one line of JSON, in valid UTF-8."""
        values = vars(self) | {
            "input": escape_name(self.input),
            "output": escape_name(self.output),
            "error": self.error and _make_printable(self.error),
            "beside": [each | {"name": escape_name(each["name"])} for each in self.beside],
            "warnings": [_make_printable(text) for text in self.warnings],
        }
        text = json.dumps(values, allow_nan=False, separators=(",", ":"), ensure_ascii=False)
        return text.encode("utf-8") + b"\n"

    @classmethod
    def from_line(cls, line: bytes) -> FileRow:
        """Decode the row on a line.

        Raises
        ------
        ValueError
            Where the line is not a row.
        """
        values = json.loads(line)
        try:
            row = cls(**{name: value for name, value in values.items() if name in cls.__dataclass_fields__})
            row.input, row.output = unescape_name(row.input), unescape_name(row.output)
            row.beside = [each | {"name": unescape_name(each["name"])} for each in row.beside]
        except (TypeError, AttributeError, KeyError):
            raise ValueError("not a row") from None
        return row


def make_row(task: Task, status: str, **values: Any) -> FileRow:
    """Make the row of a task that has ended."""
    attempts = 2 if task.again else 1
    return FileRow(
        task.name, task.output, status, format_before=task.from_, format_after=task.to, attempts=attempts, **values
    )


def make_failure(task: Task, kind: str, error: str) -> FileRow:
    """Make the row of a file that failed."""
    return make_row(task, FAILED, kind=kind, error=error, input_bytes=task.size, input_mtime_ns=task.mtime)


def make_retry(task: Task, row: FileRow) -> Task | None:
    """Return the task for a second try; None where there is none.

    A full disk is not the file's fault: a resumed run does it once there is room.
    """
    if not row.failed or row.kind in ("refused", "full") or task.again:
        return None
    return dataclasses.replace(task, again=True)


def escape_name(name: str) -> str:
    """Write a file's name as text: bytes that are not UTF-8 as ``%FF``, and the percent sign as ``%25``."""
    if name.isascii() and "%" not in name:
        return name
    text = os.fsencode(name).replace(b"%", b"%25").decode("utf-8", "surrogateescape")
    return "".join(f"%{ord(letter) - 0xDC00:02X}" if "\udc80" <= letter <= "\udcff" else letter for letter in text)


def unescape_name(text: str) -> str:
    """Read a name that `escape_name` wrote."""
    if "%" not in text:
        return text
    return os.fsdecode(re.sub(rb"%([0-9A-F]{2})", lambda found: bytes([int(found[1], 16)]), text.encode("utf-8")))


def _make_printable(text: str) -> str:
    """Escape what is not UTF-8 in a message, which only shows the name that it contains."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")
