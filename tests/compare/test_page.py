"""The page: whole in one file, safe with any file name, true in what it measures, and alive in a real browser."""

from __future__ import annotations

import base64
import io
import json
import math
import os
import shutil
import time
import zipfile
import zlib
from collections.abc import Callable, Iterator
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bldsimp import _core
from bldsimp.compare import page as page_module
from bldsimp.compare.chart import Axis, chart_svg, ticks
from bldsimp.compare.drawn import drawn, lattice
from bldsimp.compare.page import viewer_library, write_page
from bldsimp.compare.plot import lines_of
from bldsimp.compare.row import Comparison, Row
from bldsimp.compare.surface import Surface, welded
from bldsimp.errors import BldsimpError

EVIL = "</script><img src=x onerror=alert(1)>&amp;\"'<!--.obj"


def hill(n: int, height: float = 0.2) -> Surface:
    """A gentle landscape of n times n squares on a base of 8 by 8."""
    flat = np.mgrid[0 : n + 1, 0 : n + 1].reshape(2, -1).T * (8.0 / n)
    points = np.column_stack([flat, height * np.sin(flat[:, 0]) * np.cos(flat[:, 1] * 1.3)])
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).reshape(-1)
    quads = np.stack([corner, corner + n + 1, corner + n + 2, corner + 1], axis=1)
    return welded(points, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> Surface:
    """Twelve triangles."""
    corners = np.array([[(low, high)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)])
    quads = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])
    return welded(corners, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))


def row(method: str, surface: Surface | None, deviation: float | None = 0.0, **more: Any) -> Row:
    """A row with the figures of its surface."""
    if surface is None:
        return Row("hill.obj", "0.1%", method, note="cannot be reached", **more)
    points, triangles = len(surface.points), len(surface.faces)
    return Row("hill.obj", "0.1%", method, points, triangles, deviation, surface=surface, watertight=False,
               border_made=0, seconds=0.5, **more)  # fmt: skip


