"""Numbers out of text files, many at a time."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError

_WRONG = "string or file could not be read"


def numbers(text: bytes, kind: Any = np.float64) -> NDArray[Any]:
    """All numbers of a text that holds nothing else.

    Raises
    ------
    InputError
    """
    with warnings.catch_warnings():
        warnings.filterwarnings("error", message=_WRONG)
        try:
            return np.fromstring(text, dtype=kind, sep=" ")
        except (DeprecationWarning, ValueError):
            raise InputError(f"{_first_wrong(text, kind)}: the file is damaged") from None


def table(lines: Sequence[bytes]) -> NDArray[np.float64]:
    """Numbers of lines that may differ in length: a row per line, NaN where a line is shorter.

    Raises
    ------
    InputError
    """
    if not lines:
        return np.empty((0, 0))
    width = len(lines[0].split())
    # A newline is white space to the parser; infinity after each line shows that all are equally long.
    flat = numbers(b" inf ".join(lines) + b" inf")
    if len(flat) == (width + 1) * len(lines):
        rows = flat.reshape(len(lines), width + 1)
        if np.isposinf(rows[:, width]).all():
            return rows[:, :width]
    return ragged(lines)[0]


def ragged(lines: Sequence[bytes]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Like `table`, and how many numbers each line has."""
    sizes = np.array([len(line.split()) for line in lines], np.int64)
    rows = np.full((len(lines), int(sizes.max(initial=0))), np.nan)
    inside = np.arange(rows.shape[1]) < sizes[:, None]
    rows[inside] = numbers(b" ".join(lines))
    return rows, sizes


def _first_wrong(text: bytes, kind: Any) -> str:
    """Name the first token that is no number."""
    parse, noun = (float, "number") if kind is np.float64 else (int, "whole number")
    for token in text.split():
        try:
            parse(token)
        except ValueError:
            return f"'{token[:40].decode(errors='replace')}' is not a {noun}"
    return f"not every number of {len(text):,} bytes of text can be read"
