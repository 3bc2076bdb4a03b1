"""The size of an image, from what another library writes, and from broken headers."""

from __future__ import annotations

import io
import struct
from typing import Any

import pytest

from bldsimp.io.textures import read_image_size

SIZE = (37, 1021)
WRITTEN: dict[str, tuple[str, dict[str, Any]]] = {
    "PNG": ("PNG", {}),
    "JPEG": ("JPEG", {}),
    "JPEG with segments before the frame": ("JPEG", {"exif": b"Exif\0\0" + bytes(300), "comment": b"\xff\xc0" * 9}),
    "progressive JPEG": ("JPEG", {"progressive": True}),
    "WebP": ("WEBP", {}),
    "WebP without loss": ("WEBP", {"lossless": True}),
    "WebP with more chunks": ("WEBP", {"exif": b"Exif\0\0" + bytes(30)}),
    "BMP": ("BMP", {}),
    "DDS": ("DDS", {}),
}


def write_image(name: str, size: tuple[int, int]) -> bytes:
    """An image as Pillow writes it."""
    from PIL import Image

    format_, more = WRITTEN[name]
    stream = io.BytesIO()
    Image.new("RGB", size, (200, 10, 30)).save(stream, format_, **more)
    return stream.getvalue()


@pytest.mark.parametrize("name", WRITTEN)
def test_the_size_is_what_was_written(name: str) -> None:
    for size in (SIZE, SIZE[::-1], (1, 1)):
        assert read_image_size(write_image(name, size)) == size


@pytest.mark.parametrize("name", WRITTEN)
def test_a_header_that_is_cut_off_has_no_size(name: str) -> None:
    data = write_image(name, SIZE)
    found = [read_image_size(data[:length]) for length in range(min(len(data), 900))]
    assert found[0] is None
    assert set(found) <= {None, SIZE}


def test_ktx2_and_bitmaps_of_other_headers() -> None:
    ktx2 = b"\xabKTX 20\xbb\r\n\x1a\n" + struct.pack("<IIII", 0, 1, 512, 256)
    assert read_image_size(ktx2) == (512, 256)
    assert read_image_size(b"BM" + bytes(12) + struct.pack("<IHH", 12, 5, 6)) == (5, 6)
    assert read_image_size(b"BM" + bytes(12) + struct.pack("<Iii", 40, 5, -6)) == (5, 6)


NO_IMAGES = [b"", b"GIF89a" + bytes(40), b"\x89PNG and so on", b"DDS " + bytes(200), b"\xff\xd8\xff"]


@pytest.mark.parametrize("data", NO_IMAGES)
def test_what_is_no_image_has_no_size(data: bytes) -> None:
    assert read_image_size(data) is None
