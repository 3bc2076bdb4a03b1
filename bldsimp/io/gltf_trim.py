"""Buffer views that lost some of their accessors: only the bytes that the others use stay."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from .gltf import COMPONENTS, WIDTHS
from .gltf_references import view_slots

Range = tuple[dict[str, Any], int, int]
"""What has a ``byteOffset`` into a view, and where its bytes start and end there."""


def trimmed(json_: dict[str, Any], number: int, data: bytes) -> bytes:
    """The bytes of a view that accessors still use; their offsets are changed to match.

    Parameters
    ----------
    json_ : dict
        Changed in place.
    number : int
        Of the view.
    data : bytes
        All of the view.

    Returns
    -------
    bytes
        `data` itself where something other than an accessor uses the view.
    """
    view = json_["bufferViews"][number]
    ranges = sorted(_ranges(json_, number, view), key=lambda entry: entry[1])
    if not ranges or len(ranges) < sum(container[key] == number for container, key in view_slots(json_)):
        return data
    kept = bytearray()
    moved = end = 0
    for user, start, stop in ranges:
        if start >= end:
            # A multiple of four keeps every component aligned.
            kept += b"\0" * ((start - len(kept)) % 4)
            moved = start - len(kept)
        if stop > end:
            kept += data[max(start, end) : stop]
            end = stop
        user["byteOffset"] = start - moved
    return bytes(kept)


def _ranges(json_: dict[str, Any], number: int, view: dict[str, Any]) -> Iterator[Range]:
    """Where the accessors of a view read it."""
    for accessor in json_["accessors"]:
        size = np.dtype(COMPONENTS[accessor["componentType"]]).itemsize * WIDTHS[accessor["type"]]
        sparse = accessor.get("sparse", {})
        if accessor.get("bufferView") == number:
            stride = view.get("byteStride") or size
            yield _range(accessor, stride * (accessor["count"] - 1) + size)
        if sparse.get("indices", {}).get("bufferView") == number:
            index_size = np.dtype(COMPONENTS[sparse["indices"]["componentType"]]).itemsize
            yield _range(sparse["indices"], index_size * sparse["count"])
        if sparse.get("values", {}).get("bufferView") == number:
            yield _range(sparse["values"], size * sparse["count"])


def _range(user: dict[str, Any], length: int) -> Range:
    start = user.get("byteOffset", 0)
    return user, start, start + length
