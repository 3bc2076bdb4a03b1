"""The triangulation core against the oracle and SciPy, and what must hold of any input."""

from __future__ import annotations

import numpy as np
import oracle
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from planar import check, collect_shapes, compute_area, cross, ring
from quick import try_examples
from scipy.spatial import Delaunay

from bldsimp import TopologyError, triangulate

# Against others.


@try_examples(40)
@given(st.integers(4, 120), st.integers(0, 2**32))
def test_agrees_with_scipy(count, seed):
    points = np.random.default_rng(seed).random((count, 2))
    result = check(points, [], carve=False)
    expected = {frozenset(map(tuple, points[t].tolist())) for t in Delaunay(points).simplices}
    assert collect_shapes(result) == expected


def cells(triangles, points, constraints) -> set[frozenset[int]]:
    """Triangles merged across edges at which four points lie on one circle: what ties do not change."""
    apex = {(t[i], t[(i + 1) % 3]): t[(i + 2) % 3] for t in triangles for i in range(3)}
    owner = {(t[i], t[(i + 1) % 3]): n for n, t in enumerate(triangles) for i in range(3)}
    cell = list(range(len(triangles)))

    def root(i: int) -> int:
        while cell[i] != i:
            i = cell[i]
        return i

    for (a, b), c in apex.items():
        free = (b, a) in apex and (a, b) not in constraints and (b, a) not in constraints
        if free and oracle.incircle(points[a], points[b], points[c], points[apex[b, a]]) == 0:
            cell[root(owner[a, b])] = root(owner[b, a])
    merged: dict[int, set[int]] = {}
    for n, t in enumerate(triangles):
        merged.setdefault(root(n), set()).update(t)
    return {frozenset(vertices) for vertices in merged.values()}


def closed_chain(points: np.ndarray, rng: np.random.Generator) -> list[tuple[int, int]]:
    """A ring through some of the points, by angle around their middle: it does not cross itself."""
    chosen = rng.permutation(len(points))[: rng.integers(3, len(points) + 1)]
    arm = points[chosen] - points[chosen].mean(axis=0) - 1e-3
    order = chosen[np.argsort(np.arctan2(arm[:, 1], arm[:, 0]))]
    return [(int(a), int(b)) for a, b in zip(order, np.roll(order, -1), strict=True)]


@try_examples(60)
@given(st.integers(4, 24), st.integers(2, 9), st.booleans(), st.integers(0, 2**32))
def test_agrees_with_the_oracle(count, size, carve, seed):
    rng = np.random.default_rng(seed)
    points = np.unique(rng.integers(0, size, (count, 2)), axis=0).astype(float)
    points = points[rng.permutation(len(points))]
    assume(len(points) > 3)
    segments = closed_chain(points, rng)
    try:
        result = check(points, segments, carve=carve)
    except TopologyError:
        assume(False)
    net = oracle.triangulate(points.tolist(), segments, carve)
    constraints = {tuple(piece) for piece in result.segments.tolist()}
    ours = cells([tuple(t) for t in result.triangles.tolist()], net.points, constraints)
    assert ours == cells(sorted(net.triangles()), net.points, constraints)
    assert {tuple(sorted(piece)) for piece in constraints} == set(net.uses)


def test_agrees_with_the_oracle_without_ties():
    rng = np.random.default_rng(11)
    angle = np.arange(40) * (2 * np.pi / 40)
    points = np.c_[np.cos(angle), np.sin(angle)] * rng.uniform(0.3, 1, (40, 1))
    result = check(points, ring(0, 40))
    net = oracle.triangulate(points.tolist(), ring(0, 40), True)
    assert {tuple(np.roll(t, -np.argmin(t)).tolist()) for t in result.triangles} == net.triangles()


def test_oracle_turns_triangles_and_finds_normals():
    """Steps 7 and 8 of the article, on a roof of two facets."""
    points = [
        tuple(map(oracle.Fraction, p)) for p in [(0, 0, 0), (2, 0, 0), (0, 1, 1), (2, 1, 1), (0, 2, 0), (2, 2, 0)]
    ]
    south = oracle.orient(points, [(0, 1, 3), (0, 2, 3)], (0, -1, 1))
    north = oracle.orient(points, [(2, 3, 5), (4, 2, 5)], (0, 1, 1))
    assert south == [(0, 1, 3), (0, 3, 2)]
    normals = oracle.compute_vertex_normals(points, [south, north])
    assert normals[0] == dict.fromkeys((0, 1, 2, 3), (0, -4, 4))
    assert normals[1] == dict.fromkeys((2, 3, 4, 5), (0, 4, 4))