def comparison(file: str = "hill.obj", n: int = 24) -> Comparison:
    """A landscape with a coarser one, a flat one, and a method that failed."""
    original, coarse, flat = hill(n), hill(n // 3), hill(1)
    rows = [
        row("original", original),
        row("improved", coarse, 0.05, bound=0.06),
        row("fast-simplification", flat, 0.5),
        row("fast-simplification border", None),
    ]
    for each in rows:
        each.file = file
    diagonal = float(np.linalg.norm(np.ptp(original.points, axis=0)))
    return Comparison(file, original, diagonal, {"0.1%": diagonal / 1000}, rows)


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


def elements(comparisons: list[Comparison]) -> Elements:
    return Elements(write_page(comparisons).decode())


def test_nothing_comes_from_elsewhere() -> None:
    for tag, attributes in elements([comparison()]).tags:
        for name in ("src", "href", "action", "poster", "data"):
            value = attributes.get(name) or ""
            assert not value or value.startswith("data:"), (tag, attributes)
        assert tag not in ("iframe", "object", "embed", "base")


@pytest.mark.parametrize("file", [EVIL, "häuser/Straße 5, 東京.obj", "a\u2028b.obj"])
def test_any_file_name_is_text_and_nothing_more(file: str) -> None:
    plain, found = elements([comparison()]), elements([comparison(file)])
    assert [tag for tag, _ in found.tags] == [tag for tag, _ in plain.tags]
    assert [list(attributes) for _, attributes in found.tags] == [list(attributes) for _, attributes in plain.tags]
    assert found.data["files"][0]["caption"][0] == f"original · {file.rsplit('/', 1)[-1]}"


def test_a_file_name_that_is_not_unicode_is_written_all_the_same() -> None:
    assert b"h?user.obj" in write_page([comparison("h\udce4user.obj")])


def test_notes_and_methods_are_escaped() -> None:
    evil = comparison()
    evil.rows[1].note = evil.rows[3].note = evil.rows[2].method = EVIL
    assert [tag for tag, _ in elements([evil]).tags].count("img") == 0


def test_the_library_is_three_js_with_its_licence_and_no_more() -> None:
    library = viewer_library()
    assert library.startswith("/**")
    assert "SPDX-License-Identifier: MIT" in library[:300]
    assert "THREE.TrackballControls=TrackballControls" in library
    assert "</script" not in library
    assert "GLTFLoader extends" not in library
    assert "function init()" not in library


@pytest.mark.parametrize("template", ["<script>something else</script>", None])
def test_a_trimesh_without_the_library_is_told(template: str | None, tmp_path: Path, monkeypatch: Any) -> None:
    if template is not None:
        folder = tmp_path / "resources" / "templates"
        folder.mkdir(parents=True)
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w") as opened:
            opened.writestr("viewer.html.template", template)
        (folder / "viewer.zip").write_bytes(packed.getvalue())
    monkeypatch.setattr(page_module, "files", lambda _: tmp_path)
    with pytest.raises(BldsimpError, match="trimesh"):
        viewer_library()


def test_the_same_comparisons_give_the_same_bytes() -> None:
    assert write_page([comparison()]) == write_page([comparison()])


def test_a_surface_is_stored_once_however_many_rows_show_it() -> None:
    once = comparison()
    often = comparison()
    often.rows += [row("fast-simplification lossless", hill(8), 0.05), row("manifold3d", hill(24))]
    assert len(elements([often]).data["surfaces"]) == len(elements([once]).data["surfaces"]) == 3
    assert len(elements([often]).data["rows"]) == 5
    twice = elements([once, comparison("copy.obj")])
    assert {key for key in twice.scripts if key} == {key for key in elements([once]).scripts if key}


def test_rows_without_a_surface_and_files_without_rows_stand_in_the_table_only() -> None:
    failed = Comparison("broken.obj", None, 0.0, {}, [Row("broken.obj", "", "original", note="failed: no faces")])
    found = elements([failed, comparison()])
    rows = [attributes for tag, attributes in found.tags if tag == "tr" and "data-row" in attributes]
    assert [attributes["data-row"] for attributes in rows] == ["0", "1", "2"]
    assert [attributes["data-row"] for attributes in rows if "data-first" in attributes] == ["1"]
    text = write_page([failed, comparison()]).decode()
    assert "failed: no faces" in text
    assert "cannot be reached" in text
    assert elements([failed]).data == {"files": [{}], "surfaces": [], "rows": []}


def test_rounding_alone_has_no_colour() -> None:
    each = comparison()
    assert each.original is not None
    turned = np.ascontiguousarray(np.roll(each.original.faces, 1, axis=1)[::-1])
    each.rows[1].surface = Surface(each.original.points, turned)
    (row,) = [row for row in elements([each]).data["rows"] if row["caption"][0].startswith("improved")]
    assert [side["top"] for side in row["distances"]] == [0.0, 0.0]


def test_distances_are_those_of_the_surfaces_both_ways() -> None:
    """Of two boxes on one base, the tops are half a unit apart, and every point between knows its own height."""
    original, result = box((0, 0, 0), (2, 2, 2)), box((0, 0, 0), (2, 2, 1.5))
    rows = [row("original", original), row("improved", result, 0.5)]
    found = elements([Comparison("box.obj", original, 12**0.5, {"0.1%": 0.1}, rows)])
    there, back = found.data["rows"][1]["distances"]
    assert there["top"] == pytest.approx(0.5)
    assert back["top"] == pytest.approx(0.5)
    values = found.blob(there["blob"], "<u2") * (there["top"] / 65535)
    places = drawn(original).samples()
    # A side above the lower top is nearest to that top's edge; the upper top to the lower one.
    np.testing.assert_allclose(values, np.maximum(places[:, 2] - 1.5, 0.0), atol=1e-5)
    assert np.all(found.blob(found.data["rows"][0]["distances"][0]["blob"], "<u2") == 0)


@pytest.mark.parametrize("k", [1, 2, 3, 7])
def test_a_lattice_is_numbered_as_the_shader_looks_it_up(k: int) -> None:
    shares = lattice(k)
    assert len(shares) == (k + 1) * (k + 2) // 2
    for j in range(k + 1):
        for i in range(k + 1 - j):
            found = shares[j * (k + 1) - j * (j - 1) // 2 + i]
            np.testing.assert_allclose(found, [(k - i - j) / k, i / k, j / k])


def test_samples_lie_on_the_surface_and_within_their_number() -> None:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [50, 50, 3]])
    surface = welded(corners, np.array([[0, 1, 2], [1, 3, 2]]))
    shown = drawn(surface)
    assert shown.parts[1] > shown.parts[0] > 100
    samples = shown.samples()
    assert 20_000 < len(samples) <= 40_000 + 4
    assert _core.FaceTree(surface.points, surface.faces).distances(samples).max() < 1e-13


