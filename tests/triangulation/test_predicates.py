"""Exact signs, against fractions and over every small case."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import numpy as np
import oracle
import pytest
from hypothesis import given
from hypothesis import strategies as st
from quick import try_examples

from bldsimp import _core

FINITE = st.floats(allow_nan=False, allow_infinity=False)
COORDINATE = st.one_of(
    FINITE,
    st.integers(-3, 3).map(float),
    st.floats(-1, 1, width=32).map(float),
    # Close to each other, so that filters fail.
    st.integers(-4, 4).map(lambda k: 0.5 + k * 2.0**-53),
    st.sampled_from([5e-324, -5e-324, 2.0**-1022, 1.7e308, -1.7e308, 3.4e38, 1e-200, 0.1, 0.2, 0.3, 1 / 3]),
)
POINT = st.tuples(COORDINATE, COORDINATE)


def columns(rows: list) -> list[np.ndarray]:
    """One array of points per argument of a predicate."""
    return [np.ascontiguousarray(column) for column in np.swapaxes(np.array(rows, float), 0, 1)]


def near_degenerate(dimension: int, arguments: int, count: int) -> list:
    """Points on a line, or nearly: multiples of one direction, off by units in the last place."""
    rng = np.random.default_rng(5)
    along = rng.integers(1, 64, (count, arguments, 1))
    rows = 0.5 + along * rng.choice([2.0**-50, 1 / 3, 0.1], (count, 1, dimension))
    return (rows + rng.integers(-1, 2, rows.shape) * 2.0**-52).tolist()


def orient3d(a, b, c, d) -> int:
    """Sign of the determinant of a - d, b - d, c - d, in fractions."""
    u, v, w = ([Fraction(x) - Fraction(y) for x, y in zip(p, d, strict=True)] for p in (a, b, c))
    cross = (v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0])
    return oracle.sign(oracle.dot(u, cross))


@given(st.lists(st.tuples(POINT, POINT, POINT), min_size=1, max_size=20))
def test_orient2d_is_exact(rows):
    expected = [oracle.orient2d(*oracle.make_exact(row)) for row in rows]
    assert _core.orient2d(*columns(rows)).tolist() == expected


@given(st.lists(st.tuples(POINT, POINT, POINT, POINT), min_size=1, max_size=20))
def test_incircle_is_exact(rows):
    expected = [oracle.incircle(*oracle.make_exact(row)) for row in rows]
    assert _core.incircle(*columns(rows)).tolist() == expected


@given(st.lists(st.tuples(*[st.tuples(COORDINATE, COORDINATE, COORDINATE)] * 4), min_size=1, max_size=20))
def test_orient3d_is_exact(rows):
    assert _core.orient3d(*columns(rows)).tolist() == [orient3d(*row) for row in rows]


def test_near_degenerate_points():
    triples, quadruples = near_degenerate(2, 3, 2000), near_degenerate(2, 4, 1000)
    spatial = near_degenerate(3, 4, 1000)
    assert _core.orient2d(*columns(triples)).tolist() == [oracle.orient2d(*oracle.make_exact(t)) for t in triples]
    assert _core.incircle(*columns(quadruples)).tolist() == [oracle.incircle(*oracle.make_exact(q)) for q in quadruples]
    assert _core.orient3d(*columns(spatial)).tolist() == [orient3d(*q) for q in spatial]


def test_signs_of_plain_cases():
    counter_clockwise = [[(0, 0), (1, 0), (0, 1)]]
    assert _core.orient2d(*columns(counter_clockwise)).tolist() == [1]
    assert _core.incircle(*columns([[*counter_clockwise[0], (0.5, 0.5)]])).tolist() == [1]
    assert _core.incircle(*columns([[*counter_clockwise[0], (1, 1)]])).tolist() == [0]
    below = [[(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, -1)]]
    assert _core.orient3d(*columns(below)).tolist() == [1]


def test_grid_of_spacing_of_one_unit_in_the_last_place():
    """The classic picture: the filter fails all over a grid at (0.5, 0.5) seen from (12, 12), (24, 24)."""
    steps = 0.5 + np.arange(32) * 2.0**-53
    rows = [[(x, y), (12.0, 12.0), (24.0, 24.0)] for x in steps for y in steps]
    assert _core.orient2d(*columns(rows)).tolist() == [oracle.sign(Fraction(a[1]) - Fraction(a[0])) for a, _, _ in rows]


@pytest.fixture(scope="module")
def grid_triples():
    grid = list(itertools.product(range(5), repeat=2))
    return list(itertools.product(grid, repeat=3))


def test_poles_are_never_wrong_on_a_grid(grid_triples):
    told = _core.direction_by_poles(*columns(grid_triples))
    true = _core.orient2d(*columns(grid_triples))
    assert ((told == 0) | (told == true)).all()
    # They tell unless one point is in the box of the others; on its sides it depends on the side.
    a, b, c = (np.array(column) for column in zip(*grid_triples, strict=True))
    inside, touching = np.zeros(len(a), bool), np.zeros(len(a), bool)
    for p, q, m in ((a, b, c), (b, c, a), (c, a, b)):
        least, most = np.minimum(p, q), np.maximum(p, q)
        inside |= ((least < m) & (m < most)).all(axis=1)
        touching |= ((least <= m) & (m <= most)).all(axis=1)
    assert (told[inside] == 0).all()
    assert (told[~touching] != 0).all()
    assert touching.any()
    assert (~touching).any()


def test_poles_agree_with_the_oracle(grid_triples):
    chosen = grid_triples[::7]
    assert _core.direction_by_poles(*columns(chosen)).tolist() == [oracle.direction_by_poles(*t) for t in chosen]


def test_neighboring_quadrants_are_a_case_of_the_poles(grid_triples):
    """Where the products of the determinant differ in sign, the poles tell, and the same."""
    a, b, m = (np.array(column) for column in zip(*grid_triples, strict=True))
    left = (a[:, 0] - m[:, 0]) * (b[:, 1] - m[:, 1])
    right = (a[:, 1] - m[:, 1]) * (b[:, 0] - m[:, 0])
    differ = left * right < 0
    assert differ.any()
    told = _core.direction_by_poles(*columns(grid_triples))
    assert (told[differ] == np.sign(left - right)[differ]).all()


@try_examples(50)
@given(st.integers(-900, 900), st.integers(0, 2**32))
def test_signs_survive_scaling_by_a_power_of_two(power, seed):
    points = np.random.default_rng(seed).random((4, 50, 2))
    scaled = points * 2.0**power
    assert (_core.orient2d(*scaled[:3]) == _core.orient2d(*points[:3])).all()
    assert (_core.incircle(*scaled) == _core.incircle(*points)).all()
    assert math.isfinite(scaled.max())
