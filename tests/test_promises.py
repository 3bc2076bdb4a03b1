"""What a run promises, on named shapes: judged by `judge`, which knows nothing of the program."""

from __future__ import annotations

from fractions import Fraction

import judge
import numpy as np
import pytest
import solids
from judged import find_broken, simplify_and_judge
from quick import defer
from solids import HARDER, SHAPES, Shape

import bldsimp

SHARES = (None, 0.0, 1e-6, 9e-6, 1e-3, 1e-2, 0.1)
"""Tolerances as shares of the diagonal; None is `auto`."""


def keep(mesh: Shape) -> Shape:
    return mesh


WAYS = [keep, solids.add_backs, solids.rotate]
WAYS += [harder for harder in HARDER.values() if harder not in WAYS]
"""Ways to make a shape harder; a quick run tries the first three."""


@pytest.mark.parametrize("harder", defer(WAYS, WAYS[3:]), ids=lambda make: make.__name__)
@pytest.mark.parametrize("make", SHAPES.values(), ids=SHAPES)
def test_every_shape_keeps_every_promise(make, harder) -> None:
    mesh = harder(make())
    for share in SHARES:
        case = simplify_and_judge(mesh, share=share)
        assert find_broken(case) == [], share


CORNERS = {
    "box": 8, "gabled_house": 10, "pyramid": 21, "frame": 16, "room_with_cavity": 16,
    "boxes_touching_in_a_point": 15, "boxes_touching_in_an_edge": 14, "inside_out_box": 8, "square": 4,
    "one_triangle": 3, "open_cone": 11,
    "plate_with_holes": 12, "pinched_plate": 11, "bow_tie": 5, "three_leaves": 8, "staircase": 26,
    "wall_between_two_rooms": 12,
}  # fmt: skip


@pytest.mark.parametrize("tolerance", [None, 0.0])
@pytest.mark.parametrize("name", CORNERS)
def test_corners_alone_stay(name: str, tolerance: float | None) -> None:
    mesh = solids.subdivide(SHAPES[name](), 2)
    case = simplify_and_judge(mesh, tolerance)
    assert len(case.after.points) == CORNERS[name]
    assert find_broken(case) == []


@pytest.mark.parametrize("change", [solids.add_backs, solids.unweld, solids.add_copies, solids.add_isolated_points])
@pytest.mark.parametrize("name", ["box", "gabled_house", "frame", "plate_with_holes", "open_cone"])
def test_corners_alone_stay_however_the_file_is_made(name: str, change) -> None:
    case = simplify_and_judge(change(solids.subdivide(SHAPES[name](), 2)))
    assert len(case.after.points) == CORNERS[name]
    assert find_broken(case) == []


# The same whatever the order


@pytest.mark.parametrize("harder", WAYS, ids=lambda make: make.__name__)
@pytest.mark.parametrize("make", SHAPES.values(), ids=SHAPES)
def test_order_does_not_matter(make, harder) -> None:
    mesh = harder(solids.subdivide(make()))
    first = simplify_and_judge(mesh)
    for seed in range(3):
        other = simplify_and_judge(solids.shuffle(mesh, seed))
        assert np.array_equal(first.result[0], other.result[0])
        assert judge.collect_triangles(first.after) == judge.collect_triangles(other.after)


@pytest.mark.parametrize("make", SHAPES.values(), ids=SHAPES)
def test_same_bytes_from_run_to_run(make) -> None:
    mesh = solids.add_noise(solids.rotate(solids.subdivide(make(), 2)), 1e-3)
    first, second = (bldsimp.simplify(mesh, 1e-2).mesh for _ in range(2))
    assert [a.tobytes() for a in first] == [a.tobytes() for a in second]


# Winding


def test_inside_out_box_is_turned_and_reported() -> None:
    case = simplify_and_judge(solids.subdivide(solids.inside_out_box()))
    assert judge.compute_volumes(case.after) == pytest.approx([1.0])
    assert case.report.reversed_faces == 48


def test_one_of_two_boxes_is_turned() -> None:
    mesh = solids.merge(solids.box(), solids.reverse_winding(solids.box(at=(5, 0, 0))))
    case = simplify_and_judge(mesh)
    assert judge.compute_volumes(case.after) == pytest.approx([1.0, 1.0])
    assert case.report.reversed_faces == 12