def test_a_thinned_surface_keeps_points_of_its_own() -> None:
    surface = hill(100)
    shown = drawn(surface, triangles=2_000)
    assert shown.thinned
    assert len(shown.faces) <= 2_000
    own = {tuple(point) for point in surface.points.tolist()}
    assert all(tuple(point) in own for point in shown.points.tolist())
    assert len(shown.samples()) == len(shown.points)
    # Close to the whole, at its border, too.
    assert _core.FaceTree(shown.points, shown.faces).distances(surface.points).max() < 0.03
    assert not drawn(surface).thinned


def test_the_chart_puts_more_points_higher_and_larger_tolerances_farther_right() -> None:
    each = comparison()
    each.tolerances = {"auto": 1e-5, "0.1%": 0.01, "5%": 0.5}
    each.rows = [Row("a", t, "improved", points=p) for t, p in (("auto", 900), ("0.1%", 500), ("5%", 40))]
    svg = chart_svg(each, lines_of([each]), {0: 7, 2: 8})
    curve = svg.split('class="curve"')[1].split('d="M')[1].split('"')[0]
    spots = np.array([[float(v) for v in spot.split()] for spot in curve.split("L")])
    assert np.all(np.diff(spots[:, 0]) > 0)
    assert np.all(np.diff(spots[:, 1]) > 0), "downwards in SVG"
    assert svg.count("data-row") == 2
    assert 'data-row="8"' in svg
    assert chart_svg(Comparison("a", None, 0.0, {}, []), {}, {}) == ""


def test_a_line_without_marks_is_seen_at_a_single_tolerance() -> None:
    each = comparison()
    svg = chart_svg(each, lines_of([each]), {})
    curves = [part.split('d="M')[1].split('"')[0] for part in svg.split('class="curve"')[1:]]
    lengths = [np.ptp([float(spot.split()[0]) for spot in curve.split("L")]) for curve in curves]
    assert sorted(lengths) == [0.0, 0.0, 16.0]


@pytest.mark.parametrize("log", [True, False])
@pytest.mark.parametrize("most", [3, 12, 99, 976, 25_184, 1_000_000])
def test_ticks_are_few_and_within(most: float, log: bool) -> None:
    axis = Axis(most / 8 if log else 0.0, most * 1.1, 300, 10, log)
    values = ticks(axis)
    assert 2 <= len(values) <= 7
    assert all(axis.low <= value <= axis.high * (1 + 1e-9) for value in values)
    assert math.isclose(axis(axis.low), 300)
    assert math.isclose(axis(axis.high), 10)


# ---- In a browser ----

FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--hide-scrollbars",
    "--force-device-scale-factor=1",
    "--window-size=1000,800",
)
PATIENCE = 60


