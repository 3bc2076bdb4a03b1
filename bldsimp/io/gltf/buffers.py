"""Pack the numbers of a glTF document: new accessors, and the buffers of a patched document."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import references
from .document import COMPONENTS, WIDTHS, Document, Json

_VERTICES, _INDICES = 34962, 34963
_CODES = {np.dtype("<" + name): code for code, name in COMPONENTS.items()}
_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
_BLANKS: dict[str, Json] = {"accessors": {"componentType": 5126, "count": 1, "type": "VEC3"}, "bufferViews": {}}
"""Entries at numbers that nothing names."""

ByteRange = tuple[Json, int, int]
"""A JSON object with a ``byteOffset`` into a view, and where its bytes start and end there."""


@dataclass
class NewAccessors:
    """New accessors and buffer views, numbered among themselves; equal accessors are added once.

    Attributes
    ----------
    accessors : list of dict
        ``bufferView`` counts into `views`.
    views : dict of (int, int) to bytearray
        Data of accessors that share a target and a stride.
    """

    accessors: list[Json] = field(default_factory=list)
    views: dict[tuple[int, int], bytearray] = field(default_factory=dict)
    _numbers: dict[tuple[str, bytes], int] = field(default_factory=dict)

    def add_vertices(self, name: str, values: NDArray[Any], more: Json) -> int:
        """Add a vertex attribute, positions with their exact least and greatest values; return its number.

        `more` are members of the accessor that do not follow from its values, such as its name.
        """
        if name == "POSITION":
            more = {**more, "min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        return self._add(_VERTICES, values, more)

    def add_indices(self, corners: NDArray[Any], count: int) -> int:
        """Add the corners of triangles, in 16 bits if `count` vertices allow it; return their number."""
        # The greatest 16-bit number restarts a strip, and must not name a vertex.
        kind = np.dtype("<u2") if count <= 65535 else np.dtype("<u4")
        return self._add(_INDICES, corners.reshape(-1, 1).astype(kind), {})

    def _add(self, target: int, values: NDArray[Any], more: Json) -> int:
        """Add values to the view for their kind, unless they are there; return their number."""
        kind = values.dtype.newbyteorder("<")
        rows = pack_rows(values, kind, aligned=target == _VERTICES)
        stride, data = rows.shape[1] if target == _VERTICES else 0, rows.tobytes()
        entry = {"componentType": _CODES[kind], "count": len(values), "type": _TYPES[values.shape[1]], **more}
        key = json.dumps([target, entry], sort_keys=True), hashlib.sha256(data).digest()
        if key not in self._numbers:
            self._numbers[key] = len(self.accessors)
            view = self.views.setdefault((target, stride), bytearray())
            view += b"\0" * (-len(view) % 4)
            number = list(self.views).index((target, stride))
            self.accessors.append({"bufferView": number, "byteOffset": len(view), **entry})
            view += data
        return self._numbers[key]

    def list_views(self) -> list[tuple[Json, bytes]]:
        """List the views: their JSON, without a place, and their data."""
        return [
            ({"target": target, **({"byteStride": stride} if stride else {})}, bytes(data))
            for (target, stride), data in self.views.items()
        ]


def pack_rows(values: NDArray[Any], kind: np.dtype[Any], *, aligned: bool) -> NDArray[np.uint8]:
    """Return numbers, (n, k), as bytes of a component type, (n, stride); `aligned` rows start at multiples of four."""
    width = values.shape[1] * kind.itemsize
    rows = np.zeros((len(values), width + (-width % 4 if aligned else 0)), np.uint8)
    rows[:, :width] = np.ascontiguousarray(values, kind).view(np.uint8).reshape(len(values), width)
    return rows


def pack_views(pieces: list[tuple[Json, bytes]], buffer: int = 0) -> bytes:
    """Lay buffer views out in one buffer, in order, and set the place of each.

    Parameters
    ----------
    pieces : list of (dict, bytes)
        A view's JSON, changed in place, and its data.
    buffer : int
        Number of the buffer.
    """
    binary = bytearray()
    for view, data in pieces:
        # Eight suffices for every component type, and for property tables.
        binary += b"\0" * (-len(binary) % 8)
        view["buffer"], view["byteOffset"], view["byteLength"] = buffer, len(binary), len(data)
        binary += data
    return bytes(binary)


def replace_accessors(
    document: Document, json_: Json, new: NewAccessors, replaced: set[int], *, whole: bool, first: bool
) -> bytes:
    """Drop data that nothing names any more, number the rest, and lay out the buffer that changes.

    Parameters
    ----------
    document : Document
    json_ : dict
        A changed copy of the document's; negative numbers name new accessors.
    new : NewAccessors
    replaced : set of int
        Accessors that primitives named before.
    whole : bool
        All data goes into one buffer; else buffers next to the document that keep all their data stay.
    first : bool
        The new buffer comes before all others, as in a GLB.

    Returns
    -------
    bytes
        Data of the buffer without a URI.
    """
    if not (replaced or whole) and len(document.buffers) < 2:
        return document.join_own_buffers()
    accessors, views = json_.get("accessors", []), json_.get("bufferViews", [])
    dropped = replaced - references.list_numbers(json_, references.ACCESSORS)
    # Nothing names the views that compressed data was decoded from.
    freed = set(range(len(views))) if document.decoded else set()
    freed |= {view for i in dropped for view in references.list_numbers(accessors[i], references.ACCESSOR_VIEWS)}
    for accessor in new.accessors:
        accessor["bufferView"] = -1 - accessor["bufferView"]
    _replace_entries(json_, "accessors", references.ACCESSORS, dropped, new.accessors)
    kept = references.list_numbers(json_, references.VIEWS)
    # Buffers next to the document that lose nothing stay; the others become one.
    touched = {views[number]["buffer"] for number in freed}
    buffers = enumerate(document.items("buffers"))
    merged = [i for i, entry in buffers if whole or i in touched or "uri" not in entry]
    dropped = freed - kept
    data = {i: document.read_view(i) for i, one in enumerate(views) if i not in dropped and one["buffer"] in merged}
    fresh = new.list_views()
    data |= {-1 - i: view for i, (_, view) in enumerate(fresh)}
    if not references.list_unknown_extensions(json_):
        data |= _trim_views(json_, {i: document.read_view(i) for i in sorted(freed & kept)})
    numbers = _replace_entries(json_, "bufferViews", references.VIEWS, dropped, [entry for entry, _ in fresh])
    binary = _merge_buffers(json_, merged, {numbers[i]: view for i, view in data.items()}, first)
    for key in ("accessors", "bufferViews", "buffers"):
        if not json_[key]:
            del json_[key]
    return binary


def _merge_buffers(json_: Json, merged: list[int], data: dict[int, bytes], first: bool) -> bytes:
    """Lay out the data of views in one buffer, in the place of those that it is merged from."""
    views, old = json_.get("bufferViews", []), json_.get("buffers", [])
    # A view without a buffer is an empty place.
    staying = [view for i, view in enumerate(views) if i not in data and view]
    fresh = [(view, data.get(i, bytes(4))) for i, view in enumerate(views) if i in data or not view]
    order = [i for i in range(len(old)) if i not in merged]
    place = 0 if first else sum(i < merged[0] for i in order) if merged else len(order)
    if fresh:
        order.insert(place, -1)
    binary = pack_views(fresh, place)
    for view in staying:
        view["buffer"] = order.index(view["buffer"])
    head = {k: v for k, v in old[merged[0]].items() if k not in ("uri", "byteLength")} if merged else {}
    json_["buffers"] = [old[i] if i >= 0 else {**head, "byteLength": len(binary)} for i in order]
    return binary


def _replace_entries(
    json_: Json, key: str, paths: tuple[str, ...], dropped: set[int], new: list[Json]
) -> dict[int, int]:
    """Drop entries of a top-level array, add new ones, and renumber the slots that name them.

    Returns the final numbers of old entries (keys 0, 1, ...) and new ones (keys -1, -2, ...). New entries take the
    places of dropped ones, and later entries move up. With an unknown extension, which may count on the numbers, places
    that are left over stay empty instead.
    """
    old, free, count = json_.get(key, []), sorted(dropped), len(new)
    numbers = {i: i for i in range(len(old)) if i not in dropped}
    numbers |= {-1 - i: free[i] if i < len(free) else len(old) + i - len(free) for i in range(count)}
    if not references.list_unknown_extensions(json_):
        empty = set(free[count:])
        shift = np.cumsum([i in empty for i in range(len(old) + count)])
        numbers = {source: int(number - shift[number]) for source, number in numbers.items()}
    for container, name in references.iterate_slots(json_, paths):
        container[name] = numbers[container[name]]
    json_[key] = [dict(_BLANKS[key]) for _ in range(max(numbers.values(), default=-1) + 1)]
    for source, number in numbers.items():
        json_[key][number] = old[source] if source >= 0 else new[-1 - source]
    return numbers


def _trim_views(json_: Json, views: dict[int, bytes]) -> dict[int, bytes]:
    """Return the bytes of views that accessors still use, and change their offsets to match.

    A view that something other than an accessor uses stays whole.
    """
    uses = Counter(container[key] for container, key in references.iterate_slots(json_, references.VIEWS))
    ranges: dict[int, list[ByteRange]] = {number: [] for number in views}
    for accessor in json_["accessors"]:
        for number, found in _list_ranges(json_, accessor, views):
            ranges[number].append(found)
    return {
        number: _close_gaps(ranges[number], data) if 0 < len(ranges[number]) == uses[number] else data
        for number, data in views.items()
    }


def _close_gaps(ranges: list[ByteRange], data: bytes) -> bytes:
    """Return the bytes that some range covers, close together."""
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


def _list_ranges(json_: Json, accessor: Json, views: dict[int, bytes]) -> Iterator[tuple[int, ByteRange]]:
    """Yield the views that an accessor reads, and where; nothing for what is not understood, so that it stays whole."""

    def byte_range(user: Json, length: int) -> ByteRange:
        start = user.get("byteOffset", 0)
        return user, start, start + length

    number, sparse = accessor.get("bufferView"), accessor.get("sparse", {})
    size = _count_bytes(accessor.get("componentType")) * WIDTHS.get(accessor.get("type", ""), 0)
    if number in views and size and "count" in accessor:
        stride = json_["bufferViews"][number].get("byteStride", size)
        yield number, byte_range(accessor, stride * (int(accessor["count"]) - 1) + size)
    for key, each in (("indices", _count_bytes(sparse.get("indices", {}).get("componentType"))), ("values", size)):
        number = sparse.get(key, {}).get("bufferView")
        if number in views and each and "count" in sparse:
            yield number, byte_range(sparse[key], each * int(sparse["count"]))


def _count_bytes(component: int | None) -> int:
    """Return the bytes of a number, 0 if the format has no such component type."""
    return np.dtype(COMPONENTS[component]).itemsize if component in COMPONENTS else 0
