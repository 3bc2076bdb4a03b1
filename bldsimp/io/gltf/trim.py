"""Buffer views that lost some of their accessors: only the bytes that the others use stay."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np

from .document import COMPONENTS, WIDTHS
from .references import view_slots

Range = tuple[dict[str, Any], int, int]
"""What has a ``byteOffset`` into a view, and where its bytes start and end there."""


def trimmed(json_: dict[str, Any], views: dict[int, bytes]) -> dict[int, bytes]:
    """The bytes of views that accessors still use; their offsets are changed to match.

    Parameters
    ----------
    json_ : dict
        Changed in place.
    views : dict of int to bytes
        All of each view, by its number.

    Returns
    -------
    dict of int to bytes
        As given where something other than an accessor uses the view.
    """
    uses = Counter(container[key] for container, key in view_slots(json_))
    ranges: dict[int, list[Range]] = {number: [] for number in views}
    for accessor in json_["accessors"]:
        for number, found in _ranges(json_, accessor, views):
            ranges[number].append(found)
    return {
        number: _without_gaps(ranges[number], data) if 0 < len(ranges[number]) == uses[number] else data
        for number, data in views.items()
    }


def _without_gaps(ranges: list[Range], data: bytes) -> bytes:
    """Bytes that some range covers, close together."""
    kept = bytearray()
    moved = end = 0
    for user, start, stop in sorted(ranges, key=lambda entry: entry[1]):
        if start >= end:
            # A multiple of four keeps every component aligned.
            kept += b"\0" * ((start - len(kept)) % 4)
            moved = start - len(kept)
        if stop > end:
            kept += data[max(start, end) : stop]
            end = stop
        user["byteOffset"] = start - moved
    return bytes(kept)


def _ranges(json_: dict[str, Any], accessor: dict[str, Any], views: dict[int, bytes]) -> Iterator[tuple[int, Range]]:
    """Which of the views an accessor reads, and where."""
    number, sparse = accessor.get("bufferView"), accessor.get("sparse", {})
    if number not in views and not sparse:
        return
    size = _size(accessor.get("componentType")) * WIDTHS.get(accessor.get("type", ""), 0)
    # What is not understood has no range, so that its view stays whole.
    if number in views and size and "count" in accessor:
        stride = json_["bufferViews"][number].get("byteStride", size)
        yield number, _range(accessor, stride * (int(accessor["count"]) - 1) + size)
    for key, each in (("indices", _size(sparse.get("indices", {}).get("componentType"))), ("values", size)):
        number = sparse.get(key, {}).get("bufferView")
        if number in views and each and "count" in sparse:
            yield number, _range(sparse[key], each * int(sparse["count"]))


def _size(component: int | None) -> int:
    """Bytes of a number, 0 where the format has no such component type."""
    return np.dtype(COMPONENTS[component]).itemsize if component in COMPONENTS else 0


def _range(user: dict[str, Any], length: int) -> Range:
    start = user.get("byteOffset", 0)
    return user, start, start + length
