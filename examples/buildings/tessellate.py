"""Turn a facet model into an over-sampled triangle mesh, as exporters of real buildings do.

Outlines are cut into short pieces, points are scattered inside the facets, and each facet is
triangulated greedily (shortest diagonal first). Where an edge is cut depends on the edge alone, so
the facets on both sides agree and the mesh stays closed. Only exact rules and basic arithmetic decide,
so every machine makes the same mesh.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from buildings.facet_model import Model, Ring, multiply, pair_edges

Points = NDArray[np.float64]
Faces = NDArray[np.int64]


TINY = 1e-9
"""Below the size of any detail; meters or square meters."""


def tessellate(model: Model, edge: float) -> tuple[Points, Faces]:
    """Points and triangles of all facets, with edges of about `edge` meters."""
    points, faces = tessellate_facets(model, edge)
    return points, np.concatenate(faces)


def tessellate_facets(model: Model, edge: float) -> tuple[Points, list[Faces]]:
    """Tessellate, with the triangles of each facet apart."""
    points = list(model.points)
    cuts: dict[tuple[int, int], Ring] = {}
    faces = []
    for corners in model.facets:
        normal = model.find_normal(corners[0])
        rings = [cut_ring(points, ring, edge, cuts) for ring in corners]
        ids = [point for ring in rings for point in ring]
        outline, offset = [], 0
        for ring in rings:
            outline += [(offset + a, offset + b) for a, b in pair_edges(list(range(len(ring))))]
            offset += len(ring)
        inner = scatter(np.array([points[i] for i in ids]), normal, np.array(outline), edge)
        ids += range(len(points), len(points) + len(inner))
        points += list(inner)
        flat = project(np.array([points[i] for i in ids]), normal)
        faces.append(np.array(ids)[np.array(triangulate(flat, np.array(outline), len(rings)))])
    return np.array(points), faces


def cut_ring(points: list[Points], ring: Ring, edge: float, cuts: dict[tuple[int, int], Ring]) -> Ring:
    """Cut the long edges of a ring; new points are added to `points`, and `cuts` remembers them."""
    longer: Ring = []
    for start, end in pair_edges(ring):
        low, high = min(start, end), max(start, end)
        if (low, high) not in cuts:
            cuts[low, high] = cut_edge(points, low, high, edge)
        longer += [start, *(cuts[low, high] if start < end else cuts[low, high][::-1])]
    return longer


def cut_edge(points: list[Points], start: int, end: int, edge: float) -> Ring:
    """Halve an edge, unevenly, until its pieces are short; ids of the new points from `start` to `end`."""
    a, b = points[start], points[end]
    limit, share = draw_share(a + b, 1), draw_share(a + b, 2)
    if multiply(b - a, b - a) <= (edge * (0.9 + 0.7 * limit)) ** 2:
        return []
    middle = len(points)
    points.append(a + (0.36 + 0.28 * share) * (b - a))
    return [*cut_edge(points, start, middle, edge), middle, *cut_edge(points, middle, end, edge)]


def scatter(corners: Points, normal: Points, outline: Faces, edge: float) -> Points:
    """Scatter points inside a facet, one in each cell of a grid, off its center, not too near the outline."""
    flat, (right, up) = project(corners, normal), find_axes(normal)
    low, high = flat.min(axis=0), flat.max(axis=0)
    columns, rows = (int(count) for count in np.floor((high - low) / edge) + 1)
    found = []
    for cell in np.ndindex(columns, rows):
        center = low + (np.array(cell) + 0.5) * edge
        where = corners[0] + center[0] * right + center[1] * up
        place = center + 0.7 * (np.array([draw_share(where, 3), draw_share(where, 4)]) - 0.5) * edge
        if is_inside(flat, outline, place) and measure_clearance(flat, outline, place) > 0.4 * edge:
            found.append(corners[0] + place[0] * right + place[1] * up)
    return np.array(found).reshape(-1, 3)


def triangulate(flat: Points, outline: Faces, rings: int) -> list[tuple[int, int, int]]:
    """Triangulate one facet, its outline's points first: diagonals that cross nothing, shortest first."""
    first, second = np.triu_indices(len(flat), 1)
    length = np.round(((flat[first] - flat[second]) ** 2).sum(axis=1), 9)
    # Euler's formula tells how many segments a triangulation of these points has.
    segments = np.empty((3 * len(flat) - len(outline) + 3 * (rings - 2), 2), dtype=np.int64)
    segments[: len(outline)] = outline
    count = len(outline)
    taken = {(min(pair), max(pair)) for pair in outline.tolist()}
    for k in np.argsort(length, kind="stable"):
        if count == len(segments):
            break
        pair = (int(first[k]), int(second[k]))
        if pair in taken or is_blocked(flat, segments[:count], pair):
            continue
        if is_inside(flat, outline, flat[list(pair)].mean(axis=0)):
            segments[count] = pair
            count += 1
    return collect_triangles(flat, segments[:count], len(outline))


