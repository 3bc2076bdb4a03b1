"""The triangulation core: named shapes, crossings, errors; `checked` ends every test in `validate`."""

from __future__ import annotations

import numpy as np
import pytest
from planar import SQUARE, check, compute_area, ring, rings

from bldsimp import InputError, TopologyError, _core, triangulate
from bldsimp.errors import InternalError
from bldsimp.triangulation import Triangulation

# Named shapes.


def test_square_with_a_hole():
    result = check(*rings(SQUARE, [(1, 1), (3, 1), (3, 3), (1, 3)]))
    assert len(result.triangles) == 8
    assert compute_area(result) == 12.0


def test_island_in_a_hole():
    result = check(*rings(SQUARE, [(1, 1), (3, 1), (3, 3), (1, 3)], [(1.5, 1.5), (2.5, 1.5), (2.5, 2.5), (1.5, 2.5)]))
    assert compute_area(result) == 13.0


def test_slit_bounds_nothing():
    """A ring that runs to its hole and back along one segment."""
    points = [*SQUARE, (1, 1), (3, 1), (3, 3), (1, 3)]
    result = check(points, [*ring(0, 4), *ring(4, 4), (0, 4), (4, 0)])
    assert compute_area(result) == 12.0
    assert [0, 4] in result.segments.tolist()


def test_holes_that_share_an_edge_are_one_hole():
    points = [(0, 0), (6, 0), (6, 6), (0, 6), (1, 1), (3, 1), (3, 3), (1, 3), (5, 1), (5, 3)]
    segments = [*ring(0, 4), *ring(4, 4), (5, 8), (8, 9), (9, 6), (6, 5)]
    result = check(points, segments)
    assert compute_area(result) == 36.0 - 8.0


def test_open_chain_bounds_nothing():
    result = check([*SQUARE, (1, 1), (2, 3)], [*ring(0, 4), (4, 5)])
    assert compute_area(result) == 16.0
    assert check(SQUARE, [(0, 1), (1, 2)]).triangles.shape == (0, 3)


def test_wall_across_a_ring_leaves_both_rooms():
    result = check(SQUARE, [*ring(0, 4), (0, 2)])
    assert compute_area(result) == 16.0


def test_point_on_a_segment_splits_it():
    result = check([*SQUARE, (2, 0)], ring(0, 4))
    assert result.segments[:2].tolist() == [[0, 4], [4, 1]]
    assert result.input_segment.tolist() == [0, 0, 1, 2, 3]


def test_overlapping_segments_share_pieces():
    points = [(0, 0), (1, 0), (2, 0), (3, 0), (0, 1)]
    result = check(points, [(0, 2), (3, 1)], carve=False)
    assert result.segments.tolist() == [[0, 1], [1, 2], [3, 2], [2, 1]]
    assert result.input_segment.tolist() == [0, 0, 1, 1]


def test_duplicates_map_to_the_lowest_index():
    result = check([*SQUARE, (0, 0), (4.0, 4.0), (-0.0, 0.0)], [(4, 1), (1, 5), (2, 3), (3, 6), (2, 5)])
    assert result.point_of_input.tolist() == [0, 1, 2, 3, 0, 2, 0]
    assert result.segments.tolist() == [[0, 1], [1, 2], [2, 3], [3, 0]]
    assert compute_area(result) == 16.0


@pytest.mark.parametrize("points", [[], [(1, 2)], [(0, 0)] * 4, [(0, 0), (1, 1), (2, 2), (5, 5)]])
def test_nothing_to_triangulate(points):
    segments = [(0, len(points) - 1)] if points else []
    for carve in (True, False):
        result = check(points, segments, carve=carve)
        assert result.triangles.shape == result.neighbors.shape == (0, 3)
        assert result.triangles.dtype == result.neighbors.dtype == np.int32


def test_without_segments():
    assert len(check(SQUARE, []).triangles) == 0
    assert len(check(SQUARE, [], carve=False).triangles) == 2


def test_cocircular_ties_go_to_the_least_point():
    circle = [
        (5, 0),
        (4, 3),
        (3, 4),
        (0, 5),
        (-3, 4),
        (-4, 3),
        (-5, 0),
        (-4, -3),
        (-3, -4),
        (0, -5),
        (3, -4),
        (4, -3),
    ]
    result = check(circle, [], carve=False)
    assert all(6 in triangle for triangle in result.triangles)


