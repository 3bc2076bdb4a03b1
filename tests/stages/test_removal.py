"""What goes as a whole: bodies that the rest holds, and components smaller than asked for."""

from __future__ import annotations

import itertools

import judge
import numpy as np
import pytest
import solids
from judged import Verdict, simplify_and_judge
from quick import defer
from solids import Shape

from bldsimp import _core
from bldsimp.model import Attribute, Mesh, Part, Scene
from bldsimp.options import Options, Tolerance
from bldsimp.pipeline import simplify_mesh
from bldsimp.scene import simplify_scene
from bldsimp.stages.removal import find_redundant_bodies


def wall(thickness: float = 0.3) -> Shape:
    return solids.box((4, thickness, 3))


def sheet(at: float = 0.0, size: float = 4.0) -> Shape:
    """A square across y."""
    points, faces = solids.square()
    return solids.shape(points[:, [0, 2, 1]] * size + (0, at, 0), faces)


def apart(case: Verdict) -> float:
    return judge.measure_deviation(case.before, case.after, 1000)


def well_done(case: Verdict) -> bool:
    """Within the bound, both ways, and closed where it was."""
    bound, slack = case.report.deviation, judge.estimate_blur(case.before)
    closed = judge.count_topology(case.before).open_edges == 0
    return (
        apart(case) <= bound + slack
        and bound <= case.report.tolerance + slack
        and len(case.after.faces) > 0
        and (not closed or judge.count_topology(case.after).open_edges == 0)
    )


def bodies_of(mesh: Shape) -> int:
    points, faces = solids.weld(mesh)
    welded = _core.weld(points, np.ascontiguousarray(faces, np.int32), 0.0)
    return len(np.unique(_core.find_bodies(welded.points, welded.faces)))


@pytest.mark.parametrize(
    ("make", "count"),
    [
        (solids.box, 1),
        (solids.frame, 1),
        (solids.moebius, 1),
        (solids.plate_with_holes, 1),
        (solids.boxes_touching_in_a_point, 2),
        (solids.boxes_touching_in_an_edge, 2),
        (solids.boxes_sharing_part_of_a_wall, 2),
        (solids.rooms_back_to_back, 2),
        (lambda: solids.add_backs(solids.square()), 1),
        # A cavity is no body of its own; a solid in a solid is.
        (solids.room_with_cavity, 1),
        (solids.box_within_a_box, 2),
        # Each room's own walls, and the one between them, belong together only by edges that do not add up.
        (solids.wall_between_two_rooms, 3),
    ],
)
def test_solids_that_touch_are_bodies_of_their_own(make, count: int) -> None:  # type: ignore[no-untyped-def]
    assert bodies_of(make()) == count
    assert bodies_of(solids.rotate(make())) == count
    assert bodies_of(solids.subdivide(make())) == count


def test_directions_that_differ_by_rounding_are_one() -> None:
    rooms = [solids.box((0.37, 0.91, 1.13), (0.37 * i, 0, 0)) for i in range(3)]
    for degrees in (0.0, 7.3, 33.3, 71.9):
        mesh = solids.subdivide(solids.weld(solids.merge(*rooms)), 2)
        assert bodies_of(solids.rotate(mesh, degrees)) == 3


def test_a_doubled_wall_becomes_one() -> None:
    case = simplify_and_judge(solids.merge(sheet(), sheet(0.01)), 0.05)
    assert (case.report.after.points, case.report.after.triangles) == (4, 2)
    assert [(part.triangles, part.reason) for part in case.report.removed_components] == [(2, "within_tolerance")]
    assert well_done(case)


def test_at_the_files_own_rounding_nothing_goes() -> None:
    case = simplify_and_judge(solids.merge(sheet(), sheet(1e-7)))
    assert case.report.after.points == 8
    assert case.report.removed_components == []


@pytest.mark.parametrize("gap", [0.0, 0.001])
@pytest.mark.parametrize(("tolerance", "points", "dropped"), [(0.05, 8, 1), (0.01, 16, 0)])
def test_a_sill_goes_where_the_tolerance_is_wider(gap: float, tolerance: float, points: int, dropped: int) -> None:
    sill = solids.box((1, 0.04, 0.05), (1.5, -0.04 - gap, 1))
    case = simplify_and_judge(solids.merge(wall(), sill), tolerance)
    assert (case.report.after.points, len(case.report.removed_components)) == (points, dropped)
    assert case.report.after.watertight
    assert well_done(case)
    if dropped:
        np.testing.assert_allclose(
            case.report.removed_components[0].box, [[1.5, -0.04 - gap, 1], [2.5, -gap, 1.05]], atol=1e-12
        )
        assert case.report.removed_components[0].triangles == 12


