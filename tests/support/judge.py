"""An independent judge of results: plain numpy and scipy, nothing of bldsimp.

It counts what a faithful simplification keeps, measures how far two surfaces are apart, and lists, in
words, which promises a result breaks. Topology is counted after the exact weld, without faces that
repeat a point and without copies of a face with the same winding.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from distance import Boxes, measure_distance, measure_own_distance
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


WIDE = 1e-5
"""A tolerance above this share of the diagonal may move points."""


@dataclass(frozen=True)
class Surface:
    """Distinct positions that a face uses, and faces without repeats, each with its least point first."""

    points: Array
    faces: Ints

    @property
    def corners(self) -> Array:
        """(m, 3, 3): the three positions of each face."""
        return self.points[self.faces]


@dataclass(frozen=True)
class Topology:
    """What must stay. `rims` are sets of open edges joined by points; `rim_cycles` their independent cycles."""

    points: int
    triangles: int
    components: int
    open_edges: int
    nonmanifold_edges: int
    clashing: int
    euler: int
    rims: int
    rim_cycles: int


def make_surface(points: ArrayLike, faces: ArrayLike) -> Surface:
    """Weld exactly, and drop what does not count."""
    own = np.asarray(points, float).reshape(-1, 3) + 0.0  # no negative zero
    corners = np.asarray(faces, np.int64).reshape(-1, 3)
    unique, inverse = np.unique(own, axis=0, return_inverse=True)
    corners = inverse.reshape(-1)[corners].reshape(-1, 3)
    a, b, c = corners.T
    corners = corners[(a != b) & (b != c) & (c != a)]
    first = np.argmin(corners, axis=1)[:, None] if len(corners) else np.empty((0, 1), np.int64)
    corners = np.unique(np.take_along_axis(corners, (first + np.arange(3)) % 3, axis=1), axis=0)
    used, compact = np.unique(corners, return_inverse=True)
    return Surface(unique[used], compact.reshape(-1, 3))


def list_directed_edges(faces: Ints) -> Ints:
    """(3m, 2): the edges of each face in its own direction."""
    return np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)


def count_edges(faces: Ints) -> tuple[Ints, Ints, Ints]:
    """Distinct edges, lower end first; which one each directed edge is; and how many faces use each."""
    edges, edge_of, count = np.unique(
        np.sort(list_directed_edges(faces), axis=1), axis=0, return_inverse=True, return_counts=True
    )
    return edges, edge_of.reshape(-1), count


def label_components(faces: Ints) -> tuple[int, Ints]:
    """Components joined by edges."""
    edges, edge_of, _ = count_edges(faces)
    rows = np.repeat(np.arange(len(faces)), 3)
    size = len(faces) + len(edges)
    links = coo_array((np.ones(len(rows)), (rows, len(faces) + edge_of)), shape=(size, size))
    count, label = connected_components(links, directed=False)
    return int(count), label[: len(faces)]


def drop_winding(mesh: Surface) -> Surface:
    """The same without winding: a face and its back are one.

    Two faces back to back enclose a bubble, and a two-sided sheet has as many bubbles as triangles on a
    side: what must stay of it is told by the sheet. Where winding counts, a body thinner than the
    tolerance may end as two faces back to back, which is closed as it was.
    """
    return Surface(mesh.points, np.unique(np.sort(mesh.faces, axis=1), axis=0))


def count_rims(mesh: Surface) -> tuple[int, int]:
    """Sets of open edges that are joined by points, and how many independent cycles they make."""
    edges, _, count = count_edges(mesh.faces)
    ends, local = np.unique(edges[count == 1], return_inverse=True)
    if not len(ends):
        return 0, 0
    a, b = local.reshape(-1, 2).T
    links = coo_array((np.ones(len(a)), (a, b)), shape=(len(ends),) * 2)
    rims = int(connected_components(links, directed=False)[0])
    return rims, len(a) - len(ends) + rims


def count_topology(mesh: Surface) -> Topology:
    """Counts of a surface."""
    if not len(mesh.faces):
        return Topology(0, 0, 0, 0, 0, 0, 0, 0, 0)
    directed = list_directed_edges(mesh.faces)
    edges, _, count = count_edges(mesh.faces)
    return Topology(
        len(mesh.points),
        len(mesh.faces),
        label_components(mesh.faces)[0],
        int((count == 1).sum()),
        int((count > 2).sum()),
        len(directed) - len(np.unique(directed, axis=0)),
        len(mesh.points) - len(edges) + len(mesh.faces),
        *count_rims(mesh),
    )


def select_segments(mesh: Surface, uses: str) -> Array:
    """(k, 2, 3): the open edges (``open``) or those of more than two faces (``nonmanifold``)."""
    edges, _, count = count_edges(mesh.faces)
    return mesh.points[edges[count == 1 if uses == "open" else count > 2]]


def compute_area_vectors(mesh: Surface) -> Array:
    """Twice the area of each face along its normal."""
    a, b, c = mesh.corners.transpose(1, 0, 2)
    return np.cross(b - a, c - a)


def compute_area(mesh: Surface) -> float:
    """Area of all faces."""
    return float(np.linalg.norm(compute_area_vectors(mesh), axis=1).sum() / 2)


def compute_volumes(mesh: Surface) -> Array:
    """Signed volume of each component; of use where components are closed."""
    count, label = label_components(mesh.faces)
    origin = mesh.points.min(axis=0)
    parts = np.einsum("ij,ij->i", mesh.corners[:, 0] - origin, compute_area_vectors(mesh)) / 6
    return np.bincount(label, weights=parts, minlength=count)


def measure_extent(mesh: Surface) -> float:
    """Diagonal of the box of all points."""
    return float(np.linalg.norm(np.ptp(mesh.points, axis=0))) if len(mesh.points) else 0.0


def estimate_blur(mesh: Surface) -> float:
    """What rounding may add to a distance measured here."""
    if not len(mesh.points):
        return 0.0
    return 4 * float(np.spacing(np.abs(mesh.points).max())) + 16 * np.finfo(float).eps * measure_extent(mesh)


def sample_surface(mesh: Surface, count: int, seed: int = 0) -> Array:
    """Points, points on edges, centroids, and `count` points spread by area.

    Of points, edges and faces not more than a random `2 * count` each: of tiny shapes that is all.
    """
    rng, most = np.random.default_rng(seed), 2 * count
    edges, _, _ = count_edges(mesh.faces)
    edges = edges[_choose_some(len(edges), most, rng)]
    a, b = mesh.points[edges[:, 0]], mesh.points[edges[:, 1]]
    along = [a + (b - a) * t for t in (0.5, 0.28, 0.79)]
    weight = np.linalg.norm(compute_area_vectors(mesh), axis=1)
    inside = np.empty((0, 3))
    if count and weight.sum() > 0:
        p, q, r = mesh.corners[rng.choice(len(weight), count, p=weight / weight.sum())].transpose(1, 0, 2)
        u, v = np.sqrt(rng.random(count))[:, None], rng.random(count)[:, None]
        inside = p + (q - p) * (u * (1 - v)) + (r - p) * (u * v)
    points = mesh.points[_choose_some(len(mesh.points), most, rng)]
    middles = mesh.corners[_choose_some(len(mesh.faces), most, rng)]
    return np.concatenate([points, *along, middles.mean(axis=1), inside])


def _choose_some(count: int, most: int, rng: np.random.Generator) -> Ints:
    return np.arange(count) if count <= most else rng.choice(count, most, replace=False)


def measure_one_way(source: Surface, target: Surface, count: int = 2000) -> float:
    """Greatest distance from samples of one surface to the other."""
    return float(measure_distance(sample_surface(source, count), Boxes(target.corners)).max(initial=0.0))


def measure_deviation(before: Surface, after: Surface, count: int = 2000) -> float:
    """Greatest distance between two surfaces, both ways."""
    return max(measure_one_way(before, after, count), measure_one_way(after, before, count))


def measure_stray(source: Array, target: Array) -> float:
    """Greatest distance from line segments (k, 2, 3) to others; infinite where there are no others."""
    if not len(source):
        return 0.0
    if not len(target):
        return float("inf")
    source = source[_choose_some(len(source), 2000, np.random.default_rng(0))]
    points = np.concatenate([source[:, 0] + (source[:, 1] - source[:, 0]) * t for t in (0, 0.25, 0.5, 0.75, 1)])
    return float(measure_distance(points, Boxes(target[:, [0, 1, 1]])).max())


def count_strangers(before: Surface, after: Surface) -> int:
    """Output points that are no input points, bit by bit."""
    if not len(after.points):
        return 0
    known = np.unique(before.points, axis=0)
    return len(np.unique(np.concatenate([known, after.points]), axis=0)) - len(known)


def count_facing_away(mesh: Surface, other: Surface, within: float) -> int:
    """Faces of `mesh`, none too thin, under whose middle no face of `other` looks the same way."""
    vectors, others = compute_area_vectors(mesh), compute_area_vectors(other)
    sides = np.linalg.norm(mesh.corners - np.roll(mesh.corners, 1, axis=1), axis=2).max(axis=1)
    lengths = np.linalg.norm(vectors, axis=1)
    heights = np.divide(lengths, sides, out=np.zeros_like(lengths), where=sides > 0)
    wrong = 0
    for face in np.flatnonzero(heights > 16 * within + 1e-9 * measure_extent(mesh)):
        middle = np.broadcast_to(mesh.corners[face].mean(axis=0), (len(others), 3))
        near = measure_own_distance(middle, other.corners) <= within
        wrong += not np.any(others[near] @ vectors[face] > 0)
    return wrong


def find_broken(
    before: Surface,
    after: Surface,
    tolerance: float,
    bound: float,
    *,
    healed: int = 0,
    dropped: bool = False,
    closed: bool = False,
    count: int = 500,
) -> list[str]:
    """Promises that `after` breaks, in words; empty where it keeps them all.

    `tolerance` and `bound` are lengths; `healed` as reported: without healing the topology
    may not change at all, with it only towards fewer open edges. Where bodies were dropped,
    counts and borders that were theirs are gone; only what is made anew is looked at. Where details were `closed`,
    handles and borders may be fewer, never more.
    """
    if not len(before.faces):
        return [] if not len(after.faces) else ["faces out of nothing"]
    if not len(after.faces):
        return ["empty"] if compute_area(before) > 0 else []
    found = _find_wrong_counts(count_topology(before), count_topology(after), healed, dropped or closed)
    narrow = tolerance <= WIDE * np.linalg.norm(np.ptp(before.points, axis=0))
    if narrow and count_strangers(before, after):
        found.append(f"{count_strangers(before, after)} points that the input does not have")
    slack = estimate_blur(before)
    apart = measure_deviation(before, after, count)
    if apart > tolerance + slack:
        found.append(f"deviation {apart} above the tolerance {tolerance}")
    if apart > bound + slack:
        found.append(f"deviation {apart} above the printed bound {bound}")
    if bound > tolerance + slack:
        found.append(f"printed bound {bound} above the tolerance {tolerance}")
    within = max(bound, slack)
    if dropped:
        return found
    found += _find_wrong_edges("open", before, after, within, healed, closed)
    # Edges of more than two faces are held to the tolerance; the bound is that of the surface.
    within = max(tolerance, slack)
    wrong = _find_wrong_shape(before, after, within, healed, closed)
    if wrong and len(drop_winding(before).faces) < len(before.faces):
        # Of a sheet that is two-sided in places, and heals, neither count tells what must stay.
        wrong = [] if healed else _find_wrong_shape(drop_winding(before), drop_winding(after), within, healed, closed)
    return found + wrong


def _find_wrong_counts(old: Topology, new: Topology, healed: int, dropped: bool) -> list[str]:
    found = []
    if new.points > old.points or new.triangles > old.triangles:
        found.append(f"more than before: {old.points}/{old.triangles} -> {new.points}/{new.triangles}")
    if new.clashing > old.clashing:
        found.append(f"clashing edges {old.clashing} -> {new.clashing}")
    fewer = new.components < old.components and not healed
    if not dropped and (new.components > old.components or fewer):
        found.append(f"components {old.components} -> {new.components}, healed {healed}")
    if new.open_edges > 0 == old.open_edges:
        found.append(f"open edges {old.open_edges} -> {new.open_edges}")
    if new.nonmanifold_edges > 0 == old.nonmanifold_edges:
        found.append(f"fins: non-manifold edges {old.nonmanifold_edges} -> {new.nonmanifold_edges}")
    return found


def _find_wrong_shape(before: Surface, after: Surface, within: float, healed: int, closed: bool) -> list[str]:
    old, new = count_topology(before), count_topology(after)
    found = _find_wrong_edges("nonmanifold", before, after, within, healed, closed)
    # Two borders that become one edge add one; a bubble of needles that closes on its edge takes one away.
    if new.euler < old.euler - healed or (new.euler > old.euler + healed and not closed):
        found.append(f"euler {old.euler} -> {new.euler}, healed {healed}")
    fewer = closed and new.rims <= old.rims and new.rim_cycles <= old.rim_cycles
    if not healed and (old.rims, old.rim_cycles) != (new.rims, new.rim_cycles) and not fewer:
        found.append(f"rims {old.rims}, {old.rim_cycles} cycles -> {new.rims}, {new.rim_cycles} cycles")
    return found


def _find_wrong_edges(
    uses: str, before: Surface, after: Surface, within: float, healed: int, closed: bool
) -> list[str]:
    old, new = select_segments(before, uses), select_segments(after, uses)
    found = []
    if measure_stray(new, old) > within:
        found.append(f"{uses} edges {measure_stray(new, old)} away from those of the input")
    if not healed and not closed and measure_stray(old, new) > within:
        found.append(f"{uses} edges of the input {measure_stray(old, new)} away from those of the result")
    return found


def collect_positions(mesh: Surface) -> set[bytes]:
    """Positions as a set, to compare results whose points come in another order."""
    return {p.tobytes() for p in mesh.points}


def collect_triangles(mesh: Surface) -> set[bytes]:
    """Triangles as a set of their positions, each from its lexicographically least corner."""
    return {t.tobytes() for t in mesh.corners}
