"""The triangulation core: corpus, oracle, properties, errors. `validate` ends every test that makes one."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import oracle
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from bldsimp import InputError, InternalError, TopologyError, Triangulation, triangulate

SQUARE = [(0, 0), (4, 0), (4, 4), (0, 4)]


def ring(first: int, count: int) -> list[tuple[int, int]]:
    """Segments of a closed ring of consecutive points."""
    return [(first + i, first + (i + 1) % count) for i in range(count)]


def rings(*outlines) -> tuple[np.ndarray, list[tuple[int, int]]]:
    """Points and segments of several rings."""
    points = np.concatenate([np.reshape(np.array(outline, float), (-1, 2)) for outline in outlines])
    segments, first = [], 0
    for outline in outlines:
        segments += ring(first, len(outline)) if len(outline) else []
        first += len(outline)
    return points, segments


def checked(points, segments, **options) -> Triangulation:
    result = triangulate(points, segments, **options)
    result.validate()
    return result


def area(result: Triangulation) -> float:
    a, b, c = np.moveaxis(result.points[result.triangles], 1, 0)
    return 0.5 * float(np.sum((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]))


def shapes(result: Triangulation) -> set[frozenset[tuple[float, float]]]:
    """Triangles by coordinates, whatever the numbers of their points."""
    return {frozenset(map(tuple, result.points[t].tolist())) for t in result.triangles}


def even_odd_area(outlines) -> float:
    """Area of rings nested in each other, by their signs from outside in."""
    signed = []
    for outline in outlines:
        x, y = np.array(outline, float).T
        signed.append(0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))))
    return signed[0] - sum(signed[1:])


# Named shapes.


def test_square_with_a_hole():
    result = checked(*rings(SQUARE, [(1, 1), (3, 1), (3, 3), (1, 3)]))
    assert len(result.triangles) == 8
    assert area(result) == 12.0


def test_island_in_a_hole():
    result = checked(
        *rings(SQUARE, [(1, 1), (3, 1), (3, 3), (1, 3)], [(1.5, 1.5), (2.5, 1.5), (2.5, 2.5), (1.5, 2.5)])
    )
    assert area(result) == 13.0


def test_slit_bounds_nothing():
    """A ring that runs to its hole and back along one segment."""
    points = [*SQUARE, (1, 1), (3, 1), (3, 3), (1, 3)]
    result = checked(points, [*ring(0, 4), *ring(4, 4), (0, 4), (4, 0)])
    assert area(result) == 12.0
    assert [0, 4] in result.segments.tolist()


def test_holes_that_share_an_edge_are_one_hole():
    points = [(0, 0), (6, 0), (6, 6), (0, 6), (1, 1), (3, 1), (3, 3), (1, 3), (5, 1), (5, 3)]
    segments = [*ring(0, 4), *ring(4, 4), (5, 8), (8, 9), (9, 6), (6, 5)]
    result = checked(points, segments)
    assert area(result) == 36.0 - 8.0


def test_open_chain_bounds_nothing():
    result = checked([*SQUARE, (1, 1), (2, 3)], [*ring(0, 4), (4, 5)])
    assert area(result) == 16.0
    assert checked(SQUARE, [(0, 1), (1, 2)]).triangles.shape == (0, 3)


def test_wall_across_a_ring_leaves_both_rooms():
    result = checked(SQUARE, [*ring(0, 4), (0, 2)])
    assert area(result) == 16.0


def test_point_on_a_segment_splits_it():
    result = checked([*SQUARE, (2, 0)], ring(0, 4))
    assert result.segments[:2].tolist() == [[0, 4], [4, 1]]
    assert result.input_segment.tolist() == [0, 0, 1, 2, 3]


def test_overlapping_segments_share_pieces():
    points = [(0, 0), (1, 0), (2, 0), (3, 0), (0, 1)]
    result = checked(points, [(0, 2), (3, 1)], carve=False)
    assert result.segments.tolist() == [[0, 1], [1, 2], [3, 2], [2, 1]]
    assert result.input_segment.tolist() == [0, 0, 1, 1]


def test_duplicates_map_to_the_lowest_index():
    result = checked([*SQUARE, (0, 0), (4.0, 4.0), (-0.0, 0.0)], [(4, 1), (1, 5), (2, 3), (3, 6), (2, 5)])
    assert result.point_of_input.tolist() == [0, 1, 2, 3, 0, 2, 0]
    assert result.segments.tolist() == [[0, 1], [1, 2], [2, 3], [3, 0]]
    assert area(result) == 16.0


@pytest.mark.parametrize("points", [[], [(1, 2)], [(0, 0)] * 4, [(0, 0), (1, 1), (2, 2), (5, 5)]])
def test_nothing_to_triangulate(points):
    segments = [(0, len(points) - 1)] if points else []
    for carve in (True, False):
        result = checked(points, segments, carve=carve)
        assert result.triangles.shape == result.neighbours.shape == (0, 3)
        assert result.triangles.dtype == result.neighbours.dtype == np.int32


def test_without_segments():
    assert len(checked(SQUARE, []).triangles) == 0
    assert len(checked(SQUARE, [], carve=False).triangles) == 2


def test_cocircular_ties_go_to_the_least_point():
    circle = [
        (5, 0),
        (4, 3),
        (3, 4),
        (0, 5),
        (-3, 4),
        (-4, 3),
        (-5, 0),
        (-4, -3),
        (-3, -4),
        (0, -5),
        (3, -4),
        (4, -3),
    ]
    result = checked(circle, [], carve=False)
    assert all(6 in triangle for triangle in result.triangles)


def test_neighbours_lie_opposite_their_corner():
    result = checked([(0, 0), (2, 0), (0, 2), (2, 2.5)], [], carve=False)
    for row, triangle in enumerate(result.triangles):
        for corner, other in enumerate(result.neighbours[row]):
            if other >= 0:
                assert triangle[corner] not in result.triangles[other]


# Crossings.


def test_crossing_names_both_segments():
    with pytest.raises(TopologyError, match="segments 1 and 3 cross") as caught:
        triangulate([*SQUARE, (9, 9)], [(0, 1), (0, 2), (1, 2), (1, 3)])
    assert caught.value.segments == (1, 3)


def test_crossing_is_split_when_asked():
    result = checked(SQUARE, [(0, 2), (1, 3)], carve=False, split_crossings=True)
    assert result.points[4].tolist() == [2.0, 2.0]
    assert result.segments.tolist() == [[0, 4], [4, 2], [1, 4], [4, 3]]


def test_bow_tie_split():
    result = checked([(0, 0), (4, 4), (4, 0), (0, 4)], ring(0, 4), split_crossings=True)
    assert area(result) == 8.0


@pytest.mark.parametrize("seed", range(6))
def test_many_crossings_end(seed):
    """Pencils of lines through nearly one point: rounding piles the crossings on each other."""
    rng = np.random.default_rng(seed)
    angle = rng.random(24) * np.pi
    arm = np.c_[np.cos(angle), np.sin(angle)] * rng.integers(1, 9, (24, 1))
    centre = rng.normal(size=2) + rng.integers(-2, 3, (24, 1)) * 2.0**-51
    points = np.concatenate([centre - arm, centre + arm])
    result = checked(points, [(i, i + 24) for i in range(24)], carve=False, split_crossings=True)
    assert len(result.points) < len(points) + 24 * 24


# Against others.


@settings(max_examples=40, deadline=None)
@given(st.integers(4, 120), st.integers(0, 2**32))
def test_agrees_with_scipy(count, seed):
    points = np.random.default_rng(seed).random((count, 2))
    result = checked(points, [], carve=False)
    expected = {frozenset(map(tuple, points[t].tolist())) for t in Delaunay(points).simplices}
    assert shapes(result) == expected


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


@settings(max_examples=60, deadline=None)
@given(st.integers(4, 24), st.integers(2, 9), st.booleans(), st.integers(0, 2**32))
def test_agrees_with_the_oracle(count, size, carve, seed):
    rng = np.random.default_rng(seed)
    points = np.unique(rng.integers(0, size, (count, 2)), axis=0).astype(float)
    points = points[rng.permutation(len(points))]
    assume(len(points) > 3)
    segments = closed_chain(points, rng)
    try:
        result = checked(points, segments, carve=carve)
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
    result = checked(points, ring(0, 40))
    net = oracle.triangulate(points.tolist(), ring(0, 40), True)
    assert {tuple(np.roll(t, -np.argmin(t)).tolist()) for t in result.triangles} == net.triangles()


def test_oracle_turns_triangles_and_finds_normals():
    """Steps 7 and 8 of the article, on a roof of two facets."""
    points = [
        tuple(map(oracle.Fraction, p))
        for p in [(0, 0, 0), (2, 0, 0), (0, 1, 1), (2, 1, 1), (0, 2, 0), (2, 2, 0)]
    ]
    south = oracle.orient(points, [(0, 1, 3), (0, 2, 3)], (0, -1, 1))
    north = oracle.orient(points, [(2, 3, 5), (4, 2, 5)], (0, 1, 1))
    assert south == [(0, 1, 3), (0, 3, 2)]
    normals = oracle.vertex_normals(points, [south, north])
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


def cross(points, first, second) -> bool:
    """Whether two segments cross at a point that is none of the input's."""
    exact = oracle.exact(points)
    a, b, c, d = (exact[i] for i in (*first, *second))
    return (
        oracle.orient2d(a, b, c) * oracle.orient2d(a, b, d) < 0
        and oracle.orient2d(c, d, a) * oracle.orient2d(c, d, b) < 0
        and not any(oracle.orient2d(a, b, p) == oracle.orient2d(c, d, p) == 0 for p in exact)
    )


