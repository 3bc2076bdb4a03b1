"""The chart: every method with figures is in it, where and as many as its rows say; the rest is named."""

from __future__ import annotations

import io
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from quick import defer

pytest.importorskip("matplotlib", reason="the extra 'plots' is not installed")

import matplotlib
from PIL import Image
from shapes import fine_box, obj_text, write

from bldsimp.cli import main
from bldsimp.compare.plot import LINES, OTHERS, chart, check_plot, positions, remarks, write_plot
from bldsimp.compare.row import Comparison, Row
from bldsimp.compare.surface import Surface
from bldsimp.errors import UsageError

SURFACE = Surface(np.eye(3), np.array([[0, 1, 2]], np.int32))
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


def house(file: str = "some folder/house.obj") -> Comparison:
    """A comparison with a diagonal of 10, so that 0.01 is 0.1 percent."""
    rows = [
        Row(file, tolerance, method, points=points[k], note="" if points[k] else "not reached")
        for k, tolerance in enumerate(TOLERANCES)
        for method, points in POINTS.items()
    ]
    return Comparison(file, SURFACE, 10.0, TOLERANCES, rows)


def unreadable() -> Comparison:
    """What a file that could not be read leaves."""
    return Comparison("bad.obj", None, 0.0, {}, [Row("bad.obj", "", "", note="line 3 is no point")])


def words(svg: bytes) -> list[str]:
    """Every text of an SVG, which matplotlib repeats as a comment beside its outlines."""
    return re.findall(r"<!-- (.*?) -->", svg.decode("utf-8"), re.DOTALL)


def test_each_line_passes_through_its_rows() -> None:
    (axes,) = chart([house()]).axes
    drawn = {tuple(line.get_ydata()): list(line.get_xdata()) for line in axes.lines if len(line.get_xdata()) > 2}
    expected = {POINTS[m] for m in ("original", "standard", "improved", "some peer")}
    assert set(drawn) == expected
    for places in drawn.values():
        np.testing.assert_allclose(places, [1e-4, 0.1, 0.2], rtol=1e-12)
    partial = next(line for line in axes.lines if list(line.get_ydata()) == [700, 600])
    np.testing.assert_allclose(partial.get_xdata(), [1e-4, 0.1])


def test_axes_have_units_and_places_their_names() -> None:
    text = words(write_plot([house()], ".svg"))
    assert "points" in text
    assert "tolerance, % of the diagonal (10 model units)" in text
    assert {"auto", "0.02"} <= set(text)
    assert "0.1%" not in text
    assert {"90", "80", "70"} <= set(text)
    assert {"standard", "improved", "some peer"} <= set(text)


def test_what_is_not_drawn_is_named_with_its_reason() -> None:
    text = words(write_plot([house(), house("b.obj")], ".svg"))
    assert "another peer" not in text
    told = "not drawn: another peer; house.obj at auto, 0.1%, 0.02; b.obj at auto, 0.1%, 0.02: not reached"
    assert told in text
    assert "not drawn: fast-simplification; house.obj at 0.02; b.obj at 0.02: not reached" in text
    assert "not drawn: fast-simplification same points (as many points as improved, by its definition)" in text


def test_what_the_points_of_a_method_share_is_told_once() -> None:
    comparison = house()
    for k, row in enumerate(comparison.rows):
        if "peer" in row.method:
            row.note = f"same deviation as improved ({k / 7:.3g})"
    comparison.rows[1].note = "stopped (3 facets)"
    text = words(write_plot([comparison], ".svg"))
    assert "same deviation as improved: some peer" in text
    told = "not drawn: another peer; house.obj at auto, 0.1%, 0.02: same deviation as improved"
    assert told in " ".join(text)
    assert not any("stopped" in each for each in text)


def test_zero_has_a_place_and_a_remark() -> None:
    comparison = house()
    comparison.tolerances = {"auto": 1e-5, "0.1%": 0.01, "0": 0.0}
    comparison.rows = [
        replace(row, tolerance={"0.02": "0"}.get(row.tolerance, row.tolerance)) for row in comparison.rows
    ]
    figure = chart([comparison])
    line = next(each for each in figure.axes[0].lines if list(each.get_ydata()) == [70, 90, 80])
    np.testing.assert_allclose(line.get_xdata(), [1e-5, 1e-4, 0.1])
    assert any("0 has no place on a log scale" in text for text in words(write_plot([comparison], ".svg")))


def test_a_file_that_failed_shows_why_and_the_others_are_drawn() -> None:
    text = words(write_plot([house(), unreadable()], ".svg"))
    assert {"house.obj", "bad.obj", "line 3 is no point", "improved"} <= set(text)
    assert "line 3 is no point" in words(write_plot([unreadable()], ".svg"))


@pytest.mark.parametrize("count", defer([1, 2, 3, 4, 7], [2, 4, 7]))
def test_a_panel_per_building_and_none_hides_another(count: int) -> None:
    figure = chart([house(f"{k}.obj") for k in range(count)])
    figure.draw_without_rendering()
    boxes = [axes.get_tightbbox().get_points() for axes in figure.axes]
    assert len(boxes) == count
    for i, (low, high) in enumerate(boxes):
        for other_low, other_high in boxes[:i]:
            assert (low >= other_high).any() or (other_low >= high).any()
    (legend,) = figure.legends
    room = legend.get_window_extent().get_points()
    assert all(room[1, 1] <= low[1] for low, _ in boxes)
    for remark in figure.texts:
        assert remark.get_window_extent().get_points()[1, 1] <= room[0, 1] + 1.0
        assert remark.get_window_extent().get_points()[1, 0] <= figure.bbox.x1


