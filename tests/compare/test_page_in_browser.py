"""The page in a real browser: it draws, it follows clicks and keys, and it fetches nothing."""

from __future__ import annotations

import io
import json
import os
import shutil
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pages import EVIL, make_comparison, make_hill, make_row

from bldsimp.compare import page as page_module
from bldsimp.compare.display_mesh import choose_display
from bldsimp.compare.page import build_page
from bldsimp.compare.placement import weld_surface
from bldsimp.compare.rows import Comparison, MethodRow

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


def skip_unless_needed(reason: str) -> None:
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
        skip_unless_needed("no Chromium with its chromedriver (Debian: chromium, chromium-driver)")
    try:
        from selenium import webdriver
    except ImportError:
        skip_unless_needed("no selenium: sh setup.sh test")
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


def compare_pixels(a: np.ndarray, b: np.ndarray) -> float:
    """Share of the pixels that differ visibly."""
    height, width = min(a.shape[0], b.shape[0]), min(a.shape[1], b.shape[1])
    return float((np.abs(a[:height, :width] - b[:height, :width]).max(axis=2) > 12).mean())


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A page with two files."""
    path = tmp_path_factory.mktemp("page") / "Häuser & more.html"
    path.write_bytes(build_page([make_comparison(), make_comparison(EVIL, 12)]))
    return path


@pytest.fixture
def opened(browser: Any, written: Path) -> Iterator[Page]:
    """That page, opened afresh; whatever is done to it, nothing fails and nothing is fetched."""
    page = Page(browser, written)
    yield page
    assert page.errors() == []
    assert page.requests() == []


@pytest.mark.slow
def test_the_table_fits_a_usual_window_and_its_head_stays(browser: Any, tmp_path: Path) -> None:
    each = make_comparison("a_name_without_any_space" * 6 + ".obj")
    names = ("original", "improved", "fast-simplification lossless", "fast-simplification same points")
    for one, name in zip(each.rows, names, strict=True):
        one.method, one.points, one.triangles, one.deviation, one.bound = name, 1234567, 2345678, 1.23e-06, 1.23e-06
        one.seconds, one.note = 123.45, "same deviation as improved (1.04e-06 and 9.5e-07 that single precision blurs)"
    each.tolerances = {f"{k}%": k / 1000 for k in range(1, 9)}
    each.rows = [replace(one, tolerance=written) for written in each.tolerances for one in each.rows]
    path = tmp_path / "wide.html"
    path.write_bytes(build_page([each]))
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


@pytest.mark.slow
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
    assert compare_pixels(before[1], opened.picture("right")) > 0.05
    assert opened.one("tr[data-row='2']").get_attribute("aria-current") == "true"
    assert opened.one("tr[data-row='2'] input").is_selected()


@pytest.mark.slow
def test_the_chart_chooses_too_and_follows(opened: Page) -> None:
    opened.choose(2)
    opened.browser.execute_script(
        "document.querySelector('.chart .mark[data-row=\"1\"]').dispatchEvent(new MouseEvent('click', {bubbles: true}))"
    )
    opened.until(lambda: opened.shown == "1")
    assert opened.one(".chart .mark[data-row='1']").get_attribute("aria-current") == "true"
    assert [chart.is_displayed() for chart in opened.browser.find_elements("css selector", ".chart")] == [True, False]


@pytest.mark.slow
def test_another_file_is_shown_on_both_sides(opened: Page) -> None:
    opened.choose(4)
    assert EVIL.rsplit("/", 1)[-1] in opened.caption("left")
    assert [chart.is_displayed() for chart in opened.browser.find_elements("css selector", ".chart")] == [False, True]
    opened.choose(1)
    assert "hill.obj" in opened.caption("left")


@pytest.mark.slow
@pytest.mark.parametrize(("box", "least"), [("edges", 0.02), ("colors", 0.1)])
def test_a_box_switches_what_is_drawn_in_both_views_and_back(opened: Page, box: str, least: float) -> None:
    opened.choose(1)
    before = opened.pictures()
    opened.one(f"#{box}").click()
    for side, picture in zip(("left", "right"), before, strict=True):
        assert compare_pixels(picture, opened.picture(side)) > least
    opened.one(f"#{box}").click()
    for side, picture in zip(("left", "right"), before, strict=True):
        np.testing.assert_array_equal(picture, opened.picture(side))


@pytest.mark.slow
def test_without_edges_the_dark_lines_are_gone(opened: Page) -> None:
    opened.choose(1)
    opened.one("#colors").click()
    dark = []
    for _ in range(2):
        dark.append((opened.picture("right").max(axis=2) < 130).mean())
        opened.one("#edges").click()
    assert dark[0] > 10 * dark[1]


@pytest.mark.slow
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
            assert compare_pixels(*before) < 0.02, "the same surface looks the same in both"
            act.perform()
            after = opened.pictures()
            assert compare_pixels(*after) < 0.02
            assert compare_pixels(before[0], after[0]) > 0.05
    start = opened.picture("left")
    opened.one("#reset").click()
    assert compare_pixels(start, opened.picture("left")) > 0.05


@pytest.mark.slow
def test_the_keyboard_is_enough(opened: Page) -> None:
    from selenium.webdriver.common.keys import Keys

    opened.choose(1)
    opened.one("#reset").click()
    rest = opened.pictures()
    canvas = opened.one("#right canvas")
    canvas.send_keys(Keys.ARROW_LEFT * 4 + "+")
    assert all(compare_pixels(a, b) > 0.05 for a, b in zip(rest, opened.pictures(), strict=True))
    canvas.send_keys("0")
    opened.one("tr[data-row='1'] input").send_keys(Keys.ARROW_DOWN)
    opened.until(lambda: opened.shown == "2")
    opened.choose(1)


@pytest.mark.slow
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


@pytest.mark.slow
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


@pytest.mark.slow
def test_colors_are_those_of_the_distances_at_their_place(browser: Any, tmp_path: Path, monkeypatch: Any) -> None:
    """A slope above a level square, on a lattice of few points: the color runs evenly from nothing to most."""
    monkeypatch.setattr(page_module, "choose_display", lambda surface: choose_display(surface, samples=30))
    square = np.array([[0.0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]])
    original = weld_surface(square, np.array([[0, 1, 2], [0, 2, 3]]))
    lifted = weld_surface(
        square + np.array([[0.0, 0, 0], [0, 0, 1], [0, 0, 1], [0, 0, 0]]), np.array([[0, 1, 2], [0, 2, 3]])
    )
    rows = [make_row("original", original), make_row("improved", lifted, 1.0)]
    path = tmp_path / "slope.html"
    path.write_bytes(build_page([Comparison("slope.obj", original, 32**0.5, {"0.1%": 0.1}, rows)]))
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
        assert jumps.max() < 8, "neighbors have similar colors"
    # Lightness falls along the ramp; every sixth of it has to be there.
    drawn_pixels = picture[inside]
    lightness = drawn_pixels.sum(axis=1)
    counts = np.histogram(lightness, bins=6, range=(lightness.min(), lightness.max()))[0]
    assert np.all(counts > 0.02 * counts.sum())
    assert page.errors() == []


@pytest.mark.slow
def test_a_million_triangles_open_and_stay_responsive(browser: Any, tmp_path: Path) -> None:
    original, result = make_hill(708), make_hill(300)
    rows = [
        make_row("original", original),
        make_row("improved", result, 0.01),
        make_row("fast-simplification", make_hill(50), 0.02),
    ]
    path = tmp_path / "million.html"
    start = time.monotonic()
    path.write_bytes(build_page([Comparison("million.obj", original, 11.3, {"0.1%": 0.01}, rows)]))
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


@pytest.mark.slow
def test_a_page_with_nothing_to_draw_says_so(browser: Any, tmp_path: Path) -> None:
    path = tmp_path / "nothing.html"
    path.write_bytes(
        build_page([Comparison("a.obj", None, 0.0, {}, [MethodRow("a.obj", "", "original", note="failed: x")])])
    )
    browser.get(path.as_uri())
    assert "nothing to draw" in browser.find_element("id", "left").text
    assert "failed: x" in browser.find_element("tag name", "table").text
