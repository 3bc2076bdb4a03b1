"""The measure behind every comparison: exact distances, both ways, and borders."""

from __future__ import annotations

import numpy as np
import pytest
from distance import Boxes, measure_distance
from shapes import FAR, box, fine_box, open_cone
from solids import round_to_single

from bldsimp import _core
from bldsimp.compare.decimate import FastSimplification
from bldsimp.compare.measure import SAMPLES, Judge, collect_queries, find_open_edges, is_watertight, sample_surface
from bldsimp.compare.placement import PlacedSurface, place_scene, weld_surface
from bldsimp.io import read

Arrays = tuple[np.ndarray, np.ndarray]


def make_surface(mesh: Arrays) -> PlacedSurface:
    points, faces = mesh
    return weld_surface(np.asarray(points, np.float64), np.asarray(faces, np.int32))


def load_building(data) -> tuple[PlacedSurface, PlacedSurface]:
    """The house, and what a decimator makes of it when it must go too far."""
    before = place_scene(read(data / "building_a.obj", "obj"))
    return before, make_surface(FastSimplification()(before.points, before.faces, 2000))


class TestDistances:
    def test_they_are_those_of_a_slow_search(self) -> None:
        random = np.random.default_rng(3)
        points = random.random((60, 3))
        faces = random.integers(0, 60, (40, 3)).astype(np.int32)  # some repeat a point
        asked = random.random((2000, 3)) * 2 - 0.5
        told = _core.distances(asked, points, faces)
        assert told == pytest.approx(measure_distance(asked, Boxes(points[faces])), abs=1e-15)

    @pytest.mark.parametrize("height", [1e-3, 1e-8, 1e-12, 1e-16, 1e-200, 0.0])
    def test_a_needle_is_no_nearer_or_farther_than_its_longest_side(self, height: float) -> None:
        random = np.random.default_rng(4)
        a, b, up = random.random((3, 3))
        up = np.cross(b - a, up)
        corners = np.array([a, b, a + 0.3 * (b - a) + height * up / np.linalg.norm(up)])
        asked = np.concatenate([random.random((500, 3)) * 3 - 1, a + random.random((500, 1)) * (b - a)])
        for turn in range(3):
            faces = np.roll(np.arange(3, dtype=np.int32), turn)[None]
            told = _core.distances(asked, corners, faces)
            side = _core.distances(asked, corners[:2], np.array([[0, 1, 1]], np.int32))
            assert np.all(told <= side + 2e-15)
            assert np.all(told >= side - height - 2e-15)

    def test_from_far_away_and_from_a_point_without_extent(self) -> None:
        dot = np.array([[1.0, 2.0, 3.0]]), np.zeros((1, 3), np.int32)
        asked = np.array([[1.0, 2.0, 3.0], [1e6 + 1.0, 2.0, 3.0]])
        assert _core.distances(asked, *dot).tolist() == [0.0, 1e6]

    def test_a_query_does_not_depend_on_its_neighbors(self, data) -> None:
        before, after = load_building(data)
        asked = collect_queries(before.points, before.faces)
        tree = _core.FaceTree(after.points, after.faces)
        order = np.random.default_rng(5).permutation(len(asked))
        assert tree.distances(asked)[order] == pytest.approx(tree.distances(asked[order]), abs=1e-14)
        assert np.array_equal(tree.distances(asked), tree.distances(asked))

    def test_farthest_is_the_greatest_unless_one_lies_beyond_the_limit(self) -> None:
        points, faces = box()
        tree = _core.FaceTree(points, faces)
        asked = np.array([[1.0, 1.0, 5.0], [1.0, 1.0, 90.0]])
        assert tree.farthest(asked, np.inf) == tree.farthest(asked, 88.0) == 88.0
        assert tree.farthest(asked, 1.0) in (3.0, 88.0)
        assert tree.farthest(asked[:0], 1.0) == 0.0

    def test_nothing_is_infinitely_far(self) -> None:
        assert _core.distances(np.zeros((1, 3)), np.zeros((0, 3)), np.zeros((0, 3), np.int32)).tolist() == [np.inf]

    def test_faces_out_of_range_are_refused(self) -> None:
        with pytest.raises(IndexError):
            _core.FaceTree(np.zeros((3, 3)), np.array([[0, 1, 3]], np.int32))

    def test_libigl_agrees_on_a_building(self, data) -> None:
        igl = pytest.importorskip("igl", reason="libigl is not installed")
        before, after = load_building(data)
        diagonal = np.linalg.norm(np.ptp(before.points, axis=0))
        for source, target in ((before, after), (after, before)):
            asked = collect_queries(source.points, source.faces)
            squared = igl.point_mesh_squared_distance(asked, target.points, target.faces)[0]
            told = _core.distances(asked, target.points, target.faces)
            assert told.max() > 0.01
            assert np.abs(told - np.sqrt(squared)).max() < 1e-9 * diagonal


class TestSamples:
    def test_they_are_on_the_surface_and_repeat(self) -> None:
        points, faces = open_cone()
        found = sample_surface(points, faces)
        assert np.array_equal(found, sample_surface(points, faces))
        assert found.shape == (SAMPLES, 3)
        assert _core.distances(found, points, faces).max() < 1e-15

    def test_they_are_spread_by_area(self) -> None:
        points = np.array([[0.0, 0, 0], [3, 0, 0], [0, 1, 0], [0, 0, 1]])
        found = sample_surface(points, np.array([[0, 1, 2], [0, 2, 3]], np.int32))
        assert np.mean(found[:, 2] == 0) == pytest.approx(0.75, abs=0.01)
        assert found[found[:, 2] == 0].mean(axis=0) == pytest.approx([1.0, 1 / 3, 0], abs=0.02)

    def test_without_area_there_are_none(self) -> None:
        assert len(sample_surface(np.zeros((3, 3)), np.array([[0, 1, 2]], np.int32))) == 0


