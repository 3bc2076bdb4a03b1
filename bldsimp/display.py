"""Text that a terminal can show."""

from __future__ import annotations


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
    for unit, step in (("GB", 1_000_000_000), ("MB", 1_000_000), ("kB", 1_000)):
        if count >= step:
            return f"{count / step:.3g} {unit}"
    return f"{count} B"
