"""Boundary loops that a wide tolerance closes."""

from __future__ import annotations

import judge
import numpy as np
import pytest
import solids
from quick import defer
from solids import Shape

from bldsimp import _core
from bldsimp.model import Faces, Mesh, Part, Points, Scene
from bldsimp.options import Options, Tolerance
from bldsimp.report import Report
from bldsimp.scene import simplify_scene
from bldsimp.stages.removal import DETAIL_KINDS

BOUNDARY_LOOP = DETAIL_KINDS.index("boundary_loop")


def simplified(mesh: Shape, tolerance: float, keep_topology: bool = False, parts: int = 1) -> tuple[Shape, Report]:
    """A mesh with its loops closed; faces are shared out to parts along x."""
    points, faces = solids.weld(mesh)
    part = np.minimum(points[faces].mean(axis=1)[:, 0] / points[:, 0].max() * parts, parts - 1).astype(np.int32)
    given = Mesh("mesh", points, np.ascontiguousarray(faces, np.int32), part, [Part(str(i)) for i in range(parts)])
    options = Options(tolerance=Tolerance(tolerance, "length"), keep_topology=keep_topology)
    (light,), report = simplify_scene(Scene(None, "arrays", [given], 0), options)
    before = judge.make_surface(points, faces)
    result = judge.make_surface(light.points, light.faces)
    assert judge.measure_deviation(before, result, 500) <= report.deviation + judge.estimate_blur(before)
    assert report.deviation <= report.tolerance + judge.estimate_blur(before)
    assert judge.count_topology(result).open_edges == report.after.open_edges
    return (light.points, light.faces), report


def holed_box(rounds: int = 4) -> Shape:
    """A box of side 4 with a triangle of 0.25 by 0.25 missing in the middle of a side."""
    mesh = solids.subdivide(solids.box((4, 4, 4)), rounds)
    middle = mesh[0][mesh[1]].mean(axis=1)
    return solids.remove_faces(mesh, int(np.argmin(np.abs(middle - (2, 2, 4)).sum(axis=1))))


def test_a_hole_closes_unless_the_topology_is_kept() -> None:
    _, report = simplified(holed_box(), 0.1)
    assert (report.closed_boundary_loops, report.before.open_edges, report.after.open_edges) == (1, 3, 0)
    assert (report.after.points, report.after.watertight) == (8, True)
    _, report = simplified(holed_box(), 0.1, keep_topology=True)
    assert report.closed_boundary_loops == 0
    assert report.after.open_edges > 0


def test_a_hole_that_is_too_large_stays() -> None:
    # The middle of the hole is 0.073 from its rim.
    assert simplified(holed_box(), 0.07)[1].closed == 0
    assert simplified(holed_box(), 0.075)[1].closed == 1


def test_a_sheet_gets_no_back() -> None:
    for mesh in (solids.box((4, 4, 0.01)), solids.box((4, 0.01, 4))):
        strip = solids.remove_faces(mesh, *range(2, 12))
        assert simplified(solids.subdivide(strip, 2), 0.05)[1].closed == 0
    assert simplified(solids.subdivide(solids.square(), 2), 2.0)[1].closed == 0


