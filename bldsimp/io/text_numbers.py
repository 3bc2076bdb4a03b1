"""Parse numbers from text files, many at a time."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..model import Values

_NUMPY_WARNING = "string or file could not be read"


def parse_numbers(text: bytes, kind: Any = np.float64) -> NDArray[Any]:
    """Parse a text that contains only numbers and white space.

    Raises
    ------
    InputError
        If a word is no number.
    """
    if not text or text.isspace():
        # NumPy would read a zero.
        return np.empty(0, kind)
    with warnings.catch_warnings():
        warnings.filterwarnings("error", message=_NUMPY_WARNING)
        try:
            return np.fromstring(text, dtype=kind, sep=" ")
        except (DeprecationWarning, ValueError):
            raise InputError(f"{_describe_bad_word(text, kind)}: the file is damaged") from None


def parse_rows(lines: Sequence[bytes]) -> tuple[Values, NDArray[np.int64]]:
    """Parse lines of numbers.

    Returns
    -------
    rows : (n, k) float64
        NaN where a line is shorter than others.
    sizes : (n,) int64
        How many numbers each line has.

    Raises
    ------
    InputError
        If a word is no number.
    """
    widths = {len(line.split()) for line in lines[:100]}
    if len(widths) == 1:
        (width,) = widths
        # A newline is white space to the parser; infinity after each line shows that all are equally long.
        flat = parse_numbers(b" inf ".join(lines) + b" inf")
        if len(flat) == (width + 1) * len(lines) and np.isposinf(flat[width :: width + 1]).all():
            return flat.reshape(len(lines), width + 1)[:, :width], np.full(len(lines), width)
    sizes = np.array([len(line.split()) for line in lines], np.int64)
    rows, text = np.full((len(lines), int(sizes.max(initial=0))), np.nan), b" ".join(lines)
    flat = parse_numbers(text)
    # The parser takes a sign alone for that of the next number.
    if len(flat) != sizes.sum():
        raise InputError(f"{_describe_bad_word(text, np.float64)}: the file is damaged")
    rows[np.arange(rows.shape[1]) < sizes[:, None]] = flat
    return rows, sizes


def _describe_bad_word(text: bytes, kind: Any) -> str:
    """Name the first word that is no number."""
    parse, noun = (float, "number") if kind is np.float64 else (int, "whole number")
    for word in text.split():
        try:
            parse(word)
        except ValueError:
            return f"'{word[:40].decode(errors='replace')}' is not a {noun}"
    return f"not every number of {len(text):,} bytes of text can be read"
