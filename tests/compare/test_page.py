"""The page: whole in one file, safe with any file name, true in what it measures."""

from __future__ import annotations

import base64
import json
import re
import zlib
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pages import EVIL, make_box, make_comparison, make_hill, make_row

from bldsimp.compare import page as page_module
from bldsimp.compare.display_mesh import choose_display
from bldsimp.compare.page import build_page
from bldsimp.compare.placement import PlacedSurface
from bldsimp.compare.rows import Comparison, MethodRow


class Elements(HTMLParser):
    """All elements with their attributes; the text of scripts by their id."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.scripts: dict[str | None, str] = {}
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        if self.tags and self.tags[-1][0] == "script":
            name = self.tags[-1][1].get("id")
            self.scripts[name] = self.scripts.get(name, "") + data

    @property
    def data(self) -> Any:
        """What the program reads."""
        return json.loads(self.scripts["data"])

    def blob(self, number: int, kind: str) -> np.ndarray:
        """An array as the program unpacks it."""
        return np.frombuffer(zlib.decompress(base64.b64decode(self.scripts[f"blob-{number}"])), kind)


def read_elements(comparisons: list[Comparison]) -> Elements:
    return Elements(build_page(comparisons).decode())


def test_nothing_comes_from_elsewhere() -> None:
    for tag, attributes in read_elements([make_comparison()]).tags:
        for name in ("src", "href", "action", "poster", "data"):
            value = attributes.get(name) or ""
            assert not value or value.startswith("data:"), (tag, attributes)
        assert tag not in ("iframe", "object", "embed", "base")


@pytest.mark.parametrize("file", [EVIL, "häuser/Straße 5, 東京.obj", "a\u2028b.obj"])
def test_any_file_name_is_text_and_nothing_more(file: str) -> None:
    plain, found = read_elements([make_comparison()]), read_elements([make_comparison(file)])
    assert [tag for tag, _ in found.tags] == [tag for tag, _ in plain.tags]
    assert [list(attributes) for _, attributes in found.tags] == [list(attributes) for _, attributes in plain.tags]
    assert found.data["files"][0]["caption"][0] == f"original · {file.rsplit('/', 1)[-1]}"


def test_a_file_name_that_is_not_unicode_is_written_all_the_same() -> None:
    assert b"h?user.obj" in build_page([make_comparison("h\udce4user.obj")])


def test_notes_and_methods_are_escaped() -> None:
    evil = make_comparison()
    evil.rows[1].note = evil.rows[3].note = evil.rows[2].method = EVIL
    assert [tag for tag, _ in read_elements([evil]).tags].count("img") == 0


def test_the_viewer_is_named_by_its_version_and_has_its_license() -> None:
    folder = Path(page_module.__file__).parent
    library = (folder / page_module.VIEWER).read_text("utf-8")
    (version,) = re.findall(r"three-([\d.]+)\.min\.js", page_module.VIEWER)
    assert library.startswith(f"/*!\n@license three.js {version}, ")
    assert f'revision:"{version.split(".")[1]}"' in library
    assert (folder / "three-LICENSE.txt").read_text("utf-8") in library
    # Neither may end its script element, nor begin a comment there.
    assert "</script" not in library
    assert "<!--" not in library


def test_the_same_comparisons_give_the_same_bytes() -> None:
    assert build_page([make_comparison()]) == build_page([make_comparison()])


def test_a_surface_is_stored_once_however_many_rows_show_it() -> None:
    once = make_comparison()
    often = make_comparison()
    often.rows += [make_row("fast-simplification lossless", make_hill(8), 0.05), make_row("manifold3d", make_hill(24))]
    assert len(read_elements([often]).data["surfaces"]) == len(read_elements([once]).data["surfaces"]) == 3
    assert len(read_elements([often]).data["rows"]) == 5
    twice = read_elements([once, make_comparison("copy.obj")])
    assert {key for key in twice.scripts if key} == {key for key in read_elements([once]).scripts if key}


def test_rows_without_a_surface_and_files_without_rows_stand_in_the_table_only() -> None:
    failed = Comparison("broken.obj", None, 0.0, {}, [MethodRow("broken.obj", "", "original", note="failed: no faces")])
    found = read_elements([failed, make_comparison()])
    rows = [attributes for tag, attributes in found.tags if tag == "tr" and "data-row" in attributes]
    assert [attributes["data-row"] for attributes in rows] == ["0", "1", "2"]
    assert [attributes["data-row"] for attributes in rows if "data-first" in attributes] == ["1"]
    text = build_page([failed, make_comparison()]).decode()
    assert "failed: no faces" in text
    assert "cannot be reached" in text
    assert read_elements([failed]).data == {"files": [{}], "surfaces": [], "rows": []}


def test_rounding_alone_has_no_color() -> None:
    each = make_comparison()
    assert each.original is not None
    turned = np.ascontiguousarray(np.roll(each.original.faces, 1, axis=1)[::-1])
    each.rows[1].surface = PlacedSurface(each.original.points, turned)
    (row,) = [row for row in read_elements([each]).data["rows"] if row["caption"][0].startswith("improved")]
    assert [side["top"] for side in row["distances"]] == [0.0, 0.0]


def test_distances_are_those_of_the_surfaces_both_ways() -> None:
    """Of two boxes on one base, the tops are half a unit apart, and every point between knows its own height."""
    original, result = make_box((0, 0, 0), (2, 2, 2)), make_box((0, 0, 0), (2, 2, 1.5))
    rows = [make_row("original", original), make_row("improved", result, 0.5)]
    found = read_elements([Comparison("box.obj", original, 12**0.5, {"0.1%": 0.1}, rows)])
    there, back = found.data["rows"][1]["distances"]
    assert there["top"] == pytest.approx(0.5)
    assert back["top"] == pytest.approx(0.5)
    values = found.blob(there["blob"], "<u2") * (there["top"] / 65535)
    places = choose_display(original).place_samples()
    # A side above the lower top is nearest to that top's edge; the upper top to the lower one.
    np.testing.assert_allclose(values, np.maximum(places[:, 2] - 1.5, 0.0), atol=1e-5)
    assert np.all(found.blob(found.data["rows"][0]["distances"][0]["blob"], "<u2") == 0)
