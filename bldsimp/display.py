"""Text for people: safe on a terminal, and with amounts of memory in decimal units."""

from __future__ import annotations

import re

from .errors import UsageError

_UNITS = {"": 1, "K": 10**3, "M": 10**6, "G": 10**9, "T": 10**12}


def sanitize_line(text: str) -> str:
    """Replace control characters and line breaks, so that text of unknown origin stays on one line.

    Parameters
    ----------
    text : str
        May hold lone surrogates, as file names do that are not UTF-8; they become question marks.

    Returns
    -------
    str
        The same text with a space for each character that cannot be printed.
    """
    plain = text.encode("utf-8", "replace").decode("utf-8")
    return "".join(letter if letter.isprintable() else " " for letter in plain)


def format_bytes(count: int) -> str:
    """Format a number of bytes with three digits and a decimal unit: ``24.2 kB``."""
    for unit in "GMK":
        if count >= _UNITS[unit]:
            return f"{count / _UNITS[unit]:.3g} {unit.replace('K', 'k')}B"
    return f"{count} B"


def parse_bytes(text: str) -> int:
    """Read a number of bytes: ``800M``, ``8G``, ``1.5 GB``.

    Raises
    ------
    UsageError
    """
    found = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*([KMGT]?)B?\s*", text.upper())
    if found is None:
        raise UsageError(f"'{text}' is not an amount of memory: give a number with K, M, G or T, such as 8G")
    return int(float(found[1]) * _UNITS[found[2]])
