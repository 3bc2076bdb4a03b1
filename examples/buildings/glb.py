"""A glTF document in the making: arrays become accessors, and all of it one binary file."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

COMPONENTS = {"<f4": 5126, "<u2": 5123, "<u4": 5125}
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}
VERTICES, INDICES = 34962, 34963
"""What a view of the buffer is for."""

Z_UP = [-(0.5**0.5), 0, 0, 0.5**0.5]
"""The rotation of a node whose z axis points upwards, as glTF's y axis does."""


class Glb:
    """The arrays of a document."""

    def __init__(self) -> None:
        self.accessors: list[dict[str, Any]] = []
        self.views: list[dict[str, Any]] = []
        self.binary = bytearray()

    def add_view(self, data: bytes, **more: int) -> int:
        """Append bytes; the number of their view."""
        self.views.append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data), **more})
        self.binary += data + b"\0" * (-len(data) % 4)
        return len(self.views) - 1

    def add_accessor(self, values: NDArray[Any], target: int, *, bounded: bool = False) -> int:
        """Append an array of a type that glTF has; the number of its accessor."""
        entry: dict[str, Any] = {
            "bufferView": self.add_view(values.tobytes(), target=target),
            "componentType": COMPONENTS[values.dtype.str],
            "count": len(values),
            "type": TYPES[values[0].size],
        }
        if bounded:
            entry["min"] = [float(value) for value in values.min(axis=0)]
            entry["max"] = [float(value) for value in values.max(axis=0)]
        self.accessors.append(entry)
        return len(self.accessors) - 1

    def write(self, path: Path, **parts: Any) -> None:
        """Write the file; `parts` are the rest of its JSON, in their order."""
        document = {
            "asset": {"version": "2.0", "generator": "make_buildings.py"},
            **parts,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": len(self.binary)}],
        }
        text = json.dumps(document, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        chunks += struct.pack("<II", len(self.binary), 0x004E4942) + self.binary
        path.write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks)
