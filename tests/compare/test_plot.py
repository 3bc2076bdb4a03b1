"""The chart: every method with figures is in it, where and as many as its rows say; the rest is named."""

from __future__ import annotations

import io
import math
import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from html import unescape
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from shapes import fine_box, obj_text, write

from bldsimp.cli import main
from bldsimp.compare import drawing as drawing_module
from bldsimp.compare import plot as plot_module
from bldsimp.compare.drawing import Drawing, Shape, ShapeGroup, Text, build_figure, format_svg
from bldsimp.compare.drawing import Path as Line
from bldsimp.compare.placement import PlacedSurface
from bldsimp.compare.plot import (
    LINES,
    OTHERS,
    PANEL_HEIGHT,
    PANEL_WIDTH,
    Axis,
    check_plot,
    choose_count_axis,
    choose_ticks,
    draw_chart,
    draw_plot,
    list_lines,
    place_tolerances,
    write_remarks,
)
from bldsimp.compare.rows import Comparison, MethodRow
from bldsimp.errors import UsageError

SURFACE = PlacedSurface(np.eye(3), np.array([[0, 1, 2]], np.int32))
TOLERANCES = {"auto": 1e-5, "0.1%": 0.01, "0.02": 0.02}
POINTS: dict[str, tuple[int | None, ...]] = {
    "original": (9000, 9000, 9000),
    "standard": (500, 400, 300),
    "improved": (90, 80, 70),
    "fast-simplification": (700, 600, None),
    "fast-simplification same points": (90, 80, 70),
    "some peer": (95, 85, 75),
    "another peer": (None, None, None),
}


def make_house(file: str = "some folder/house.obj") -> Comparison:
    """A comparison with a diagonal of 10, so that 0.01 is 0.1 percent."""
    rows = [
        MethodRow(file, tolerance, method, points=points[k], note="" if points[k] else "not reached")
        for k, tolerance in enumerate(TOLERANCES)
        for method, points in POINTS.items()
    ]
    return Comparison(file, SURFACE, 10.0, TOLERANCES, rows)


def make_failure() -> Comparison:
    """The comparison of a file that could not be read."""
    return Comparison("bad.obj", None, 0.0, {}, [MethodRow("bad.obj", "", "", note="line 3 is no point")])


def draw(*comparisons: Comparison) -> Drawing:
    """The chart as `draw_plot` writes it."""
    return draw_chart(comparisons, list_lines(comparisons), write_remarks(comparisons))


def list_words(svg: bytes) -> list[str]:
    """Every text of an SVG."""
    return [unescape(text) for text in re.findall(r"<text [^>]*>(.*?)</text>", svg.decode("utf-8"))]


def find_lines(shapes: Sequence[Shape]) -> Iterator[Line]:
    """The curves of a panel: lines that are neither level lines nor axes."""
    colors = {style.color for style in (*LINES.values(), *OTHERS)}
    return (shape for shape in shapes if isinstance(shape, Line) and shape.color in colors)


def find_texts(drawing: Drawing) -> dict[str, Text]:
    """All texts outside of panels, by their words."""
    return {shape.words: shape for shape in drawing.shapes if isinstance(shape, Text)}