def test_segments_that_meet_in_a_point_do_not_cross():
    result = checked([*SQUARE, (2, 2)], [(0, 2), (1, 3)], carve=False)
    assert result.segments.tolist() == [[0, 4], [4, 2], [1, 4], [4, 3]]


@settings(max_examples=300, deadline=None)
@given(graphs(), st.booleans())
def test_any_graph(graph, carve):
    points, segments = graph
    pairs = [
        (i, j) for i in range(len(segments)) for j in range(i) if cross(points, segments[i], segments[j])
    ]
    if pairs:
        with pytest.raises(TopologyError) as caught:
            triangulate(points, segments, carve=carve)
        assert caught.value.segments[::-1] in pairs
    else:
        checked(points, segments, carve=carve)


@settings(max_examples=300, deadline=None)
@given(graphs(), st.booleans())
def test_any_graph_split(graph, carve):
    points, segments = graph
    result = checked(points, segments, carve=carve, split_crossings=True)
    assert (result.points[: len(points)] == points).all()


@settings(max_examples=100, deadline=None)
@given(
    st.lists(st.tuples(*[st.floats(allow_nan=False, allow_infinity=False)] * 2), min_size=3, max_size=12),
    st.booleans(),
)
def test_any_doubles(points, split):
    """Coordinates of any magnitude, in one ring."""
    try:
        checked(points, ring(0, len(points)), split_crossings=split)
    except TopologyError:
        assert not split


