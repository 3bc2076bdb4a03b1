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

from .document import COMPONENTS, WIDTHS, Document
from .references import (
    iterate_accessor_slots,
    iterate_accessor_view_slots,
    iterate_view_slots,
    list_unknown_extensions,
)

_VERTICES, _INDICES = 34962, 34963
_CODES = {np.dtype("<" + name): code for code, name in COMPONENTS.items()}
_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
_BLANK = {"componentType": 5126, "count": 1, "type": "VEC3"}
"""An accessor at a number that nothing names."""

ByteRange = tuple[dict[str, Any], int, int]
"""A JSON object with a ``byteOffset`` into a view, and where its bytes start and end there."""


@dataclass
class NewView:
    """Data of accessors that share a stride."""

    target: int
    stride: int
    data: bytearray = field(default_factory=bytearray)

    def to_json(self) -> dict[str, Any]:
        """Return the view's JSON, without its place."""
        return {"target": self.target, **({"byteStride": self.stride} if self.stride else {})}


@dataclass
class NewAccessors:
    """New accessors and buffer views, numbered among themselves; equal accessors are added once.

    Attributes
    ----------
    accessors : list of dict
        ``bufferView`` counts into `views`.
    views : list of NewView
    """

    accessors: list[dict[str, Any]] = field(default_factory=list)
    views: list[NewView] = field(default_factory=list)
    _numbers: dict[tuple[str, bytes], int] = field(default_factory=dict)

    def add_vertices(self, values: NDArray[Any], *, normalized: bool = False, bounds: bool = False, **more: Any) -> int:
        """Add a vertex attribute, with `bounds` also its exact least and greatest values; return its number.

        `more` are members of the accessor that do not follow from its values, such as its name.
        """
        kind = values.dtype.newbyteorder("<")
        rows = pack_rows(values, kind, aligned=True)
        if normalized:
            more["normalized"] = True
        if bounds:
            more |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        return self._add(_VERTICES, rows.shape[1], rows.tobytes(), {**_describe_values(kind, values.shape), **more})

    def add_indices(self, corners: NDArray[Any], count: int) -> int:
        """Add the corners of triangles, in 16 bits if `count` vertices allow it; return their number."""
        # The greatest 16-bit number restarts a strip, and must not name a vertex.
        kind = np.dtype("<u2") if count <= 65535 else np.dtype("<u4")
        values = np.ascontiguousarray(corners.reshape(-1, 1), kind)
        return self._add(_INDICES, 0, values.tobytes(), _describe_values(kind, values.shape))

    def _add(self, target: int, stride: int, data: bytes, entry: dict[str, Any]) -> int:
        """Add data to the view for its kind, unless it is there; return its number."""
        key = json.dumps([target, entry], sort_keys=True), hashlib.sha256(data).digest()
        if key not in self._numbers:
            self._numbers[key] = len(self.accessors)
            kinds = [(view.target, view.stride) for view in self.views]
            if (target, stride) not in kinds:
                kinds.append((target, stride))
                self.views.append(NewView(target, stride))
            number = kinds.index((target, stride))
            view = self.views[number].data
            view += b"\0" * (-len(view) % 4)
            self.accessors.append({"bufferView": number, "byteOffset": len(view), **entry})
            view += data
        return self._numbers[key]


def _describe_values(kind: np.dtype[Any], shape: tuple[int, ...]) -> dict[str, Any]:
    """Return the members of an accessor that follow from its values."""
    return {"componentType": _CODES[kind], "count": shape[0], "type": _TYPES[shape[1]]}


def pack_rows(values: NDArray[Any], kind: np.dtype[Any], *, aligned: bool) -> NDArray[np.uint8]:
    """Return numbers, (n, k), as bytes of a component type, (n, stride); `aligned` rows start at multiples of four."""
    width = values.shape[1] * kind.itemsize
    rows = np.zeros((len(values), width + (-width % 4 if aligned else 0)), np.uint8)
    rows[:, :width] = np.ascontiguousarray(values, kind).view(np.uint8).reshape(len(values), width)
    return rows


def pack_views(pieces: list[tuple[dict[str, Any], bytes]]) -> bytes:
    """Lay buffer views out in one buffer, in order, and set the place of each.

    Parameters
    ----------
    pieces : list of (dict, bytes)
        A view's JSON, changed in place, and its data.
    """
    binary = bytearray()
    for view, data in pieces:
        # Eight suffices for every component type, and for property tables.
        binary += b"\0" * (-len(binary) % 8)
        view["buffer"], view["byteOffset"], view["byteLength"] = 0, len(binary), len(data)
        binary += data
    return bytes(binary)


