"""The standard method: every piece a Delaunay edge by itself, and nothing else changed."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import judge
import numpy as np
import pytest
import solids
from quick import LARGE_MODELS, defer
from random_shapes import random_shape
from solids import Shape
from test_models import MODELS, SLOW_WHEN_ROUGH, read_scene

from bldsimp import _core
from bldsimp.compare.placement import place_scene
from bldsimp.compare.standard import Conformity, StandardMesh, build_standard_surface, triangulate_standard
from bldsimp.model import Mesh, Part, Scene
from bldsimp.options import Options, Tolerance
from bldsimp.pipeline import simplify_mesh
from bldsimp.result import MeshResult
from bldsimp.scene import simplify_meshes
from bldsimp.stages.triangulate import Attempt
from bldsimp.triangulation import Statistics

FLAT = {
    "box": solids.box,
    "gabled_house": solids.gabled_house,
    "frame": solids.frame,
    "staircase": solids.staircase,
    "plate_with_holes": solids.plate_with_holes,
    "pinched_plate": solids.pinched_plate,
    "pyramid": solids.pyramid,
    "comb": solids.comb,
    "narrow_comb": lambda: solids.comb(gap=2**-4),
    "two_sided": lambda: solids.add_backs(solids.plate_with_holes()),
    "sheared_star": lambda: shear(solids.star(3)),
    **{f"star_{seed}": lambda seed=seed: solids.star(seed) for seed in range(6)},
}
"""Shapes whose facets are flat to the last bit, or nearly; some make the standard method cut."""


def shear(mesh: Shape) -> Shape:
    """Caps that no axis is perpendicular to."""
    points = mesh[0].copy()
    points[:, 2] += points[:, 0] / 2 + points[:, 1]
    return points, mesh[1]


def make_mesh(shape: Shape, *names: str, part_of_face: np.ndarray | None = None) -> Mesh:
    points, faces = shape
    parts = [Part(name) for name in names or ("mesh",)]
    which = np.zeros(len(faces), np.int32) if part_of_face is None else part_of_face.astype(np.int32)
    return Mesh("mesh", np.ascontiguousarray(points), np.ascontiguousarray(faces, np.int32), which, parts)


def run_both(mesh: Mesh, tolerance: float = 0.0) -> tuple[MeshResult, StandardMesh]:
    outcome = simplify_mesh(mesh, tolerance, keep_layout=True)
    return outcome, triangulate_standard(outcome)


def conform(outcome: MeshResult) -> _core.ConformResult:
    layout = outcome.layout
    return _core.conform(
        outcome.points, layout.surface.facets.planes, layout.outlines.chains, layout.pieces,
        layout.triangles, layout.patch_of_triangle, layout.fate.keep,
    )  # fmt: skip


def count_edge_uses(triangles: np.ndarray) -> np.ndarray:
    return judge.count_edges(np.asarray(triangles, np.int64))[2]


def measure_area_and_volume(points: np.ndarray, triangles: np.ndarray) -> tuple[float, float]:
    a, b, c = (points[triangles[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    return float(np.linalg.norm(normal, axis=1).sum() / 2), float(np.einsum("ij,ij->", a, normal) / 6)


def count_inside_circumcircles(points: np.ndarray, triangles: np.ndarray) -> int:
    """How many pairs there are of a triangle and a point, of those the triangles use, inside its circle."""
    own = points[np.unique(triangles)]
    count = 0
    for a, b, c in points[triangles]:
        u, v = b - a, c - a
        n = np.cross(u, v)
        center = a + (v @ v * np.cross(n, u) + u @ u * np.cross(v, n)) / (2 * n @ n)
        radius = np.linalg.norm(center - a)
        count += int(np.count_nonzero(np.linalg.norm(own - center, axis=1) < radius * (1 - 1e-9)))
    return count


def find_cuts(outcome: MeshResult, result: StandardMesh) -> dict[tuple[int, int], np.ndarray]:
    """Points that cutting made, as shares of the way along the piece that they lie on."""
    pieces = outcome.layout.pieces
    ends = np.unique(np.sort(np.stack([pieces.begin, pieces.end], axis=1), axis=1), axis=0)
    a, b = result.points[ends[:, 0]], result.points[ends[:, 1]]
    way = b - a
    length = np.linalg.norm(way, axis=1)
    found: dict[tuple[int, int], list[float]] = {}
    for point in result.points[len(outcome.points) :]:
        share = np.clip(np.einsum("ij,ij->i", point - a, way) / length**2, 0, 1)
        distance = np.linalg.norm(a + share[:, None] * way - point, axis=1)
        at = int(np.argmin(distance))
        assert distance[at] <= 1e-12 * length.max()
        found.setdefault(tuple(ends[at].tolist()), []).append(float(share[at]))
    return {edge: np.sort(shares) for edge, shares in found.items()}


@pytest.mark.parametrize("name", FLAT)
def test_only_the_triangulation_differs(name: str) -> None:
    outcome, result = run_both(make_mesh(FLAT[name]()))
    before, after = count_edge_uses(outcome.triangles), count_edge_uses(result.triangles)
    assert set(after) <= set(before)
    assert judge.count_topology(judge.make_surface(result.points, result.triangles)).euler == (
        judge.count_topology(judge.make_surface(outcome.points, outcome.triangles)).euler
    )
    old, new = np.unique(outcome.triangles), np.unique(result.triangles)
    assert np.isin(old, new).all()
    assert len(new) == len(old) + len(result.points) - len(outcome.points)
    assert measure_area_and_volume(result.points, result.triangles) == pytest.approx(
        measure_area_and_volume(outcome.points, outcome.triangles), rel=1e-12, abs=1e-9
    )
    assert set(result.facets) == {Conformity.DELAUNAY}
    find_cuts(outcome, result)


@pytest.mark.parametrize("name", FLAT)
def test_every_facet_is_delaunay_by_itself(name: str) -> None:
    outcome, result = run_both(make_mesh(FLAT[name]()))
    core = conform(outcome)
    assert np.array_equal(core.triangles, result.triangles)
    for facet in range(outcome.layout.outlines.patch_count):
        assert count_inside_circumcircles(result.points, core.triangles[core.facet_of_triangle == facet]) == 0


def test_what_is_delaunay_already_is_not_cut() -> None:
    outcome, result = run_both(make_mesh(solids.subdivide(solids.box((3, 4, 5)), 2)))
    assert len(outcome.points) == len(result.points)
    assert (len(np.unique(result.triangles)), len(result.triangles)) == (8, 12)


def test_the_gaps_of_a_comb_are_cut_and_the_more_the_narrower() -> None:
    made = []
    for gap in (1.0, 2.0**-4, 2.0**-8):
        outcome, result = run_both(make_mesh(solids.comb(gap=gap)))
        assert result.facets[Conformity.STOPPED] == 0
        made.append(len(result.points) - len(outcome.points))
    assert 0 < 9 * made[0] < 3 * made[1] < made[2]


def test_a_piece_is_cut_in_its_middle() -> None:
    outcome, result = run_both(make_mesh(solids.prism(solids.doorway())))
    cuts = find_cuts(outcome, result)
    assert [outcome.points[list(edge)].tolist() for edge in sorted(cuts)] == [
        [[0, 0, level], [12, 0, level]] for level in (0, 4)
    ]
    assert [shares.tolist() for shares in cuts.values()] == [[0.5], [0.5]]


@pytest.mark.parametrize("seed", range(6))
def test_beside_sharp_corners_pieces_end_on_common_spheres(seed: int) -> None:
    outcome, result = run_both(make_mesh(solids.star(seed)))
    sharp = find_sharp_points(outcome)
    nearest = 0
    for (low, high), shares in find_cuts(outcome, result).items():
        length = math.dist(outcome.points[low], outcome.points[high])
        for corner, other, share in ((low, high, shares[0]), (high, low, 1 - shares[-1])):
            if corner not in sharp or (other in sharp and share == pytest.approx(0.5)):
                continue
            nearest += 1
            assert math.log2(share * length) == pytest.approx(round(math.log2(share * length)), abs=1e-9)
    assert nearest > 0


def find_sharp_points(outcome: MeshResult) -> set[int]:
    """Points at which two pieces of a facet meet under less than 60 degrees."""
    layout = outcome.layout
    uses, start = layout.outlines.chains.use_facet, layout.outlines.chains.use_start
    spokes: dict[tuple[int, int], list[np.ndarray]] = {}
    for begin, end, chain in zip(layout.pieces.begin, layout.pieces.end, layout.pieces.chain, strict=True):
        way = outcome.points[end] - outcome.points[begin]
        way /= np.linalg.norm(way)
        for facet in uses[start[chain] : start[chain + 1]]:
            spokes.setdefault((int(facet), int(begin)), []).append(way)
            spokes.setdefault((int(facet), int(end)), []).append(-way)
    return {
        point
        for (_, point), ways in spokes.items()
        if any(ways[i] @ ways[j] > 0.5 for i in range(len(ways)) for j in range(i))
    }


@pytest.mark.parametrize("gap", [2.0**-20, 2.0**-40])
def test_a_facet_that_needs_too_many_points_stops_and_stays_closed(gap: float) -> None:
    mesh = make_mesh(solids.comb(gap=gap))
    outcome, result = run_both(mesh)
    assert result.facets[Conformity.STOPPED] == 2
    assert set(count_edge_uses(result.triangles)) == {2}
    assert measure_area_and_volume(result.points, result.triangles) == pytest.approx(
        measure_area_and_volume(outcome.points, outcome.triangles), rel=1e-12
    )
    scene = Scene(None, "arrays", [mesh], 0)
    results, _ = simplify_meshes(scene, Options(tolerance=Tolerance(0.0, "length")), keep_layout=True)
    assert build_standard_surface(scene, results).note == "stopped (2 facets)"


def test_faces_that_were_kept_are_cut_where_their_neighbors_are() -> None:
    points, faces = solids.comb()
    upright = np.ptp(points[faces][:, :, 2], axis=1) > 0
    mesh = make_mesh((points, faces), "caps", "walls", part_of_face=upright)
    mesh.parts[1] = dataclasses.replace(mesh.parts[1], fixed=("skin",))
    outcome, result = run_both(mesh)
    assert result.facets == {Conformity.KEPT: upright.sum(), Conformity.DELAUNAY: 2}
    told = build_standard_surface(Scene(None, "arrays", [mesh], 0), [outcome]).note
    assert told == f"{upright.sum()} facets as improved"
    assert len(result.points) > len(outcome.points)
    assert set(count_edge_uses(result.triangles)) == {2}
    assert measure_area_and_volume(result.points, result.triangles) == pytest.approx(
        measure_area_and_volume(outcome.points, outcome.triangles), rel=1e-12
    )


def test_all_three_sides_of_a_kept_face_are_cut() -> None:
    shape = solids.canopy()
    first = np.arange(len(shape[1])) == 0
    mesh = make_mesh(shape, "doorways", "canopy", part_of_face=first)
    mesh.parts[1] = dataclasses.replace(mesh.parts[1], fixed=("skin",))
    outcome, result = run_both(mesh, 1e-9)
    assert np.array(list(find_cuts(outcome, result).values())) == pytest.approx(np.full((3, 1), 0.5))
    canopy = result.triangles[(result.points[result.triangles][:, :, 2] == 0).all(axis=1)]
    assert len(canopy) == 4
    assert measure_area_and_volume(result.points, canopy)[0] == pytest.approx(96.0)
    # Nine edges, three of them inside; all that were shared still are.
    assert np.bincount(count_edge_uses(canopy)).tolist() == [0, 6, 3]
    assert set(count_edge_uses(result.triangles)) == set(count_edge_uses(outcome.triangles)) == {1, 2}


def test_facets_that_lie_back_to_back_lay_no_edge_on_each_other() -> None:
    """Two rooms whose common wall is there twice: by itself each would get the same diagonal."""
    outcome, result = run_both(make_mesh(solids.rooms_back_to_back()))
    assert result.facets == {Conformity.DELAUNAY: 6, Conformity.CLASH: 2}
    assert sorted(count_edge_uses(result.triangles)) == sorted(count_edge_uses(outcome.triangles))


def test_a_facet_whose_pieces_cross_is_not_cut() -> None:
    outcome, result = run_both(make_mesh(solids.looping_path()))
    assert result.facets == {Conformity.CROSSING: 1}
    assert len(result.points) == len(outcome.points)
    assert np.array_equal(result.triangles, outcome.triangles)


@pytest.mark.parametrize("seed", range(40))
def test_random_shapes_keep_their_rims(seed: int) -> None:
    shape, _ = random_shape(seed)
    for tolerance in (0.0, 0.3):
        outcome, result = run_both(make_mesh(shape), tolerance)
        assert_same_rim(outcome)
        assert np.isin(np.unique(outcome.triangles), result.triangles).all()


@pytest.mark.parametrize("name", ["comb", "star_1", "sheared_star"])
def test_the_order_of_faces_does_not_matter(name: str) -> None:
    shape = FLAT[name]()
    _, first = run_both(make_mesh(shape))
    _, second = run_both(make_mesh(solids.shuffle(shape)))
    assert np.array_equal(first.points, second.points)
    assert np.array_equal(first.triangles, second.triangles)
    assert first.statistics == second.statistics


def test_the_methods_tell_what_the_article_is_about() -> None:
    outcome, result = run_both(make_mesh(solids.subdivide(solids.comb(), 2)))
    assert result.statistics.by_poles == 0
    assert outcome.statistics.by_poles > 0
    for counts in (outcome.statistics, result.statistics):
        assert min(counts.by_determinant, counts.located, counts.flips) > 0
        assert 0 < counts.walked < 10 * counts.located
    assert Statistics(1, 2, 3, 4, 5) + Statistics(10, 20, 30, 40, 50) == Statistics(11, 22, 33, 44, 55)


def test_a_layout_is_there_for_those_who_ask() -> None:
    outcome = simplify_mesh(make_mesh(solids.box()), 0.0)
    with pytest.raises(ValueError, match="layout"):
        triangulate_standard(outcome)


def test_every_instance_of_a_mesh_is_there() -> None:
    mesh = make_mesh(solids.comb())
    mirrored = np.diag([-1.0, 1, 1, 1])
    mirrored[0, 3] = -10
    mesh.transforms = np.stack([np.eye(4), mirrored])
    scene = Scene(None, "arrays", [mesh], 0)
    results, _ = simplify_meshes(scene, Options(tolerance=Tolerance(0.0, "length")), keep_layout=True)
    standard = build_standard_surface(scene, results)
    _, alone = run_both(mesh)
    assert len(standard.surface.points) == 2 * len(np.unique(alone.triangles))
    assert standard.note == ""
    area, volume = measure_area_and_volume(alone.points, alone.triangles)
    assert measure_area_and_volume(standard.surface.points, standard.surface.faces) == pytest.approx(
        (2 * area, 2 * volume)
    )


def compare_methods(path: Path, tolerance: Tolerance) -> None:
    """The standard method's points and edges beside the improved method's."""
    scene = read_scene(path)
    options = Options(tolerance=tolerance, delimit=frozenset())
    results, _ = simplify_meshes(scene, options, keep_layout=True)
    standard = build_standard_surface(scene, results)
    improved = place_scene(scene, [outcome.mesh for outcome in results])
    assert len(improved.points) <= len(standard.surface.points)
    assert standard.statistics.by_poles == 0
    for outcome in results:
        assert_same_rim(outcome)


def assert_same_rim(outcome: MeshResult) -> None:
    """Open edges run where they ran, and no edge is used more than twice where none was."""
    core, layout = conform(outcome), outcome.layout
    points = np.concatenate([outcome.points, core.made])
    open_before, crowded_before = measure_rim(layout, outcome.points, layout.triangles, layout.patch_of_triangle)
    open_after, crowded_after = measure_rim(layout, points, core.triangles, core.facet_of_triangle)
    assert open_after == pytest.approx(open_before, rel=1e-9)
    assert crowded_before > 0 or crowded_after == 0


def measure_rim(layout: Attempt, points: np.ndarray, triangles: np.ndarray, facet: np.ndarray) -> tuple[float, int]:
    """Length of the open edges, and how many edges are used more than twice.

    Of the two sides of a sheet the first counts: its diagonals may be those of the second, and need not.
    """
    edges, _, count = judge.count_edges(triangles[layout.outlines.chains.back[facet] < facet])
    length = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    return float(length[count == 1].sum()), int((count > 2).sum())


@pytest.mark.parametrize("name", ["building_a.obj", "building_b.glb"])
def test_our_own_buildings_need_more_points(name: str, data: Path) -> None:
    compare_methods(data / name, Tolerance())
    compare_methods(data / name, Tolerance(0.1, "percent"))


@pytest.mark.parametrize("name", defer(MODELS, LARGE_MODELS))
def test_no_model_needs_fewer_points(name: str, models: Path) -> None:
    compare_methods(models / name, Tolerance())
    if name not in SLOW_WHEN_ROUGH:
        compare_methods(models / name, Tolerance(0.1, "percent"))
