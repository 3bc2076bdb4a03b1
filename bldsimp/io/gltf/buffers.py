"""The binary half of a glTF document under construction: vertex and index data, packed and described."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .document import COMPONENTS

VERTICES, INDICES = 34962, 34963
_CODES = {np.dtype("<" + name): code for code, name in COMPONENTS.items()}
_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


@dataclass
class NewView:
    """Data of accessors that share a stride."""

    target: int
    stride: int
    data: bytearray = field(default_factory=bytearray)


@dataclass
class Body:
    """New accessors and buffer views, numbered among themselves. What is added twice is there once.

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
        """Add a vertex attribute; with `bounds`, its exact least and greatest values are stored.

        Members of the accessor that are not told by its values, such as its name, may be given.
        """
        kind = values.dtype.newbyteorder("<")
        width = values.shape[1] * kind.itemsize
        stride = width + -width % 4
        rows = np.zeros((len(values), stride), np.uint8)
        rows[:, :width] = np.ascontiguousarray(values, kind).view(np.uint8).reshape(len(values), width)
        if normalized:
            more["normalized"] = True
        if bounds:
            more |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        return self._add(VERTICES, stride, rows.tobytes(), kind, values.shape, more)

    def add_indices(self, corners: NDArray[Any], count: int) -> int:
        """Add the corners of triangles, in 16 bits where `count` vertices allow it."""
        # The greatest 16-bit number restarts a strip, and must not name a vertex.
        kind = np.dtype("<u2") if count <= 65535 else np.dtype("<u4")
        values = np.ascontiguousarray(corners.reshape(-1, 1), kind)
        return self._add(INDICES, 0, values.tobytes(), kind, values.shape, {})

    def _add(
        self, target: int, stride: int, data: bytes, kind: np.dtype[Any], shape: tuple[int, ...], more: dict[str, Any]
    ) -> int:
        said = {"componentType": _CODES[kind], "count": shape[0], "type": _TYPES[shape[1]], **more}
        key = json.dumps([target, said], sort_keys=True), hashlib.sha256(data).digest()
        if key not in self._numbers:
            self._numbers[key] = len(self.accessors)
            self.accessors.append({**self._place(target, stride, data), **said})
        return self._numbers[key]

    def _place(self, target: int, stride: int, data: bytes) -> dict[str, Any]:
        """Put data into the view for its kind; where it is."""
        number, view = next(
            ((i, v) for i, v in enumerate(self.views) if (v.target, v.stride) == (target, stride)), (-1, None)
        )
        if view is None:
            number, view = len(self.views), NewView(target, stride)
            self.views.append(view)
        view.data += b"\0" * (-len(view.data) % 4)
        start = len(view.data)
        view.data += data
        return {"bufferView": number, "byteOffset": start}


def pack_views(pieces: list[tuple[dict[str, Any], bytes]]) -> bytes:
    """Lay buffer views out in one buffer, in order, and tell each its place.

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


def view_json(view: NewView) -> dict[str, Any]:
    """A new view's JSON, without its place."""
    found: dict[str, Any] = {"target": view.target}
    if view.stride:
        found["byteStride"] = view.stride
    return found
