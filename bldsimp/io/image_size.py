"""How large an image is, by its header alone."""

from __future__ import annotations

import struct
from collections.abc import Callable

Size = tuple[int, int]

_NO_FRAME = {0xC4, 0xC8, 0xCC}
"""JPEG markers among those of frames (0xC0 to 0xCF) that start none."""


def image_size(data: bytes) -> Size | None:
    """Width and height of a PNG, JPEG, WebP, KTX2, BMP or DDS image.

    Parameters
    ----------
    data : bytes
        All of the file, or enough of its beginning.

    Returns
    -------
    (width, height) : tuple of int, texels; or None
        None where the format is another one, or the header is cut off or names no size.

    Examples
    --------
    >>> image_size(b"BM" + bytes(12) + (12).to_bytes(4, "little") + bytes([3, 0, 2, 0]))
    (3, 2)
    """
    for magic, read in _READERS:
        if data.startswith(magic):
            try:
                size = read(data)
            except (struct.error, IndexError):
                return None
            return size if size is not None and min(size) > 0 else None
    return None


def _png(data: bytes) -> Size:
    width, height = struct.unpack_from(">II", data, 16)
    return width, height


def _jpeg(data: bytes) -> Size | None:
    """The size that the first frame states; segments before it are skipped."""
    place = 2
    while data[place] == 0xFF:
        marker = data[place + 1]
        if marker == 0xFF:
            place += 1
        elif marker == 0x01 or 0xD0 <= marker <= 0xD7:
            place += 2
        elif 0xC0 <= marker <= 0xCF and marker not in _NO_FRAME:
            height, width = struct.unpack_from(">HH", data, place + 5)
            return width, height
        else:
            place += 2 + struct.unpack_from(">H", data, place + 2)[0]
    return None


def _webp(data: bytes) -> Size | None:
    chunk = data[8:16]
    if chunk == b"WEBPVP8 ":
        width, height = struct.unpack_from("<HH", data, 26)
        return width & 0x3FFF, height & 0x3FFF
    if chunk == b"WEBPVP8L":
        (bits,) = struct.unpack_from("<I", data, 21)
        return (bits & 0x3FFF) + 1, (bits >> 14 & 0x3FFF) + 1
    if chunk == b"WEBPVP8X" and len(data) >= 30:
        return int.from_bytes(data[24:27], "little") + 1, int.from_bytes(data[27:30], "little") + 1
    return None


def _ktx2(data: bytes) -> Size:
    width, height = struct.unpack_from("<II", data, 20)
    return width, height


def _bmp(data: bytes) -> Size:
    """The oldest header has 16 bits for each; in the others a height below zero means rows from the top."""
    old = struct.unpack_from("<I", data, 14)[0] == 12
    width, height = struct.unpack_from("<HH" if old else "<ii", data, 18)
    return width, abs(height)


def _dds(data: bytes) -> Size:
    height, width = struct.unpack_from("<II", data, 12)
    return width, height


_READERS: tuple[tuple[bytes, Callable[[bytes], Size | None]], ...] = (
    (b"\x89PNG\r\n\x1a\n", _png),
    (b"\xff\xd8", _jpeg),
    (b"RIFF", _webp),
    (b"\xabKTX 20\xbb\r\n\x1a\n", _ktx2),
    (b"BM", _bmp),
    (b"DDS ", _dds),
)