def replace_accessors(
    document: Document, json_: dict[str, Any], new: NewAccessors, replaced: set[int], *, whole: bool, first: bool
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
    dropped = replaced - {container[key] for container, key in iterate_accessor_slots(json_)}
    old = json_.get("accessors", [])
    freed = {container[key] for number in dropped for container, key in iterate_accessor_view_slots(old[number])}
    numbers = _assign_numbers(json_, "accessors", dropped, len(new.accessors))
    for container, key in list(iterate_accessor_slots(json_)):
        container[key] = numbers[container[key]]
    for accessor in new.accessors:
        accessor["bufferView"] = -1 - accessor["bufferView"]
    _place_entries(json_, "accessors", numbers, new.accessors, _BLANK)
    return _replace_views(document, json_, new.views, freed, whole=whole, first=first)


def _replace_views(
    document: Document, json_: dict[str, Any], new: list[NewView], freed: set[int], *, whole: bool, first: bool
) -> bytes:
    """Drop, number and lay out buffer views; those of new accessors are named by negative numbers."""
    old, fixed = json_.get("bufferViews", []), bool(list_unknown_extensions(json_))
    # Nothing names the views that compressed data was decoded from.
    freed |= set(range(len(old))) if document.decoded else set()
    kept = {container[key] for container, key in iterate_view_slots(json_)}
    numbers = _assign_numbers(json_, "bufferViews", freed - kept, len(new))
    # Buffers next to the document that lose nothing stay; the others become one.
    touched = {old[number]["buffer"] for number in freed}
    entries = enumerate(document.items("buffers"))
    merged = [i for i, entry in entries if whole or i in touched or "uri" not in entry]
    data = {
        numbers[i]: document.read_view(i) for i, view in enumerate(old) if i in numbers and view["buffer"] in merged
    }
    if not fixed:
        trimmed = _trim_views(json_, {i: document.read_view(i) for i in sorted(freed & kept)})
        data |= {numbers[i]: view for i, view in trimmed.items()}
    data |= {numbers[-1 - i]: bytes(view.data) for i, view in enumerate(new)}
    for container, key in list(iterate_view_slots(json_)):
        container[key] = numbers[container[key]]
    _place_entries(json_, "bufferViews", numbers, [view.to_json() for view in new], {})
    binary = _merge_buffers(json_, merged, data, first)
    for key in ("accessors", "bufferViews", "buffers"):
        if not json_[key]:
            del json_[key]
    return binary


def _merge_buffers(json_: dict[str, Any], merged: list[int], data: dict[int, bytes], first: bool) -> bytes:
    """Lay out the data of views in one buffer, in the place of those that it is merged from."""
    views, old = json_.get("bufferViews", []), json_.get("buffers", [])
    # A view without a buffer is an empty place.
    staying = [view for i, view in enumerate(views) if i not in data and view]
    fresh = [(view, data.get(i, bytes(4))) for i, view in enumerate(views) if i in data or not view]
    binary = pack_views(fresh)
    stay = [i for i in range(len(old)) if i not in merged]
    place = 0 if first else sum(i < merged[0] for i in stay) if merged else len(stay)
    number = {i: new + (new >= place and bool(fresh)) for new, i in enumerate(stay)}
    for view in staying:
        view["buffer"] = number[view["buffer"]]
    for view, _ in fresh:
        view["buffer"] = place
    json_["buffers"] = [old[i] for i in stay]
    if fresh:
        head = {k: v for k, v in old[merged[0]].items() if k not in ("uri", "byteLength")} if merged else {}
        json_["buffers"].insert(place, {**head, "byteLength": len(binary)})
    return binary


def _assign_numbers(json_: dict[str, Any], key: str, dropped: set[int], new: int) -> dict[int, int]:
    """Return final numbers of old entries (keys 0, 1, ...) and so many new ones (keys -1, -2, ...).

    New entries take the places of dropped ones, and later entries move up. With an unknown extension, which may count
    on the numbers, places that are left over stay empty instead.
    """
    old, free = len(json_.get(key, [])), sorted(dropped)
    numbers = {i: i for i in range(old) if i not in dropped}
    numbers |= {-1 - i: free[i] if i < len(free) else old + i - len(free) for i in range(new)}
    empty = set(free[new:])
    if not empty or list_unknown_extensions(json_):
        return numbers
    shift = np.cumsum([i in empty for i in range(old + new)])
    return {key: int(number - shift[number]) for key, number in numbers.items()}


def _place_entries(
    json_: dict[str, Any], key: str, numbers: dict[int, int], new: list[dict[str, Any]], blank: dict[str, Any]
) -> None:
    """Put old and new entries of a top-level array at their final numbers."""
    old = json_.get(key, [])
    placed = [dict(blank) for _ in range(max(numbers.values(), default=-1) + 1)]
    for source, target in numbers.items():
        placed[target] = old[source] if source >= 0 else new[-1 - source]
    json_[key] = placed


def _trim_views(json_: dict[str, Any], views: dict[int, bytes]) -> dict[int, bytes]:
    """Return the bytes of views that accessors still use, and change their offsets to match.

    A view that something other than an accessor uses stays whole.
    """
    uses = Counter(container[key] for container, key in iterate_view_slots(json_))
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


def _list_ranges(
    json_: dict[str, Any], accessor: dict[str, Any], views: dict[int, bytes]
) -> Iterator[tuple[int, ByteRange]]:
    """Yield the views that an accessor reads, and where; nothing for what is not understood, so that it stays whole."""

    def byte_range(user: dict[str, Any], length: int) -> ByteRange:
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
