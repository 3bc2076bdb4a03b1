"""Pictures do not change: textured models look the same from eight sides before and after, in every format."""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
import trimesh
from conftest import ROOT, models_folder
from quick import defer
from shapes import Gltf, read_values, split_glb

pytest.importorskip("PIL", reason="the extra 'pictures' is not installed")
sys.path.insert(0, str(ROOT / "examples"))

from buildings.tessellate import tessellate
from buildings.textured_house import build_terrace, color_terrace
from textured.difference import LOCAL, MEAN, Difference, Views, compare_views
from textured.model import Model
from textured.read import is_gltf, read_model

from bldsimp import Options, Tolerance
from bldsimp.io import read
from bldsimp.io import write as write_scene
from bldsimp.scene import simplify_scene

LOCAL_MOVED = 0.15
"""The same where points may move by a quarter of a pixel, and what is smaller may go."""

HOUSE = ROOT / "data" / "house_textured.glb"
HOUSE_OBJ = HOUSE.with_suffix(".obj")
TEXTURED = sorted(
    path for path in (models_folder() / "textured").rglob("*") if path.suffix in (".glb", ".gltf", ".obj")
)
SLOW = [pytest.mark.slow]
OUR_WAYS = [
    pytest.param(
        source, suffix, id=f"{source.suffix[1:]}-{suffix}", marks=[] if source.suffix == f".{suffix}" else SLOW
    )
    for source in (HOUSE, HOUSE_OBJ)
    for suffix in ("glb", "gltf", "obj")
]


def remove_light(model: Model) -> Model:
    """What formats without a second map can show: a loss that is told."""
    return replace(model, materials=[replace(material, occlusion=None) for material in model.materials])


@lru_cache
def draw_views(path: Path, lit: bool) -> Views:
    """Views of an original; drawn once."""
    model = read_model(path)
    return Views.draw(model if lit else remove_light(model))


def compare_looks(source: Path, target: Path, tolerance: Tolerance) -> Difference:
    """Simplify a file, and compare what the files show."""
    scene = read(source, source.suffix[1:].lower())
    options = Options(tolerance=tolerance)
    lights, _ = simplify_scene(scene, options)
    write_scene(scene, lights, target, target.suffix[1:], options)
    before = draw_views(source, is_gltf(target))
    # No format turns the model: what stands y up does so in a format that does not, too.
    found = compare_views(before, Views.draw(read_model(target, y_up=is_gltf(source)), before))
    print(f"{source.name} -> {target.suffix[1:]}: mean {found.mean:.2e}, local {found.local:.2e} in {found}")
    return found


@pytest.mark.parametrize(("source", "suffix"), OUR_WAYS)
def test_our_house_looks_the_same(source: Path, suffix: str, tmp_path: Path) -> None:
    found = compare_looks(source, tmp_path / f"light.{suffix}", Tolerance())
    assert found.mean < MEAN
    assert found.local < LOCAL


@pytest.mark.parametrize(("source", "suffix"), [(HOUSE, "glb"), (HOUSE_OBJ, "obj")])
def test_our_house_looks_the_same_within_a_wide_tolerance(source: Path, suffix: str, tmp_path: Path) -> None:
    found = compare_looks(source, tmp_path / f"light.{suffix}", Tolerance(0.1, "percent"))
    assert found.mean < MEAN
    assert found.local < LOCAL_MOVED


def roughen(glb: bytes, size: float) -> bytes:
    """A GLB whose walls are rough: points inside of them are off by up to `size`, square to the wall; UV stay."""
    json_, body = split_glb(glb)
    binary, rng = bytearray(body), np.random.default_rng(0)
    for mesh in json_["meshes"]:
        names = [primitive["attributes"] for primitive in mesh["primitives"] if "NORMAL" in primitive["attributes"]]
        stored = [read_values(glb, each["POSITION"]) for each in names]
        if not stored:
            continue
        _, inverse, uses = np.unique(np.concatenate(stored), axis=0, return_inverse=True, return_counts=True)
        inside = np.split(uses[inverse.reshape(-1)] == 1, np.cumsum([len(each) for each in stored])[:-1])
        for each, own, moves in zip(names, stored, inside, strict=True):
            height = rng.uniform(-size, size, (len(own), 1)) * moves[:, None]
            rough = (own + height * read_values(glb, each["NORMAL"])).astype("<f4")
            entry = json_["accessors"][each["POSITION"]]
            entry["min"], entry["max"] = rough.min(axis=0).tolist(), rough.max(axis=0).tolist()
            start = json_["bufferViews"][entry["bufferView"]]["byteOffset"]
            binary[start : start + rough.nbytes] = rough.tobytes()
    document = Gltf()
    document.json, document.data = json_, binary
    return document.glb()


@pytest.mark.slow
def test_a_rough_house_looks_the_same_within_a_tolerance_that_takes_the_roughness(tmp_path: Path) -> None:
    source, target = tmp_path / "rough.glb", tmp_path / "light.glb"
    source.write_bytes(roughen(HOUSE.read_bytes(), 0.004))
    found = compare_looks(source, target, Tolerance(0.1, "percent"))
    assert found.mean < MEAN
    assert found.local < LOCAL_MOVED
    assert len(read_model(target).corners) < 0.1 * len(read_model(source).corners)


@pytest.mark.parametrize("suffix", defer(["ply", "glb", "obj"], ["glb", "obj"]))
@pytest.mark.parametrize("on", ["vertices", "faces"])
def test_colors_of_a_ply_look_the_same(on: str, suffix: str, tmp_path: Path) -> None:
    points, faces = tessellate(build_terrace(), 0.4)
    mesh = trimesh.Trimesh(points, faces, process=False)
    if on == "vertices":
        mesh.visual.vertex_colors = np.round(255 * color_terrace(points)).astype(np.uint8)
    else:
        mesh.visual.face_colors = np.round(255 * color_terrace(np.round(mesh.triangles_center))).astype(np.uint8)
    source = tmp_path / "colored.ply"
    mesh.export(source)
    found = compare_looks(source, tmp_path / f"light.{suffix}", Tolerance())
    assert found.mean < MEAN
    assert found.local < LOCAL


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [Tolerance(), Tolerance(0.1, "percent")], ids=["auto", "wide"])
@pytest.mark.parametrize("source", TEXTURED, ids=lambda path: path.name)
def test_third_party_models_look_the_same(source: Path, tolerance: Tolerance, tmp_path: Path) -> None:
    found = compare_looks(source, tmp_path / f"light{source.suffix}", tolerance)
    assert found.mean < MEAN
    assert found.local < (LOCAL if tolerance == Tolerance() else LOCAL_MOVED)
