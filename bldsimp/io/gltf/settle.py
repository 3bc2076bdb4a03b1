"""A patched glTF document put in order: what nothing names any more goes, what is left is numbered and laid out."""

from __future__ import annotations

from typing import Any

import numpy as np

from .buffers import Body, pack_views, view_json
from .document import Document
from .references import accessor_slots, accessor_view_slots, unknown_extensions, view_slots
from .trim import trimmed


def settle(
    document: Document, json_: dict[str, Any], body: Body, replaced: set[int], *, whole: bool, first: bool
) -> bytes:
    """Drop what nothing names any more, number what is left, and lay out the buffer that changes.

    Parameters
    ----------
    document : Document
    json_ : dict
        A changed copy of the document's; new accessors are named by negative numbers.
    body : Body
        The new accessors.
    replaced : set of int
        Accessors that primitives named.
    whole, first : bool
        See `patched`.
    """
    if not (replaced or whole) and len(document.buffers) < 2:
        return b"".join(b"" if "uri" in entry else data for entry, data in _buffers(document))
    kept = {container[key] for container, key in accessor_slots(json_) if container[key] >= 0}
    dropped = sorted(replaced - kept)
    old = json_.get("accessors", [])
    freed_views = {container[key] for number in dropped for container, key in accessor_view_slots(old[number])}
    numbers = _merged(len(old), dropped, len(body.accessors), bool(unknown_extensions(json_)))
    for container, key in list(accessor_slots(json_)):
        container[key] = numbers[container[key]]
    blank = {"componentType": 5126, "count": 1, "type": "VEC3"}
    _place(json_, "accessors", numbers, body.accessors, blank)
    return _settle_views(document, json_, body, freed_views, whole, first)


def _buffers(document: Document) -> list[tuple[dict[str, Any], bytes]]:
    return list(zip(document.items("buffers"), document.buffers, strict=True))


def _settle_views(
    document: Document, json_: dict[str, Any], body: Body, freed: set[int], whole: bool, first: bool
) -> bytes:
    """The same for buffer views, and their data."""
    for accessor in body.accessors:
        accessor["bufferView"] = -1 - accessor["bufferView"]
    old = json_.get("bufferViews", [])
    kept = {container[key] for container, key in view_slots(json_) if container[key] >= 0}
    # What data was unpacked from is named by nothing.
    freed |= set(range(len(old))) if document.unpacked else set()
    dropped = sorted(freed - kept)
    numbers = _merged(len(old), dropped, len(body.views), bool(unknown_extensions(json_)))
    # Buffers beside the document that lose nothing stay; the others become one.
    touched = {old[number]["buffer"] for number in freed}
    made = [i for i, (entry, _) in enumerate(_buffers(document)) if whole or i in touched or "uri" not in entry]
    data = {numbers[i]: document.view(i) for i in range(len(old)) if i in numbers and old[i]["buffer"] in made}
    if not unknown_extensions(json_):
        short = trimmed(json_, {i: document.view(i) for i in sorted(freed & kept)})
        data |= {numbers[i]: view for i, view in short.items()}
    data |= {numbers[-1 - i]: bytes(view.data) for i, view in enumerate(body.views)}
    for container, key in list(view_slots(json_)):
        container[key] = numbers[container[key]]
    _place(json_, "bufferViews", numbers, [view_json(view) for view in body.views], {})
    binary = _settle_buffers(json_, made, data, first)
    for key in ("accessors", "bufferViews", "buffers"):
        if not json_[key]:
            del json_[key]
    return binary


def _settle_buffers(json_: dict[str, Any], made: list[int], data: dict[int, bytes], first: bool) -> bytes:
    """Lay out the data of views in one buffer, in the place of those that it is made of."""
    views, old = json_.get("bufferViews", []), json_.get("buffers", [])
    # A view without a buffer is an empty place.
    staying = [view for i, view in enumerate(views) if i not in data and view]
    fresh = [(view, data.get(i, bytes(4))) for i, view in enumerate(views) if i in data or not view]
    binary = pack_views(fresh)
    stay = [i for i in range(len(old)) if i not in made]
    place = 0 if first else sum(i < made[0] for i in stay) if made else len(stay)
    number = {i: new + (new >= place and bool(fresh)) for new, i in enumerate(stay)}
    for view in staying:
        view["buffer"] = number[view["buffer"]]
    for view, _ in fresh:
        view["buffer"] = place
    json_["buffers"] = [old[i] for i in stay]
    if fresh:
        head = {k: v for k, v in old[made[0]].items() if k not in ("uri", "byteLength")} if made else {}
        json_["buffers"].insert(place, {**head, "byteLength": len(binary)})
    return binary


def _merged(old: int, dropped: list[int], new: int, fixed: bool) -> dict[int, int]:
    """Final numbers of old entries (keys 0, 1, ...) and new ones (keys -1, -2, ...).

    New entries take the places of dropped ones. Where `fixed`, places that are left over stay empty,
    since an unknown extension may count on the numbers; else later entries move up.
    """
    free = list(dropped)
    taken = {-1 - i: free[i] if i < len(free) else old + i - len(free) for i in range(new)}
    left = set(free[new:])
    gone = set(dropped)
    final = {i: i for i in range(old) if i not in gone} | taken
    if fixed or not left:
        return final
    shift = np.cumsum([i in left for i in range(old + new)])
    return {key: int(number - shift[number]) for key, number in final.items()}


def _place(
    json_: dict[str, Any],
    key: str,
    numbers: dict[int, int],
    new: list[dict[str, Any]],
    blank: dict[str, Any],
) -> None:
    """Put old and new entries of a top-level array at their final numbers."""
    old = json_.get(key, [])
    count = max([*numbers.values(), -1]) + 1
    placed = [dict(blank) for _ in range(max(count, 0))]
    for source, target in numbers.items():
        placed[target] = old[source] if source >= 0 else new[-1 - source]
    json_[key] = placed