# Properties.

GRID = st.tuples(st.integers(0, 6), st.integers(0, 6)).map(lambda p: (float(p[0]), float(p[1])))


@st.composite
def graphs(draw):
    """Points of a small grid, with duplicates, collinear and cocircular ones, and any segments."""
    points = draw(st.lists(GRID, min_size=1, max_size=24))
    end = st.integers(0, len(points) - 1)
    return points, draw(st.lists(st.tuples(end, end), max_size=14))


@try_examples(300)
@given(graphs(), st.booleans())
def test_any_graph(graph, carve):
    points, segments = graph
    pairs = [(i, j) for i in range(len(segments)) for j in range(i) if cross(points, segments[i], segments[j])]
    if pairs:
        with pytest.raises(TopologyError) as caught:
            triangulate(points, segments, carve=carve)
        assert caught.value.segments[::-1] in pairs
    else:
        check(points, segments, carve=carve)


@try_examples(300)
@given(graphs(), st.booleans())
def test_any_graph_split(graph, carve):
    points, segments = graph
    result = check(points, segments, carve=carve, split_crossings=True)
    assert (result.points[: len(points)] == points).all()


@try_examples(100)
@given(
    st.lists(st.tuples(*[st.floats(allow_nan=False, allow_infinity=False)] * 2), min_size=3, max_size=12),
    st.booleans(),
)
def test_any_doubles(points, split):
    """Coordinates of any magnitude, in one ring."""
    try:
        check(points, ring(0, len(points)), split_crossings=split)
    except TopologyError:
        assert not split


@try_examples(100)
@given(graphs(), st.integers(0, 2**32))
def test_order_does_not_matter(graph, seed):
    points, segments = graph
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(points))
    place = np.argsort(order)
    moved = [(int(place[b]), int(place[a])) for a, b in segments]
    moved = [moved[i] for i in rng.permutation(len(moved))]
    plain = check(points, segments, split_crossings=True)
    shuffled = check(np.array(points)[order], moved, split_crossings=True)
    assert collect_shapes(plain) == collect_shapes(shuffled)
    first = plain.points[plain.triangles]
    assert (first == shuffled.points[shuffled.triangles]).all(), "the same triangles in another order"


@try_examples(100)
@given(graphs(), st.integers(-40, 40))
def test_scaled_by_a_power_of_two(graph, power):
    points, segments = graph
    plain = check(points, segments, split_crossings=True)
    scaled = check(np.array(points) * 2.0**power, segments, split_crossings=True)
    assert (plain.triangles == scaled.triangles).all()
    assert (plain.points * 2.0**power == scaled.points).all()


@try_examples(100)
@given(graphs())
def test_mirrored(graph):
    points, segments = graph
    plain = check(points, segments, split_crossings=True)
    mirrored = check(np.array(points)[:, ::-1], segments, split_crossings=True)
    # A crossing that rounds in another direction may take a segment off a point that lies on it.
    assume({tuple(point) for point in plain.points} == {tuple(point[::-1]) for point in mirrored.points})
    assert compute_area(mirrored) == pytest.approx(compute_area(plain), rel=1e-12)


@try_examples(60)
@given(st.integers(3, 16), st.integers(3, 9), st.integers(0, 2**32))
def test_carved_as_by_the_midpoint_of_a_median(count, size, seed):
    """Step 6 of the article, triangle by triangle, against the flood fill."""
    rng = np.random.default_rng(seed)
    points = rng.integers(0, size, (count, 2)).astype(float)
    segments = ring(0, count)
    whole = check(points, segments, carve=False, split_crossings=True)
    carved = check(points, segments, carve=True, split_crossings=True)
    exact = oracle.make_exact(whole.points)
    pieces = whole.segments.tolist()
    inside = {
        frozenset(t)
        for t in whole.triangles.tolist()
        if oracle.is_inside(oracle.find_median_midpoint(*(exact[i] for i in t)), exact, pieces)
    }
    assert {frozenset(t) for t in carved.triangles.tolist()} == inside