def test_both_ends_of_a_narrow_pipe_close() -> None:
    angle = np.arange(8) * np.pi / 4
    pipe = solids.prism(0.04 * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    normal = np.cross(*(pipe[0][pipe[1][:, i]] - pipe[0][pipe[1][:, 0]] for i in (1, 2)))
    mesh = solids.remove_faces(pipe, *np.flatnonzero(np.abs(normal[:, 2]) > 1e-9).tolist())
    _, report = simplified(solids.move(solids.subdivide(mesh, 1), (5, 5, 0)), 0.05)
    assert (report.closed_boundary_loops, report.after.watertight) == (2, True)
    assert simplified(solids.move(mesh, (5, 5, 0)), 0.03)[1].closed == 0


def test_a_loop_between_two_parts_stays() -> None:
    assert simplified(holed_box(), 0.1, parts=2)[1].closed == 0
    assert simplified(holed_box(), 0.1, parts=1)[1].closed == 1


def close_loops(points: Points, faces: Faces, limit: float) -> _core.FeatureRemoval:
    """Close loops, and remove nothing else."""
    zeros, flags = np.zeros(len(faces), np.int32), np.zeros(len(faces), np.uint8)
    found = _core.remove_features(
        points, faces, zeros, zeros, np.zeros(len(points), np.uint8), flags, flags, limit, 1e-9, -1, False, False, 1000
    )
    assert len(found.faces) == len(found.parent)
    return found


def lids(mesh: Shape, limit: float = 10.0) -> tuple[int, int]:
    """Loops and faces that close them."""
    points, faces = solids.weld(mesh)
    faces = np.ascontiguousarray(faces, np.int32)
    found = close_loops(points, faces, limit)
    return np.count_nonzero(found.kinds == BOUNDARY_LOOP), len(found.faces)


def test_lids_cross_nothing_and_lie_on_nothing() -> None:
    open_box = solids.remove_faces(solids.box((1, 1, 4)), 2, 3)
    assert lids(open_box) == (1, 2)
    pole = solids.shape([[0.25, 0.25, 3], [0.35, 0.25, 5], [0.25, 0.35, 5]], [[0, 1, 2]])
    assert lids(solids.merge(open_box, pole)) == (0, 0)
    pane = solids.shape([[0.25, 0.25, 4], [0.75, 0.25, 4], [0.25, 0.75, 4]], [[0, 1, 2]])
    assert lids(solids.merge(open_box, pane)) == (0, 0)
    assert lids(solids.merge(open_box, solids.move(pane, (0, 0, -0.5)))) == (1, 2)


def test_a_lid_adds_no_face_to_an_edge_that_is_whole() -> None:
    # Two bowls under one rim with a ridge between them: across it a lid would be shorter.
    rim = [(0, 0, 0), (1, -1.2, 0), (2, 0, 0), (1, 1.2, 0)]
    a, m, c, n = rim
    low, high = (1, -0.5, -1), (1, 0.5, -1)
    bowls = [(a, low, m), (m, low, c), (c, low, a), (c, high, n), (n, high, a), (a, high, c)]
    mesh = solids.fan_polygons(*bowls)
    assert lids(mesh) == (1, 2)
    faces = np.ascontiguousarray(mesh[1], np.int32)
    found = close_loops(mesh[0], faces, 10.0)
    assert _core.count_edges(np.concatenate([faces, found.faces]), len(mesh[0])) == (0, 0)


def test_loops_that_touch_stay() -> None:
    mesh = solids.subdivide(solids.square(), 3)
    faces, middle = mesh[1], np.mean(mesh[0][mesh[1]], axis=1)
    inside = np.flatnonzero(np.abs(middle[:, :2] - 0.5).max(axis=1) < 0.3)
    first = inside[np.argmin(np.abs(middle[inside, :2] - 0.5).sum(axis=1))]
    touching = [f for f in inside if len(np.intersect1d(faces[f], faces[first])) == 1]
    assert len(touching) > 4
    for other in touching:
        assert lids(solids.remove_faces(mesh, int(first), int(other)), 0.1) == (0, 0)
    assert lids(solids.remove_faces(mesh, int(first)), 0.1) == (1, 1)


def test_the_deviation_of_a_lid_alone_is_counted() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], np.int32)
    ones, zeros = np.ones(4, np.uint8), np.zeros(4, np.uint8)
    found = _core.collapse(points, faces, np.zeros(4, np.int32), ones, zeros, 1.0, 15, False, 1)
    assert (found.accepted, found.moved, len(found.triangles), len(found.holder)) == (0, 0, 4, 3)
    # From the middle of the fourth face to the others.
    assert 0.3 < found.deviation <= 1.0


@pytest.mark.parametrize("seed", defer(range(6), range(2, 6)))
def test_any_holes_in_a_rough_box_stay_within_the_bound(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mesh = solids.add_noise(solids.subdivide(solids.box((4, 3, 2)), 3), 0.01, seed)
    gone = rng.choice(len(mesh[1]), int(rng.integers(1, 60)), replace=False)
    holed = solids.remove_faces(mesh, *gone.tolist())
    for tolerance in (0.03, 0.1, 0.3):
        _, report = simplified(holed, tolerance)
        assert report.after.open_edges <= report.before.open_edges
        assert report.after.nonmanifold_edges == 0


def test_the_order_of_faces_does_not_matter() -> None:
    mesh = solids.subdivide(solids.box((4, 3, 2)), 3)
    holed = solids.remove_faces(mesh, *range(5, 300, 23))
    results = [simplified(one, 0.3)[0] for one in (holed, solids.shuffle(holed))]
    assert len({frozenset(judge.collect_triangles(judge.make_surface(*one))) for one in results}) == 1


def test_blocks_do_not_rely_on_lids() -> None:
    """A large sheet is collapsed in blocks; the middles of its lids lie nearly a tolerance away from it."""
    cells, every, size, tolerance = 120, 10, 3, 1.55
    x, y = np.meshgrid(np.arange(cells + 1.0), np.arange(cells + 1.0), indexing="ij")
    z = 0.6 * tolerance * np.sin(x * 2 * np.pi / 23) * np.cos(y * 2 * np.pi / 23)
    corner = np.arange(x.size).reshape(x.shape)
    i, j = np.meshgrid(np.arange(cells), np.arange(cells), indexing="ij")
    stays = (i % every >= size) | (j % every >= size)
    a, b, c, d = (corner[i + k, j + n][stays] for k, n in ((0, 0), (1, 0), (1, 1), (0, 1)))
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    _, report = simplified(solids.shape(np.stack([x, y, z], axis=-1).reshape(-1, 3), faces), tolerance)
    assert report.closed_boundary_loops == 12 * 12 - 23  # those at the rim are no loops of their own
    assert report.after.points < 1000
