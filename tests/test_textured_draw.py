"""Textured models are drawn as they are, and the judge of two pictures sees what is wrong with the second.

A picture that shows nothing cannot change: so the renderer is tested, and each way to spoil a texture must be seen.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT
from shapes import Gltf

pytest.importorskip("PIL", reason="the extra 'pictures' is not installed")
sys.path.insert(0, str(ROOT / "examples"))

from textured.difference import LOCAL, Views, compare_views
from textured.draw import draw, place_cameras
from textured.model import CLAMP, MIRROR, REPEAT, Material, Model, Surface, Texture, wrap_places
from textured.read import read_model

# The renderer


CHECKS = np.zeros((4, 4, 4))
CHECKS[..., 3] = 1.0
CHECKS[::2, ::2, :3] = CHECKS[1::2, 1::2, :3] = 1.0


def wall(material: Material, *, turned: bool = False, repeats: float = 1.0) -> Model:
    """A square that faces east, two triangles, one picture on it."""
    corners = np.array([[0, -1, -1], [0, 1, -1], [0, 1, 1], [0, -1, 1.0]])
    uv = np.array([[0, 1], [1, 1], [1, 0], [0, 0.0]]) * repeats
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    return Model.join([Surface(corners, faces[:, ::-1] if turned else faces, material, uv={0: uv})])


def draw_from_side(model: Model, azimuth: float, size: int = 64) -> np.ndarray:
    return draw(model, *place_cameras(model, size, [(azimuth, 0.0)])[0])


def test_a_picture_stands_upright_and_reads_from_left_to_right() -> None:
    pixels = np.ones((2, 2, 4))
    pixels[:, :, :3] = [[[1, 0, 0], [0, 1, 0]], [[0, 0, 1], [1, 1, 0]]]
    shown = draw_from_side(wall(Material(picture=Texture(pixels, nearest=True))), 0.0)
    assert [np.argmax(shown[row, column]) for row, column in ((16, 16), (16, 48), (48, 16))] == [0, 1, 2]
    assert shown[48, 48, 2] < 0.1 < shown[48, 48, 0]


def halve(model: Model) -> Model:
    """Each triangle cut from its last corner to the middle of the side opposite to it."""

    def halve_rows(rows: np.ndarray) -> np.ndarray:
        middle = rows[:, :2].mean(axis=1)
        first, second = rows.copy(), rows.copy()
        first[:, 1] = second[:, 0] = middle
        return np.concatenate([first, second])

    own = {name: halve_rows(getattr(model, name)) for name in ("corners", "normals", "colors")}
    uv = {name: halve_rows(rows) for name, rows in model.uv.items()}
    return replace(model, uv=uv, material=np.tile(model.material, 2), **own)


def test_perspective_bends_nothing_that_is_straight() -> None:
    """Were coordinates mixed on the screen instead of in space, smaller triangles would show another picture."""
    coarse = wall(Material(picture=Texture(CHECKS, nearest=True)))
    assert np.abs(draw_from_side(coarse, 65.0) - draw_from_side(halve(halve(coarse)), 65.0)).mean() < 1e-3


def test_backs_are_hidden_unless_a_material_has_two_sides() -> None:
    for two_sided, azimuth, blank in ((False, 0.0, False), (False, 180.0, True), (True, 180.0, False)):
        shown = draw_from_side(wall(Material(color=(1, 0, 0, 1), two_sided=two_sided)), azimuth)
        assert np.all(shown == 1.0) == blank


def test_wrapping() -> None:
    for wrap, expected in ((REPEAT, [2, 3, 0, 1]), (CLAMP, [0, 0, 0, 1]), (MIRROR, [1, 0, 0, 1])):
        np.testing.assert_array_equal(wrap_places(np.arange(-2, 2), 4, wrap), expected)


def test_colors_pictures_and_occlusion_multiply() -> None:
    gray = np.full((1, 1, 4), 0.5)
    gray[..., 3] = 1.0
    plain, all_of_it = Material(), Material(color=(0.8, 0.4, 0.2, 1.0), picture=Texture(gray), occlusion=Texture(gray))
    bright, dim = (draw_from_side(wall(material), 0.0)[32, 32] for material in (plain, all_of_it))
    np.testing.assert_allclose(dim, bright * [0.2, 0.1, 0.05], rtol=1e-6)


def test_a_mirrored_node_keeps_its_front_outside_and_its_picture_mirrored(tmp_path: Path) -> None:
    document = Gltf()
    corners = np.array([[0, -1, 1], [0, -1, -1], [0, 1, -1], [0, 1, 1.0]])
    colors = np.array([[1, 0, 0], [0, 0, 1], [0, 0, 1], [1, 0, 0.0]])
    primitive = {
        "attributes": {"POSITION": document.accessor(corners), "COLOR_0": document.accessor(colors)},
        "indices": document.accessor(np.array([0, 1, 2, 0, 2, 3]), "u2"),
    }
    document.mesh(primitive, node={"scale": [1, 1, -1]})
    path = tmp_path / "mirrored.glb"
    path.write_bytes(document.glb())
    shown = draw_from_side(read_model(path), 0.0)
    assert shown[32, 16, 2] > shown[32, 16, 0]
    assert shown[32, 48, 0] > shown[32, 48, 2]


# The judge


@pytest.fixture(scope="module")
def house(data: Path) -> Model:
    return read_model(data / "house_textured.glb")


@pytest.fixture(scope="module")
def views(house: Model) -> Views:
    return Views.draw(house)


def alter(model: Model, name: str, **changes: object) -> Model:
    """One material of a model changed."""
    return replace(
        model,
        materials=[replace(each, **changes) if each.name == name else each for each in model.materials],
    )


def shift(model: Model, name: str, texels: float) -> Model:
    """The picture of one material moved."""
    (number,) = [k for k, each in enumerate(model.materials) if each.name == name]
    uv = model.uv["picture"].copy()
    uv[model.material == number, :, 0] += texels / model.materials[number].picture.pixels.shape[1]
    return replace(model, uv={**model.uv, "picture": uv})


def colorless(model: Model, name: str) -> Model:
    """No color but the picture's on one material."""
    (number,) = [k for k, each in enumerate(model.materials) if each.name == name]
    return replace(model, colors=np.where(model.material[:, None, None] == number, 1.0, model.colors))


