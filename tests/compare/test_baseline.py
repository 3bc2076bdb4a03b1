"""The baseline: points that fast-simplification needs for the same deviation."""

from __future__ import annotations

import pytest
from shapes import Gltf, fine_box, obj_text, open_cone

from bldsimp.compare.baseline import baseline_points
from bldsimp.io import read


def test_a_box_needs_no_more_than_its_corners_once_the_deviation_allows_it() -> None:
    scene = read(obj_text(*fine_box()).encode(), "obj")
    warnings: list[str] = []
    assert baseline_points(scene, 0.5, warnings) == pytest.approx(8, abs=8)
    assert warnings == []


def test_where_it_drops_nothing_that_is_told() -> None:
    scene = read(obj_text(*open_cone()).encode(), "obj")
    warnings: list[str] = []
    assert baseline_points(scene, 0.0, warnings) is None
    assert warnings == ["fast-simplification drops nothing within the same deviation"]


def test_a_mesh_that_is_placed_twice_counts_once() -> None:
    counts = []
    for places in (1, 2):
        gltf = Gltf()
        gltf.mesh(gltf.box(fine=True))
        for k in range(1, places):
            gltf.json["nodes"].append({"mesh": 0, "translation": [9.0 * k, 0.0, 0.0]})
            gltf.json["scenes"][0]["nodes"].append(k)
        counts.append(baseline_points(read(gltf.glb(), "glb"), 0.3, []))
    assert counts[0] is not None
    assert counts[0] == counts[1]
