"""What is asked of a worker: files, and what to do to them."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from typing import Any

from .. import __version__
from ..options import DEFAULTS, Options
from .storage import join


@dataclass(frozen=True, slots=True)
class Task:
    """One file to be made light.

    Attributes
    ----------
    root, name : str
        Path or URL of a folder, and the input's name beneath it, which the manifest knows it by.
    target_root, output : str
        The same of the result.
    from_, to : str
        Formats.
    size : int
        Bytes of the input.
    mtime : int
        When it was last changed; nanoseconds since 1970, 0 where nobody knows.
    again : bool
        It has failed once and is tried by itself.
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
        return join(self.root, self.name)

    @property
    def target(self) -> str:
        """Path or URL of the result."""
        return join(self.target_root, self.output)


@dataclass(frozen=True)
class Order:
    """Tasks for one worker, one after the other.

    Attributes
    ----------
    tasks : list of Task
    options : Options
    overwrite : bool
        Whether files beside the outputs that differ may be replaced.
    memory : int or None
        Bytes that the worker may take beyond what it has when it starts; None for as many as there are.
    version : str
        Of bldsimp, where the order was given.
    """

    tasks: list[Task]
    options: Options
    overwrite: bool
    memory: int | None = None
    version: str = __version__


def recipe(options: Options) -> str:
    """What differs from the defaults, as JSON: with equal formats and versions, equal where results are."""
    changed = {
        field.name: getattr(options, field.name)
        for field in dataclasses.fields(options)
        if getattr(options, field.name) != getattr(DEFAULTS, field.name)
    }
    return json.dumps(changed, sort_keys=True, default=_plain)


def _plain(value: Any) -> Any:
    """What JSON can say of an option: the words of a set in order, the fields of a class."""
    return sorted(value) if isinstance(value, frozenset) else vars(value)