def swap_materials(model: Model) -> Model:
    """Bricks on the roof."""
    names = [each.name for each in model.materials]
    order = list(range(len(names)))
    bricks, tiles = names.index("bricks"), names.index("tiles")
    order[bricks], order[tiles] = tiles, bricks
    return replace(model, materials=[model.materials[k] for k in order])


def cut_hole(model: Model) -> Model:
    """A few faces of the sign gone."""
    (sign,) = [k for k, each in enumerate(model.materials) if each.name == "sign"]
    keep = np.ones(len(model.corners), bool)
    keep[np.flatnonzero(model.material == sign)[:8]] = False
    own = {name: getattr(model, name)[keep] for name in ("corners", "normals", "colors", "material")}
    return replace(model, uv={name: values[keep] for name, values in model.uv.items()}, **own)


PICTURES = ("bricks", "facade", "tiles", "sign")
SPOILT = {
    **{f"{name} two texels off": lambda m, n=name: shift(m, n, 2.0) for name in PICTURES},
    **{f"picture of {name} lost": lambda m, n=name: alter(m, n, picture=None) for name in PICTURES},
    "light lost": lambda m: alter(m, "tiles", occlusion=None),
    "color lost": lambda m: colorless(m, "timber"),
    "vertex colors lost": lambda m: colorless(m, "terrace"),
    "bricks and tiles swapped": swap_materials,
    "faces lost": cut_hole,
}


@pytest.mark.parametrize("spoil", SPOILT)
def test_the_judge_sees_what_is_wrong(spoil: str, house: Model, views: Views) -> None:
    found = compare_views(views, Views.draw(SPOILT[spoil](house), views))
    assert found.local > LOCAL


def test_the_judge_sees_nothing_where_nothing_is(house: Model, views: Views) -> None:
    found = compare_views(views, Views.draw(house, views))
    assert found.mean == found.local == 0.0
    assert all(0.1 < np.mean(picture.min(axis=2) < 0.99) < 0.9 for picture in views.pictures)
