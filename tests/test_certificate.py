"""The certificate of the release build: bounds of two surfaces, and checks of a change, beside dense samples."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from shapes import box, fine_box

from bldsimp import _core
from bldsimp.compare.measure import sample_surface

Arrays = tuple[NDArray[np.float64], NDArray[np.int32]]

ROUNDING = 1e-12


def make_sheet(random: np.random.Generator, side: int, noise: float) -> Arrays:
    """Make a square of 1 by 1 in `side` by `side` cells, its points moved by some noise, cut along random diagonals."""
    x, y = np.meshgrid(np.linspace(0, 1, side + 1), np.linspace(0, 1, side + 1))
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1) + random.uniform(-noise, noise, (x.size, 3))
    corner = (np.arange(side) + (side + 1) * np.arange(side)[:, None]).ravel()
    a, b, c, d = corner, corner + 1, corner + side + 2, corner + side + 1
    one, other = ([a, b, c], [a, c, d]), ([a, b, d], [b, c, d])
    turned = random.random(len(a)) < 0.5
    halves = [np.where(turned, first, second).T for first, second in zip(one, other, strict=True)]
    return points, np.concatenate(halves).astype(np.int32)


def make_soup(random: np.random.Generator) -> Arrays:
    """Make faces between any of a few points: needles, segments and points among them."""
    points = random.uniform(-1, 1, (12, 3)).round(random.integers(0, 4))
    return points, random.integers(0, 12, (random.integers(1, 20), 3)).astype(np.int32)


@pytest.mark.parametrize("seed", range(30))
def test_a_bound_is_never_below_samples_and_near_them_where_they_are_dense(seed: int) -> None:
    random = np.random.default_rng(seed)
    if seed % 3:
        one, other = (make_sheet(random, int(random.integers(1, 9)), 10.0 ** -random.integers(1, 4)) for _ in range(2))
    else:
        one, other = make_soup(random), make_soup(random)
    tree = _core.FaceTree(*other)
    sampled = tree.farthest(np.concatenate([one[0][one[1]].reshape(-1, 3), sample_surface(*one)]), np.inf)
    bounds = {precision: tree.bound(*one, precision).distance for precision in (1e-1, 1e-3, 1e-5)}
    for precision, bound in bounds.items():
        assert sampled - ROUNDING <= bound
        assert bound <= bounds[1e-5] + precision + ROUNDING
    assert bounds[1e-5] <= sampled + 0.05
    for share in (0.5, 0.99, 1.01, 2.0):
        limit = share * bounds[1e-5] + 1e-9
        if tree.holds(*one, limit):
            assert sampled <= limit + ROUNDING
        else:
            assert bounds[1e-5] > 0.95 * limit
    assert tree.bound(*one, 1e-5, 10.0).distance == 10.0


def test_the_same_surface_in_other_faces_is_next_to_nothing_away() -> None:
    fine, coarse = fine_box(), box()
    for (points, faces), other in ((fine, coarse), (coarse, fine)):
        tree = _core.FaceTree(other[0], np.asarray(other[1], np.int32))
        assert tree.bound(points, faces, 0.0).distance < 1e-13
        assert tree.holds(points, faces, 1e-12)
        assert not tree.holds(points + 1e-3, faces, 1e-4)


def test_the_number_of_cells_does_not_grow_as_the_limit_shrinks() -> None:
    """The tenfold precision asks for more only where the farthest point lies."""
    random = np.random.default_rng(1)
    (points, faces), other = make_sheet(random, 20, 1e-3), make_sheet(random, 7, 1e-3)
    tree = _core.FaceTree(*other)
    cells = [tree.bound(points, faces, 10.0**-digits).cells for digits in range(4, 10)]
    assert max(cells) < 30 * (len(faces) + len(other[1]))


def test_it_is_the_same_whatever_the_order_of_the_faces_but_for_the_precision() -> None:
    random = np.random.default_rng(2)
    (points, faces), other = make_sheet(random, 12, 1e-2), make_sheet(random, 12, 1e-2)
    tree = _core.FaceTree(*other)
    shuffled = random.permutation(faces)
    assert tree.bound(points, faces, 1e-6).distance == pytest.approx(
        tree.bound(points, shuffled, 1e-6).distance, abs=2e-6
    )


def test_faces_out_of_range_are_refused() -> None:
    tree = _core.FaceTree(*make_sheet(np.random.default_rng(0), 1, 0.0))
    with pytest.raises(IndexError):
        tree.bound(np.zeros((3, 3)), np.array([[0, 1, 3]], np.int32), 1.0)
    with pytest.raises(IndexError):
        tree.holds(np.zeros((3, 3)), np.array([[0, 1, 3]], np.int32), 1.0)
