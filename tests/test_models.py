"""The promises on third-party models, where their folder is there, and on the buildings in data/."""

from __future__ import annotations

from pathlib import Path

import judge
import numpy as np
import pytest
from quick import LARGE_MODELS, defer

from bldsimp.io import SUFFIXES, read
from bldsimp.model import Faces, Flags, Mesh, Points, Scene, SimplifiedMesh
from bldsimp.options import Options, Tolerance
from bldsimp.scene import simplify_scene
from bldsimp.stages import removal
from bldsimp.stages.removal import Dropped
from bldsimp.tolerance import measure_scale

REFUSED = {"trimesh_empty.ply", "trimesh_points_emptyface.ply", "trimesh_notenoughindices.obj"}
MODELS = (
    "broken/manifold_Generic_Twin_7863.1.t0_right.obj", "broken/manifold_Havocglass8_left.obj",
    "broken/manifold_Offset2.obj", "broken/manifold_openscad-nonmanifold-crash.obj", "broken/pmp_fandisk.off",
    "broken/trimesh_busted.STL", "broken/trimesh_joined_tetrahedra.obj", "broken/trimesh_mirror.ply",
    "broken/trimesh_multibody.stl", "broken/trimesh_nancolor.obj", "broken/trimesh_negative_indices.obj",
    "broken/trimesh_plate_holes.STL", "broken/trimesh_polygonfaces.obj", "broken/trimesh_soup.stl",
    "broken/trimesh_wallhole.obj", "city/derived_citygml4j_lod3_building.obj",
    "city/derived_cjio_delft_buildings.obj", "city/derived_savenow_lod3_4018128.obj",
    "city/derived_val3dity_fzk_haus.obj", "exact/cesium_building_tower.glb", "exact/hideba_bk.obj",
    "exact/ifcderived_bimwhale_TallBuilding.obj", "exact/ifcderived_thatopen_duplex.obj",
    "exact/oversampled_100k.glb", "exact/oversampled_10k.ply", "exact/oversampled_minimal.ply",
    "exact/vcity_tour_part_dieu.obj", "noisy/abspy_test_church.obj", "noisy/easy3d_building.off",
    "noisy/oversampled_10k_noise1cm.ply", "noisy/planeopt_copyroom.ply", "textured/cesium_house-3-0.glb",
    "textured/kaykit_building_H/building_H.gltf", "textured/kenney_building-small-a.glb",
    "textured/khronos_NegativeScaleTest.glb", "textured/khronos_SimpleInstancing.glb",
    "textured/trimesh_no_indices_3storybuilding.glb",
    "tiles/metadata/house-3-0.glb", "tiles/metadata/house-4-2.glb", "tiles/metadata/house-5-3.glb",
    "tiles/metadata/house1-1.glb", "tiles/sibbe/1.1/content/1_1_0.glb", "tiles/sibbe/1.1/content/2_2_3.glb",
    "tiles/sibbe/1.1/content/2_3_2.glb",
)  # fmt: skip
BUILDINGS = ("building_a.obj", "building_b.obj", "building_a.glb", "building_b.glb")
SLOW_WHEN_ROUGH = {"exact/cesium_building_tower.glb", "exact/oversampled_100k.glb"}


def read_scene(path: Path) -> Scene:
    return read(path, path.suffix[1:].lower())


def rebuild_mesh(mesh: Mesh, light: SimplifiedMesh) -> Mesh:
    """The result as a mesh again."""
    return Mesh(
        mesh.name, light.points, light.faces, light.part_of_face, mesh.parts, mesh.transforms,
        single=mesh.single, rounding=mesh.rounding,
    )  # fmt: skip


def judge_scene(scene: Scene, tolerance: Tolerance) -> list[Mesh]:
    """Simplify a scene, have every mesh judged, and return the results."""
    options = Options(tolerance=tolerance, delimit=frozenset())
    lights, report = simplify_scene(scene, options)
    results = []
    for mesh, light in zip(scene.meshes, lights, strict=True):
        results.append(rebuild_mesh(mesh, light))
        stretch = measure_scale(mesh) or 1.0
        found = judge.find_broken(
            judge.make_surface(mesh.points, mesh.faces),
            judge.make_surface(light.points, light.faces),
            report.tolerance / stretch,
            report.deviation / stretch,
            healed=report.healed_t_junctions,
            closed=bool(report.removed_details),
            count=100,
        )
        assert found == [], mesh.name
    return results


