"""Facets end where textures, colors, feature ids and creases do, and what points carry stays right."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import trimesh

import bldsimp
from bldsimp.model import Attribute, Mesh, Part, SimplifiedMesh
from bldsimp.options import DEFAULTS, DELIMITS, Options
from bldsimp.pipeline import simplify_mesh
from bldsimp.result import MeshResult
from bldsimp.stages.attributes import AttributeCharts, KeptAttributes

WIDTH, HEIGHT, TEXELS = 10.0, 5.0, 1024
Map = Callable[[np.ndarray], np.ndarray]


def wall(steps: int, noise: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """A flat grid of (steps, steps) squares, its points off the plane by up to `noise`."""
    x, y = np.meshgrid(np.linspace(0, WIDTH, steps + 1), np.linspace(0, HEIGHT, steps + 1), indexing="ij")
    z = noise * np.random.default_rng(0).uniform(-1, 1, x.shape)
    corner = np.arange(steps * (steps + 1)).reshape(steps, steps + 1)[:, :-1].reshape(-1)
    a, b, c, d = corner, corner + steps + 1, corner + steps + 2, corner + 1
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return np.stack([x, y, z], axis=-1).reshape(-1, 3), faces.astype(np.int32)


def cut(points: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The same surface with rows of its own for the right half, and which rows those are."""
    right = points[faces].mean(axis=1)[:, 0] > WIDTH / 2
    used = np.unique(faces[right])
    row = np.arange(len(points), dtype=np.int32)
    row[used] = len(points) + np.arange(len(used))
    faces = faces.copy()
    faces[right] = row[faces[right]]
    return np.concatenate([points, points[used]]), faces, np.arange(len(points) + len(used)) >= len(points)


def mesh(points: np.ndarray, faces: np.ndarray, *carried: Attribute) -> Mesh:
    names = tuple(one.name for one in carried)
    return Mesh("wall", points, faces, np.zeros(len(faces), np.int32), [Part("wall", names)], attributes=list(carried))


def uv(values: np.ndarray) -> Attribute:
    return Attribute("TEXCOORD_0", "uv", values, np.full((1, 2), float(TEXELS)))


def color(values: np.ndarray) -> Attribute:
    return Attribute("COLOR_0", "color", values, np.full((1, values.shape[1]), 255.0))


def left_map(points: np.ndarray) -> np.ndarray:
    return points[:, :2] * [3.1, 0.7] + [5.0, 2.0]


def right_map(points: np.ndarray) -> np.ndarray:
    return points[:, 1::-1] * [0.2, 1.5] + [0.3, 0.1]