def test_neighbors_lie_opposite_their_corner():
    result = check([(0, 0), (2, 0), (0, 2), (2, 2.5)], [], carve=False)
    for row, triangle in enumerate(result.triangles):
        for corner, other in enumerate(result.neighbors[row]):
            if other >= 0:
                assert triangle[corner] not in result.triangles[other]


# Work that must not grow with the square of the input.


def along_a_segment(count: int, bend: float) -> tuple[np.ndarray, list[tuple[int, int]]]:
    """One segment between two rows of points that bend towards it or away from it."""
    x = np.linspace(0.0, 1.0, count // 2)
    y = 0.3 + bend * x * (1.0 - x)
    return np.concatenate([np.c_[x, y], np.c_[x, -y], [(-1.0, 1e-9), (2.0, -1e-9)]]), [(count, count + 1)]


@pytest.mark.parametrize("bend", [-1.0, 1.0])
def test_a_segment_past_many_points_takes_few_swaps(bend):
    points, segments = along_a_segment(4000, bend)
    result = check(points, segments, carve=False)
    assert result.statistics.flips < 20 * len(points)


def test_an_influence_domain_that_holds_other_segments():
    """Spikes point at the segment from both sides: its rim runs up and down along them."""
    rng = np.random.default_rng(5)
    points = rng.random((3000, 2)) * [1.0, 1e-3] + [0.0, 1e-4]
    points[::2, 1] *= -1.0
    spikes = np.c_[np.linspace(0.01, 0.99, 40), np.full(40, 5e-5)]
    roots = spikes * [1.0, 10.0]
    roots[::2, 1] *= -1.0
    spikes[::2, 1] *= -1.0
    segments = [(3000 + i, 3040 + i) for i in range(40)]
    together = np.concatenate([points, spikes, roots, [(-1.0, 0.0), (2.0, 0.0)]])
    at_once = check(together, [*segments, (3080, 3081)], carve=False)
    assert np.isin([3080, 3081], at_once.segments[-1]).all()
    assert len(at_once.segments) == 41


# Crossings.


def test_crossing_names_both_segments():
    with pytest.raises(TopologyError, match="segments 1 and 3 cross") as caught:
        triangulate([*SQUARE, (9, 9)], [(0, 1), (0, 2), (1, 2), (1, 3)])
    assert caught.value.segments == (1, 3)


def test_crossing_is_split_when_asked():
    result = check(SQUARE, [(0, 2), (1, 3)], carve=False, split_crossings=True)
    assert result.points[4].tolist() == [2.0, 2.0]
    assert result.segments.tolist() == [[0, 4], [4, 2], [1, 4], [4, 3]]


def test_bow_tie_split():
    result = check([(0, 0), (4, 4), (4, 0), (0, 4)], ring(0, 4), split_crossings=True)
    assert compute_area(result) == 8.0


@pytest.mark.parametrize("seed", range(6))
def test_many_crossings_end(seed):
    """Pencils of lines through nearly one point: rounding piles the crossings on each other."""
    rng = np.random.default_rng(seed)
    angle = rng.random(24) * np.pi
    arm = np.c_[np.cos(angle), np.sin(angle)] * rng.integers(1, 9, (24, 1))
    center = rng.normal(size=2) + rng.integers(-2, 3, (24, 1)) * 2.0**-51
    points = np.concatenate([center - arm, center + arm])
    result = check(points, [(i, i + 24) for i in range(24)], carve=False, split_crossings=True)
    assert len(result.points) < len(points) + 24 * 24


@pytest.mark.parametrize("seed", range(8))
def test_many_crossings_of_nearly_parallel_segments_end(seed):
    """A bundle a few units in the last place wide, where each bend would make new crossings."""
    rng = np.random.default_rng(seed)
    width = rng.random((2, 40)) * 1e-12
    angle = rng.random() * 6
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    points = np.stack([np.repeat([0.0, 1.0], 40), width.ravel()], axis=1) @ turn + 1e3 * (seed % 2)
    result = check(points, [(i, i + 40) for i in range(40)], carve=False, split_crossings=True)
    assert len(result.points) < len(points) + 40 * 39 / 2


@pytest.mark.parametrize("seed", range(8))
def test_segments_between_neighboring_doubles(seed):
    rng = np.random.default_rng(seed)
    points = rng.random(2) + rng.integers(-6, 7, (60, 2)) * 2.0**-53 * rng.choice([1, 2, 8], (60, 1))
    check(points, np.arange(60).reshape(-1, 2), carve=False, split_crossings=True)


def test_segments_that_meet_in_a_point_do_not_cross():
    result = check([*SQUARE, (2, 2)], [(0, 2), (1, 3)], carve=False)
    assert result.segments.tolist() == [[0, 4], [4, 2], [1, 4], [4, 3]]


# Validation finds what is wrong.


def broken(**changes) -> Triangulation:
    result = triangulate([(0, 0), (4, 0), (9, 9), (0, 4)], ring(0, 4))
    values = {name: np.copy(value) if isinstance(value, np.ndarray) else value for name, value in vars(result).items()}
    return Triangulation(**{**values, **{name: change(values[name]) for name, change in changes.items()}})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"triangles": lambda t: t[:, ::-1]}, "not counter-clockwise|neighbor"),
        ({"triangles": lambda t: t + 2}, "out of range"),
        ({"neighbors": lambda n: np.roll(n, 1, axis=0)}, "neighbor"),
        ({"points": lambda p: np.where(p == 9, 3, p)}, "not Delaunay"),
        ({"points": lambda p: np.where(p == 9, 4, p)}, "tie"),
        ({"input_segment": lambda s: s[::-1]}, "order"),
        ({"constraints": lambda c: c[:, ::-1]}, "one piece"),
        ({"triangles": lambda t: t[:-1], "neighbors": lambda n: n[:-1]}, "neighbor"),
        ({"segments": lambda s: s[:-1], "input_segment": lambda s: s[:-1]}, "without pieces"),
    ],
)
def test_validate_finds(changes, message):
    broken().validate()
    with pytest.raises(InternalError, match=message):
        broken(**changes).validate()


