"""What a worker is asked to do: files, grouped, and the options for them."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from .. import __version__
from ..options import DEFAULTS, Options
from .storage import join_path


@dataclass(frozen=True, slots=True)
class Task:
    """One file to simplify.

    Attributes
    ----------
    root, name : str
        Path or URL of a folder, and the input's name below it, which the manifest uses.
    target_root, output : str
        The same of the result.
    from_, to : str
        Formats.
    size : int
        Bytes of the input.
    mtime : int
        Time of its last change; nanoseconds since 1970, 0 where it is not known.
    again : bool
        Whether this is the second try, in a group of its own.
    """

    root: str
    name: str
    target_root: str
    output: str
    from_: str
    to: str
    size: int = 0
    mtime: int = 0
    again: bool = False

    @property
    def source(self) -> str:
        """Path or URL of the input."""
        return join_path(self.root, self.name)

    @property
    def target(self) -> str:
        """Path or URL of the result."""
        return join_path(self.target_root, self.output)


@dataclass(frozen=True)
class WorkOrder:
    """Tasks for one worker, one after the other.

    Attributes
    ----------
    tasks : list of Task
    options : Options
    overwrite : bool
        Whether files next to the outputs that differ may be replaced.
    memory : int or None
        Bytes that the worker may use beyond those it has when it starts; None for no limit.
    version : str
        Of bldsimp, where the order was made.
    """

    tasks: list[Task]
    options: Options
    overwrite: bool
    memory: int | None = None
    version: str = __version__


def split_into_groups(tasks: list[Task], most_files: int, most_bytes: int) -> Iterator[list[Task]]:
    """Split tasks into groups, so that small files do not wait for messages.

    The largest files come first, so that no large one is left for the end. A group is full with `most_files`, or
    with `most_bytes` of them; a file that is larger has a group of its own.
    """
    group: list[Task] = []
    size = 0
    for task in sorted(tasks, key=lambda task: (-task.size, task.name)):
        if group and (len(group) == most_files or size + task.size > most_bytes):
            yield group
            group, size = [], 0
        group.append(task)
        size += task.size
    if group:
        yield group


def encode_options(options: Options) -> str:
    """Encode the options that differ from the defaults as JSON.

    Results are equal where this text, the formats and the version are.
    """
    changed = {name: value for name, value in vars(options).items() if value != getattr(DEFAULTS, name)}
    return json.dumps(changed, sort_keys=True, default=_to_plain)


def _to_plain(value: Any) -> Any:
    """Convert an option to what JSON knows: a set to a sorted list, an object to its fields."""
    return sorted(value) if isinstance(value, frozenset) else vars(value)