def test_a_cavity_is_not_turned() -> None:
    case = simplify_and_judge(solids.subdivide(solids.room_with_cavity()))
    assert sorted(judge.compute_volumes(case.after)) == pytest.approx([-8.0, 64.0])
    assert case.report.reversed_faces == 0


def test_boxes_in_boxes_are_turned_by_how_many_enclose_them() -> None:
    """All inside out, on one axis and with faces in common planes: every second one is a cavity, and right."""
    boxes = [solids.reverse_winding(solids.box((size,) * 3, ((9 - size) / 2,) * 3)) for size in range(9, 0, -2)]
    beside = solids.reverse_winding(solids.box((9, 9, 9), (9, 0, 0)))
    case = simplify_and_judge(solids.merge(*boxes, beside))
    assert case.report.reversed_faces == 12 * 4
    assert find_broken(case) == []


def test_a_comb_keeps_its_corners_and_no_more() -> None:
    """So many teeth that its outline is cut in the middle too."""
    x = np.arange(200.0)
    teeth = np.c_[x, np.where(np.arange(200) % 2, 1.0, 9.0)]
    corners = np.concatenate([teeth[::-1], [(0.0, 0.0), (199.0, 0.0)]])
    outline = np.stack([corners, (corners + np.roll(corners, -1, axis=0)) / 2], axis=1).reshape(-1, 2)
    i = np.arange(len(outline))
    cut = bldsimp.triangulate(outline, np.stack([i, (i + 1) % len(outline)], axis=1))
    case = simplify_and_judge((np.c_[cut.points, np.zeros(len(cut.points))], cut.triangles))
    assert case.report.after.points == len(corners)
    assert find_broken(case) == []


def test_points_that_stay_where_sheets_meet_are_told() -> None:
    """The two sides of a party wall, cut along different diagonals, share points and some edges."""
    case = simplify_and_judge(solids.subdivide(solids.rooms_back_to_back()))
    assert case.report.contact_points == case.report.after.points - 12 == 5
    one_wall = simplify_and_judge(solids.subdivide(solids.wall_between_two_rooms()))
    assert one_wall.report.contact_points == one_wall.report.after.points - 12 == 0


def test_many_sheets_round_one_edge_keep_their_points() -> None:
    angle = np.linspace(0.0, 6.0, 90)
    rim = np.stack([np.cos(angle), np.sin(angle), np.full(90, 0.5)], axis=1)
    pages = solids.shape([(0, 0, 0), (0, 0, 1), *rim], [(0, 1, i + 2) for i in range(90)])
    case = simplify_and_judge(solids.subdivide(pages))
    assert case.report.after.points == 92
    assert find_broken(case) == []


def test_an_outer_wall_is_turned_round_its_cavity() -> None:
    mesh = solids.merge(
        solids.reverse_winding(solids.box((4, 4, 4))),
        solids.reverse_winding(solids.box((2, 2, 2), (1, 1, 1))),
    )
    case = simplify_and_judge(mesh)
    assert sorted(judge.compute_volumes(case.after)) == pytest.approx([-8.0, 64.0])
    assert case.report.reversed_faces == 12


@pytest.mark.parametrize("name", ["open_cone", "plate_with_holes", "staircase", "gabled_house", "box"])
def test_a_few_turned_faces_are_turned_back(name: str) -> None:
    points, faces = solids.subdivide(SHAPES[name](), 2)
    turned = faces.copy()
    turned[3::17] = turned[3::17, ::-1]
    case = simplify_and_judge((points, turned))
    assert judge.count_topology(case.after).clashing == 0
    assert case.report.reversed_faces == len(turned[3::17])
    assert judge.collect_triangles(case.after) == judge.collect_triangles(simplify_and_judge((points, faces)).after)


def test_moebius_band_is_left_as_it_is() -> None:
    mesh = solids.moebius()
    case = simplify_and_judge(solids.subdivide(mesh))
    assert 0 < judge.count_topology(case.after).clashing <= judge.count_topology(case.before).clashing
    assert case.report.reversed_faces == 0