def test_what_shares_edges_with_a_wall_goes_without_opening_it() -> None:
    # The middle one of three slabs side by side is as thin as the tolerance, and shares its long walls' edges.
    slabs = solids.merge(
        solids.box((4, 1, 3)), solids.box((4, 0.05, 3), (0, 1, 0)), solids.box((4, 1, 3), (0, 1.05, 0))
    )
    case = simplify_and_judge(solids.weld(slabs), 0.04)
    assert [part.triangles for part in case.report.removed_components] == [12]
    assert judge.count_topology(case.before).nonmanifold_edges == 8
    assert case.report.after.watertight
    assert well_done(case)


def test_a_solid_deep_in_a_thick_wall_stays() -> None:
    core = solids.box((1, 0.1, 1), (1, 0.1, 1))
    assert simplify_and_judge(solids.merge(wall(), core), 0.05).report.removed_components == []
    assert (
        len(
            simplify_and_judge(
                solids.merge(wall(0.09), solids.box((1, 0.05, 1), (1, 0.02, 1))), 0.05
            ).report.removed_components
        )
        == 1
    )


def test_the_smaller_one_goes() -> None:
    for mesh in (solids.merge(sheet(), sheet(0.01, 4.02)), solids.merge(sheet(0.01), sheet(0.0, 4.02))):
        case = simplify_and_judge(mesh, 0.05)
        assert case.after.points.max() == 4.02
        assert well_done(case)


def test_what_went_frees_what_it_was_joined_to() -> None:
    # Without the flap, which is larger and goes later, the box would leave its edge to the flap alone.
    box = solids.box((0.2, 0.02, 0.2), (1, 0.01, 1))
    flap = solids.fan_polygons([(1, 0.01, 0.5), (1.2, 0.01, 0.5), (1.2, 0.01, 1), (1, 0.01, 1)])
    case = simplify_and_judge(solids.weld(solids.merge(sheet(), box, flap)), 0.05)
    assert sorted(part.triangles for part in case.report.removed_components) == [2, 12]
    assert well_done(case)


def test_sheets_that_hold_one_another_never_all_go() -> None:
    # Each is near its neighbors alone: what a chain of them leaves must be near every one.
    heights = [0.08 * i for i in range(7)]
    case = simplify_and_judge(solids.merge(*(sheet(height) for height in heights)), 0.1)
    left = np.unique(case.after.points[:, 1])
    assert 3 <= len(left) < 7
    assert np.abs(np.subtract.outer(heights, left)).min(axis=1).max() <= 0.1
    assert well_done(case)


@pytest.mark.parametrize("seed", defer(range(8), range(2, 8)))
def test_heaps_of_plates_stay_within_the_bound(seed: int) -> None:
    rng = np.random.default_rng(seed)
    shapes = [solids.box((4, 4, 0.2))]
    for _ in range(int(rng.integers(3, 30))):
        size = rng.uniform(0.02, 2.0, 3) * rng.choice([1, 1, 0.05], 3)
        at = rng.uniform(-0.3, 3.0, 3) * (1, 1, 0.1)
        shapes.append(solids.box(np.round(size, 2) + 0.01, np.round(at, rng.choice([1, 2]))))
    mesh = solids.rotate(solids.merge(*shapes), float(rng.uniform(0, 90))) if seed % 2 else solids.merge(*shapes)
    for tolerance in (0.02, 0.1, 0.4):
        assert well_done(simplify_and_judge(mesh, tolerance))


@pytest.mark.parametrize("seed", defer(range(4), range(1, 4)))
def test_crumpled_sheets_on_one_another_stay_within_the_bound(seed: int) -> None:
    rng = np.random.default_rng(seed)
    base = solids.subdivide(sheet(), 3)
    sheets = [solids.move(solids.add_noise(base, 0.03, seed + i), (0, rng.uniform(0, 0.1), 0)) for i in range(4)]
    for tolerance in (0.02, 0.07, 0.2):
        assert well_done(simplify_and_judge(solids.merge(*sheets), tolerance))