class TestContents:
    def test_each_line_passes_through_its_rows(self) -> None:
        house = make_house()
        counts = [row.points for row in house.rows if row.points]
        y = choose_count_axis(counts)
        drawn = {tuple(v for _, v in line.points): line for line in find_lines(draw(house).shapes[0].shapes)}
        expected = {m: tuple(y(c) for c in POINTS[m] if c) for m in POINTS if any(POINTS[m]) and "same" not in m}
        assert set(drawn) == set(expected.values())
        places = {tuple(u for u, _ in line.points) for line in drawn.values() if len(line.points) == 3}
        assert len(places) == 1
        ((auto, tenth, fifth),) = places
        # On a log scale from 1e-4 % over 0.1 % to 0.2 %.
        assert (fifth - tenth) / (tenth - auto) == pytest.approx(math.log10(2) / 3, abs=0.001)
        partial = drawn[expected["fast-simplification"]]
        assert [u for u, _ in partial.points] == [auto, tenth]

    def test_more_points_are_higher_and_larger_tolerances_farther_right(self) -> None:
        house = make_house()
        (improved,) = [
            each for each in find_lines(draw(house).shapes[0].shapes) if each.color == LINES["improved"].color
        ]
        spots = np.array(improved.points)
        assert np.all(np.diff(spots[:, 0]) > 0)
        assert np.all(np.diff(spots[:, 1]) > 0), "downwards in a drawing"

    def test_marks_are_tied_to_rows(self) -> None:
        house = make_house()
        svg = format_svg(draw_chart([house], list_lines([house]), numbers=[{0: 7, 2: 8}]), "house")
        assert svg.count("data-row") == 2
        assert 'data-row="8"' in svg
        marks = ElementTree.fromstring(svg).iter("{http://www.w3.org/2000/svg}g")
        titles = {
            mark.get("data-row"): mark[0 if mark.get("data-row") is None else 2].text
            for mark in marks
            if mark.get("class")
        }
        assert titles == {"7": "original at auto: 9,000 points", "8": "improved at auto: 90 points"}
        assert "data-row" not in format_svg(draw(house), "house")

    def test_axes_have_units_and_places_their_names(self) -> None:
        text = list_words(draw_plot([make_house()], ".svg"))
        assert "points" in text
        assert "tolerance, log scale; diagonal 10 model units" in text
        assert {"auto = 0.0001%", "0.1%", "0.02 = 0.2%"} <= set(text)
        assert {"90", "80", "70"} <= set(text)
        assert {"standard", "improved", "some peer"} <= set(text)

    def test_what_is_not_drawn_is_named_with_its_reason(self) -> None:
        text = list_words(draw_plot([make_house(), make_house("b.obj")], ".svg"))
        assert "another peer" not in text
        reason = "not drawn: another peer; house.obj at auto, 0.1%, 0.02; b.obj at auto, 0.1%, 0.02: not reached"
        assert reason in text
        assert "not drawn: fast-simplification; house.obj at 0.02; b.obj at 0.02: not reached" in text
        assert "not drawn: fast-simplification same points (as many points as improved, by its definition)" in text

    def test_a_note_that_all_points_of_a_method_share_is_written_once(self) -> None:
        comparison = make_house()
        for k, row in enumerate(comparison.rows):
            if "peer" in row.method:
                row.note = f"same deviation as improved ({k / 7:.3g})"
        comparison.rows[1].note = "stopped (3 facets)"
        text = list_words(draw_plot([comparison], ".svg"))
        assert "same deviation as improved: some peer" in text
        reason = "not drawn: another peer; house.obj at auto, 0.1%, 0.02: same deviation as improved"
        assert reason in " ".join(text)
        assert not any("stopped" in each for each in text)

    def test_zero_has_a_place_and_a_remark(self) -> None:
        comparison = make_house()
        comparison.tolerances = {"auto": 1e-5, "0.1%": 0.01, "0": 0.0}
        comparison.rows = [
            replace(row, tolerance={"0.02": "0"}.get(row.tolerance, row.tolerance)) for row in comparison.rows
        ]
        assert place_tolerances(comparison) == pytest.approx({"auto": 1e-4, "0.1%": 0.1, "0": 1e-5}, rel=1e-12)
        text = list_words(draw_plot([comparison], ".svg"))
        assert "0" in text
        assert any("0 has no place on a log scale" in each for each in text)

    def test_a_file_that_failed_shows_why_and_the_others_are_drawn(self) -> None:
        text = list_words(draw_plot([make_house(), make_failure()], ".svg"))
        assert {"house.obj", "bad.obj", "line 3 is no point", "improved"} <= set(text)
        assert "line 3 is no point" in list_words(draw_plot([make_failure()], ".svg"))

    @pytest.mark.parametrize(
        "name", ["$x_y$.obj", "$a.obj", "$\\frac{$.obj", "<b>&.obj", "a\tb\x1b.obj", "漢字.obj", "caf\udce9.obj"]
    )
    def test_names_are_shown_as_they_are(self, name: str) -> None:
        failed = Comparison(name, None, 0.0, {}, [MethodRow(name, "", "", note=f"{name}: no faces")])
        svg = draw_plot([make_house(name), failed], ".svg")
        ElementTree.fromstring(svg)
        plain = name.replace("\t", " ").replace("\x1b", " ").replace("\udce9", "?")
        assert {plain, f"{plain}: no faces"} <= set(list_words(svg))

    @pytest.mark.filterwarnings("error")
    def test_the_smallest_model_has_its_places(self) -> None:
        least = Comparison("a.obj", SURFACE, 3e-310, {"auto": 6e-323, "1%": 3e-312}, [])
        assert place_tolerances(least) == pytest.approx({"auto": 2e-11, "1%": 1.0}, rel=0.1)


