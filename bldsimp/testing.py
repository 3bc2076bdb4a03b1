"""Check results against their promises; each check raises `InternalError` that says what is broken."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import _core
from .errors import InternalError
from .unique_rows import join_pairs

Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class TriangulationArrays:
    """The arrays of a `Triangulation`, which tells what each is."""

    points: NDArray[np.float64]
    triangles: NDArray[np.int32]
    neighbors: NDArray[np.int32]
    point_of_input: NDArray[np.int32]
    segments: NDArray[np.int32]
    input_segment: NDArray[np.int32]
    constraints: NDArray[np.int32]
    carved: bool


class _Halfedges:
    """Halfedge ``3 t + i`` runs from corner ``i`` of triangle ``t`` to the next corner."""

    def __init__(self, triangles: NDArray[np.int32], neighbors: NDArray[np.int32], point_count: int) -> None:
        self.count = triangles.size
        self.start = triangles.astype(np.int64).ravel()
        self.end = np.roll(triangles, -1, axis=1).astype(np.int64).ravel()
        self.apex = np.roll(triangles, -2, axis=1).astype(np.int64).ravel()
        edges = np.arange(self.count)
        self.next = edges - edges % 3 + (edges + 1) % 3
        self.across = np.roll(neighbors, 1, axis=1).ravel()
        self.key = self.start * point_count + self.end
        reverse_key = self.end * point_count + self.start
        order = np.argsort(self.key, kind="stable")
        found = order[np.minimum(np.searchsorted(self.key[order], reverse_key), self.count - 1)]
        self.twin = np.where(self.key[found] == reverse_key, found, -1)


def check_triangulation(result: TriangulationArrays) -> None:
    """Check every promise of a triangulation; see `Triangulation.validate`."""
    _check_pieces(result)
    if len(result.triangles) == 0:
        _check_empty(result)
        return
    _check_rows(result)
    edges = _Halfedges(result.triangles, result.neighbors, len(result.points))
    _check_neighbors(edges)
    _require(_find_directions(result, *result.triangles.T) <= 0, "triangle not counter-clockwise")
    _check_delaunay(result, edges)
    _check_constraints(result, edges)
    loops = _check_euler(edges)
    if not result.carved:
        _check_hull(result, edges, loops)


def _require(broken: Flags | np.bool_, message: str) -> None:
    """Raise with the first row at which `broken` holds."""
    rows = np.flatnonzero(broken)
    if len(rows):
        raise InternalError(f"{message}: {rows[0]}" + (f" and {len(rows) - 1} more" if len(rows) > 1 else ""))


def _find_directions(result: TriangulationArrays, a: Ints, b: Ints, c: Ints) -> NDArray[np.int8]:
    """Return the direction of each triangle a, b, c of points: above 0 where it is counter-clockwise."""
    return _core.orient2d(*(result.points[corner] for corner in np.broadcast_arrays(a, b, c)))


def _check_rows(result: TriangulationArrays) -> None:
    triangles = result.triangles
    _require(((triangles < 0) | (triangles >= len(result.points))).any(axis=1), "triangle out of range")
    represented = np.arange(len(result.points))
    represented[: len(result.point_of_input)] = result.point_of_input
    _require((represented[triangles] != triangles).any(axis=1), "triangle with a repeated point")


def _check_neighbors(edges: _Halfedges) -> None:
    _require(np.bincount(np.unique(edges.key, return_inverse=True)[1]) > 1, "directed edge used twice")
    expected = np.where(edges.twin < 0, -1, edges.twin // 3)
    _require(expected != edges.across, "neighbor across a halfedge is wrong")


def _key_pieces(result: TriangulationArrays) -> tuple[Ints, Ints]:
    """Return the key that a halfedge along each piece would have, and the key of its reverse."""
    a, b = result.segments.astype(np.int64).T
    return a * len(result.points) + b, b * len(result.points) + a


def _check_delaunay(result: TriangulationArrays, edges: _Halfedges) -> None:
    constrained = np.isin(edges.key, np.concatenate(_key_pieces(result)))
    inner = np.flatnonzero(~constrained & (edges.twin > np.arange(edges.count)))
    a, b, p = edges.start[inner], edges.end[inner], edges.apex[inner]
    q = edges.apex[edges.twin[inner]]
    side = _core.incircle(*(result.points[corner] for corner in (a, b, p, q)))
    _require(side > 0, "inner edge not Delaunay")
    rank = np.empty(len(result.points), np.int64)
    rank[np.lexsort((result.points[:, 1], result.points[:, 0]))] = np.arange(len(result.points))
    least_ab, least_pq = np.minimum(rank[a], rank[b]), np.minimum(rank[p], rank[q])
    _require((side == 0) & (least_pq < least_ab), "cocircular tie broken against the order of points")


def _check_pieces(result: TriangulationArrays) -> None:
    """Check that the pieces of each segment form a chain from its first to its second end."""
    ends = result.point_of_input[result.constraints]
    long = np.flatnonzero(ends[:, 0] != ends[:, 1])
    if len(result.triangles) == 0 and len(result.segments) == 0:
        return
    counts = np.bincount(result.input_segment, minlength=len(ends))
    _require((counts > 0) != (ends[:, 0] != ends[:, 1]), "segment without pieces, or of no length with one")
    if (np.diff(result.input_segment) < 0).any():
        raise InternalError("pieces are not in the order of the segments")
    last = np.cumsum(counts)[long] - 1
    first = last - counts[long] + 1
    net = np.zeros((len(result.points), 2), np.int64)  # uses as start, as end: only the sum need agree
    np.add.at(net[:, 0], result.segments[:, 0], 1)
    np.add.at(net[:, 1], result.segments[:, 1], 1)
    np.add.at(net[:, 0], ends[long, 0], -1)
    np.add.at(net[:, 1], ends[long, 1], -1)
    _require(net[:, 0] != net[:, 1], "pieces do not lead from end to end at point")
    straight = np.flatnonzero(first == last)
    pieces = result.segments[first[straight]]
    _require((pieces != ends[long[straight]]).any(axis=1), "the one piece of a segment is not the segment")


def _check_constraints(result: TriangulationArrays, edges: _Halfedges) -> None:
    """Check that every piece is an edge; where triangles were carved away, that none lies across it."""
    key, reverse_key = _key_pieces(result)
    missing = ~np.isin(key, edges.key) & ~np.isin(reverse_key, edges.key)
    if not result.carved:
        _require(missing, "piece of a segment is no edge")
    for row in np.flatnonzero(missing):
        start, end = result.segments[row]
        fan = np.flatnonzero(edges.start == start)
        right = _find_directions(result, start, end, edges.end[fan])
        left = _find_directions(result, start, end, edges.apex[fan])
        _require((right < 0) & (left > 0), f"triangle across piece {row} of a segment, around its start")


def _count_joined(count: int, first: Ints, second: Ints) -> int:
    """Count what is left of `count` things when pairs of them are joined."""
    return len(np.unique(join_pairs(count, first, second)))


def _check_euler(edges: _Halfedges) -> Flags:
    """Check that every component is a piece of the plane; returns the halfedges on its border."""
    inner = np.flatnonzero(edges.twin >= 0)
    twin = edges.twin[inner]
    components = _count_joined(edges.count // 3, inner // 3, twin // 3)
    # A point where parts of the border touch counts once for each fan of triangles around it.
    fans = _count_joined(edges.count, inner, edges.next[twin])
    border = edges.twin < 0
    open_edges = np.flatnonzero(border)
    following = edges.next[open_edges]
    while not border[following].all():
        following = np.where(border[following], following, edges.next[edges.twin[following]])
    place = np.full(edges.count, -1)
    place[open_edges] = np.arange(len(open_edges))
    loops = _count_joined(len(open_edges), np.arange(len(open_edges)), place[following])
    edge_count = len(open_edges) + len(inner) // 2
    if fans - edge_count + edges.count // 3 != 2 * components - loops:
        raise InternalError(
            f"Euler's formula fails: {fans} vertices, {edge_count} edges, {edges.count // 3} triangles, "
            f"{components} components, {loops} border loops"
        )
    return border


def _check_hull(result: TriangulationArrays, edges: _Halfedges, border: Flags) -> None:
    """Check that all points are used, and that the border is one loop that nowhere turns right."""
    used = np.zeros(len(result.points), np.bool_)
    used[result.triangles.ravel()] = True
    expected = np.ones(len(result.points), np.bool_)
    expected[: len(result.point_of_input)] = result.point_of_input == np.arange(len(result.point_of_input))
    _require(used != expected, "point not used, or a repeated one used")
    rim = np.flatnonzero(border)
    after = np.full(len(result.points), -1)
    after[edges.start[rim]] = edges.end[rim]
    if len(np.unique(edges.start[rim])) != len(rim):
        raise InternalError("the hull passes a point twice")
    turns = _find_directions(result, edges.start[rim], edges.end[rim], after[edges.end[rim]])
    _require(turns < 0, "hull not convex")
    if _count_joined(len(result.points), edges.start[rim], edges.end[rim]) != len(result.points) - len(rim) + 1:
        raise InternalError("the hull is not one loop")


def _check_empty(result: TriangulationArrays) -> None:
    """Check that, without carving, only collinear points have no triangle."""
    if result.carved or len(result.points) < 3:
        return
    different = np.flatnonzero((result.points != result.points[0]).any(axis=1))
    if len(different):
        every = np.arange(len(result.points))
        _require(_find_directions(result, every[:1], different[:1], every) != 0, "no triangle at point")