class TestJudge:
    def test_it_looks_both_ways(self) -> None:
        whole = make_surface(box())
        open_ = make_surface((box()[0], box()[1][:-1]))
        assert Judge(whole).measure_deviation(make_surface(fine_box())) == 0.0
        assert Judge(whole).measure_deviation(open_) > 0.1
        assert Judge(open_).measure_deviation(whole) > 0.1
        assert Judge(whole).measure_deviation(PlacedSurface(np.zeros((0, 3)), np.zeros((0, 3), np.int32))) == np.inf

    @pytest.mark.parametrize("shift", FAR)
    def test_a_moved_roof_is_found_wherever_the_model_is(self, shift: float) -> None:
        points, faces = fine_box(shift=shift)
        raised = points + [0.0, 0.0, 0.25] * (points[:, 2:] == shift + 2.0)
        told = Judge(make_surface((points, faces))).measure_deviation(make_surface((raised, faces)))
        assert told <= 0.25
        assert told == pytest.approx(0.25, abs=1e-14)

    def test_a_limit_is_a_limit(self) -> None:
        points, faces = fine_box()
        judge = Judge(make_surface((points, faces)))
        raised = make_surface((points + [0.0, 0.0, 0.25] * (points[:, 2:] == 2.0), faces))
        assert judge.measure_within(raised, 0.25) == judge.measure_deviation(raised) == pytest.approx(0.25, abs=1e-14)
        assert 0.1 < judge.measure_within(raised, 0.1) <= 0.25

    def test_it_finds_what_lies_between_the_samples(self) -> None:
        """A spike so thin that no sample lies on it, between points that are all on the other surface."""
        points, faces = box()
        low, high = points.min(axis=0), points.max(axis=0)
        tip = [(low + high) / 2 + [0.0, 0.0, 2 * high[2]]]
        base = (low + high) / 2 + np.array([[-1e-9, 0.0, 0.0], [1e-9, 0.0, 0.0]])
        spiked = np.concatenate([points, base, tip]), np.concatenate([faces, [[8, 9, 10]]])
        found = Judge(make_surface((points, faces))).measure_deviation(make_surface(spiked))
        assert found == pytest.approx(Judge(make_surface(spiked)).measure_deviation(make_surface((points, faces))))
        assert found == pytest.approx(tip[0][2] - high[2])

    def test_a_ridge_of_the_original_between_the_points_of_both_is_found(self) -> None:
        """Two triangles that part a bent square along its one diagonal, and along the other one."""
        points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0.5], [0, 1, 0]])
        one = make_surface((points, [[0, 1, 2], [0, 2, 3]]))
        other = make_surface((points, [[0, 1, 3], [1, 2, 3]]))
        reach = [_core.distances(np.linspace(points[i], points[j], 20_001), side.points, side.faces).max()
                 for i, j, side in ((0, 2, other), (1, 3, one))]  # fmt: skip
        assert Judge(one).measure_deviation(other) == pytest.approx(max(reach), rel=1e-3)

    def test_a_hole_makes_borders_and_a_border_of_the_original_does_not(self) -> None:
        points, faces = fine_box()
        closed, holed = make_surface((points, faces)), make_surface((points, faces[2:]))
        assert len(find_open_edges(holed)) == 4
        assert Judge(closed).count_new_borders(holed, 10.0) == 4
        assert Judge(holed).count_new_borders(holed, 0.0) == 0
        assert Judge(holed).count_new_borders(closed, 0.0) == 0
        elsewhere = make_surface((points, np.concatenate([faces[:4], faces[6:]])))
        assert Judge(holed).count_new_borders(elsewhere, 0.0) > 0
        assert Judge(holed).count_new_borders(elsewhere, 5.0) == 0

    def test_an_edge_along_several_open_ones_is_theirs(self) -> None:
        points, faces = fine_box()
        upper = make_surface((points, faces[~np.all(points[faces][:, :, 2] == 0.0, axis=1)]))
        coarse_points, coarse_faces = box()
        coarse = make_surface(
            (coarse_points, coarse_faces[~np.all(coarse_points[coarse_faces][:, :, 2] == 0.0, axis=1)])
        )
        assert len(find_open_edges(coarse)) == 4
        assert Judge(upper).count_new_borders(coarse, 0.0) == 0

    def test_single_precision_blurs_by_its_spacing_about_the_middle(self) -> None:
        points, faces = round_to_single(fine_box(shift=5_000_000.0))
        judge = Judge(make_surface((points, faces)))
        assert judge.blur == 2.0 * np.spacing(np.float32(1.0))


def test_watertight_means_every_edge_has_two_faces() -> None:
    points, faces = box()
    assert is_watertight(make_surface((points, faces)))
    assert not is_watertight(make_surface((points, faces[1:])))
    assert not is_watertight(PlacedSurface(np.zeros((0, 3)), np.zeros((0, 3), np.int32)))


def test_only_edges_of_one_face_are_open() -> None:
    """Neither an edge of two faces that are turned against each other, nor one of three faces."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 0, 1]])
    for faces, count in (
        ([[0, 1, 2], [1, 2, 3]], 4),
        ([[0, 1, 2], [2, 1, 3]], 4),
        ([[0, 1, 2], [2, 1, 3], [1, 2, 4]], 6),
    ):
        edges = find_open_edges(make_surface((points, np.array(faces))))
        assert len(edges) == count
        assert [1, 2] not in np.sort(edges, axis=1).tolist()