@pytest.mark.parametrize("make", SHAPES.values(), ids=SHAPES)
@pytest.mark.parametrize("harder", [keep, solids.add_backs, solids.rotate], ids=lambda make: make.__name__)
def test_every_face_still_looks_the_same_way(make, harder) -> None:
    case = simplify_and_judge(harder(solids.subdivide(make())))
    if case.report.reversed_faces:
        pytest.skip("faces were turned on purpose")
    within = case.report.tolerance + judge.estimate_blur(case.before)
    assert judge.count_facing_away(case.before, case.after, within) == 0
    assert judge.count_facing_away(case.after, case.before, within) == 0


# T-junctions


def test_a_t_junction_heals_and_is_reported() -> None:
    case = simplify_and_judge(solids.t_junction_wall())
    assert (case.report.healed_t_junctions, len(case.after.points)) == (1, 6)
    assert judge.count_topology(case.after).open_edges == 6
    assert find_broken(case) == []


def test_a_face_without_area_that_closes_a_t_junction_goes_with_its_point() -> None:
    case = simplify_and_judge(solids.closed_t_junction_wall())
    assert len(case.after.points) == 4
    assert find_broken(case) == []


def test_three_leaves_keep_their_common_edge() -> None:
    case = simplify_and_judge(solids.subdivide(solids.three_leaves(), 2))
    assert judge.count_topology(case.after).nonmanifold_edges == 1


# Never worse


@pytest.mark.parametrize("share", [0.1, 0.5, 1.0, 10.0])
@pytest.mark.parametrize("make", SHAPES.values(), ids=SHAPES)
def test_never_empty_nor_worse_at_any_tolerance(make, share: float) -> None:
    case = simplify_and_judge(solids.subdivide(make()), share=share)
    assert find_broken(case) == []
    assert len(case.after.faces) > 0


@pytest.mark.parametrize("make", SHAPES.values(), ids=SHAPES)
def test_a_second_run_drops_nothing(make) -> None:
    once = simplify_and_judge(solids.subdivide(make(), 2), 0.0)
    if once.report.healed_t_junctions:
        pytest.skip("what healed lies in one plane now")
    twice = simplify_and_judge(once.result, 0.0)
    assert judge.collect_positions(twice.after) == judge.collect_positions(once.after)
    assert judge.collect_triangles(twice.after) == judge.collect_triangles(once.after)


# Exactly coplanar, exactly collinear


@pytest.mark.parametrize("shift", [np.inf, -np.inf])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_tolerance_zero_sees_the_last_bit(axis: int, shift: float) -> None:
    points, faces = solids.move(solids.subdivide(solids.box(), 2), (1, 1, 1))
    assert len(simplify_and_judge((points, faces), 0.0).after.points) == 8
    at = int(np.flatnonzero((points == [1.25, 1.5, 2.0]).all(axis=1))[0])
    points = points.copy()
    points[at, axis] = np.nextafter(points[at, axis], shift)
    case = simplify_and_judge((points, faces), 0.0)
    assert (points[at].tobytes() in judge.collect_positions(case.after)) == (axis == 2)
    assert find_broken(case) == []


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_tolerance_zero_sees_the_last_bit_along_an_edge(axis: int) -> None:
    points, faces = solids.move(solids.subdivide(solids.box(), 2), (1, 1, 1))
    at = int(np.flatnonzero((points == [1.5, 2.0, 2.0]).all(axis=1))[0])
    points = points.copy()
    points[at, axis] = np.nextafter(points[at, axis], 0.0)
    case = simplify_and_judge((points, faces), 0.0)
    assert (points[at].tobytes() in judge.collect_positions(case.after)) == (axis != 0)
    assert find_broken(case) == []


def make_fractions(point: np.ndarray) -> tuple[Fraction, ...]:
    return tuple(Fraction(float(x)) for x in point)


def is_inside(point: np.ndarray, corners: np.ndarray) -> bool:
    """Whether a point lies in a triangle, by exact arithmetic."""
    p, a, b, c = (np.array(make_fractions(q), object) for q in (point, *corners))
    normal = np.cross(b - a, c - a)
    if normal @ (p - a) != 0:
        return False
    ways = [normal @ np.cross(v - u, p - u) for u, v in ((a, b), (b, c), (c, a))]
    return all(way >= 0 for way in ways) and any(normal)


