"""Triangles that pass through one another: found exactly, and never made."""

from __future__ import annotations

import itertools
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import solids
from judged import simplify_and_judge
from numpy.typing import NDArray
from quick import LARGE_MODELS, defer

from bldsimp import _core
from bldsimp.io import read
from bldsimp.options import Options, Tolerance
from bldsimp.scene import simplify_scene

CROSSING = 6
"""Place of this reason among the refusals of the collapse."""

Vector = tuple[Fraction, ...]
Polygon = list[Vector]


def minus(a: Vector, b: Vector) -> Vector:
    return tuple(x - y for x, y in zip(a, b, strict=True))


def dot(a: Vector, b: Vector) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def normal(triangle: Polygon) -> Vector:
    a, b, c = triangle
    return cross(minus(b, a), minus(c, a))


def inside(triangle: Polygon, point: Vector) -> bool:
    """Whether a point of the triangle's plane is inside of it, sides not included."""
    n = normal(triangle)
    return all(
        dot(cross(minus(triangle[(i + 1) % 3], triangle[i]), minus(point, triangle[i])), n) > 0 for i in range(3)
    )


def clipped(polygon: Polygon, through: Vector, inward: Vector) -> Polygon:
    """The part of a convex polygon on one side of a plane."""
    kept: Polygon = []
    for p, q in itertools.pairwise([*polygon, polygon[0]]):
        a, b = dot(minus(p, through), inward), dot(minus(q, through), inward)
        if a >= 0:
            kept.append(p)
        if a * b < 0:
            kept.append(tuple(x + a / (a - b) * (y - x) for x, y in zip(p, q, strict=True)))
    return kept


def oracle(f: NDArray[np.float64], g: NDArray[np.float64]) -> bool:
    """Whether two triangles have an inner point in common: what is left of f within g holds one if any does."""
    first, second = ([tuple(map(Fraction, p)) for p in t.tolist()] for t in (f, g))
    n, m = normal(first), normal(second)
    if not any(n) or not any(m) or set(first) == set(second):
        return False
    common = first
    for i in range(3):
        if common:
            common = clipped(common, second[i], cross(m, minus(second[(i + 1) % 3], second[i])))
    above = [dot(minus(p, second[0]), m) for p in common]
    if common and any(above):  # the piece of the line in which the planes meet
        common = [p for p, h in zip(common, above, strict=True) if h == 0] + [
            tuple(x + a / (a - b) * (y - x) for x, y in zip(p, q, strict=True))
            for (p, a), (q, b) in itertools.combinations(zip(common, above, strict=True), 2)
            if a * b < 0
        ]
    if not common:
        return False
    middle = tuple(sum(x, Fraction(0)) / len(common) for x in zip(*common, strict=True))
    return inside(first, middle) and inside(second, middle)


def crossing(points: NDArray[np.float64], faces: list[list[int]]) -> list[tuple[int, int]]:
    found = _core.find_crossings(np.array(points, float), np.array(faces, np.int32).reshape(-1, 3))
    return [(int(f), int(g)) for f, g in found]


def expected(points: NDArray[np.float64], faces: list[list[int]]) -> list[tuple[int, int]]:
    pairs = itertools.combinations(range(len(faces)), 2)
    return [(f, g) for f, g in pairs if oracle(points[faces[f]], points[faces[g]])]


@pytest.mark.parametrize("size", defer([2, 3, 4, 7], [3, 7]))
def test_grid_triangles_cross_as_fractions_tell(size: int) -> None:
    """Small grids hold every kind of touching: shared corners and edges, corners on edges, one plane."""
    rng = np.random.default_rng(size)
    some = 0
    for _ in range(60):
        points = np.unique(rng.integers(0, size, (6, 3)), axis=0).astype(float)
        if len(points) < 3:
            continue
        faces = [rng.choice(len(points), 3, replace=False).tolist() for _ in range(6)]
        assert crossing(points, faces) == expected(points, faces)
        some += len(expected(points, faces))
    assert some > 20


def test_nearly_flat_triangles_cross_as_fractions_tell() -> None:
    """Off by units in the last place, so that no filter can tell."""
    rng = np.random.default_rng(8)
    some = 0
    for _ in range(60):
        flat = rng.integers(0, 5, (7, 2)) @ rng.choice([0.1, 1 / 3, 0.7], (2, 3))
        points = np.unique(flat + rng.integers(-1, 2, flat.shape) * 2.0**-53, axis=0)
        faces = [rng.choice(len(points), 3, replace=False).tolist() for _ in range(6)]
        assert crossing(points, faces) == expected(points, faces)
        some += len(expected(points, faces))
    assert some > 100


@pytest.mark.parametrize("power", [-300, -70, 100, 300])
def test_coordinates_of_any_size(power: int) -> None:
    points = np.random.default_rng(3).integers(0, 5, (9, 3)).astype(float)
    faces = np.random.default_rng(4).permuted(np.tile(np.arange(9), (20, 1)), axis=1)[:, :3].tolist()
    assert crossing(points, faces)
    assert crossing(points * 2.0**power, faces) == crossing(points, faces)