@settings(max_examples=100, deadline=None)
@given(graphs(), st.integers(0, 2**32))
def test_order_does_not_matter(graph, seed):
    points, segments = graph
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(points))
    place = np.argsort(order)
    moved = [(int(place[b]), int(place[a])) for a, b in segments]
    moved = [moved[i] for i in rng.permutation(len(moved))]
    plain = checked(points, segments, split_crossings=True)
    shuffled = checked(np.array(points)[order], moved, split_crossings=True)
    assert shapes(plain) == shapes(shuffled)
    first = plain.points[plain.triangles]
    assert (first == shuffled.points[shuffled.triangles]).all(), "the same triangles in another order"


@settings(max_examples=100, deadline=None)
@given(graphs(), st.integers(-40, 40))
def test_scaled_by_a_power_of_two(graph, power):
    points, segments = graph
    plain = checked(points, segments, split_crossings=True)
    scaled = checked(np.array(points) * 2.0**power, segments, split_crossings=True)
    assert (plain.triangles == scaled.triangles).all()
    assert (plain.points * 2.0**power == scaled.points).all()


@settings(max_examples=100, deadline=None)
@given(graphs())
def test_mirrored(graph):
    points, segments = graph
    plain = checked(points, segments, split_crossings=True)
    mirrored = checked(np.array(points)[:, ::-1], segments, split_crossings=True)
    assert area(mirrored) == pytest.approx(area(plain), rel=1e-12)


@settings(max_examples=60, deadline=None)
@given(st.integers(3, 16), st.integers(3, 9), st.integers(0, 2**32))
def test_carved_as_by_the_midpoint_of_a_median(count, size, seed):
    """Step 6 of the article, triangle by triangle, against the flood fill."""
    rng = np.random.default_rng(seed)
    points = rng.integers(0, size, (count, 2)).astype(float)
    segments = ring(0, count)
    whole = checked(points, segments, carve=False, split_crossings=True)
    carved = checked(points, segments, carve=True, split_crossings=True)
    exact = oracle.exact(whole.points)
    pieces = whole.segments.tolist()
    inside = {
        frozenset(t)
        for t in whole.triangles.tolist()
        if oracle.is_inside(oracle.median_midpoint(*(exact[i] for i in t)), exact, pieces)
    }
    assert {frozenset(t) for t in carved.triangles.tolist()} == inside


# Validation finds what is wrong.


