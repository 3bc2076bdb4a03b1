"""The baseline and the distances behind it."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import box, fine_box, obj_text, open_cone

from bldsimp import _core
from bldsimp.baseline import baseline_points, samples, within
from bldsimp.io import read


def slow_distance(p: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> float:
    """Distance to a triangle: the least over a fine net of its points, from above."""
    steps = np.linspace(0, 1, 81)
    s, t = np.meshgrid(steps, steps)
    s, t = s[s + t <= 1 + 1e-9], t[s + t <= 1 + 1e-9]
    return float(np.linalg.norm(a + s[:, None] * (b - a) + t[:, None] * (c - a) - p, axis=1).min())


def test_farthest_agrees_with_a_slow_search() -> None:
    random = np.random.default_rng(3)
    points = random.random((30, 3))
    faces = random.integers(0, 30, (20, 3)).astype(np.int32)  # some repeat a point
    for query in random.random((20, 3)) * 2 - 0.5:
        told = _core.farthest(query[None], points, faces, np.inf)
        slow = min(slow_distance(query, *points[face]) for face in faces)
        assert slow - 0.03 <= told <= slow + 1e-12


def test_farthest_stops_beyond_the_limit() -> None:
    points, faces = box()
    queries = np.array([[1.0, 1.0, 5.0], [1.0, 1.0, 90.0]])
    assert _core.farthest(queries, points, faces, np.inf) == 88.0
    assert _core.farthest(queries, points, faces, 1.0) == 3.0


def test_within_looks_both_ways() -> None:
    points, faces = box()
    assert within((points, faces), fine_box(), 1e-12)
    assert not within((points, faces), (points, faces[:-1]), 0.1)
    assert not within((points, faces[:-1]), (points, faces), 0.1)


def test_samples_are_on_the_surface_and_repeat() -> None:
    points, faces = open_cone()
    found = samples(points, faces)
    assert np.array_equal(found, samples(points, faces))
    assert _core.farthest(found, points, faces, np.inf) < 1e-15


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