def absent(reason: str) -> None:
    """Skip, unless whoever runs the tests has promised a browser."""
    if os.environ.get("BLDSIMP_NEED_BROWSER") == "1":
        pytest.fail(reason)
    pytest.skip(reason)


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Chromium without a screen, drawing in software."""
    found = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    driver = shutil.which("chromedriver")
    if found is None or driver is None:
        absent("no Chromium with its chromedriver (Debian: chromium, chromium-driver)")
    try:
        from selenium import webdriver
    except ImportError:
        absent("no selenium: sh setup.sh test")
    options = webdriver.ChromeOptions()
    options.binary_location = found
    for flag in (*FLAGS, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    opened = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    opened.set_page_load_timeout(PATIENCE)
    yield opened
    opened.quit()


class Page:
    """An opened page, as a user meets it."""

    def __init__(self, browser: Any, path: Path) -> None:
        self.browser = browser
        for kind in ("browser", "performance"):
            browser.get_log(kind)
        browser.get(path.as_uri())
        self.until(lambda: self.shown is not None)

    @property
    def shown(self) -> str | None:
        """Number of the row that is drawn."""
        found: str | None = self.browser.execute_script("return document.body.dataset.shown ?? null")
        return found

    def one(self, selector: str) -> Any:
        return self.browser.find_element("css selector", selector)

    def until(self, holds: Callable[[], bool]) -> None:
        end = time.monotonic() + PATIENCE
        while not holds():
            assert time.monotonic() < end, "the page does not get there"
            time.sleep(0.05)

    def choose(self, number: int) -> None:
        self.one(f"tr[data-row='{number}']").click()
        self.until(lambda: self.shown == str(number))

    def picture(self, side: str) -> np.ndarray:
        """Pixels of a view once they have come to rest, (h, w, 3)."""
        from PIL import Image

        self.browser.execute_script("window.scrollTo(0, 0)")
        last, end = b"", time.monotonic() + PATIENCE
        while True:
            self.browser.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")
            now = self.one(f"#{side} canvas").screenshot_as_png
            if now == last:
                return np.asarray(Image.open(io.BytesIO(now)).convert("RGB")).astype(int)
            assert time.monotonic() < end, "the view does not come to rest"
            last = now

    def pictures(self) -> tuple[np.ndarray, np.ndarray]:
        return self.picture("left"), self.picture("right")

    def caption(self, side: str) -> str:
        text: str = self.one(f"#{side} figcaption").text
        return text

    def errors(self) -> list[str]:
        entries = self.browser.get_log("browser")
        return [entry["message"] for entry in entries if entry["level"] == "SEVERE"]

    def requests(self) -> list[str]:
        """Addresses that were asked for, but the page's own, and what the browser shows before it."""
        messages = [json.loads(entry["message"])["message"] for entry in self.browser.get_log("performance")]
        asked = [each["params"]["request"]["url"] for each in messages if each["method"] == "Network.requestWillBeSent"]
        return [url for url in asked if not url.startswith(("file:", "data:", "blob:", "chrome:", "chrome-untrusted:"))]


