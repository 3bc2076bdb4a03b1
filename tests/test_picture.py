"""The renderer: what is in front is drawn, edges are drawn, and what cannot be drawn is said."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT

pytest.importorskip("PIL")
sys.path.insert(0, str(ROOT / "examples"))

from picture import Style, View, crop, draw_picture, find_creases, find_nearest_faces
from PIL import Image

from bldsimp.errors import BldsimpError

SMALL = Style(width=120, height=100, samples=2)


def square(height: float, size: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Two triangles in a horizontal plane about the z axis."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * size
    return np.column_stack([corners, np.full(4, height)]), np.array([[0, 1, 2], [0, 2, 3]])


def tetrahedron() -> View:
    """A closed solid with six sharp edges."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    return View(points, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]), "one\ntwo")


def test_the_nearest_face_wins() -> None:
    corners = np.array(
        [
            [[0.0, 0, 1], [10, 0, 1], [0, 10, 1]],
            [[0, 0, 2], [4, 0, 2], [0, 4, 2]],
            [[0, 0, 0], [10, 0, 0], [0, 10, 0]],
        ]
    )
    owner = find_nearest_faces(corners, 10, 10).reshape(10, 10)
    assert owner[0, 0] == 1
    assert owner[5, 2] == 0
    assert owner[9, 9] == -1
    assert not np.any(owner == 2)
    for order in ([1, 2, 0], [2, 0, 1]):
        again = find_nearest_faces(corners[order], 10, 10).reshape(10, 10)
        np.testing.assert_array_equal(np.append(order, -1)[again], owner)


def test_two_triangles_cover_their_square_once_and_without_a_gap() -> None:
    points, faces = square(0.0)
    corners = np.column_stack([points[:, :2] * 8 + 10, np.ones(4)])[faces]
    owner = find_nearest_faces(corners, 20, 20).reshape(20, 20)
    assert np.all(owner[2:18, 2:18] >= 0)
    assert np.count_nonzero(owner >= 0) == 16 * 16


def test_creases_are_the_edges_where_the_surface_bends_or_ends() -> None:
    assert find_creases(tetrahedron()).all()
    points, faces = square(0.0)
    np.testing.assert_array_equal(find_creases(View(points, faces, "")), [[True, True, False], [False, True, True]])


def test_picture_shows_each_view_in_its_own_half() -> None:
    image = np.asarray(draw_picture([tetrahedron(), tetrahedron()], SMALL))
    assert image.shape[1] == 2 * SMALL.width
    left, right = image[:, : SMALL.width], image[:, SMALL.width :]
    drawn = (left != 255).any(axis=2)
    assert 0.1 < drawn.mean() < 0.9
    np.testing.assert_array_equal(left, right)


def test_picture_is_the_same_for_faces_in_another_order() -> None:
    view = tetrahedron()
    turned = View(view.points, view.faces[::-1], view.caption)
    first, second = (np.asarray(draw_picture([each], SMALL)) for each in (view, turned))
    assert (np.abs(first.astype(int) - second) > 8).mean() < 0.02


def test_rows_of_views_are_filled_one_after_the_other() -> None:
    flat = View(*square(0.0), "")
    row = np.asarray(draw_picture([tetrahedron(), flat, tetrahedron()], SMALL))
    sheet = np.asarray(draw_picture([tetrahedron(), flat, tetrahedron()], SMALL, columns=2))
    assert sheet.shape[:2] == (2 * row.shape[0], 2 * SMALL.width)
    upper, lower = sheet[: row.shape[0]], sheet[row.shape[0] :]
    np.testing.assert_array_equal(upper, row[:, : 2 * SMALL.width])
    np.testing.assert_array_equal(lower[:, : SMALL.width], row[:, 2 * SMALL.width :])
    assert (lower[:, SMALL.width :] == 255).all()


def test_no_edge_is_drawn_with_lines_of_no_width() -> None:
    view = View(*square(0.0), "")
    shades = {
        line: np.unique(np.asarray(draw_picture([view], replace(SMALL, line=line, crease=line))).reshape(-1, 3), axis=0)
        for line in (0.0, 1.0)
    }
    # Of one flat square only its own shade is left, and what blends it with the paper at its rim.
    assert len(shades[0.0]) <= SMALL.samples**2 + 1 < len(shades[1.0])


def test_a_zoom_shows_a_part_of_the_model_and_more_of_it() -> None:
    view = View(*square(0.0), "")
    above = replace(SMALL, elevation=90.0, azimuth=-90.0)
    covered = {}
    for zoom, aim in ((1.0, (0.5, 0.5)), (2.0, (0.5, 0.5)), (2.0, (0.0, 0.5))):
        image = np.asarray(draw_picture([view], replace(above, zoom=zoom, aim=aim)))
        drawn = (image[:-90] != 255).any(axis=2)
        covered[zoom, aim[0]] = drawn[:, : SMALL.width // 2].mean(), drawn[:, SMALL.width // 2 :].mean()
    assert max(covered[1.0, 0.5]) < 0.9
    assert min(covered[2.0, 0.5]) == 1.0
    # Its left border stands in the middle.
    assert covered[2.0, 0.0][0] < 0.05
    assert covered[2.0, 0.0][1] == 1.0


def test_a_gap_stays_blank() -> None:
    view = View(*square(0.0), "")
    image = np.asarray(draw_picture([view, view], replace(SMALL, elevation=90.0, zoom=3.0, gap=5)))[:-90]
    blank = (image == 255).all(axis=(0, 2))
    expected = np.zeros(SMALL.width, bool)
    expected[:5] = expected[-5:] = True
    np.testing.assert_array_equal(blank, np.tile(expected, 2))


def test_crop_keeps_the_rows_that_any_panel_uses() -> None:
    blank = np.full((50, 4, 3), 255, dtype=np.uint8)
    one, two = blank.copy(), blank.copy()
    one[20], two[30] = 0, 0
    assert [panel.shape[0] for panel in crop([one, two], margin=2)] == [15, 15]


def test_nothing_to_draw_is_an_error() -> None:
    with pytest.raises(BldsimpError, match="nothing to draw"):
        draw_picture([View(np.zeros((3, 3)), np.zeros((0, 3), dtype=int), "")], SMALL)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("script", "source", "shown"),
    [
        ("render.py", "building_a.glb", "building_a.png"),
        ("render_textured.py", "house_textured.glb", "textured_house.png"),
    ],
)
def test_pictures_of_the_docs_are_what_is_drawn_today(
    script: str, source: str, shown: str, data: Path, tmp_path: Path
) -> None:
    light, drawn = tmp_path / "light.glb", tmp_path / "drawn.png"
    house = data / source
    subprocess.run([Path(sys.executable).parent / "bldsimp", "simplify", "-q", house, light], check=True)
    subprocess.run([sys.executable, ROOT / "examples" / script, house, light, drawn], check=True)
    before, today = (np.asarray(Image.open(path).convert("RGB"), np.int16) for path in (ROOT / "docs" / shown, drawn))
    assert before.shape == today.shape
    # Palettes may differ a little between versions of Pillow; one diagonal more or less is some 0.02 %.
    assert (np.abs(before - today).max(axis=2) > 48).mean() < 1e-4
