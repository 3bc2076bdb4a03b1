"""The search: the fewest points within a deviation, and as many points as asked."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shapes import Gltf, box, fine_box, obj_text, open_cone

from bldsimp.compare.decimate import LEAST_TRIANGLES, Decimator, FastSimplification, count_baseline_points
from bldsimp.compare.measure import Judge
from bldsimp.compare.peers import FINEST
from bldsimp.compare.placement import PlacedSurface, weld_surface
from bldsimp.io import read


def make_faces_apart(count: int) -> PlacedSurface:
    """Faces that share no point."""
    rows = np.arange(3 * count)
    return weld_surface(
        np.stack([rows, rows % 3, rows % 2], axis=1).astype(float), rows.reshape(-1, 3).astype(np.int32)
    )


class TestDecimator:
    def test_runs_are_shared_between_limits(self) -> None:
        points, faces = fine_box(12)
        asked: list[int] = []
        tool = FastSimplification()

        def count(points, faces, target):
            asked.append(target)
            return tool(points, faces, target)

        start = weld_surface(points, faces)
        shared = Decimator(Judge(start), count)
        both = [shared.find_fewest_points(limit) for limit in (1e-3, 0.2, 1e-3)]
        alone = [Decimator(Judge(start), tool).find_fewest_points(limit) for limit in (1e-3, 0.2)]
        assert [len(found.surface.points) for found in both] == [len(alone[k].surface.points) for k in (0, 1, 0)]
        assert both[0].deviation == alone[0].deviation <= 1e-3
        repeated = len(asked) - len(set(asked))
        assert repeated <= 6

    def test_a_target_that_is_never_met_is_none(self) -> None:
        start = weld_surface(*open_cone())
        assert Decimator(Judge(start), FastSimplification()).find_fewest_points(0.0) is None

    def test_lossless_is_asked_once(self) -> None:
        calls: list[int] = []

        def one_result(points, faces, target):
            calls.append(target)
            return points[:0], faces[:0]

        start = weld_surface(*fine_box())
        assert Decimator(Judge(start), one_result, aimed=False).find_fewest_points(1.0) is None
        assert len(calls) == 1

    @pytest.mark.parametrize("points", [8, 40, 97, 98])
    def test_as_many_points_as_asked(self, points: int) -> None:
        start = weld_surface(*fine_box())
        found = Decimator(Judge(start), FastSimplification()).find_point_count(points)
        assert points <= len(found.surface.points) <= points + 1
        assert found.deviation == Judge(start).measure_deviation(found.surface)

    @pytest.mark.parametrize("points", [90, 300, 597])
    def test_a_tool_that_takes_a_length_is_asked_for_points_too(self, points: int) -> None:
        def longer_is_fewer(points, faces, target):
            return points, faces[: round(len(faces) * math.log(target) / math.log(FINEST))]

        found = Decimator(Judge(make_faces_apart(200)), longer_is_fewer, most=FINEST).find_point_count(points)
        assert points <= len(found.surface.points) <= points + 3

    def test_points_that_stay_the_same_for_many_targets_are_left_behind(self) -> None:
        def stops_early(points, faces, target):
            return points, faces[: max(target, 900)]

        found = Decimator(Judge(make_faces_apart(20_000)), stops_early).find_point_count(2_730)
        assert 2_730 <= len(found.surface.points) <= 2_760

    def test_no_fewer_points_than_the_tool_gives(self) -> None:
        start = weld_surface(*fine_box())
        found = Decimator(Judge(start), lambda points, faces, target: (points, faces)).find_point_count(20)
        assert len(found.surface.points) == 98


def test_the_least_target_is_a_box() -> None:
    assert len(box()[1]) == LEAST_TRIANGLES


def test_a_box_needs_no_more_than_its_corners_once_the_deviation_allows_it() -> None:
    scene = read(obj_text(*fine_box()).encode(), "obj")
    warnings: list[str] = []
    assert count_baseline_points(scene, 0.5, warnings) == pytest.approx(8, abs=8)
    assert warnings == []


def test_where_it_drops_nothing_that_is_told() -> None:
    scene = read(obj_text(*open_cone()).encode(), "obj")
    warnings: list[str] = []
    assert count_baseline_points(scene, 0.0, warnings) is None
    assert warnings == ["fast-simplification removes nothing within the same deviation"]


def test_a_mesh_that_is_placed_twice_counts_once() -> None:
    counts = []
    for places in (1, 2):
        gltf = Gltf()
        gltf.mesh(gltf.box(fine=True))
        for k in range(1, places):
            gltf.json["nodes"].append({"mesh": 0, "translation": [9.0 * k, 0.0, 0.0]})
            gltf.json["scenes"][0]["nodes"].append(k)
        counts.append(count_baseline_points(read(gltf.glb(), "glb"), 0.3, []))
    assert counts[0] is not None
    assert counts[0] == counts[1]