def broken(**changes) -> Triangulation:
    result = triangulate([(0, 0), (4, 0), (9, 9), (0, 4)], ring(0, 4))
    values = {
        name: np.copy(value) if isinstance(value, np.ndarray) else value
        for name, value in vars(result).items()
    }
    return Triangulation(**{**values, **{name: change(values[name]) for name, change in changes.items()}})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"triangles": lambda t: t[:, ::-1]}, "not counter-clockwise|neighbour"),
        ({"triangles": lambda t: t + 2}, "out of range"),
        ({"neighbours": lambda n: np.roll(n, 1, axis=0)}, "neighbour"),
        ({"points": lambda p: np.where(p == 9, 3, p)}, "not Delaunay"),
        ({"points": lambda p: np.where(p == 9, 4, p)}, "tie"),
        ({"input_segment": lambda s: s[::-1]}, "order"),
        ({"constraints": lambda c: c[:, ::-1]}, "one piece"),
        ({"triangles": lambda t: t[:-1], "neighbours": lambda n: n[:-1]}, "neighbour"),
        ({"segments": lambda s: s[:-1], "input_segment": lambda s: s[:-1]}, "without pieces"),
    ],
)
def test_validate_finds(changes, message):
    broken().validate()
    with pytest.raises(InternalError, match=message):
        broken(**changes).validate()


# Input that is refused.


@pytest.mark.parametrize(
    ("points", "segments", "message"),
    [
        ([(0, 0, 0)], [], r"shape \(1, 3\)"),
        ([(0, 0), (1, float("nan")), (float("inf"), 0)], [], "not finite: 1, 2"),
        (["ab", "cd"], [], "not numbers"),
        (SQUARE, [(0, 1, 2)], r"shape \(1, 3\)"),
        (SQUARE, [(0, 1.5)], "not integers"),
        (SQUARE, [(0, 1), (0, 4), (-1, 2)], "outside the 4 points: 1, 2"),
        (SQUARE, np.array([(0, 4)], np.int32), "outside the 4 points: 0"),
        (SQUARE, [(0, 2**32)], "outside the 4 points: 0"),
        ([(float("nan"), 0)] * 12, [], "8, 9 and 2 more"),
    ],
)
def test_bad_input(points, segments, message):
    with pytest.raises(InputError, match=message):
        triangulate(points, segments)


# Corpus: adding a file adds a test.


def corpus(kind: str) -> list[Path]:
    from conftest import models_folder

    return sorted((models_folder() / "cdt" / kind).glob("[!_]*.*"))


def read_graph(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Header of two counts, points, segments."""
    words = path.read_text().split()
    n, m = int(words[0]), int(words[1])
    points = np.array(words[2 : 2 + 2 * n], float).reshape(-1, 2)
    return points, np.array(words[2 + 2 * n : 2 + 2 * n + 2 * m], int).reshape(-1, 2)


@pytest.mark.parametrize("path", corpus("artemogre"), ids=lambda p: p.stem)
def test_graph_corpus(path, models):
    points, segments = read_graph(path)
    for carve in (False, True):
        checked(points, segments, carve=carve, split_crossings=True)
    try:
        plain = checked(points, segments, carve=False)
    except TopologyError as error:
        named = error.segments
    else:
        assert len(plain.points) == len(points)
        return
    assert named is not None
    assert cross(points, *(segments[i] for i in named))


@pytest.mark.parametrize("path", corpus("earcut"), ids=lambda p: p.stem)
def test_ring_corpus(path, models):
    outlines = json.loads(path.read_text())
    points, segments = rings(*outlines)
    result = checked(points, segments, split_crossings=True)
    checked(points, segments, carve=False, split_crossings=True)
    expected = json.loads((path.parent / "_expected.json").read_text())
    deviation = expected.get("errors", {}).get(path.stem, 0)
    # Where rings cross, overlap, or the first one is not the outer one, conventions differ.
    if len(result.points) == len(points) and deviation == 0 and expected["triangles"].get(path.stem, 0):
        assert area(result) == pytest.approx(even_odd_area(outlines), rel=1e-9)


def read_polygons(path: Path) -> dict[str, list[list[list[float]]]]:
    """Per polygon: name, count, precision, number of rings; per ring its count and points."""
    words = iter(path.read_text().split())
    polygons: dict[str, list[list[list[float]]]] = {}
    for name in words:
        next(words), next(words)
        polygons[name] = [
            [[float(next(words)), float(next(words))] for _ in range(int(next(words)))]
            for _ in range(int(next(words)))
        ]
    return polygons


def test_polygon_corpus(models):
    polygons = read_polygons(models / "cdt" / "manifold_polygon_corpus.txt")
    assert len(polygons) > 20
    for outlines in polygons.values():
        points, segments = rings(*outlines)
        for carve in (False, True):
            checked(points, segments, carve=carve, split_crossings=True)