def count_points(meshes: list[Mesh]) -> int:
    return sum(len(judge.make_surface(mesh.points, mesh.faces).points) for mesh in meshes)


@pytest.mark.parametrize("name", defer(MODELS, LARGE_MODELS))
def test_models_keep_every_promise(name: str, models: Path) -> None:
    judge_scene(read_scene(models / name), Tolerance())


@pytest.mark.parametrize("tolerance", [Tolerance(), Tolerance(1e-4, "percent"), Tolerance(9e-4, "percent")], ids=str)
@pytest.mark.parametrize("name", defer(MODELS, LARGE_MODELS))
def test_a_second_run_drops_next_to_nothing(name: str, tolerance: Tolerance, models: Path) -> None:
    scene = read_scene(models / name)
    options = Options(tolerance=tolerance, delimit=frozenset())
    lights, _ = simplify_scene(scene, options)
    scene.meshes = once = [rebuild_mesh(mesh, light) for mesh, light in zip(scene.meshes, lights, strict=True)]
    lights, _ = simplify_scene(scene, options)
    twice = [rebuild_mesh(mesh, light) for mesh, light in zip(once, lights, strict=True)]
    assert count_points(twice) >= 0.995 * count_points(once)


ROUGH = tuple(name for name in MODELS if name not in SLOW_WHEN_ROUGH)


def find_nothing(points: Points, faces: Faces, *_: object) -> tuple[Flags, list[Dropped]]:
    """Stand in for `find_redundant_bodies`: removed bodies change the counts that are judged."""
    return np.zeros(len(faces), np.uint8), []


@pytest.mark.parametrize("name", defer(ROUGH, LARGE_MODELS))
def test_models_keep_every_promise_at_a_rough_tolerance(
    name: str, models: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(removal, "find_redundant_bodies", find_nothing)
    judge_scene(read_scene(models / name), Tolerance(1.0, "percent"))


@pytest.mark.parametrize("name", defer(ROUGH, LARGE_MODELS))
def test_models_stay_within_a_rough_tolerance_where_bodies_go(name: str, models: Path) -> None:
    scene = read_scene(models / name)
    lights, report = simplify_scene(scene, Options(tolerance=Tolerance(1.0, "percent"), delimit=frozenset()))
    assert report.after.points <= report.before.points
    assert report.after.watertight or not report.before.watertight
    for mesh, light in zip(scene.meshes, lights, strict=True):
        before, after = judge.make_surface(mesh.points, mesh.faces), judge.make_surface(light.points, light.faces)
        apart = judge.measure_deviation(before, after, 100) - judge.estimate_blur(before)
        assert apart * (measure_scale(mesh) or 1.0) <= report.deviation <= report.tolerance, mesh.name


def test_no_model_is_forgotten(models: Path) -> None:
    found = {
        str(path.relative_to(models))
        for path in models.rglob("*")
        if path.suffix[1:].lower() in SUFFIXES and "cdt" not in path.parts and path.name not in REFUSED
    }
    assert found == set(MODELS)


@pytest.mark.parametrize("name", defer(BUILDINGS, BUILDINGS[1:]))
def test_a_second_run_on_our_own_buildings_changes_nothing(name: str, data: Path) -> None:
    scene = read_scene(data / name)
    scene.meshes = once = judge_scene(scene, Tolerance())
    lights, _ = simplify_scene(scene, Options())
    for mesh, light in zip(once, lights, strict=True):
        first = judge.make_surface(mesh.points, mesh.faces)
        second = judge.make_surface(light.points, light.faces)
        assert np.array_equal(first.points, second.points)
        assert judge.collect_triangles(first) == judge.collect_triangles(second)