def changed(a: np.ndarray, b: np.ndarray) -> float:
    """Share of the pixels that differ visibly."""
    height, width = min(a.shape[0], b.shape[0]), min(a.shape[1], b.shape[1])
    return float((np.abs(a[:height, :width] - b[:height, :width]).max(axis=2) > 12).mean())


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A page with two files."""
    path = tmp_path_factory.mktemp("page") / "Häuser & more.html"
    path.write_bytes(write_page([comparison(), comparison(EVIL, 12)]))
    return path


@pytest.fixture
def opened(browser: Any, written: Path) -> Iterator[Page]:
    """That page, opened afresh; whatever is done to it, nothing fails and nothing is fetched."""
    page = Page(browser, written)
    yield page
    assert page.errors() == []
    assert page.requests() == []


def test_the_table_fits_a_usual_window_and_its_head_stays(browser: Any, tmp_path: Path) -> None:
    each = comparison("a_name_without_any_space" * 6 + ".obj")
    names = ("original", "improved", "fast-simplification lossless", "fast-simplification same points")
    for one, name in zip(each.rows, names, strict=True):
        one.method, one.points, one.triangles, one.deviation, one.bound = name, 1234567, 2345678, 1.23e-06, 1.23e-06
        one.seconds, one.note = 123.45, "same deviation as improved (1.04e-06 and 9.5e-07 that single precision blurs)"
    each.tolerances = {f"{k}%": k / 1000 for k in range(1, 9)}
    each.rows = [replace(one, tolerance=written) for written in each.tolerances for one in each.rows]
    path = tmp_path / "wide.html"
    path.write_bytes(write_page([each]))
    browser.set_window_size(1400, 900)
    try:
        page = Page(browser, path)
        told = "const rows = document.querySelector('.rows'), head = rows.querySelector('thead th');"
        measured = browser.execute_script(
            told + "rows.scrollTop = 1e6;"
            " return [rows.scrollWidth, rows.clientWidth, rows.scrollTop, rows.clientHeight,"
            " head.getBoundingClientRect().top - rows.getBoundingClientRect().top,"
            " document.documentElement.scrollWidth - document.documentElement.clientWidth];"
        )
        assert page.errors() == []
    finally:
        browser.set_window_size(1000, 800)
    wide, room, scrolled, height, head, beyond = measured
    assert beyond == 0
    assert wide <= room
    assert scrolled > 0
    assert height < 900
    assert abs(head) < 2


def test_both_views_are_drawn(opened: Page) -> None:
    opened.choose(1)
    for picture in opened.pictures():
        background = picture[:4].mean(axis=(0, 1))
        drawn_share = (np.abs(picture - background).max(axis=2) > 40).mean()
        assert 0.1 < drawn_share < 0.9
        assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 100
    assert "hill.obj" in opened.caption("left")
    assert "625 points" in opened.caption("left")
    assert "improved" in opened.caption("right")
    assert "0.06" in opened.caption("right")


def test_a_click_on_a_row_shows_its_surface(opened: Page) -> None:
    opened.choose(1)
    before = opened.pictures()
    opened.choose(2)
    assert "fast-simplification" in opened.caption("right")
    assert "4 points" in opened.caption("right")
    assert changed(before[1], opened.picture("right")) > 0.05
    assert opened.one("tr[data-row='2']").get_attribute("aria-current") == "true"
    assert opened.one("tr[data-row='2'] input").is_selected()


def test_the_chart_chooses_too_and_follows(opened: Page) -> None:
    opened.choose(2)
    opened.browser.execute_script(
        "document.querySelector('.chart .mark[data-row=\"1\"]').dispatchEvent(new MouseEvent('click', {bubbles: true}))"
    )
    opened.until(lambda: opened.shown == "1")
    assert opened.one(".chart .mark[data-row='1']").get_attribute("aria-current") == "true"
    assert [chart.is_displayed() for chart in opened.browser.find_elements("css selector", ".chart")] == [True, False]


def test_another_file_is_shown_on_both_sides(opened: Page) -> None:
    opened.choose(4)
    assert EVIL.rsplit("/", 1)[-1] in opened.caption("left")
    assert [chart.is_displayed() for chart in opened.browser.find_elements("css selector", ".chart")] == [False, True]
    opened.choose(1)
    assert "hill.obj" in opened.caption("left")


@pytest.mark.parametrize(("box", "least"), [("edges", 0.02), ("colours", 0.1)])
def test_a_box_switches_what_is_drawn_in_both_views_and_back(opened: Page, box: str, least: float) -> None:
    opened.choose(1)
    before = opened.pictures()
    opened.one(f"#{box}").click()
    for side, picture in zip(("left", "right"), before, strict=True):
        assert changed(picture, opened.picture(side)) > least
    opened.one(f"#{box}").click()
    for side, picture in zip(("left", "right"), before, strict=True):
        np.testing.assert_array_equal(picture, opened.picture(side))


def test_without_edges_the_dark_lines_are_gone(opened: Page) -> None:
    opened.choose(1)
    opened.one("#colours").click()
    dark = []
    for _ in range(2):
        dark.append((opened.picture("right").max(axis=2) < 130).mean())
        opened.one("#edges").click()
    assert dark[0] > 10 * dark[1]


def test_both_views_turn_and_zoom_as_one_whichever_is_dragged(opened: Page) -> None:
    from selenium.webdriver import ActionChains
    from selenium.webdriver.common.actions.wheel_input import ScrollOrigin

    opened.choose(0)
    opened.one("#edges").click()
    opened.one("#reset").click()
    for side in ("left", "right"):
        canvas = opened.one(f"#{side} canvas")
        for act in (
            ActionChains(opened.browser).drag_and_drop_by_offset(canvas, 90, 35),
            ActionChains(opened.browser).scroll_from_origin(ScrollOrigin.from_element(canvas), 0, -300),
        ):
            before = opened.pictures()
            assert changed(*before) < 0.02, "the same surface looks the same in both"
            act.perform()
            after = opened.pictures()
            assert changed(*after) < 0.02
            assert changed(before[0], after[0]) > 0.05
    start = opened.picture("left")
    opened.one("#reset").click()
    assert changed(start, opened.picture("left")) > 0.05


def test_the_keyboard_is_enough(opened: Page) -> None:
    from selenium.webdriver.common.keys import Keys

    opened.choose(1)
    opened.one("#reset").click()
    rest = opened.pictures()
    canvas = opened.one("#right canvas")
    canvas.send_keys(Keys.ARROW_LEFT * 4 + "+")
    assert all(changed(a, b) > 0.05 for a, b in zip(rest, opened.pictures(), strict=True))
    canvas.send_keys("0")
    opened.one("tr[data-row='1'] input").send_keys(Keys.ARROW_DOWN)
    opened.until(lambda: opened.shown == "2")
    opened.choose(1)


def test_the_legend_tells_distances_of_the_result_or_the_tolerance(opened: Page) -> None:
    opened.choose(2)
    legend = opened.one("#scale")
    assert "model units" in legend.text
    ticks = [float(text) for text in legend.find_element("class name", "ticks").text.split()]
    assert ticks == [0, 0.125, 0.25, 0.375, 0.5]
    opened.one("#top option[value='tolerance']").click()
    assert "≥ 0.0113" in legend.text
    opened.choose(1)
    assert "≥ 0.0113" in legend.text, "the scale stays as it was chosen"


@pytest.mark.parametrize("width", [560, 1000, 1800])
def test_it_fits_windows_of_any_width(opened: Page, width: int) -> None:
    opened.browser.set_window_size(width, 800)
    try:
        for picture in opened.pictures():
            assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 100
        assert opened.browser.execute_script("return document.documentElement.scrollWidth <= window.innerWidth")
        left, right = (opened.one(f"#{side}").rect for side in ("left", "right"))
        assert (right["y"] > left["y"]) == (width < 640)
    finally:
        opened.browser.set_window_size(1000, 800)


def test_colours_are_those_of_the_distances_at_their_place(browser: Any, tmp_path: Path, monkeypatch: Any) -> None:
    """A slope above a level square, on a lattice of few points: the colour runs evenly from nothing to most."""
    monkeypatch.setattr(page_module, "drawn", lambda surface: drawn(surface, samples=30))
    square = np.array([[0.0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]])
    original = welded(square, np.array([[0, 1, 2], [0, 2, 3]]))
    lifted = welded(square + np.array([[0.0, 0, 0], [0, 0, 1], [0, 0, 1], [0, 0, 0]]), np.array([[0, 1, 2], [0, 2, 3]]))
    rows = [row("original", original), row("improved", lifted, 1.0)]
    path = tmp_path / "slope.html"
    path.write_bytes(write_page([Comparison("slope.obj", original, 32**0.5, {"0.1%": 0.1}, rows)]))
    page = Page(browser, path)
    page.choose(1)
    page.one("#edges").click()
    from selenium.webdriver.common.keys import Keys

    page.one("#right canvas").send_keys(Keys.ARROW_UP * 30)
    picture = page.picture("right")
    inside = np.ptp(picture, axis=2) > 25
    for axis, shift in ((0, -3), (0, 3), (1, -3), (1, 3)):
        inside &= np.roll(inside, shift, axis=axis)
    # Nor the ring that says where the keys go.
    inside[:9] = inside[-9:] = inside[:, :9] = inside[:, -9:] = False
    assert inside.mean() > 0.1
    for axis in (0, 1):
        jumps = np.abs(picture - np.roll(picture, 1, axis=axis)).max(axis=2)[inside]
        assert jumps.max() < 8, "neighbours are coloured alike"
    # Lightness falls along the ramp; every sixth of it has to be there.
    drawn_pixels = picture[inside]
    lightness = drawn_pixels.sum(axis=1)
    counts = np.histogram(lightness, bins=6, range=(lightness.min(), lightness.max()))[0]
    assert np.all(counts > 0.02 * counts.sum())
    assert page.errors() == []


@pytest.mark.slow
def test_a_million_triangles_open_and_stay_responsive(browser: Any, tmp_path: Path) -> None:
    original, result = hill(708), hill(300)
    rows = [row("original", original), row("improved", result, 0.01), row("fast-simplification", hill(50), 0.02)]
    path = tmp_path / "million.html"
    start = time.monotonic()
    path.write_bytes(write_page([Comparison("million.obj", original, 11.3, {"0.1%": 0.01}, rows)]))
    assert time.monotonic() - start < 60
    start = time.monotonic()
    page = Page(browser, path)
    assert time.monotonic() - start < 20
    assert "1,002,528 triangles" in page.caption("left")
    assert "drawn with 200,000 of its 1,002,528 triangles" in page.caption("left")
    assert "drawn with" not in page.caption("right")
    for picture in page.pictures():
        assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 100
    start = time.monotonic()
    page.choose(2)
    assert time.monotonic() - start < 5
    assert page.errors() == []
    assert page.requests() == []


def test_a_page_with_nothing_to_draw_says_so(browser: Any, tmp_path: Path) -> None:
    path = tmp_path / "nothing.html"
    path.write_bytes(write_page([Comparison("a.obj", None, 0.0, {}, [Row("a.obj", "", "original", note="failed: x")])]))
    browser.get(path.as_uri())
    assert "nothing to draw" in browser.find_element("id", "left").text
    assert "failed: x" in browser.find_element("tag name", "table").text