class TestStyle:
    def test_little_differences_are_drawn_from_zero(self) -> None:
        assert choose_count_axis([75, 90]).low == 0.0
        assert not choose_count_axis([75, 90]).log
        assert choose_count_axis([75, 9000]).log

    def test_lines_differ_in_color_mark_and_dashes(self) -> None:
        styles = [*LINES.values(), *OTHERS]
        assert len({style.mark for style in styles}) == len(styles)
        assert len({style.dashes for style in styles}) == len(styles)
        assert len({style.color for style in LINES.values()}) == len(LINES)

    def test_at_a_single_tolerance_the_original_is_seen(self) -> None:
        whole = make_house()
        single = [row for row in whole.rows if row.tolerance == "0.1%"]
        panel = draw(Comparison("a.obj", SURFACE, 10.0, {"0.1%": 0.01}, single)).shapes[0].shapes
        (line,) = find_lines(panel)
        assert np.ptp([u for u, _ in line.points]) == 16.0
        marks = [shape for shape in panel if isinstance(shape, ShapeGroup) and shape.shapes]
        assert len(marks) == 4

    @pytest.mark.parametrize("log", [True, False])
    @pytest.mark.parametrize("most", [3, 12, 99, 976, 25_184, 1_000_000])
    def test_ticks_are_few_and_within(self, most: float, log: bool) -> None:
        axis = Axis(most / 8 if log else 0.0, most * 1.1, 300, 10, log)
        values = choose_ticks(axis)
        assert 2 <= len(values) <= 7
        assert all(axis.low <= value <= axis.high * (1 + 1e-9) for value in values)
        assert math.isclose(axis(axis.low), 300)
        assert math.isclose(axis(axis.high), 10)

    def test_files_of_one_name_and_long_names_are_told_apart(self) -> None:
        long = "a_very_long_name_of_a_building_from_some_city_model_lod3_final.obj"
        files = ["a/house.obj", "b/house.obj", long, f"some folder/{long[1:]}"]
        houses = [make_house(file) for file in files]
        titles = [panel.shapes[0].words for panel in draw(*houses).shapes[:4]]
        assert titles[:2] == files[:2]
        assert len(set(titles)) == 4
        assert max(map(len, titles)) < 45
        assert "a/house.obj at 0.02; b/house.obj at 0.02" in " ".join(write_remarks(houses))


