"""A fair comparison: every method gets the same input, limit and measure."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from comparisons import METHODS, NOT_MET, compare_data, find_row
from shapes import FAR, Gltf, box, fine_box, obj_text, open_cone, write

from bldsimp import simplify
from bldsimp.compare.decimate import RefusalError
from bldsimp.compare.measure import Judge
from bldsimp.compare.peers import Peer
from bldsimp.compare.placement import PlacedSurface
from bldsimp.compare.rows import VARIANTS, Comparison, compare_file, list_methods
from bldsimp.compare.table import format_csv
from bldsimp.errors import UsageError


@pytest.fixture
def house(tmp_path: Path) -> Path:
    return write(tmp_path / "house.obj", obj_text(*fine_box()))


@pytest.fixture
def data_comparisons(data: Path) -> list[Comparison]:
    return compare_data(data)


class TestFairness:
    def test_each_tolerance_has_every_method_in_its_order(self, data_comparisons: list[Comparison]) -> None:
        assert list_methods([]) == METHODS
        for comparison in data_comparisons:
            assert [row.method for row in comparison.rows] == 2 * METHODS
            assert [row.tolerance for row in comparison.rows] == ["auto"] * 7 + ["0.1%"] * 7
            assert comparison.tolerances["0.1%"] == pytest.approx(1e-3 * comparison.diagonal)

    def test_improved_is_what_simplify_does_and_never_more_than_standard(
        self, data_comparisons: list[Comparison]
    ) -> None:
        for comparison in data_comparisons:
            original = comparison.original
            for text, tolerance in comparison.tolerances.items():
                improved = find_row(comparison, "improved", text)
                simplified = simplify((original.points, original.faces), tolerance)
                assert (improved.points, improved.triangles) == (len(simplified.mesh[0]), len(simplified.mesh[1]))
                assert improved.bound == pytest.approx(simplified.report.deviation)
                assert improved.points <= find_row(comparison, "standard", text).points
                assert improved.points < improved.triangles < find_row(comparison, "original", text).triangles

    def test_the_bound_is_not_below_the_deviation_which_is_within_the_tolerance(
        self, data_comparisons: list[Comparison]
    ) -> None:
        for comparison in data_comparisons:
            for one in comparison.rows:
                if one.method == "improved":
                    assert 0.0 < one.deviation <= one.bound <= comparison.tolerances[one.tolerance]
                if one.method == "standard":
                    assert one.deviation <= comparison.tolerances[one.tolerance]

    def test_every_row_is_measured_alike(self, data_comparisons: list[Comparison]) -> None:
        for comparison in data_comparisons:
            judge = Judge(comparison.original)
            for one in comparison.rows[7:]:
                if one.surface is None:
                    assert one.note.startswith(NOT_MET)
                    continue
                assert one.deviation == (0.0 if one.method == "original" else judge.measure_deviation(one.surface))
                assert (one.points, one.triangles) == (len(one.surface.points), len(one.surface.faces))

    def test_decimators_stay_within_the_deviation_of_improved_or_have_its_points(
        self, data_comparisons: list[Comparison]
    ) -> None:
        met = 0
        for comparison in data_comparisons:
            judge = Judge(comparison.original)
            for text in comparison.tolerances:
                improved = find_row(comparison, "improved", text)
                for method in VARIANTS:
                    one = find_row(comparison, method, text)
                    if one.points is not None:
                        assert one.deviation <= improved.deviation + judge.blur
                        met += 1
                same = find_row(comparison, METHODS[-1], text)
                assert improved.points <= same.points <= 1.01 * improved.points + 1
                assert same.deviation > improved.deviation
        assert met > 4

    def test_statistics_are_there_for_the_two_that_triangulate(self, data_comparisons: list[Comparison]) -> None:
        for one in data_comparisons[1].rows:
            assert bool(one.statistics) == (one.method in ("standard", "improved"))
        standard, improved = (
            find_row(data_comparisons[1], method, "auto").statistics for method in ("standard", "improved")
        )
        assert standard["by_poles"] == 0 < improved["by_poles"]
        assert min(improved[name] for name in ("by_determinant", "located", "walked", "flips")) > 0

    @pytest.mark.parametrize("shift", FAR)
    def test_map_coordinates_measure_as_well(self, tmp_path: Path, shift: float) -> None:
        path = write(tmp_path / "far.obj", obj_text(*fine_box(shift=shift)))
        comparison = compare_file(path, "obj", "far", ["0"])
        improved = find_row(comparison, "improved", "0")
        assert (improved.points, improved.deviation, improved.border_made) == (8, pytest.approx(0.0, abs=1e-14), 0)

    def test_all_instances_are_compared_mirrored_ones_too(self, tmp_path: Path) -> None:
        gltf = Gltf()
        gltf.mesh(gltf.box(fine=True))
        gltf.json["nodes"].append({"mesh": 0, "translation": [9.0, 0.0, 0.0], "scale": [-1.0, 1.0, 1.0]})
        gltf.json["scenes"][0]["nodes"].append(1)
        comparison = compare_file(write(tmp_path / "two.glb", gltf.glb()), "glb", "two", ["auto"])
        assert [one.points for one in comparison.rows[:3]] == [2 * 98, 16, 16]
        assert find_row(comparison, "improved", "auto").watertight

    def test_attributes_are_not_regarded(self, tmp_path: Path) -> None:
        gltf = Gltf()
        colors = gltf.accessor(np.ones((98, 3)))
        gltf.mesh(gltf.box(fine=True, COLOR_0=colors))
        comparison = compare_file(write(tmp_path / "red.glb", gltf.glb()), "glb", "red", ["auto"])
        assert find_row(comparison, "improved", "auto").points == 8

    @pytest.mark.parametrize("shape", [([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]), open_cone(3), box()])
    def test_shapes_smaller_than_the_least_target(self, tmp_path: Path, shape) -> None:
        comparison = compare_file(write(tmp_path / "tiny.obj", obj_text(*shape)), "obj", "tiny", ["auto"])
        assert not comparison.failed
        improved = find_row(comparison, "improved", "auto")
        assert improved.points == len(shape[0])
        assert improved.border_made == 0


class TestNotMet:
    def test_it_is_told_instead_of_a_number(self, tmp_path: Path) -> None:
        comparison = compare_file(write(tmp_path / "cone.obj", obj_text(*open_cone())), "obj", "cone", ["auto"])
        for method in ("fast-simplification", "fast-simplification border"):
            one = find_row(comparison, method, "auto")
            assert one.note.startswith("no reduction within the same deviation as improved")
            assert (one.points, one.triangles, one.deviation, one.seconds) == (None,) * 4
        line = format_csv([comparison]).splitlines()[4]
        assert line.startswith("cone,auto,fast-simplification,,,,,,,,no reduction within")

    def test_a_peer_that_refuses(self, house: Path) -> None:
        def refuse(module, points, faces, target):
            raise RefusalError("not to its taste")

        comparison = compare_file(house, "obj", "house", ["auto"], [Peer("json", refuse)])
        one = comparison.rows[-1]
        assert (one.method, one.points, one.note) == ("json", None, "refuses the input: not to its taste")

    def test_borders_that_are_torn_are_counted(self, house: Path) -> None:
        def tear(module, points, faces, target):
            return points, faces[2:]

        comparison = compare_file(house, "obj", "house", ["1"], [Peer("json", tear)])
        assert find_row(comparison, "original", "1").border_made == 0
        torn = Judge(comparison.original).count_new_borders(
            PlacedSurface(comparison.original.points, comparison.original.faces[2:]), 1e-3
        )
        assert torn == 4


def test_a_wrong_tolerance_is_refused(house: Path) -> None:
    with pytest.raises(UsageError):
        compare_file(house, "obj", "house", ["much"])


@pytest.mark.slow
def test_models_have_no_more_points_than_the_standard_method_leaves(models: Path) -> None:
    for path in ("city/derived_val3dity_fzk_haus.obj", "exact/vcity_tour_part_dieu.obj"):
        comparison = compare_file(models / path, "obj", path, ["auto", "0.1%"])
        assert not comparison.failed
        for text, tolerance in comparison.tolerances.items():
            improved = find_row(comparison, "improved", text)
            assert improved.points <= find_row(comparison, "standard", text).points
            assert improved.deviation <= improved.bound <= tolerance
