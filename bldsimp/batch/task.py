"""What is asked of a worker: files, and what to do to them."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass

from .. import __version__
from ..options import DEFAULTS, Options


@dataclass(frozen=True)
class Task:
    """One file to be made light.

    Attributes
    ----------
    name : str
        Of the input beneath its root, with ``/`` between; what the manifest knows it by.
    source : str
        Path or URL of the input.
    output : str
        Name of the output beneath the folder of outputs.
    target : str
        Path or URL of the output.
    from_, to : str
        Formats.
    size : int
        Bytes of the input.
    mtime : int
        When it was last changed; nanoseconds since 1970, 0 where nobody knows.
    again : bool
        It has failed once and is tried by itself.
    """

    name: str
    source: str
    output: str
    target: str
    from_: str
    to: str
    size: int = 0
    mtime: int = 0
    again: bool = False


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
    """What differs from the defaults, as JSON: equal for options that make equal results of the same version."""
    changed = {
        field.name: getattr(options, field.name)
        for field in dataclasses.fields(options)
        if getattr(options, field.name) != getattr(DEFAULTS, field.name)
    }
    return json.dumps(changed, sort_keys=True, default=vars)