def halves(outcome: MeshResult, given: Mesh) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Corners of the result left and right of the middle, and their UV; no triangle lies on both sides."""
    light, values = outcome.mesh, outcome.mesh.values(given.attributes[0])
    x = light.points[light.faces][:, :, 0]
    on_left = x.max(axis=1) <= WIDTH / 2 + 1e-9
    assert np.all(on_left | (x.min(axis=1) >= WIDTH / 2 - 1e-9))
    return {
        name: (light.points[light.faces[side].reshape(-1)], values[light.faces[side].reshape(-1)])
        for name, side in (("left", on_left), ("right", ~on_left))
    }


def test_one_map_is_no_reason_to_keep_a_point() -> None:
    points, faces = wall(20)
    given = mesh(points, faces, uv(left_map(points)))
    outcome = simplify_mesh(given, 1e-6)
    assert outcome.after.points == 4
    assert outcome.texels < 1e-6
    assert np.array_equal(outcome.mesh.values(given.attributes[0]), given.attributes[0].values)


def test_a_seam_stays_and_both_sides_keep_their_own() -> None:
    points, faces, right = cut(*wall(20))
    given = mesh(points, faces, uv(np.where(right[:, None], right_map(points), left_map(points))))
    outcome = simplify_mesh(given, 1e-6)
    assert outcome.after.points == 6
    for name, map_ in (("left", left_map), ("right", right_map)):
        at, values = halves(outcome, given)[name]
        assert np.array_equal(values, map_(at))


def test_a_seam_with_one_map_on_both_sides_is_none() -> None:
    points, faces, _ = cut(*wall(20))
    assert simplify_mesh(mesh(points, faces, uv(left_map(points))), 1e-6).after.points == 4


def test_a_facet_ends_where_a_map_bends() -> None:
    points, faces = wall(20)
    bent = np.stack([np.abs(points[:, 0] - WIDTH / 2), points[:, 1]], axis=1)
    given = mesh(points, faces, uv(bent))
    outcome = simplify_mesh(given, 1e-6)
    assert outcome.after.points == 6
    halves(outcome, given)


@pytest.mark.parametrize("allowed", [0.1, 0.5, 4.0])
def test_a_map_that_is_not_affine_moves_by_no_more_than_told(allowed: float) -> None:
    points, faces = wall(40)
    given = mesh(points, faces, uv(np.stack([np.sin(points[:, 0] / 5), points[:, 1] / 5], axis=1)))
    outcome = simplify_mesh(given, 1e-6, Options(texture_tolerance=allowed))
    assert 4 < outcome.after.points < len(points) / 3
    assert 0.0 < outcome.texels <= allowed
    light = outcome.mesh
    values = light.values(given.attributes[0])
    weights = np.random.default_rng(1).dirichlet(np.ones(3), 50)
    at = np.einsum("sc,tcx->tsx", weights, light.points[light.faces]).reshape(-1, 3)
    shown = np.einsum("sc,tcx->tsx", weights, values[light.faces]).reshape(-1, 2)
    # The input is linear between its own points.
    grid = np.linspace(0, WIDTH, 41)
    was = np.stack([np.interp(at[:, 0], grid, np.sin(grid / 5)), at[:, 1] / 5], axis=1)
    assert np.abs(shown - was).max() * TEXELS <= outcome.texels + 1e-6


def test_a_smaller_texture_tolerance_keeps_more() -> None:
    points, faces = wall(40)
    given = mesh(points, faces, uv(np.stack([np.sin(points[:, 0] / 5), points[:, 1] / 5], axis=1)))
    counts = [simplify_mesh(given, 1e-6, Options(texture_tolerance=one)).after.points for one in (4.0, 0.5, 0.1, 0.0)]
    assert counts == sorted(counts)
    assert counts[0] < counts[-1]


@pytest.mark.parametrize("tolerance", [1e-6, 0.05])
def test_noise_goes_and_the_picture_stays(tolerance: float) -> None:
    points, faces, right = cut(*wall(20, noise=0.01))
    given = mesh(points, faces, uv(np.where(right[:, None], right_map(points), left_map(points))))
    outcome = simplify_mesh(given, tolerance)
    assert outcome.texels <= 0.5
    if tolerance < 0.01:
        return
    assert outcome.after.points == 6
    for name, map_ in (("left", left_map), ("right", right_map)):
        at, values = halves(outcome, given)[name]
        assert np.abs(values - map_(at)).max() * TEXELS <= 0.5


def test_what_two_maps_need_of_one_moved_row_becomes_two_rows() -> None:
    points = np.array([[0.0, 0, 0], [0, 1, 0], [-1, 0, 0], [1, 0, 0]])
    faces = np.array([[0, 1, 2], [0, 3, 1]], np.int32)
    given = mesh(points, faces, uv(np.abs(points[:, :2])))
    moved = points.copy()
    moved[0] = [0.25, 0.5, 0]
    row = np.arange(4, dtype=np.int32)
    light = SimplifiedMesh(moved, faces, np.zeros(2, np.int32), row, np.zeros(2, np.int32))
    maps = np.array([[[-1.0, 0, 0, 0], [0, 1, 0, 0]], [[1, 0, 0, 0], [0, 1, 0, 0]]])
    charted = AttributeCharts(np.array([0, 1], np.int32), maps, np.zeros(2))
    none = np.empty(0, np.int32)
    KeptAttributes(given, DEFAULTS).update_values(light, points, none, np.array([0, 1], np.int32), charted)
    values = light.values(given.attributes[0])
    assert light.row.tolist() == [0, 1, 2, 3, 0]
    assert np.array_equal(light.points[4], moved[0])
    assert sorted(values[light.faces[:, 0]].tolist()) == [[-0.25, 0.5], [0.25, 0.5]]
    assert np.array_equal(values[1:4], given.attributes[0].values[1:])


def test_a_needle_of_which_no_map_can_be_told_is_no_displacement() -> None:
    points, faces = wall(4)
    needle = np.array([[20.0, 0.0, 0.0], [21.0, 0.0, 0.0], [22.0, 0.0, 0.0]])
    rows = np.concatenate([points, needle])
    both = np.concatenate([faces, [[len(points), len(points) + 1, len(points) + 2]]]).astype(np.int32)
    values = np.concatenate([left_map(points), [[0.0, 0.0], [5.0, 3.0], [-7.0, 9.0]]])
    for tolerance in (1e-6, 0.05):
        assert simplify_mesh(mesh(rows, both, uv(values)), tolerance).texels <= 0.5


def test_a_step_of_color_stays_and_a_rounded_gradient_is_one() -> None:
    points, faces, right = cut(*wall(20))
    step = np.where(right[:, None], [1.0, 0.5, 0.0], [0.0, 0.5, 1.0])
    assert simplify_mesh(mesh(points, faces, color(step)), 1e-6).after.points == 6
    points, faces = wall(20)
    gradient = np.round(np.tile(points[:, :1] / WIDTH, 3) * 255) / 255
    assert simplify_mesh(mesh(points, faces, color(gradient)), 1e-6).after.points == 4


def test_feature_ids_never_mix() -> None:
    points, faces, right = cut(*wall(20))
    given = mesh(points, faces, Attribute("_BATCHID", "feature", right[:, None].astype(float), np.ones((1, 1))))
    for tolerance in (1e-6, 0.05):
        outcome = simplify_mesh(given, tolerance)
        assert outcome.after.points == 6
        for number, name in enumerate(("left", "right")):
            assert np.all(halves(outcome, given)[name][1] == number)


def test_colors_on_faces_never_mix() -> None:
    points, faces = wall(20)
    right = points[faces].mean(axis=1)[:, :1] > WIDTH / 2
    given = mesh(points, faces, Attribute("COLOR_0", "color", right.astype(float), np.ones((1, 1)), on_faces=True))
    outcome = simplify_mesh(given, 1e-6)
    light = outcome.mesh
    assert outcome.after.points == 6
    middle = light.points[light.faces].mean(axis=1)[:, :1] > WIDTH / 2
    assert np.array_equal(light.values(given.attributes[0]) > 0.5, middle)


def test_creases_inside_a_wall_are_outlines() -> None:
    points, faces, right = cut(*wall(20))
    given = mesh(points, faces)
    given.normals = np.where(right[:, None], [0.8, 0.0, 0.6], [0.0, 0.0, 1.0])
    assert simplify_mesh(given, 1e-6).after.points == 6
    assert simplify_mesh(given, 1e-6, Options(crease_angle=90.0)).after.points == 4
    assert simplify_mesh(given, 1e-6, Options(delimit=frozenset(DELIMITS) - {"crease"})).after.points == 4


@pytest.mark.parametrize("word", ["uv", "color", "feature"])
def test_what_is_no_delimiter_may_be_crossed(word: str) -> None:
    points, faces, right = cut(*wall(20))
    step = np.tile(right[:, None].astype(float), 2)
    given = mesh(points, faces, Attribute("it", word, step, np.full((1, 2), 1000.0)))
    assert simplify_mesh(given, 1e-6).after.points == 6
    assert simplify_mesh(given, 1e-6, Options(delimit=frozenset(DELIMITS) - {word})).after.points == 4


def test_materials_are_crossed_only_when_asked() -> None:
    points, faces = wall(20)
    part = (points[faces].mean(axis=1)[:, 0] > WIDTH / 2).astype(np.int32)
    given = Mesh("wall", points, faces, part, [Part("left"), Part("right")])
    assert simplify_mesh(given, 1e-6).after.points == 6
    assert simplify_mesh(given, 1e-6, Options(delimit=frozenset())).after.points == 4


def test_rows_without_texture_are_told_from_rows_with_one() -> None:
    points, faces, right = cut(*wall(20))
    values = np.where(right[:, None], np.nan, left_map(points))
    given = mesh(points, faces, uv(values))
    outcome = simplify_mesh(given, 1e-6)
    assert outcome.after.points == 6
    assert np.isnan(halves(outcome, given)["right"][1]).all()
    assert not np.isnan(halves(outcome, given)["left"][1]).any()


def test_a_layer_of_another_texture_is_no_copy() -> None:
    points, faces = wall(8)
    both = np.concatenate([faces, faces + len(points)]).astype(np.int32)
    twice = np.concatenate([points, points])
    names = ("TEXCOORD_0",)
    values = np.concatenate([left_map(points), right_map(points)])
    given = Mesh(
        "wall", twice, both, np.repeat([0, 1], len(faces)).astype(np.int32), [Part("wall", names), Part("dirt", names)],
        attributes=[Attribute("TEXCOORD_0", "uv", values, np.full((2, 2), float(TEXELS)))],
    )  # fmt: skip
    for tolerance in (1e-6, 0.05):
        outcome = simplify_mesh(given, tolerance)
        light, shown = outcome.mesh, outcome.mesh.values(given.attributes[0])
        for part, map_ in enumerate((left_map, right_map)):
            own = light.faces[light.part_of_face == part]
            a, b, c = (light.points[own[:, i]] for i in range(3))
            assert np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 == pytest.approx(WIDTH * HEIGHT)
            assert np.allclose(shown[own.reshape(-1)], map_(light.points[own.reshape(-1)]))


def test_near_points_that_are_welded_keep_their_sides_texture() -> None:
    points, faces, right = cut(*wall(20))
    points = points + np.where(right[:, None], [1e-4, 0.0, 0.0], 0.0)
    given = mesh(points, faces, uv(np.where(right[:, None], right_map(points), left_map(points))))
    outcome = simplify_mesh(given, 1e-5, Options(weld=2e-4))
    assert outcome.after.points == 6
    for name, map_ in (("left", left_map), ("right", right_map)):
        at, values = halves(outcome, given)[name]
        assert np.abs(values - map_(at)).max() * TEXELS <= 1e-4 * 3.1 * TEXELS


def test_what_a_weld_moves_of_a_texture_is_told() -> None:
    points, faces = wall(10)
    inside = np.all((points[:, :2] > 0) & (points[:, :2] < [WIDTH, HEIGHT]), axis=1)
    strayed = points + 0.03 * inside[:, None] * np.random.default_rng(1).uniform(-1, 1, points.shape) * [1, 1, 0]
    rows = np.concatenate([points, strayed])
    right = points[faces].mean(axis=1)[:, 0] > WIDTH / 2
    both = np.where(right[:, None], faces + len(points), faces).astype(np.int32)
    given = mesh(rows, both, uv(left_map(rows)))
    outcome = simplify_mesh(given, 1e-6, Options(weld=0.05))
    light = outcome.mesh
    corners = np.unique(light.faces)
    off = np.abs(light.values(given.attributes[0]) - left_map(light.points))[corners].max() * TEXELS
    assert 1.0 < off <= outcome.texels + 1e-6
    # Rows that are where they were keep their own.
    still = corners[corners < len(rows)]
    assert np.array_equal(light.values(given.attributes[0])[still], left_map(rows)[light.row[still]])


def test_a_wall_of_many_faces_is_a_wall() -> None:
    assert simplify_mesh(mesh(*wall(450)), 1e-6).after.points == 4


@pytest.mark.parametrize("seed", range(3))
def test_the_order_of_faces_and_rows_leaves_no_trace(seed: int) -> None:
    points, faces = wall(24)
    values = np.stack([np.sin(points[:, 0] / 5), points[:, 1] / 5], axis=1)
    generator = np.random.default_rng(seed)
    rows, order = generator.permutation(len(points)), generator.permutation(len(faces))
    place = np.argsort(rows).astype(np.int32)
    plain = simplify_mesh(mesh(points, faces, uv(values)), 1e-6)
    mixed = simplify_mesh(mesh(points[rows], place[faces[order]], uv(values[rows])), 1e-6)
    assert np.array_equal(plain.points, mixed.points)
    assert np.array_equal(plain.triangles, mixed.triangles)


def paint_box(kind: str, halvings: int) -> trimesh.Trimesh:
    """A box with one picture from above, a picture on each wall, or colors that change over all of it."""
    box = trimesh.creation.box([3, 4, 5])
    for _ in range(halvings):
        box = box.subdivide()
    if kind == "ramp":
        levels = 51 * (box.vertices - box.vertices.min(axis=0))
        box.visual.vertex_colors = np.column_stack([levels, np.full(len(levels), 255)]).astype(np.uint8)
        return box
    points, uv = box.vertices, box.vertices[:, :2] / 10
    if kind == "walls":
        points = box.triangles.reshape(-1, 3)
        row, axis = np.arange(len(points)), np.repeat(np.abs(box.face_normals).argmax(axis=1), 3)
        uv = np.stack([points[row, (axis + 1) % 3], points[row, (axis + 2) % 3]], axis=1) / 10
        box = trimesh.Trimesh(points, row.reshape(-1, 3), process=False)
    box.visual = trimesh.visual.TextureVisuals(uv=uv)
    return box


@pytest.mark.parametrize("halvings", [1, 2, 3])
@pytest.mark.parametrize("kind", ["picture", "walls", "ramp"])
def test_charts_that_span_walls_end_in_the_middle_of_none(kind: str, halvings: int) -> None:
    given = paint_box(kind, halvings)
    default = bldsimp.simplify(given).report.after.points
    assert bldsimp.simplify(given, "0.1%").report.after.points <= default
