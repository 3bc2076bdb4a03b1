"""The two buildings in data/: closed, in agreement with their construction, and the same in both forms."""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import trimesh
from conftest import ROOT
from quick import defer
from scipy.spatial import cKDTree

sys.path.insert(0, str(ROOT / "examples"))

from buildings.facet_model import Frame, Model, make_rectangle
from buildings.house import build_house
from buildings.tessellate import tessellate
from buildings.tower import build_tower

from bldsimp import Options, Tolerance, simplify
from bldsimp.io import read
from bldsimp.scene import simplify_scene

BUILDINGS = {"building_a": build_house, "building_b": build_tower}
Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


@cache
def build(name: str) -> Model:
    """Return the construction of a building."""
    return BUILDINGS[name]()


def load(path: Path) -> trimesh.Trimesh:
    """Read a mesh as it is stored, z upwards."""
    mesh = trimesh.load_mesh(path, process=False)
    if path.suffix == ".glb":
        mesh.vertices = mesh.vertices @ Z_UP.T
    return mesh


def cube() -> Model:
    """A unit cube with a square recess in its top."""
    model = Model()
    for origin, right in (((0, 0), (1, 0)), ((1, 0), (0, 1)), ((1, 1), (-1, 0)), ((0, 1), (0, -1))):
        frame = Frame.span((*origin, 0), (*right, 0), (0, 0, 1))
        model.add_plate(frame, make_rectangle(0, 0, 1, 1))
    top = model.add_plate(Frame.span((0, 0, 1), (1, 0, 0), (0, 1, 0)), make_rectangle(0, 0, 1, 1))
    top.recess(make_rectangle(0.25, 0.25, 0.75, 0.75), 0.5)
    model.add_plate(Frame.span((0, 1, 0), (1, 0, 0), (0, -1, 0)), make_rectangle(0, 0, 1, 1))
    return model


def test_fewest_points_of_a_cube_with_a_recess() -> None:
    model = cube().finish()
    assert model.count_corners() == 16
    assert model.count_fewest_triangles() == 28


def test_finish_refuses_an_open_model() -> None:
    model = cube()
    model.plates.pop()
    with pytest.raises(ValueError, match="is open"):
        model.finish()


@pytest.mark.parametrize("edge", [10.0, 0.3, 0.11])
def test_tessellation_keeps_volume_and_closure(edge: float) -> None:
    points, faces = tessellate(cube().finish(), edge)
    mesh = trimesh.Trimesh(points, faces, process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume == pytest.approx(1 - 0.25 * 0.5)
    assert mesh.area == pytest.approx(6 + 4 * 0.5 * 0.5)
    assert mesh.area_faces.min() > 0
    assert np.linalg.norm(np.diff(points[mesh.edges_unique], axis=1), axis=-1).max() < max(edge * 3, 1.5)


@pytest.mark.parametrize("name", defer(BUILDINGS, ["building_b"]))
def test_building_is_a_closed_solid_of_its_construction(data: Path, name: str) -> None:
    model = build(name)
    plain = trimesh.Trimesh(*tessellate(model, 1e9), process=False)
    assert len(plain.vertices) == model.count_corners()
    assert len(plain.faces) == model.count_fewest_triangles()
    for suffix in ("obj", "glb"):
        mesh = load(data / f"{name}.{suffix}")
        assert mesh.is_watertight
        assert mesh.is_winding_consistent
        assert len(np.unique(mesh.vertices, axis=0)) == len(mesh.vertices)
        assert mesh.euler_number == plain.euler_number
        assert mesh.body_count == plain.body_count
        assert mesh.volume == pytest.approx(plain.volume, rel=1e-6)
        assert mesh.area == pytest.approx(plain.area, rel=1e-6)
        assert len(mesh.vertices) > 10 * model.count_corners()
        assert cKDTree(mesh.vertices).query(plain.vertices)[0].max() < 4e-6


@pytest.mark.parametrize("name", BUILDINGS)
def test_both_forms_are_one_model(data: Path, name: str) -> None:
    text, binary = load(data / f"{name}.obj"), load(data / f"{name}.glb")
    np.testing.assert_array_equal(text.faces, binary.faces)
    np.testing.assert_allclose(text.vertices, binary.vertices, atol=2e-6, rtol=0)


@pytest.mark.parametrize("name", BUILDINGS)
@pytest.mark.parametrize("suffix", ["obj", "glb"])
def test_simplify_finds_the_fewest_points_of_the_construction(data: Path, name: str, suffix: str) -> None:
    model = build(name)
    _, report = simplify_scene(read(data / f"{name}.{suffix}", suffix), Options())
    assert report.after.points == model.count_corners()
    assert report.after.triangles == model.count_fewest_triangles()
    assert report.facets == len(model.facets)
    assert report.after.watertight
    assert 0 < report.deviation <= report.tolerance


@pytest.mark.parametrize("name", BUILDINGS)
@pytest.mark.parametrize("percent", defer([0.1, 0.5, 2.0], [0.1, 2.0]))
def test_a_wide_tolerance_keeps_no_more_points_than_the_default(data: Path, name: str, percent: float) -> None:
    scene = read(data / f"{name}.obj", "obj")
    _, report = simplify_scene(scene, Options(tolerance=Tolerance(percent, "percent")))
    assert report.after.points <= build(name).count_corners()
    assert report.after.watertight
    assert report.deviation <= report.tolerance


@pytest.mark.parametrize("tolerance", ["0.1%", "0.5%"])
def test_every_face_is_told_with_one_facet(data: Path, tolerance: str) -> None:
    mesh = load(data / "building_b.obj")
    told = np.concatenate([facet.faces for facet in simplify(mesh, tolerance).facets])
    assert len(told) == len(np.unique(told)) > 0.99 * len(mesh.faces)


def test_facets_tell_their_faces_at_a_tolerance_that_leaves_them_flat(data: Path) -> None:
    mesh = load(data / "building_b.obj")
    light = simplify(mesh, "0.1%")
    beyond = 0
    for facet in light.facets:
        own = mesh.vertices[mesh.faces[facet.faces]]
        heights = np.abs((own - light.mesh.vertices[facet.rings[0][0]]) @ facet.normal).max(axis=1)
        # Faces that were flat together and are parted now go with one of the pieces.
        beyond += np.count_nonzero(heights > light.report.tolerance)
    assert beyond < 0.01 * len(mesh.faces)


def test_files_stay_small(data: Path) -> None:
    assert sum(path.stat().st_size for path in data.iterdir()) < 5_000_000
