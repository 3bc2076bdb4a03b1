"""Read the size of images from their headers, and measure UV in texels."""

from __future__ import annotations

import struct
from collections.abc import Callable

import numpy as np

from ..model import Attribute, Part, Values
from ..options import UNKNOWN_TEXELS
from .input_folder import LoadFile

ImageSize = tuple[int, int]

_NO_FRAME = {0xC4, 0xC8, 0xCC}
"""JPEG markers among those of frames (0xC0 to 0xCF) that start none."""

_MEDIA = {b"\x89PNG": "image/png", b"\xff\xd8\xff": "image/jpeg", b"RIFF": "image/webp", b"\xabKTX 20": "image/ktx2"}


def make_uv_attribute(values: Values, parts: list[Part], load: LoadFile) -> Attribute:
    """Make an attribute of texture coordinates; a unit is worth the texels of the largest image of each material.

    Parameters
    ----------
    values : (n, 2) float64
        NaN where a row has none.
    parts : list of Part
    load : function of a relative path
        Returns the bytes of a file next to the model, or None.
    """
    sizes: dict[str, ImageSize] = {}
    steps = np.full((len(parts), 2), float(UNKNOWN_TEXELS))
    for row, part in enumerate(parts):
        material = part.material
        if material is None or not material.textures:
            continue
        for name in material.textures:
            if name not in sizes:
                data = material.image if material.image is not None and name == material.texture else load(name)
                sizes[name] = read_image_size(data or b"") or (UNKNOWN_TEXELS, UNKNOWN_TEXELS)
        steps[row] = np.max([sizes[name] for name in material.textures], axis=0) * material.repeats
    return Attribute("TEXCOORD_0", "uv", values, steps)


def find_media_type(data: bytes) -> str:
    """Return the media type of an image, by its first bytes."""
    return next((kind for magic, kind in _MEDIA.items() if data.startswith(magic)), "application/octet-stream")


def read_image_size(data: bytes) -> ImageSize | None:
    """Read width and height of a PNG, JPEG, WebP, KTX2, BMP or DDS image.

    Parameters
    ----------
    data : bytes
        All of the file, or enough of its beginning.

    Returns
    -------
    (width, height) : tuple of int, texels; or None
        None if the format is another one, or the header is cut off or names no size.

    Examples
    --------
    >>> read_image_size(b"BM" + bytes(12) + (12).to_bytes(4, "little") + bytes([3, 0, 2, 0]))
    (3, 2)
    """
    for magic, read in _READERS.items():
        if data.startswith(magic):
            try:
                size = read(data)
            except (struct.error, IndexError):
                return None
            return size if size is not None and min(size) > 0 else None
    return None


def _read_jpeg(data: bytes) -> ImageSize | None:
    """Read the size that the first frame states; skip the segments before it."""
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


def _read_webp(data: bytes) -> ImageSize | None:
    """Read the size from the first chunk, of whichever kind."""
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


def _read_bmp(data: bytes) -> ImageSize:
    """Read 16 bits for each in the oldest header; in the others a height below zero means rows from the top."""
    old = struct.unpack_from("<I", data, 14)[0] == 12
    width, height = struct.unpack_from("<HH" if old else "<ii", data, 18)
    return width, abs(height)


_READERS: dict[bytes, Callable[[bytes], ImageSize | None]] = {
    b"\x89PNG\r\n\x1a\n": lambda data: struct.unpack_from(">II", data, 16),
    b"\xff\xd8": _read_jpeg,
    b"RIFF": _read_webp,
    b"\xabKTX 20\xbb\r\n\x1a\n": lambda data: struct.unpack_from("<II", data, 20),
    b"BM": _read_bmp,
    # Height comes before width.
    b"DDS ": lambda data: struct.unpack_from("<II", data, 12)[::-1],
}