def test_what_touches_does_not_cross() -> None:
    slab = [[0, 0, 0], [4, 0, 0], [0, 4, 0]]
    wall = [[1, 1, 0], [2, 1, 0], [1, 1, 3]]
    on_its_corner = [[1, 2, 0], [1, 3, 1], [2, 2, 1]]
    beside = [[4, 0, 0], [0, 4, 0], [4, 4, 0]]
    points = np.array(slab + wall + on_its_corner + beside)
    assert crossing(points, [[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 10, 11]]) == []


def test_folds_overlaps_and_copies() -> None:
    points = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, 0], [0, -4, 0], [0, 0, 4]])
    fold, flat, up = [[0, 1, 2], [0, 1, 3]], [[0, 1, 2], [1, 0, 4]], [[0, 1, 2], [0, 1, 5]]
    assert crossing(points, fold) == [(0, 1)]
    assert crossing(points, flat) == crossing(points, up) == []
    assert crossing(points, [[0, 1, 2], [2, 1, 0], [1, 2, 0]]) == []
    assert crossing(points, [[0, 1, 2], [0, 1, 1]]) == []


def test_only_what_is_wanted_is_looked_for() -> None:
    points = np.random.default_rng(1).random((60, 3))
    faces = np.arange(60, dtype=np.int32).reshape(-1, 3)
    wanted = (np.arange(20) % 3 == 0).astype(np.uint8)
    of_all = [tuple(pair) for pair in _core.find_crossings(points, faces).tolist()]
    of_some = [tuple(pair) for pair in _core.find_crossings(points, faces, wanted).tolist()]
    assert of_some == [(f, g) for f, g in of_all if wanted[f] or wanted[g]]
    assert 0 < len(of_some) < len(of_all)


def of_meshes(meshes: list[solids.Shape]) -> int:
    """Pairs of faces that cross, by mesh, after an exact weld."""
    welded = [
        _core.weld(np.ascontiguousarray(points, np.float64), np.ascontiguousarray(faces, np.int32), 0.0)
        for points, faces in meshes
    ]
    return sum(len(_core.find_crossings(each.points, each.faces)) for each in welded)


def before_and_after(path: Path, tolerance: Tolerance) -> tuple[int, int, int]:
    """Pairs that cross in a model and in its result, and the points of that."""
    scene = read(path, path.suffix[1:].lower())
    lights, report = simplify_scene(scene, Options(tolerance=tolerance, delimit=frozenset()))
    before = of_meshes([(mesh.points, mesh.faces) for mesh in scene.meshes])
    return before, of_meshes([(light.points, light.faces) for light in lights]), report.after.points


TOLERANCES = [Tolerance(), Tolerance(1e-3, "percent"), Tolerance(0.1, "percent"), Tolerance(0.5, "percent")]


@pytest.mark.parametrize("tolerance", TOLERANCES, ids=str)
@pytest.mark.parametrize("name", ["building_a.obj", "building_b.obj"])
def test_buildings_do_not_come_to_cross(name: str, tolerance: Tolerance, data: Path) -> None:
    assert before_and_after(data / name, tolerance)[:2] == (0, 0)


CLEAN = (
    "broken/manifold_Havocglass8_left.obj", "broken/manifold_Offset2.obj", "broken/pmp_fandisk.off",
    "broken/trimesh_busted.STL", "broken/trimesh_plate_holes.STL", "exact/oversampled_10k.ply",
    "noisy/abspy_test_church.obj", "textured/khronos_NegativeScaleTest.glb",
)  # fmt: skip


@pytest.mark.parametrize("tolerance", TOLERANCES, ids=str)
@pytest.mark.parametrize("name", defer(CLEAN, LARGE_MODELS))
def test_models_do_not_come_to_cross(name: str, tolerance: Tolerance, models: Path) -> None:
    assert before_and_after(models / name, tolerance)[:2] == (0, 0)


def test_crossings_of_the_input_hinder_little(models: Path) -> None:
    before, after, points = before_and_after(models / "noisy/easy3d_building.off", Tolerance(0.5, "percent"))
    # They may move on, or go, but not become more.
    assert after <= before
    assert points < 600


DENT = 1e-5
FINE = 4e-5
"""So near that facets alone deal with it."""


def dented_plate() -> solids.Shape:
    """A plate of which one side has a shallow dent."""
    return solids.fan_polygons([(2, DENT, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0), (0, 0, 0)])


