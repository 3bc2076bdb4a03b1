"""The textured house in data/: what its scene holds, closed as it is built, the same in both forms, and lighter."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from conftest import ROOT
from shapes import read_values, split_glb

sys.path.insert(0, str(ROOT / "examples"))

from buildings import painted
from buildings.png import encode_png
from buildings.textured_files import IMAGES, NAME
from buildings.textured_house import build_body, build_terrace, build_wing

from bldsimp import Options
from bldsimp.io import read
from bldsimp.scene import simplify_scene


@pytest.fixture(scope="module")
def glb(data: Path) -> bytes:
    return (data / f"{NAME}.glb").read_bytes()


def group_by_mesh(glb: bytes) -> dict[str, trimesh.Trimesh]:
    """The four meshes of the scene in their own frames, equal positions welded."""
    json_, _ = split_glb(glb)
    found = {}
    for mesh in json_["meshes"]:
        corners = [
            read_values(glb, each["attributes"]["POSITION"])[read_values(glb, each["indices"]).reshape(-1, 3)]
            for each in mesh["primitives"]
        ]
        points = np.concatenate(corners).reshape(-1, 3).astype(float)
        unique, inverse = np.unique(points, axis=0, return_inverse=True)
        found[mesh["name"]] = trimesh.Trimesh(unique, inverse.reshape(-1, 3), process=False)
    return found


def test_the_scene_holds_what_it_is_for(glb: bytes) -> None:
    json_, _ = split_glb(glb)
    nodes = {node["name"]: node for node in json_["nodes"]}
    assert nodes["wing_west"]["mesh"] == nodes["wing_east"]["mesh"]
    assert np.prod(nodes["wing_west"]["scale"]) < 0
    assert "camera" in nodes["eye"]
    assert "extensions" in nodes["sun"]
    assert nodes["sign"]["extras"] == {"text": "BRICKS"}
    materials = {material["name"]: material for material in json_["materials"]}
    assert materials["facade"]["occlusionTexture"]["texCoord"] == 1
    body_, _, _, colored = json_["meshes"]
    looks = [json_["materials"][each["material"]]["name"] for each in body_["primitives"]]
    assert looks == ["bricks", "facade", "tiles", "timber"]
    ranges = {}
    for look, each in zip(looks, body_["primitives"], strict=True):
        ranges[look] = np.ptp(read_values(glb, each["attributes"]["TEXCOORD_0"]), axis=0)
        second = read_values(glb, each["attributes"]["TEXCOORD_1"])
        assert 0 < second.min() < second.max() < 1
    assert ranges["bricks"].max() > 10
    assert ranges["tiles"].max() > 5
    assert ranges["facade"].max() <= 1
    colors = read_values(glb, colored["primitives"][0]["attributes"]["COLOR_0"])
    assert 0 < colors.min() < colors.max() < 1
    assert np.ptp(colors, axis=0).min() > 0.1


def test_each_solid_is_closed_and_over_sampled(glb: bytes) -> None:
    meshes = group_by_mesh(glb)
    first = build_body().model
    models = {"body": first, "wing": build_wing(len(first.facets)).model, "terrace": build_terrace()}
    for name, model in models.items():
        mesh = meshes[name]
        assert mesh.is_watertight, name
        assert mesh.is_winding_consistent
        assert mesh.volume > 0
        assert len(mesh.vertices) > 20 * model.count_corners(), name


@pytest.mark.parametrize("name", IMAGES)
def test_pictures_are_read_as_they_were_painted(name: str) -> None:
    images = pytest.importorskip("PIL.Image", reason="the extra 'pictures' is not installed")
    picture = images.open(io.BytesIO(IMAGES[name]()))
    assert picture.size[0] % 2 == 0
    assert len(picture.convert("RGBA").getcolors(16)) > 2


def test_a_picture_of_all_its_colors() -> None:
    images = pytest.importorskip("PIL.Image", reason="the extra 'pictures' is not installed")
    palette = [(16 * k, 255 - 16 * k, k, 255 - k) for k in range(16)]
    pixels = painted.make_grain((300, 500), 16, 3)
    shown = images.open(io.BytesIO(encode_png(pixels, palette))).convert("RGBA")
    np.testing.assert_array_equal(np.asarray(shown), np.array(palette)[pixels])
    with pytest.raises(ValueError, match="even"):
        encode_png(pixels[:, :3], palette)


def test_both_forms_are_one_house(glb: bytes, data: Path) -> None:
    meshes = group_by_mesh(glb)
    text = trimesh.load_mesh(data / f"{NAME}.obj", process=False)
    assert text.area == pytest.approx(meshes["body"].area + 2 * meshes["wing"].area + meshes["sign"].area, rel=1e-5)
    text.merge_vertices(merge_tex=True, merge_norm=True)
    assert text.volume == pytest.approx(meshes["body"].volume + 2 * meshes["wing"].volume, rel=1e-3)


@pytest.mark.parametrize("suffix", ["glb", "obj"])
def test_the_house_loses_95_percent_of_its_points(data: Path, suffix: str) -> None:
    _, report = simplify_scene(read(data / f"{NAME}.{suffix}", suffix), Options())
    assert report.after.points <= 0.05 * report.before.points
    assert report.deviation <= report.tolerance


def test_the_figures_of_the_docs_are_those_of_today(data: Path) -> None:
    scene = read(data / f"{NAME}.glb", "glb")
    text = (ROOT / "docs" / "textures.md").read_text(encoding="utf-8")
    _, report = simplify_scene(scene, Options())
    _, plain = simplify_scene(scene, Options(delimit=frozenset()))
    before, after, alone = report.before, report.after, plain.after
    assert f"| before | {before.points:,} | {before.triangles:,} | |" in text
    assert f"| after | {after.points:,} | {after.triangles:,} | {report.texels:.2g} texels |" in text
    assert f"(`--delimit none`) | {alone.points:,} | {alone.triangles:,} | |" in text
    assert f"textures cost is {after.points - alone.points} points" in text