def test_little_differences_are_drawn_from_zero() -> None:
    comparison = house()
    comparison.rows = [row for row in comparison.rows if row.method in ("improved", "some peer")]
    (axes,) = chart([comparison]).axes
    assert axes.get_yscale() == "linear"
    assert axes.get_ylim()[0] == 0.0
    assert chart([house()]).axes[0].get_yscale() == "log"


def test_lines_differ_in_colour_marker_and_dashes() -> None:
    styles = [*LINES.values(), *OTHERS]
    assert len({style.marker for style in styles}) == len(styles)
    assert len({str(style.dashes) for style in styles}) == len(styles)
    assert len({style.colour for style in LINES.values()}) == len(LINES)


def test_the_same_rows_give_the_same_bytes_whatever_the_settings() -> None:
    first = write_plot([house()], ".svg")
    with matplotlib.rc_context({"font.size": 30.0, "axes.grid": True, "lines.linewidth": 9.0}):
        assert write_plot([house()], ".svg") == first
        assert matplotlib.rcParams["font.size"] == 30.0
    assert b"<dc:date>" not in first
    assert matplotlib.__version__.encode() not in first


def test_png_is_a_picture_and_pyplot_stays_out() -> None:
    image = Image.open(io.BytesIO(write_plot([house()], ".PNG")))
    assert image.format == "PNG"
    assert image.width > 600
    draw = "import sys, bldsimp.compare.plot as plot; plot.write_plot([], '.svg')"
    code = f"{draw}; assert 'matplotlib.pyplot' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_other_suffixes_are_wrong_usage() -> None:
    with pytest.raises(UsageError, match=r"'\.jpg'.*\.svg or \.png"):
        check_plot(".jpg")


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", ["$x_y$.obj", "$a.obj", "$\\frac{$.obj", "a\tb\x1b.obj", "漢字.obj", "caf\udce9.obj"])
def test_names_are_shown_as_they_are(name: str) -> None:
    failed = Comparison(name, None, 0.0, {}, [Row(name, "", "", note=f"{name}: no faces")])
    shown = words(write_plot([house(name), failed], ".svg"))
    plain = name.replace("\t", " ").replace("\x1b", " ").replace("\udce9", "?")
    assert {plain, f"{plain}: no faces"} <= set(shown)


def test_files_of_one_name_and_long_names_are_told_apart() -> None:
    long = "a_very_long_name_of_a_building_from_some_city_model_lod3_final.obj"
    files = ["a/house.obj", "b/house.obj", long, f"some folder/{long[1:]}"]
    drawn = chart([house(file) for file in files])
    titles = [axes.get_title(loc="left") for axes in drawn.axes]
    assert titles[:2] == files[:2]
    assert len(set(titles)) == 4
    drawn.draw_without_rendering()
    boxes = [axes._left_title.get_window_extent() for axes in drawn.axes]
    assert boxes[0].x1 < boxes[1].x0
    assert boxes[1].x1 < boxes[2].x0
    assert boxes[2].x1 < drawn.bbox.x1
    assert "a/house.obj at 0.02; b/house.obj at 0.02" in " ".join(remarks([house(file) for file in files]))


def test_at_a_single_tolerance_the_original_is_seen() -> None:
    whole = house()
    single = [row for row in whole.rows if row.tolerance == "0.1%"]
    (axes,) = chart([Comparison("a.obj", SURFACE, 10.0, {"0.1%": 0.01}, single)]).axes
    drawn = {tuple(line.get_ydata()): line.get_marker() for line in axes.lines if len(line.get_xdata()) == 1}
    assert len(drawn) >= 3
    assert all(marker not in ("", "None") for marker in drawn.values())


@pytest.mark.filterwarnings("error")
def test_the_smallest_model_has_its_places() -> None:
    least = Comparison("a.obj", SURFACE, 3e-310, {"auto": 6e-323, "1%": 3e-312}, [])
    assert positions(least) == pytest.approx({"auto": 2e-11, "1%": 1.0}, rel=0.1)


def test_without_matplotlib_one_line_tells_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(UsageError, match="pip install matplotlib"):
        write_plot([house()], ".svg")


def test_the_command_draws_what_it_compared(tmp_path: Path) -> None:
    model = write(tmp_path / "house.obj", obj_text(*fine_box()))
    chart_file = tmp_path / "points.svg"
    command = ["compare", str(model), "--tolerances", "auto,1%", "--plot", str(chart_file), "-q"]
    assert main(command) == 0
    text = words(chart_file.read_bytes())
    assert {"house.obj", "auto", "improved", "8"} <= set(text)
    assert main(command) == 2
    assert main([*command, "--overwrite"]) == 0


def test_the_command_refuses_other_files_before_it_reads(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compare", str(tmp_path / "not there.obj"), "--plot", str(tmp_path / "a.pdf")]) == 2
    assert "a chart cannot be written as '.pdf'" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
