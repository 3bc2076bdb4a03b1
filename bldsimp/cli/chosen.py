"""What the options of a command choose."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..errors import UsageError
from ..options import Options, parse_delimit, parse_length, parse_tolerance

_PARSERS: dict[str, Callable[[str], Any]] = {
    "tolerance": parse_tolerance,
    "weld": parse_length,
    "min_part": parse_length,
    "crease_angle": parse_length,
    "delimit": parse_delimit,
    "texture_tolerance": parse_length,
}


def chosen(**values: Any) -> Options:
    """Options from the command line's values, by the names of their fields.

    Raises
    ------
    UsageError
        Where one of them is wrong: it is named.
    """
    return Options(**{name: _parsed(name, value) for name, value in values.items()})


def _parsed(name: str, value: Any) -> Any:
    if name not in _PARSERS:
        return value
    try:
        return _PARSERS[name](value)
    except UsageError as error:
        raise UsageError(f"--{name.replace('_', '-')}: {error}") from None