@pytest.mark.parametrize("count", [1, 2, 3, 4, 7])
def test_a_panel_per_building_and_no_words_hide_others(count: int) -> None:
    """Measured in matplotlib's own font, which is a wide one."""
    pytest.importorskip("matplotlib", reason="the extra 'plots' is not installed")
    drawing = draw(*(make_house(f"{k} {'long ' * 12}.obj") for k in range(count)))
    corners = {(panel.x, panel.y) for panel in drawing.shapes[:count]}
    assert corners == {(PANEL_WIDTH * (k % 3), PANEL_HEIGHT * (k // 3)) for k in range(count)}
    figure = build_figure(drawing)
    figure.draw_without_rendering()
    boxes = [text.get_window_extent().get_points() for text in figure.texts]
    for i, (low, high) in enumerate(boxes):
        assert (low >= figure.bbox.min - 1).all(), figure.texts[i].get_text()
        assert (high <= figure.bbox.max + 1).all(), figure.texts[i].get_text()
        for j, (other_low, other_high) in enumerate(boxes[:i]):
            apart = (low >= other_high - 1).any() or (other_low >= high - 1).any()
            assert apart, (figure.texts[i].get_text(), figure.texts[j].get_text())


class TestFiles:
    def test_the_same_rows_give_the_same_bytes(self) -> None:
        assert draw_plot([make_house()], ".svg") == draw_plot([make_house()], ".svg")

    def test_png_does_not_depend_on_settings_and_pyplot_stays_out(self) -> None:
        matplotlib = pytest.importorskip("matplotlib", reason="the extra 'plots' is not installed")
        from PIL import Image

        first = draw_plot([make_house()], ".PNG")
        image = Image.open(io.BytesIO(first))
        assert image.format == "PNG"
        assert image.width > 600
        with matplotlib.rc_context({"font.size": 30.0, "lines.linewidth": 9.0, "text.color": "red"}):
            assert draw_plot([make_house()], ".png") == first
            assert matplotlib.rcParams["font.size"] == 30.0
        assert matplotlib.__version__.encode() not in first
        assert "matplotlib.pyplot" not in sys.modules

    @pytest.mark.filterwarnings("error")
    def test_png_shows_any_name(self) -> None:
        pytest.importorskip("matplotlib", reason="the extra 'plots' is not installed")
        assert draw_plot([make_house(name) for name in ("$\\frac{$.obj", "漢字.obj", "caf\udce9.obj")], ".png")

    def test_png_shows_every_shape(self) -> None:
        """All that SVG has is in the figure, at its place."""
        pytest.importorskip("matplotlib", reason="the extra 'plots' is not installed")
        drawing = draw(make_house(), make_failure())
        figure, svg = build_figure(drawing), format_svg(drawing, "both")
        assert [text.get_text() for text in figure.texts] == list_words(svg.encode())
        assert len(figure.artists) == svg.count("<path ")
        low, high = figure.artists[-1].get_window_extent().get_points() / (figure.dpi / drawing_module.PIXELS_PER_INCH)
        assert 0 < low[0] < high[0] < drawing.width
        assert 0 < low[1] < high[1] < drawing.height - 2 * PANEL_HEIGHT / 3

    def test_svg_needs_no_matplotlib_and_png_says_how_to_get_it(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(plot_module, "find_spec", lambda name: None)
        monkeypatch.setitem(sys.modules, "matplotlib", None)
        assert draw_plot([make_house()], ".svg").startswith(b"<svg ")
        with pytest.raises(UsageError, match="pip install matplotlib"):
            draw_plot([make_house()], ".png")

    def test_other_suffixes_are_wrong_usage(self) -> None:
        with pytest.raises(UsageError, match=r"'\.jpg'.*\.svg or \.png"):
            check_plot(".jpg")

    def test_the_command_draws_what_it_compared(self, tmp_path: Path) -> None:
        model = write(tmp_path / "house.obj", obj_text(*fine_box()))
        chart_file = tmp_path / "points.svg"
        command = ["compare", str(model), "--tolerances", "auto,1%", "--plot", str(chart_file), "-q"]
        assert main(command) == 0
        text = list_words(chart_file.read_bytes())
        assert {"house.obj", "improved", "8"} <= set(text)
        assert any(each.startswith("auto = ") for each in text)
        assert main(command) == 2
        assert main([*command, "--overwrite"]) == 0

    def test_the_command_refuses_other_files_before_it_reads(
        self, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert main(["compare", str(tmp_path / "not there.obj"), "--plot", str(tmp_path / "a.pdf")]) == 2
        assert "a chart cannot be written as '.pdf'" in capsys.readouterr().err
        assert list(tmp_path.iterdir()) == []
