"""Textures stay where they are on their walls: random over-sampled textured shapes, seen by an independent judge."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT
from quick import split_seeds
from texels import INTERPOLATED, Dressed, dress, measure_displacement
from textured_shapes import COLORS, MAPS, PLACES, SOURCES, label_walls, map_planes, share_rows, textured_shape

from bldsimp import Options, Tolerance
from bldsimp.io import read
from bldsimp.model import Mesh, Scene, SimplifiedMesh
from bldsimp.options import COLOR_TOLERANCE, TEXTURE_TOLERANCE
from bldsimp.report import Report
from bldsimp.scene import simplify_scene

SEEDS = range(100)
ROUNDED = 1e-4
"""What arithmetic may add; texels or levels."""


def simplified(mesh: Mesh, percent: float = 0.0) -> tuple[SimplifiedMesh, Report]:
    """At `auto`, or within a share of the diagonal."""
    options = Options(tolerance=Tolerance(percent, "percent")) if percent else Options()
    lights, report = simplify_scene(Scene(None, "glb", [mesh], 0), options)
    return lights[0], report


def reach(mesh: Mesh, report: Report) -> float:
    return max(report.deviation, report.tolerance) + 1e-9 * float(np.linalg.norm(np.ptp(mesh.points, axis=0)))


def off(mesh: Mesh, light: SimplifiedMesh, report: Report, kind: str, *, back: bool) -> float:
    """How far UV or colors have moved on the result, and seen from the original too, if asked."""
    before, after = dress(mesh, kinds=(kind,)), dress(mesh, light, (kind,))
    within = reach(mesh, report)
    found = measure_displacement(after, before, within, np.random.default_rng(0), 3).max()
    if back:
        found = max(found, measure_displacement(before, after, within, np.random.default_rng(1), 1).max())
    return float(found)


# The judge


@pytest.fixture
def walls() -> Dressed:
    mesh, _ = textured_shape(4)
    assert {attribute.kind for attribute in mesh.attributes} == {"uv", "color"}
    return dress(mesh)


def judged(spoilt: Dressed, original: Dressed) -> float:
    """The greatest displacement within a thousandth of the size."""
    return float(measure_displacement(spoilt, original, 1e-3, np.random.default_rng(0)).max())


def test_the_judge_sees_nothing_where_nothing_is(walls: Dressed) -> None:
    assert judged(walls, walls) < ROUNDED


@pytest.mark.parametrize("column", [0, 1])
def test_the_judge_sees_a_texture_move_on_one_face(walls: Dressed, column: int) -> None:
    values = walls.values.copy()
    values[7, :, column] += 2.0
    assert judged(replace(walls, values=values), walls) == pytest.approx(2.0, abs=1e-2)


def test_the_judge_sees_one_corner_pulled(walls: Dressed) -> None:
    values = walls.values.copy()
    values[7, 1, 0] += 2.0
    assert judged(replace(walls, values=values), walls) > 1.5


def test_the_judge_sees_another_material_and_a_face_that_crosses(walls: Dressed) -> None:
    names = walls.names.copy()
    names[7] += 1.0
    assert judged(replace(walls, names=names), walls) == np.inf
    corners = walls.corners.copy()
    corners[7, 0] += corners[7, 0] - corners[7, 1]
    assert judged(replace(walls, corners=corners), walls) > 2.0


def test_the_judge_sees_what_is_lost(walls: Dressed) -> None:
    fewer = Dressed(walls.corners[3:], walls.values[3:], walls.names[3:], 0)
    assert judged(walls, fewer) > 2.0


def test_every_source_map_and_place_comes_up() -> None:
    stories = " ".join(textured_shape(seed)[1] for seed in SEEDS).replace(":", " ").split()
    assert {make.__name__ for make in (*SOURCES, *MAPS, *COLORS, *PLACES)} <= set(stories)


# Random shapes


@pytest.mark.parametrize("seeds", split_seeds(20, 100))
def test_random_textures_stay_within_half_a_texel_and_what_the_report_says(seeds: range) -> None:
    for seed in seeds:
        mesh, story = textured_shape(seed)
        light, report = simplified(mesh)
        assert dress(mesh, light).torn == 0, f"seed {seed}: {story}"
        told = report.texels or 0.0
        assert told <= TEXTURE_TOLERANCE
        assert off(mesh, light, report, "uv", back=True) <= told + ROUNDED, f"seed {seed}: {story}"
        assert off(mesh, light, report, "color", back=True) <= COLOR_TOLERANCE + ROUNDED, f"seed {seed}: {story}"


@pytest.mark.parametrize("seeds", split_seeds(20, 100))
@pytest.mark.parametrize("percent", [0.1, 1.0, 5.0])
def test_textures_follow_points_that_move(percent: float, seeds: range) -> None:
    """What the result shows is what the original shows within reach; what is narrower than that may go."""
    for seed in seeds:
        mesh, story = textured_shape(seed)
        light, report = simplified(mesh, percent)
        told = (report.texels or 0.0) + ROUNDED
        assert off(mesh, light, report, "uv", back=False) <= told, f"seed {seed}: {story}"
        assert off(mesh, light, report, "color", back=False) <= COLOR_TOLERANCE + ROUNDED, f"seed {seed}: {story}"


def test_points_that_stay_keep_exactly_what_they_carried() -> None:
    for seed in SEEDS:
        mesh, story = textured_shape(seed)
        light, _ = simplified(mesh)
        used = np.unique(light.faces)
        at = {}
        for row in range(len(mesh.points)):
            carried = b"".join(attribute.values[row].tobytes() for attribute in mesh.attributes)
            at.setdefault(mesh.points[row].tobytes(), set()).add(carried)
        for row in used:
            carried = b"".join(light.values(attribute)[row].tobytes() for attribute in mesh.attributes)
            assert carried in at[light.points[row].tobytes()], f"seed {seed}: {story}"


def test_affine_maps_cost_no_points_but_those_of_their_changes() -> None:
    """One map for each wall, however it is turned and tiled: as light as without."""
    for seed in range(30):
        rng = np.random.default_rng(seed)
        points, faces = SOURCES[seed % 2](rng)
        walls = label_walls(points, faces)
        one = np.zeros(len(faces), np.int64)
        uv = map_planes(points[faces], one, walls, rng)
        textured, plain = (
            share_rows((points, faces), one, {"TEXCOORD_0": uv}, rng),
            share_rows((points, faces), one, {}, rng),
        )
        counts = [simplified(mesh)[1].after.points for mesh in (textured, plain)]
        assert counts[0] == counts[1] < len(plain.points), f"seed {seed}"


# Our house


@pytest.mark.parametrize("percent", [0.0, 0.1, 1.0])
@pytest.mark.parametrize("suffix", ["glb", "obj"])
def test_textures_of_our_house_stay_in_place(suffix: str, percent: float) -> None:
    scene = read(ROOT / "data" / f"house_textured.{suffix}", suffix)
    options = Options(tolerance=Tolerance(percent, "percent")) if percent else Options()
    lights, report = simplify_scene(scene, options)
    assert report.texels is not None
    assert report.texels <= TEXTURE_TOLERANCE
    for mesh, light in zip(scene.meshes, lights, strict=True):
        kinds = {attribute.kind for attribute in mesh.attributes}
        assert kinds <= set(INTERPOLATED)
        assert kinds, mesh.name
        before, after = dress(mesh), dress(mesh, light)
        found = measure_displacement(after, before, reach(mesh, report), np.random.default_rng(0), 20).max()
        assert found <= report.texels + ROUNDED, mesh.name