def test_the_order_of_faces_does_not_matter() -> None:
    heap = solids.merge(*(sheet(0.03 * i, 1 + 0.1 * (i % 3)) for i in range(9)))
    cases = [simplify_and_judge(mesh, 0.1) for mesh in (heap, solids.shuffle(heap, 1), solids.shuffle(heap, 2))]
    assert len({frozenset(judge.collect_triangles(case.after)) for case in cases}) == 1
    assert len({len(case.report.removed_components) for case in cases}) == 1


def storeys() -> Shape:
    """Six slabs, and between them the walls of five storeys as panels that touch."""
    shapes = [solids.box((20, 14, 0.3), (0, 0, 3 * i)) for i in range(6)]
    for floor in np.arange(0.3, 15, 3):
        shapes += [solids.box((5, 0.25, 2.7), (x, y, floor)) for x in (0, 5, 10, 15) for y in (0, 13.75)]
        shapes += [solids.box((0.25, 6.75, 2.7), (x, y, floor)) for x in (0, 19.75) for y in (0.25, 7)]
    return solids.weld(solids.merge(*shapes))


def remove_bodies(mesh: Shape, tolerance: float) -> list[int]:
    """Return the triangles of each body that goes."""
    points, faces = mesh
    none = np.zeros(len(faces), np.uint8)
    part = np.zeros(len(faces), np.int32)
    _, dropped = find_redundant_bodies(points, np.ascontiguousarray(faces, np.int32), part, none, none, tolerance)
    return [body.triangles for body in dropped]


@pytest.mark.parametrize("percent", [0.5, 1.0, 2.0, 3.0, 5.0, 8.0])
def test_panels_of_a_facade_stay_between_slabs(percent: float) -> None:
    # At 5 % every point of a panel is within the tolerance of a slab.
    mesh = storeys()
    tolerance = percent / 100 * judge.measure_extent(judge.make_surface(*mesh))
    assert remove_bodies(mesh, tolerance) == []
    assert remove_bodies(solids.rotate(mesh), tolerance) == []


@pytest.mark.parametrize("percent", [0.5, 1.0, 2.0, 3.0])
def test_a_facade_keeps_its_area(percent: float) -> None:
    mesh = storeys()
    case = simplify_and_judge(mesh, percent / 100 * judge.measure_extent(judge.make_surface(*mesh)))
    assert judge.compute_area(case.after) >= 0.9 * judge.compute_area(case.before)
    assert well_done(case)


def test_a_panel_square_to_a_slab_stays_and_one_along_a_wall_goes() -> None:
    slabs = [solids.box((6, 6, 0.3), (0, 0, z)) for z in (0.0, 1.8)]
    panel = solids.box((5, 0.1, 1.5), (0.5, 2, 0.3))
    wall = solids.box((6, 0.3, 1.5), (0, 2.2, 0.3))
    assert remove_bodies(solids.merge(*slabs, panel), 1.0) == []
    assert remove_bodies(solids.merge(*slabs, panel, wall), 1.0) == [12]


def test_a_small_box_on_a_wall_goes_though_its_sides_are_square_to_it() -> None:
    block = solids.box((0.15, 0.09, 0.15), (1.5, -0.09, 1))
    for mesh in (solids.merge(wall(), block), solids.rotate(solids.merge(wall(), block))):
        assert remove_bodies(mesh, 0.1) == [12]
        case = simplify_and_judge(mesh, 0.1)
        assert case.report.after.points == 8
        assert well_done(case)


def test_a_cavity_does_not_go_by_itself() -> None:
    outer, inner = solids.box((2, 2, 2)), solids.box((1.8, 1.8, 1.8), (0.1, 0.1, 0.1))
    assert remove_bodies(solids.merge(outer, solids.reverse_winding(inner)), 0.2) == []
    assert remove_bodies(solids.merge(outer, inner), 0.2) == [12]


def spare(points: list[tuple[float, float, float]], pinned: int = -1, limit: float = 0.5) -> list[int]:
    """Which of triangles of their own, one for each three points, can go."""
    faces = np.arange(len(points), dtype=np.int32).reshape(-1, 3)
    stays = (np.arange(len(faces)) == pinned).astype(np.uint8)
    return np.flatnonzero(
        _core.find_redundant_bodies(np.array(points, float), faces, np.arange(len(faces), dtype=np.int32), stays, limit)
    ).tolist()


