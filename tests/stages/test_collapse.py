"""Collapses of edges: what goes, what stays, and that the bound holds."""

from __future__ import annotations

import judge
import numpy as np
import pytest
import solids
from quick import defer
from solids import Shape

from bldsimp import _core

ROUNDING = 1e-14  # the kernel's own bound leaves it out


def collapsed(mesh: Shape, tolerance: float, label: list[int] | None = None, pinned: list[int] | None = None):
    """A mesh with its edges collapsed, over points in lexicographic order, and what the kernel tells."""
    welded = _core.weld(*(np.ascontiguousarray(a, t) for a, t in zip(mesh, (np.float64, np.int32), strict=True)), 0.0)
    faces = np.array(welded.faces)
    labels = np.zeros(len(faces), np.int32) if label is None else np.array(label, np.int32)[welded.source]
    stays = np.zeros(len(faces), np.uint8)
    if pinned is not None:
        stays[np.isin(welded.source, pinned)] = 1
    none = np.zeros(len(faces), np.uint8)
    found = _core.collapse(welded.points, faces, labels, stays, none, tolerance, 15, False)
    return (np.array(found.points), np.array(found.triangles)), found


def count(mesh: Shape) -> int:
    return len(np.unique(mesh[1]))


def test_a_flat_plate_keeps_its_corners() -> None:
    result, found = collapsed(solids.subdivide(solids.square(), 3), 1e-3)
    assert (count(result), len(result[1])) == (4, 2)
    assert found.deviation <= 1e-3


@pytest.mark.parametrize("seed", range(3))
def test_noise_goes_and_what_was_closed_stays_closed(seed: int) -> None:
    mesh = solids.add_noise(solids.subdivide(solids.box(), 3), 0.01, seed)
    result, found = collapsed(mesh, 0.05)
    before, after = judge.make_surface(*mesh), judge.make_surface(*result)
    assert count(result) <= 30
    assert judge.find_broken(before, after, 0.05, found.deviation + ROUNDING, healed=0, count=2000) == []


@pytest.mark.parametrize("make", [solids.frame, solids.moebius, solids.plate_with_holes, solids.room_with_cavity])
@pytest.mark.parametrize("tolerance", defer([0.01, 0.1, 1.0], [0.01]))
def test_topology_and_bound_hold_at_any_tolerance(make, tolerance: float) -> None:  # type: ignore[no-untyped-def]
    mesh = solids.subdivide(make(), 2)
    result, found = collapsed(mesh, tolerance)
    before, after = judge.make_surface(*mesh), judge.make_surface(*result)
    assert judge.find_broken(before, after, tolerance, found.deviation + ROUNDING, healed=0) == []
    assert found.accepted > 0


def test_pinned_faces_stay() -> None:
    mesh = solids.subdivide(solids.square(), 2)
    result, _ = collapsed(mesh, 1e-3, pinned=[0])
    kept = {tuple(sorted(map(tuple, result[0][face].tolist()))) for face in result[1]}
    assert tuple(sorted(map(tuple, np.asarray(mesh[0])[mesh[1][0]].tolist()))) in kept


def test_edges_between_labels_stay_edges_between_them() -> None:
    points, faces = solids.subdivide(solids.square(), 3)
    middle = np.asarray(points)[faces].mean(axis=1)
    half = (np.max(points, axis=0) + np.min(points, axis=0))[0] / 2
    label = (middle[:, 0] > half).astype(np.int32)
    result, found = collapsed((points, faces), 1e-3, label=label.tolist())
    sides = np.sign(result[0][result[1]].mean(axis=1)[:, 0] - half)
    welded = _core.weld(np.ascontiguousarray(points, np.float64), np.ascontiguousarray(faces, np.int32), 0.0)
    assert np.array_equal(sides > 0, label[welded.source][found.source] == 1)
    assert count(result) == 6


def test_the_order_of_faces_does_not_matter() -> None:
    mesh = solids.add_noise(solids.subdivide(solids.frame(), 2), 0.01)
    results = [collapsed(m, 0.03)[0] for m in (mesh, solids.shuffle(mesh))]
    shapes = [sorted(tuple(sorted(map(tuple, points[f].tolist()))) for f in faces) for points, faces in results]
    assert shapes[0] == shapes[1]


@pytest.mark.parametrize("share", [1e-2, 1e-4])
def test_the_bound_holds_for_faces_that_are_long_beside_the_tolerance(share: float) -> None:
    """A flat strip cut along one diagonal becomes one that is cut along another."""
    length, cuts = 30.0, 4
    x = np.repeat(np.linspace(0, length, cuts), 2)
    points = np.stack([x, np.tile([0.0, 1.0], cuts), np.zeros_like(x)], axis=1)
    first = 2 * np.arange(cuts - 1)
    faces = np.concatenate([np.stack([first + i for i in corners], axis=1) for corners in ((0, 2, 1), (1, 2, 3))])
    result, found = collapsed((points, faces), share * length)
    assert len(result[1]) == 2
    assert found.deviation <= share * length
