"""PNG of at most sixteen colors, not compressed: a compressor's bytes depend on its version, these do not."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.uint8]

BLOCK = 65535
"""Bytes that a stored block holds at most."""


def encode_png(pixels: Pixels, palette: Sequence[tuple[int, ...]]) -> bytes:
    """Encode a picture of numbers into a palette of RGB or RGBA; its width must be even."""
    height, width = pixels.shape
    if width % 2 or len(palette) > 16:
        raise ValueError("the width must be even, and 16 colors are the most")
    rows = np.zeros((height, 1 + width // 2), np.uint8)
    rows[:, 1:] = pixels[:, ::2] << 4 | pixels[:, 1::2]
    colors = b"".join(bytes(color[:3]) for color in palette)
    opacity = bytes(color[3] if len(color) > 3 else 255 for color in palette)
    head = struct.pack(">IIBBBBB", width, height, 4, 3, 0, 0, 0)
    parts = [(b"IHDR", head), (b"PLTE", colors)]
    if min(opacity) < 255:
        parts.append((b"tRNS", opacity))
    parts += [(b"IDAT", store(rows.tobytes())), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(encode_chunk(name, data) for name, data in parts)


def encode_chunk(name: bytes, data: bytes) -> bytes:
    """Encode one chunk of the file."""
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


def store(data: bytes) -> bytes:
    """Wrap bytes in a zlib stream of stored blocks, without compression."""
    blocks = [data[start : start + BLOCK] for start in range(0, len(data), BLOCK)]
    stream = b"\x78\x01"
    for k, block in enumerate(blocks):
        stream += struct.pack("<BHH", k == len(blocks) - 1, len(block), len(block) ^ 0xFFFF) + block
    return stream + struct.pack(">I", zlib.adler32(data))
