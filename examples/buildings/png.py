"""PNG of at most sixteen colours, not compressed: a compressor's bytes depend on its version, these do not."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.uint8]

BLOCK = 65535
"""Bytes that a stored block holds at most."""


def png(pixels: Pixels, palette: Sequence[tuple[int, ...]]) -> bytes:
    """A picture of numbers into a palette of RGB or RGBA; its width is even."""
    height, width = pixels.shape
    if width % 2 or len(palette) > 16:
        raise ValueError("the width must be even, and 16 colours are the most")
    rows = np.zeros((height, 1 + width // 2), np.uint8)
    rows[:, 1:] = pixels[:, ::2] << 4 | pixels[:, 1::2]
    colours = b"".join(bytes(colour[:3]) for colour in palette)
    opacity = bytes(colour[3] if len(colour) > 3 else 255 for colour in palette)
    head = struct.pack(">IIBBBBB", width, height, 4, 3, 0, 0, 0)
    parts = [(b"IHDR", head), (b"PLTE", colours)]
    if min(opacity) < 255:
        parts.append((b"tRNS", opacity))
    parts += [(b"IDAT", stored(rows.tobytes())), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(name, data) for name, data in parts)


def chunk(name: bytes, data: bytes) -> bytes:
    """One chunk of the file."""
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


def stored(data: bytes) -> bytes:
    """Bytes as a zlib stream of blocks that are only stored."""
    blocks = [data[start : start + BLOCK] for start in range(0, len(data), BLOCK)]
    stream = b"\x78\x01"
    for k, block in enumerate(blocks):
        stream += struct.pack("<BHH", k == len(blocks) - 1, len(block), len(block) ^ 0xFFFF) + block
    return stream + struct.pack(">I", zlib.adler32(data))