def test_pinned_faces_stay_and_may_hold_others() -> None:
    large = [(0.0, 0, 0), (8, 0, 0), (0, 8, 0)]
    small = [(1.0, 1, 0.25), (2, 1, 0.25), (1, 2, 0.25)]
    assert spare(large + small) == [1]
    assert spare(large + small, pinned=0) == [1]
    assert spare(large + small, pinned=1) == []
    assert spare(small) == []


def test_two_halves_hold_what_neither_holds_alone() -> None:
    left, right = [(0.0, 0, 0), (4, 0, 0), (4, 4, 0)], [(0.0, 0, 0), (4, 4, 0), (0, 4, 0)]
    across = [(0.5, 2.0, 0.25), (3.5, 1.5, 0.25), (3, 3.5, 0.25)]
    assert spare(left + right + across) == [2]
    assert spare(left + across) == []


def scene(*shapes: Shape, fixed: tuple[tuple[str, ...], ...] = ()) -> Scene:
    """One mesh, each shape a part of it."""
    points, faces = solids.merge(*shapes)
    parts = [Part(f"part {i}", fixed=fixed[i] if fixed else ()) for i in range(len(shapes))]
    part = np.repeat(np.arange(len(shapes), dtype=np.int32), [len(f) for _, f in shapes])
    return Scene(None, "arrays", [Mesh("mesh", points, np.ascontiguousarray(faces, np.int32), part, parts)], 0)


SPECK = solids.box((0.1, 0.1, 0.1), (9, 9, 9))


def test_a_speck_goes_where_asked_and_is_listed() -> None:
    given = scene(wall(), SPECK, solids.move(SPECK, (0, 0, 3)))
    for tolerance in (Tolerance(), Tolerance(0.01, "length")):
        (light,), report = simplify_scene(given, Options(tolerance=tolerance, min_component=0.2))
        assert len(light.faces) == report.after.triangles == 12
        assert (report.before.points, report.before.triangles, report.before.watertight) == (24, 36, True)
        assert [(part.part, part.triangles, part.reason) for part in report.removed_components] == [
            ("part 1", 12, "smaller_than_min_component"), ("part 2", 12, "smaller_than_min_component"),
        ]  # fmt: skip
        np.testing.assert_allclose(report.removed_components[0].box, [[9, 9, 9], [9.1, 9.1, 9.1]])
        assert report.deviation <= report.tolerance
        (light,), report = simplify_scene(given, Options(tolerance=tolerance, min_component=0.17))
        assert len(light.faces) == 36
        assert report.removed_components == []


def test_the_largest_component_of_a_file_stays() -> None:
    one, two = scene(wall(), SPECK), scene(SPECK)
    both = Scene(None, "arrays", [*one.meshes, *two.meshes], 0)
    lights, report = simplify_scene(both, Options(min_component=100.0))
    assert [len(light.faces) for light in lights] == [12, 0]
    assert [part.triangles for part in report.removed_components] == [12, 12]
    assert report.after.points == 8


def test_size_is_measured_in_world_space() -> None:
    given = scene(wall(), SPECK)
    given.meshes[0].transforms = np.stack([np.diag([2.0, 2, 2, 1]), np.eye(4)])
    assert simplify_scene(given, Options(min_component=0.3))[1].removed_components == []
    (part,) = simplify_scene(given, Options(min_component=0.4))[1].removed_components
    np.testing.assert_allclose(part.box, [[18, 18, 18], [18.2, 18.2, 18.2]])


def test_specks_of_parts_that_are_passed_on_stay_and_are_told() -> None:
    given = scene(wall(), SPECK, solids.move(SPECK, (0, 0, 3)), fixed=((), ("skin",), ()))
    (light,), report = simplify_scene(given, Options(min_component=0.2))
    assert sorted(set(light.part_of_face.tolist())) == [0, 1]
    assert [part.part for part in report.removed_components] == ["part 2"]
    assert any("1 component smaller than 0.2 stays" in text for text in report.warnings)


