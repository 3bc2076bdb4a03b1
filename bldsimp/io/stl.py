"""Whether an STL file is whole: trimesh, which reads it, takes a binary one of another length for a text."""

from __future__ import annotations

from ..errors import InputError

HEADER, FACE = 84, 50
"""Bytes of the header with the number of faces, and of each face."""


def whole_stl(data: bytes, warnings: list[str]) -> bytes:
    """The part of an STL file, binary or text, that holds its faces.

    Raises
    ------
    InputError
        Where the file ends before the faces that it begins or promises.
    """
    head = data[: 10 * HEADER].lstrip().lower()
    if head.startswith(b"solid") and (b"facet" in head or b"endsolid" in head):
        _check_text(data.lower())
        return data
    if len(data) < HEADER:
        raise InputError("the STL file ends within its header: it is truncated, or no STL")
    promised, fit = int.from_bytes(data[HEADER - 4 : HEADER], "little"), (len(data) - HEADER) // FACE
    if promised > fit:
        raise InputError(
            f"the STL file's header promises {promised:,} faces, and {fit:,} fit in its {len(data):,} bytes:"
            " it is truncated, or no STL"
        )
    if not promised and fit:
        raise InputError(f"the STL file's header promises no face, though {fit:,} would fit: the file is damaged")
    end = HEADER + FACE * promised
    if end < len(data):
        warnings.append(f"{len(data) - end:,} bytes after the {promised:,} faces of the STL file were left out")
    return data[:end]


def _check_text(lower: bytes) -> None:
    """Refuse a text that ends within a face."""
    before, _, rest = lower.rpartition(b"endfacet")
    words = rest.split()
    cut = words and words[0] not in (b"endsolid", b"solid") if before else b"facet" in words
    if cut:
        whole = lower.count(b"endfacet")
        raise InputError(f"the STL text ends within a face, after {whole:,} whole ones: it is truncated")