# Input that is refused.


@pytest.mark.parametrize(
    ("points", "segments", "message"),
    [
        ([(0, 0, 0)], [], r"shape \(1, 3\)"),
        ([(0, 0), (1, float("nan")), (float("inf"), 0)], [], "not finite: 1, 2"),
        (["ab", "cd"], [], "not numbers"),
        (SQUARE, [(0, 1, 2)], r"shape \(1, 3\)"),
        (SQUARE, [(0, 1.5)], "not integers"),
        (SQUARE, [(0, 1), (0, 4), (-1, 2)], "outside the 4 points: 1, 2"),
        (SQUARE, np.array([(0, 4)], np.int32), "outside the 4 points: 0"),
        (SQUARE, [(0, 2**32)], "outside the 4 points: 0"),
        ([(float("nan"), 0)] * 12, [], "8, 9 and 2 more"),
    ],
)
def test_bad_input(points, segments, message):
    with pytest.raises(InputError, match=message):
        triangulate(points, segments)


# Polygons of files; their outlines are tested beside the kernels.


def test_polygons():
    points = np.array([(0, 0, 0), (4, 0, 0), (1, 1, 0), (0, 4, 0), (9, 9, 9)], float)
    offsets, corners = np.array([0, 3, 7]), np.array([0, 1, 4, 1, 2, 3, 0], np.int32)
    faces, polygon_of_face = _core.triangulate_polygons(points, offsets, corners)
    assert polygon_of_face.tolist() == [0, 1, 1]
    assert faces[0].tolist() == [0, 1, 4]
    assert {frozenset(face) for face in faces[1:].tolist()} == {frozenset({0, 1, 2}), frozenset({0, 2, 3})}


@pytest.mark.parametrize("offsets", [[0, 2], [0, 4], [1, 0, 3], [-1, 3]])
def test_polygons_out_of_range(offsets):
    with pytest.raises(IndexError):
        _core.triangulate_polygons(np.zeros((2, 3)), np.array(offsets), np.array([0, 1, 2], np.int32))