def test_copies_and_faces_without_area_go_with_their_speck() -> None:
    points, faces = solids.add_copies(SPECK)
    speck = solids.shape(points, np.concatenate([faces, [[0, 0, 1], faces[0][[0, 2, 1]]]]))
    (result,), report = simplify_scene(scene(wall(), speck), Options(min_component=0.2))
    assert len(result.faces) == 12
    assert report.removed_components[
        0
    ].triangles + report.removed_degenerate_faces + report.removed_duplicate_faces == len(speck[1])


def test_parts_passed_on_hold_others() -> None:
    given = scene(sheet(), sheet(0.01), fixed=((), ("skin",)))
    (light,), report = simplify_scene(given, Options(tolerance=Tolerance(0.05, "length")))
    assert light.part_of_face.tolist() == [1, 1]
    assert [part.part for part in report.removed_components] == ["part 0"]


def test_corners_of_a_heap_in_any_place(capsys: pytest.CaptureFixture[str]) -> None:
    # Coordinates of map projections: proofs are about a local origin.
    mesh = solids.move(solids.merge(wall(), solids.box((1, 0.04, 0.05), (1.5, -0.04, 1))), (4e6, 5e6, 100))
    case = simplify_and_judge(mesh, 0.05)
    assert len(case.report.removed_components) == 1
    assert well_done(case)


def test_every_combination_of_three_plates() -> None:
    # Plates that touch, overlap, coincide: whatever goes, nothing opens.
    plates = [solids.box((2, 2, 0.25)), solids.box((1, 2, 0.25), (0, 0, 0.25)), solids.box((2, 2, 0.25), (0, 0, 0.25)),
              solids.box((1, 1, 0.25), (0.5, 0.5, -0.25)), solids.box((2, 2, 0.5), (0, 0, 0))]  # fmt: skip
    for chosen in itertools.combinations(plates, 3):
        case = simplify_and_judge(solids.weld(solids.merge(*chosen)), 0.3)
        assert well_done(case), chosen


def test_what_faces_carry_stays_theirs_where_small_parts_go() -> None:
    """A wall of two colors behind a speck that goes."""
    speck, left, right = solids.square(), solids.square(), solids.move(solids.square(), (1, 0, 0))
    small = (0.01 * speck[0] - 5.0, speck[1])
    shape = solids.merge(small, left, right)
    color = np.repeat([[0.0], [1.0], [0.5]], 2, axis=0)
    carried = Attribute("FACE_COLOR_0", "color", color, np.ones((1, 1)), on_faces=True)
    mesh = Mesh("wall", *shape, np.zeros(6, np.int32), [Part("wall")], attributes=[carried])
    (light,), report = simplify_scene(Scene(None, "arrays", [mesh], 0), Options(min_component=0.1))
    assert len(report.removed_components) == 1
    middle = light.points[light.faces].mean(axis=1)[:, 0]
    assert np.array_equal(light.values(carried)[:, 0], np.where(middle < 1, 1.0, 0.5))


@pytest.mark.parametrize("one_sided", [False, True])
def test_a_sheet_seen_from_one_side_stays_before_its_back(one_sided: bool) -> None:
    front, back = solids.square(), solids.reverse_winding(solids.move(solids.square(), (0, 0, 1e-3)))
    shape = solids.merge(front, back)
    mesh = Mesh("sign", *shape, np.repeat([0, 1], 2).astype(np.int32), [Part(n, (), (), one_sided) for n in "ab"])
    outcome = simplify_mesh(mesh, 0.01)
    assert len(outcome.dropped) == (0 if one_sided else 1)
    assert len(outcome.mesh.faces) == (4 if one_sided else 2)


@pytest.mark.parametrize("whole", [True, False])
def test_what_is_removed_has_no_part_in_what_a_weld_moved(whole: bool) -> None:
    """A speck of which a weld joins points is removed: the rest is as if it had not been there."""
    points, faces = SPECK
    torn = solids.shape(points[faces].reshape(-1, 3) + np.linspace(0, 0.01, 36)[:, None], np.arange(36).reshape(-1, 3))
    alone = scene(wall())
    both = scene(wall(), torn)
    if whole:
        both.meshes = [*alone.meshes, *scene(torn).meshes]
    options = Options(weld=0.02, min_component=0.5)
    results, report = simplify_scene(both, options)
    assert len(report.removed_components) == 1
    assert report.deviation == simplify_scene(alone, options)[1].deviation
    assert len(results[0].faces) == 12
    assert sum(len(result.faces) for result in results) == 12