@pytest.mark.parametrize("make", SHAPES.values(), ids=SHAPES)
def test_tolerance_zero_drops_only_what_lies_exactly_in_the_result(make) -> None:
    for mesh in (solids.subdivide(make()), solids.rotate(solids.subdivide(make()))):
        case = simplify_and_judge(mesh, 0.0)
        kept = judge.collect_positions(case.after)
        for point in case.before.points:
            if point.tobytes() in kept:
                continue
            near = (case.after.corners.min(axis=1) <= point) & (point <= case.after.corners.max(axis=1))
            assert any(is_inside(point, corners) for corners in case.after.corners[near.all(axis=1)])


# The same shape in another place


CHANGES = {
    "mirrored": lambda mesh: (mesh[0] * [-1, 1, 1], mesh[1][:, ::-1]),
    "axes permuted": lambda mesh: (mesh[0][:, [1, 2, 0]], mesh[1]),
    "axes swapped": lambda mesh: (mesh[0][:, [1, 0, 2]], mesh[1][:, ::-1]),
    "enlarged": lambda mesh: (mesh[0] * 2.0**10, mesh[1]),
    "shrunk": lambda mesh: (mesh[0] * 2.0**-20, mesh[1]),
    "moved": lambda mesh: (mesh[0] + [3, -17, 256], mesh[1]),
    "on the map": lambda mesh: (mesh[0] + [500_000, 5_000_000, 0], mesh[1]),
    "subdivided": solids.subdivide,
}


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("name", CORNERS)
def test_a_changed_shape_keeps_its_counts(name: str, change: str) -> None:
    mesh = solids.subdivide(SHAPES[name]())
    before, after = simplify_and_judge(mesh, 0.0), simplify_and_judge(CHANGES[change](mesh), 0.0)
    assert (len(after.after.points), len(after.after.faces)) == (
        len(before.after.points),
        len(before.after.faces),
    )
    assert find_broken(after) == []


@pytest.mark.parametrize("name", ["box", "gabled_house", "frame", "staircase", "plate_with_holes"])
@pytest.mark.parametrize("degrees", [1.0, 21.0, 77.7])
def test_a_turned_shape_keeps_its_counts_within_rounding(name: str, degrees: float) -> None:
    mesh = solids.round_to_single(solids.rotate(solids.subdivide(SHAPES[name](), 2), degrees))
    case = simplify_and_judge(mesh)
    assert len(case.after.points) == CORNERS[name]
    assert 0 < case.report.deviation <= case.report.tolerance
    assert find_broken(case, 2000) == []


@pytest.mark.parametrize("size", [1e-4, 1e-3])
@pytest.mark.parametrize("name", ["box", "gabled_house", "frame", "staircase", "plate_with_holes"])
def test_noise_under_the_tolerance_goes_and_above_it_stays(name: str, size: float) -> None:
    mesh = solids.add_noise(solids.subdivide(SHAPES[name](), 2), size)
    rough, fine = simplify_and_judge(mesh, 8 * size), simplify_and_judge(mesh, size / 100)
    assert len(rough.after.points) < len(rough.before.points) / 2 + CORNERS[name]
    assert len(fine.after.points) > 0.9 * len(fine.before.points)
    assert find_broken(rough) == find_broken(fine) == []


def rough_ground(count: int, height: float, seed: int) -> solids.Shape:
    """A grid of `count` squared points, one apart, each at a random height up to `height` either way."""
    x, y = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    heights = np.random.default_rng(seed).uniform(-height, height, count**2)
    rows = np.arange(count**2).reshape(count, count)
    a, b, c, d = (part.reshape(-1) for part in (rows[:-1, :-1], rows[1:, :-1], rows[1:, 1:], rows[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return solids.shape(np.c_[x.reshape(-1), y.reshape(-1), heights], faces)


@pytest.mark.parametrize("seed", range(3))
def test_another_cut_of_a_rough_surface_is_not_worth_a_few_points(seed: int) -> None:
    once = simplify_and_judge(rough_ground(16, 1e-4, seed), 1e-4)
    twice = simplify_and_judge(once.result, 1e-4)
    assert len(once.after.points) < 0.9 * 256
    assert len(twice.after.points) >= 0.99 * len(once.after.points)
    assert twice.report.fallback_reasons["little_gain"] > 0