def bulging_plate() -> solids.Shape:
    """A plate whose middle is a little too high."""
    return solids.shape(
        [(0, 0, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0), (2, 2, DENT)], [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    )


def spike(x: float, y: float, top: float) -> solids.Shape:
    return solids.shape([(x - 0.1, y, -1), (x + 0.1, y, -1), (x, y, top)], [(0, 1, 2)])


@pytest.mark.parametrize(
    ("plate", "pierced_by"), [(dented_plate(), spike(2, DENT / 2, 1)), (bulging_plate(), spike(2, 2, DENT / 2))]
)
def test_facets_step_down_where_they_would_be_pierced(plate: solids.Shape, pierced_by: solids.Shape) -> None:
    alone = simplify_and_judge(plate, FINE)
    assert len(alone.after.points) == 4
    both = solids.merge(plate, pierced_by)
    assert of_meshes([both]) == 0
    held = simplify_and_judge(both, FINE)
    assert len(held.after.points) == 8
    assert held.report.fallback_reasons == {"pierced": 1}
    assert of_meshes([held.result]) == 0


def test_facets_that_were_pierced_may_be() -> None:
    """The side is pierced before and after, and need not step down."""
    both = solids.merge(dented_plate(), spike(2, 2 * DENT, 1))
    assert of_meshes([both]) > 0
    assert len(simplify_and_judge(both, FINE).after.points) == 7


def sheets(cells: int, gap: float, noise: float, waves: float, layers: int = 2) -> solids.Shape:
    """Wavy sheets, one above the other, their points a little up or down."""
    rng = np.random.default_rng(6)
    x, y = np.meshgrid(np.arange(cells + 1.0), np.arange(cells + 1.0), indexing="ij")
    corner = np.arange((cells + 1) ** 2).reshape(x.shape)
    a, b, c, d = (corner[i : i + cells, j : j + cells].ravel() for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
    sheet = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    wave = waves * np.sin(x / 3) * np.cos(y / 4)
    heights = [gap * k + wave + rng.uniform(-noise, noise, x.shape) for k in range(layers)]
    points = np.concatenate([np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1) for z in heights])
    return solids.shape(points, np.concatenate([sheet + k * corner.size for k in range(layers)]))


@pytest.mark.parametrize("cells", defer([20, 80], [80]))
def test_sheets_nearer_than_the_tolerance_do_not_come_to_cross(cells: int) -> None:
    """The larger ones are collapsed in blocks."""
    points, faces = sheets(cells, 0.1, 0.04, 1.0)
    welded = _core.weld(points, faces.astype(np.int32), 0.0)
    faces = np.array(welded.faces)
    label, none = np.zeros(len(faces), np.int32), np.zeros(len(faces), np.uint8)
    assert len(_core.find_crossings(welded.points, faces)) == 0
    found = _core.collapse(welded.points, faces, label, none, none, 0.3, 4, False)
    assert len(found.triangles) < len(faces) / 4
    assert found.refusals[CROSSING] > 0
    assert len(_core.find_crossings(found.points, found.triangles)) == 0


def far_sheet(height: float) -> solids.Shape:
    """A flat sheet of 8,450 faces: with two of them a mesh is collapsed in blocks, one with each of them."""
    points, faces = sheets(65, 0.0, 0.0, 0.0, layers=1)
    return solids.shape(points / 65 + (0, 0, height), faces)


def in_two_blocks(lower: solids.Shape, upper: solids.Shape, decimals: int) -> tuple[solids.Shape, solids.Shape]:
    """Two shapes with as many faces each, before and after they were collapsed in a block each."""
    points, faces = solids.merge(lower, upper, far_sheet(-9.0), far_sheet(9.0))
    welded = _core.weld(np.ascontiguousarray(points), faces.astype(np.int32), 0.0)
    label, none = np.zeros(len(faces), np.int32), np.zeros(len(faces), np.uint8)
    found = _core.collapse(welded.points, welded.faces, label, none, none, 0.3, decimals, False)
    return (np.array(welded.points), np.array(welded.faces)), (np.array(found.points), np.array(found.triangles))


def notched_ridge() -> solids.Shape:
    """A roof whose ridge dips in its middle."""
    a, b, c, d = (-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1)
    e, dip, f = (-1, 0, 0), (0, 0, -0.15), (1, 0, 0)
    return solids.fan_polygons((a, b, dip), (a, dip, e), (b, f, dip), (c, d, dip), (c, dip, f), (d, e, dip))


def blunt_tip(cut: float = 0.14) -> solids.Shape:
    """A pyramid without its tip, which would be at the origin."""
    base = solids.square()[0] * 2 - (1, 1, 0)
    low, high = base - (0, 0, 1), base * cut - (0, 0, cut)
    return solids.fan_polygons(*((low[i - 1], low[i], high[i], high[i - 1]) for i in range(4)), high)


def test_what_two_blocks_changed_does_not_come_to_cross() -> None:
    """A ridge and a trough across it, both rid of the dent by which they passed each other."""
    ridge = notched_ridge()
    trough = solids.shape(ridge[0][:, [1, 0, 2]] * (1, 1, -1) + (0, 0, -0.1), ridge[1])
    before, after = in_two_blocks(ridge, trough, decimals=-1)
    assert len(_core.find_crossings(*before)) == 0
    assert len(_core.find_crossings(*after)) == 0
    assert len(after[1]) < 24


def test_points_of_two_blocks_do_not_move_to_one_place() -> None:
    """Two blunt tips, one above the other, which both would be sharp at the same place."""
    tip = blunt_tip()
    before, after = in_two_blocks(tip, solids.shape(tip[0] * (1, 1, -1), tip[1][:, ::-1]), decimals=0)
    used = after[0][np.unique(after[1])] + 0.0  # no zero is negative
    assert len(used) < len(before[0]) / 100
    assert len(np.unique(used, axis=0)) == len(used)
