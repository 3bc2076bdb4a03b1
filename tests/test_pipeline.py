"""The pipeline does each thing once, takes points that are decided outside, and names what breaks."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import solids

from bldsimp import _core
from bldsimp.errors import InternalError
from bldsimp.io import read
from bldsimp.model import Mesh, Part, Scene, cast_indices
from bldsimp.options import Options, Tolerance
from bldsimp.pipeline import DecidedPoints, simplify_mesh
from bldsimp.scene import simplify_scene
from bldsimp.stages.planar import merge_after_collapses
from bldsimp.stages.provenance import ResolvedRows
from bldsimp.stages.surface import Surface, sort_faces

COUNTED = ("weld", "pair_halfedges", "find_misoriented", "assign_rows", "find_charts")


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """Count the calls of kernels."""
    counted: Counter[str] = Counter()

    def count(name: str) -> None:
        kernel = getattr(_core, name)

        def call(*arguments: Any, **options: Any) -> Any:
            counted[name] += 1
            return kernel(*arguments, **options)

        monkeypatch.setattr(_core, name, call)

    for name in COUNTED:
        count(name)
    return counted


def mesh_of(shape: solids.Shape) -> Mesh:
    points, faces = shape
    return Mesh("mesh", points, faces, np.zeros(len(faces), np.int32), [Part("mesh")])


class TestOnce:
    @pytest.mark.parametrize("unit", ["auto", "percent"])
    def test_a_textured_building_is_welded_and_looked_up_once(self, data: Path, calls: Counter[str], unit: str) -> None:
        scene = read(data / "house_textured.obj", "obj")
        assert len(scene.meshes) == 1
        simplify_scene(scene, Options(tolerance=Tolerance(0.5 if unit == "percent" else 0.0, unit)))
        # At a wide tolerance charts are cut within facets and across them.
        assert (calls["weld"], calls["find_charts"], calls["assign_rows"]) == (1, 1 if unit == "auto" else 2, 1)

    def test_halfedges_are_paired_once_for_each_set_of_faces(self, calls: Counter[str]) -> None:
        mesh = mesh_of(solids.subdivide(solids.box(), 3))
        simplify_mesh(mesh, 1e-9)
        assert calls["pair_halfedges"] == calls["find_misoriented"] == 1
        simplify_mesh(mesh, 0.05)
        # At a wide tolerance collapses give other faces.
        assert calls["pair_halfedges"] == calls["find_misoriented"] == 3

    def test_small_components_cost_no_second_weld(self, calls: Counter[str]) -> None:
        points, faces = solids.box()
        shape = (
            np.concatenate([points, points * 0.01 + 5.0]),
            np.concatenate([faces, cast_indices(faces + len(points))]),
        )
        scene = Scene(None, "arrays", [mesh_of(shape)], 0)
        _, report = simplify_scene(scene, Options(min_component=0.1))
        assert len(report.removed_components) == 1
        assert report.before.points == 2 * report.after.points == 16
        assert calls["weld"] == 1


class TestDecidedPoints:
    """A sheet of 2 by 2 squares, whose upper border has a point in the middle."""

    def sheet(self, bend: float = 0.0) -> tuple[Mesh, int]:
        points, faces = solids.subdivide(solids.square(), 1)
        mesh = mesh_of((points.copy(), faces))
        middle = int(np.flatnonzero((mesh.points[:, 0] == 0.5) & (mesh.points[:, 1] == 1.0))[0])
        mesh.points[middle, 1] += bend
        return mesh, middle

    def test_a_point_that_no_chain_needs_stays_where_it_is_decided(self) -> None:
        mesh, middle = self.sheet()
        assert simplify_mesh(mesh, 1e-6).after.points == 4
        decided = DecidedPoints(np.array([middle], np.int32), np.array([True]))
        result = simplify_mesh(mesh, 1e-6, decided=decided)
        assert result.after.points == 5
        assert middle in result.mesh.faces

    def test_a_point_that_the_tolerance_keeps_goes_where_it_is_decided(self) -> None:
        mesh, middle = self.sheet(0.01)
        assert simplify_mesh(mesh, 1e-6).after.points == 5
        decided = DecidedPoints(np.array([middle], np.int32), np.array([False]))
        result = simplify_mesh(mesh, 1e-6, decided=decided)
        assert result.after.points == 4
        assert result.deviation >= 0.01

    def test_a_point_stays_at_a_wide_tolerance_too(self) -> None:
        mesh, middle = self.sheet(0.01)
        assert simplify_mesh(mesh, 0.05).after.points == 4
        decided = DecidedPoints(np.array([middle], np.int32), np.array([True]))
        result = simplify_mesh(mesh, 0.05, decided=decided)
        assert result.after.points == 5
        assert middle in result.mesh.faces
        assert np.array_equal(result.mesh.points[middle], mesh.points[middle])


class TestBrokenInvariants:
    """A kernel that finds an invariant broken ends in one error that names it, and its input can be had."""

    @pytest.fixture
    def broken(self, monkeypatch: pytest.MonkeyPatch) -> Mesh:
        def find_facets(*_: Any) -> None:
            raise _core.KernelError("find_facets: a facet without faces")

        monkeypatch.setattr(_core, "find_facets", find_facets)
        return mesh_of(solids.box())

    def test_the_error_names_the_stage_and_how_to_get_the_input(
        self, broken: Mesh, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.delenv("BLDSIMP_DUMP", raising=False)
        with pytest.raises(InternalError, match=r"^find_facets: a facet without faces: a bug.*BLDSIMP_DUMP=FOLDER"):
            simplify_mesh(broken, 1e-6)

    def test_the_input_is_written_where_the_environment_says(
        self, broken: Mesh, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
    ) -> None:
        monkeypatch.setenv("BLDSIMP_DUMP", str(tmp_path / "dump"))
        with pytest.raises(InternalError, match=r"report it with .*\.npz"):
            simplify_mesh(broken, 1e-6)
        (path,) = (tmp_path / "dump").iterdir()
        with np.load(path) as dumped:
            assert np.array_equal(dumped["points"], broken.points)
            assert np.array_equal(dumped["faces"], broken.faces)
            assert dumped["tolerance"] == 1e-6


def test_rows_follow_faces_that_are_turned_after_edges_collapsed() -> None:
    points, faces = solids.box()
    faces = faces.copy()
    faces[3] = faces[3][[0, 2, 1]]
    faces, order = sort_faces(faces)
    count = np.arange(len(points), dtype=np.int32)
    label, source = np.zeros(len(faces), np.int32), order
    surface = Surface(points, faces, label, source, label, count, np.zeros(len(points), np.uint8))
    merged = merge_after_collapses(surface, ResolvedRows(faces, np.zeros(faces.shape, bool)), 1e-9)
    assert merged.turned == 1
    assert np.array_equal(merged.trace_rows().rows, merged.assembly.triangles)