def find_axes(normal: Points) -> tuple[Points, Points]:
    """Return two axes in the plane of a facet; with its normal they form a right-handed frame."""
    axis = np.zeros(3)
    axis[int(np.argmin(np.abs(np.round(normal, 6))))] = 1.0
    right = np.cross(axis, normal)
    right /= multiply(right, right) ** 0.5
    return right, np.cross(normal, right)


def project(points: Points, normal: Points) -> Points:
    """Return 2D coordinates in the plane of a facet, about its first point, counter-clockwise from outside."""
    right, up = find_axes(normal)
    offset = points - points[0]
    return np.stack([(offset * right).sum(axis=1), (offset * up).sum(axis=1)], axis=1)


def measure_side(a: Points, b: Points, c: Points) -> Points:
    """Return twice the signed area of a, b, c, zero where it is below the size of any detail."""
    along, offset = b - a, c - a
    area = along[..., 0] * offset[..., 1] - along[..., 1] * offset[..., 0]
    return np.where(np.abs(area) < TINY, 0.0, area)


def is_blocked(flat: Points, segments: Faces, pair: tuple[int, int]) -> bool:
    """Return whether a diagonal crosses a segment or runs through a point."""
    a, b = flat[pair[0]], flat[pair[1]]
    sides = measure_side(a, b, flat)
    on_line = flat[sides == 0] - a
    share, length = (on_line * (b - a)).sum(axis=1), multiply(b - a, b - a)
    if np.any((share > TINY) & (share < length - TINY)):
        return True
    apart = segments[sides[segments[:, 0]] * sides[segments[:, 1]] < 0]
    c, d = flat[apart[:, 0]], flat[apart[:, 1]]
    return bool(np.any(measure_side(c, d, a) * measure_side(c, d, b) < 0))


def is_inside(flat: Points, outline: Faces, point: Points) -> bool:
    """Return whether a point lies inside the rings: a ray to the right crosses them an odd number of times."""
    a, b = flat[outline[:, 0]], flat[outline[:, 1]]
    upward = a[:, 1] <= b[:, 1]
    low, high = np.where(upward[:, None], a, b), np.where(upward[:, None], b, a)
    spans = (low[:, 1] <= point[1]) & (point[1] < high[:, 1])
    return bool(np.count_nonzero(spans & (measure_side(low, high, point[None]) > 0)) % 2)


def measure_clearance(flat: Points, outline: Faces, point: Points) -> float:
    """Return the distance from a point to the outline."""
    a, b = flat[outline[:, 0]], flat[outline[:, 1]]
    along = b - a
    share = ((point - a) * along).sum(axis=1) / (along * along).sum(axis=1)
    nearest = a + np.clip(share, 0.0, 1.0)[:, None] * along
    return float(np.sqrt(((point - nearest) ** 2).sum(axis=1).min()))


def collect_triangles(flat: Points, segments: Faces, outline: int) -> list[tuple[int, int, int]]:
    """Collect the triangles of a plane graph; its first `outline` segments have a triangle on their left only."""
    halfedges = [(int(a), int(b)) for a, b in segments]
    halfedges += [(b, a) for a, b in halfedges[outline:]]
    leaving: dict[int, list[int]] = {}
    for a, b in halfedges:
        leaving.setdefault(a, []).append(b)
    found = []
    for a, b in halfedges:
        apex = -1
        for c in leaving[b]:
            sharper = apex < 0 or measure_side(flat[b], flat[apex], flat[c]) > 0
            if measure_side(flat[a], flat[b], flat[c]) > 0 and sharper:
                apex = c
        if apex < 0 or a not in leaving[apex]:
            raise ValueError("a facet did not fall into triangles")
        if a < min(b, apex):
            found.append((a, b, apex))
    return found


def draw_share(place: Points, stream: int) -> float:
    """Draw a number from 0 to 1 that depends only on the place, rounded to a tenth of a millimeter."""
    # Model coordinates are round; the odd offset keeps them away from the steps of the floor.
    x, y, z = (int(value) for value in np.floor(place * 1e4 + 0.3137))
    mixed = ((x * 73856093) ^ (y * 19349663) ^ (z * 83492791)) + stream
    for factor in (0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9):
        mixed = mixed * factor % (1 << 64)
        mixed ^= mixed >> 29
    return (mixed >> 11) / (1 << 53)
