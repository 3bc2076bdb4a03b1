"""Named tiny shapes, each as (points, faces), and ways to make them harder without changing them.

Numbers are integers or halves wherever possible, so that coplanar is exactly coplanar.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bldsimp import triangulate

Points = NDArray[np.float64]
Faces = NDArray[np.int64]
Shape = tuple[Points, Faces]

SIDES = (
    ((0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 0)),
    ((0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)),
    ((0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)),
    ((1, 1, 0), (0, 1, 0), (0, 1, 1), (1, 1, 1)),
    ((0, 1, 0), (0, 0, 0), (0, 0, 1), (0, 1, 1)),
    ((1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1)),
)
"""The six sides of the unit box, counter-clockwise seen from outside: -z +z -y +y -x +x."""


def shape(points: ArrayLike, faces: ArrayLike) -> Shape:
    return np.asarray(points, float).reshape(-1, 3), np.asarray(faces, np.int64).reshape(-1, 3)


def merge(*shapes: Shape) -> Shape:
    """Shapes side by side in one mesh; equal positions are not welded."""
    offset = np.cumsum([0] + [len(p) for p, _ in shapes[:-1]])
    points = np.concatenate([p for p, _ in shapes])
    return shape(points, np.concatenate([f + o for (_, f), o in zip(shapes, offset, strict=True)]))


def weld(mesh: Shape) -> Shape:
    """Equal positions become one row."""
    points, inverse = np.unique(mesh[0] + 0.0, axis=0, return_inverse=True)
    return shape(points, inverse.reshape(-1)[mesh[1]])


def fan_polygons(*polygons: ArrayLike) -> Shape:
    """Convex polygons as fans from their first corner, welded."""
    fans = []
    for polygon in polygons:
        corners = np.asarray(polygon, float)
        fans.append(shape(corners, [[0, i, i + 1] for i in range(1, len(corners) - 1)]))
    return weld(merge(*fans))


# Solids


def box(size: ArrayLike = (1, 1, 1), at: ArrayLike = (0, 0, 0)) -> Shape:
    return fan_polygons(*(np.array(side) * size + at for side in SIDES))


def prism(outline: ArrayLike, height: float = 4.0) -> Shape:
    """A simple polygon, counter-clockwise, pulled up."""
    ring = np.asarray(outline, float)
    count = len(ring)
    after = (np.arange(count) + 1) % count
    cap = triangulate(ring, np.stack([np.arange(count), after], axis=1)).triangles.astype(np.int64)
    walls = [[[i, j, count + j], [i, count + j, count + i]] for i, j in enumerate(after)]
    points = np.concatenate([np.c_[ring, np.zeros(count)], np.c_[ring, np.full(count, height)]])
    return shape(points, np.concatenate([cap[:, ::-1], cap + count, np.reshape(walls, (-1, 3))]))


def comb(teeth: int = 5, gap: float = 0.25, depth: float = 16.0) -> Shape:
    """Broad teeth, short and long, with narrow gaps between them: beside each short one, a long side."""
    outline = [(0.0, -1.0), (teeth * (3 + gap) - gap, -1.0)]
    for tooth in reversed(range(teeth)):
        left, top = tooth * (3 + gap), depth if tooth % 2 else depth / 3
        outline += [(left + 3, 0.0), (left + 3, top), (left, top), (left, 0.0)]
    return prism(outline[:2] + outline[3:-1])


def star(seed: int, spikes: int = 30) -> Shape:
    """Spikes of many lengths with sharp notches between them, on a grid."""
    rng = np.random.default_rng(seed)
    tips, count = np.arange(2 * spikes) % 2 == 0, 2 * spikes
    angle = (np.arange(count) + rng.uniform(0, 0.8, count)) * np.pi / spikes
    radius = np.where(tips, rng.uniform(200, 1000, count), rng.uniform(50, 150, count))
    return prism(np.round(np.stack([np.cos(angle), np.sin(angle)], axis=1) * radius[:, None]))


def doorway(width: float = 12.0) -> tuple[tuple[float, float], ...]:
    """Outline with a lintel from (0, 0) to (width, 0), and a dent just above the middle of the lintel."""
    middle = width / 2
    dent = ((middle + 1, 6.0), (middle, 1.0), (middle - 1, 6.0))
    right = ((width, 0.0), (width, -4.0), (width + 3, -4.0), (width + 3, 6.0))
    return ((0.0, 0.0), *right, *dent, (-3.0, 6.0), (-3.0, -4.0), (0.0, -4.0))


def canopy() -> Shape:
    """A triangle, each side of which is the lintel of a doorway; its first face is the triangle."""
    corners = np.array([(0.0, 0, 0), (16, 0, 0), (4, 12, 0)])
    shapes = [shape(corners, [[0, 1, 2]])]
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        outline = np.array(doorway(float(np.linalg.norm(b - a))))
        rows = np.arange(len(outline))
        faces = triangulate(outline, np.stack([rows, np.roll(rows, -1)], axis=1)).triangles
        points = a + outline[:, :1] * (b - a) / np.linalg.norm(b - a) + outline[:, 1:] * (0, 0, 1)
        points[1] = b
        shapes.append(shape(points, faces))
    return merge(*shapes)


def gabled_house() -> Shape:
    a, b, c, d = (0, 0, 0), (8, 0, 0), (8, 6, 0), (0, 6, 0)
    e, f, g, h = (0, 0, 4), (8, 0, 4), (8, 6, 4), (0, 6, 4)
    west, east = (0, 3, 6), (8, 3, 6)
    return fan_polygons(
        [a, d, c, b], [a, b, f, e], [c, d, h, g], [b, c, g, east, f], [d, a, e, west, h],
        [e, f, east, west], [g, h, west, east],
    )  # fmt: skip


def pillow() -> Shape:
    """Two triangles back to back: closed, no volume."""
    return shape([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 1]])


def inside_out_box() -> Shape:
    return reverse_winding(box())


def room_with_cavity() -> Shape:
    """A box within a box; the inner one faces inwards, as a cavity must."""
    return merge(box((4, 4, 4)), reverse_winding(box((2, 2, 2), (1, 1, 1))))


def box_within_a_box() -> Shape:
    """Both face outwards; as a cavity the inner one stands wrong, as a solid it is right."""
    return merge(box((4, 4, 4)), box((2, 2, 2), (1, 1, 1)))


def thin_plate(thickness: float = 2**-30) -> Shape:
    return box((1, 1, thickness))


def frame() -> Shape:
    """A square ring of eight unit cubes: one hole through it."""
    return voxels(np.array([[[1], [1], [1]], [[1], [0], [1]], [[1], [1], [1]]], bool))


def boxes_touching_in_an_edge() -> Shape:
    return weld(merge(box(), box(at=(1, 1, 0))))


def boxes_touching_in_a_point() -> Shape:
    return weld(merge(box(), box(at=(1, 1, 1))))


def boxes_sharing_part_of_a_wall() -> Shape:
    """Two boxes whose walls overlap, but share no edge."""
    return merge(box((2, 2, 2)), box((2, 1, 1), (2, 0.5, 0.5)))


def rooms_back_to_back() -> Shape:
    """Two boxes that share a whole wall, each with its own diagonal there."""
    return weld(merge(box(), box(at=(1, 0, 0))))


def wall_between_two_rooms() -> Shape:
    """The same with one wall between them: three faces meet at its edges."""
    points, faces = rooms_back_to_back()
    inside = np.flatnonzero((points[faces][:, :, 0] == 1).all(axis=1))
    return shape(points, np.delete(faces, inside[:2], axis=0))


def voxels(filled: NDArray[np.bool_], size: ArrayLike = (1, 1, 1)) -> Shape:
    """Surface of a union of boxes on a grid, welded; non-manifold where cells touch in edges or points."""
    around = np.pad(filled, 1)
    polygons = []
    for cell in np.argwhere(filled):
        for side in SIDES:
            corners = np.array(side)
            out = np.round(corners.mean(axis=0) * 2 - 1).astype(int)
            if not around[tuple(cell + 1 + out)]:
                polygons.append((corners + cell) * np.asarray(size, float))
    return fan_polygons(*polygons)


def pyramid() -> Shape:
    """A prism of ten sides under a tip: faces of many directions."""
    turn = [(10, 0), (8, 6), (6, 8), (0, 10), (-6, 8), (-10, 0), (-8, -6), (-6, -8), (0, -10), (8, -6)]
    low, high = [(x, y, 0) for x, y in turn], [(x, y, 4) for x, y in turn]
    walls = [[low[i - 1], low[i], high[i], high[i - 1]] for i in range(10)]
    return fan_polygons(low[::-1], *walls, *([high[i - 1], high[i], (0, 0, 12)] for i in range(10)))


# Open and odd surfaces


def square() -> Shape:
    return shape([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])


def one_triangle() -> Shape:
    return shape([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])


def open_cone() -> Shape:
    points, faces = pyramid()
    return shape(points, [f for f in faces if points[f].max() == 12 and points[f][:, 2].min() == 4])


def plate_with_holes() -> Shape:
    """A plate 5 x 3 with two square holes."""
    return fan_polygons(
        *(
            [(x, y, 0), (x + 1, y, 0), (x + 1, y + 1, 0), (x, y + 1, 0)]
            for x in range(5)
            for y in range(3)
            if (x, y) not in ((1, 1), (3, 1))
        )
    )


def looping_path() -> Shape:
    """A path in one plane that runs over itself."""
    return fan_polygons(
        *(
            [(x, y, 0) for x, y in ring]
            for ring in (
                ((0, 0), (5, 0), (4, 1), (0, 1)), ((5, 0), (5, 5), (4, 4), (4, 1)),
                ((5, 5), (1, 5), (2, 4), (4, 4)), ((1, 5), (1, -2), (2, -2), (2, 4)),
            )
        )
    )  # fmt: skip


def pinched_plate() -> Shape:
    """A plate whose two holes touch in one point."""
    return fan_polygons(
        *(
            [(x, y, 0), (x + 1, y, 0), (x + 1, y + 1, 0), (x, y + 1, 0)]
            for x in range(4)
            for y in range(4)
            if (x, y) not in ((1, 1), (2, 2))
        )
    )


def bow_tie() -> Shape:
    """Two triangles that share a point alone."""
    return shape([[0, 0, 0], [2, 0, 0], [1, 1, 0], [0, 2, 0], [2, 2, 0]], [[0, 1, 2], [2, 4, 3]])


def moebius(steps: int = 9) -> Shape:
    """A band with half a turn: no consistent winding exists."""
    angle = np.arange(steps) * 2 * np.pi / steps
    points = []
    for sign in (-1, 1):
        radius = 4 + sign * np.cos(angle / 2)
        points.append(np.stack([radius * np.cos(angle), radius * np.sin(angle), sign * np.sin(angle / 2)], axis=1))
    faces = []
    for i in range(steps):
        j = (i + 1) % steps
        a, b, c, d = i, j, steps + i, steps + j
        if j == 0:
            b, d = d, b
        faces += [[a, b, d], [a, d, c]]
    return shape(np.concatenate(points), faces)


def three_leaves() -> Shape:
    """Three squares on one edge."""
    leaves = ((1, 0), (-1, 1), (-1, -1))
    return fan_polygons(*([(0, 0, 0), (0, 0, 2), (x, y, 2), (x, y, 0)] for x, y in leaves))


def t_junction_wall() -> Shape:
    """Two squares above a wide one that does not know the point between them."""
    return fan_polygons(
        [(0, 0, 0), (2, 0, 0), (2, 0, 1), (0, 0, 1)],
        [(0, 0, 1), (1, 0, 1), (1, 0, 2), (0, 0, 2)],
        [(1, 0, 1), (2, 0, 1), (2, 0, 2), (1, 0, 2)],
    )


def closed_t_junction_wall() -> Shape:
    """The same, its T-junction closed by a face without area."""
    points, faces = t_junction_wall()
    ends = [int(np.flatnonzero((points == p).all(axis=1))[0]) for p in ((0, 0, 1), (1, 0, 1), (2, 0, 1))]
    return shape(points, [*faces.tolist(), [ends[0], ends[2], ends[1]]])


def fan_with_sliver(height: float = 2**-40) -> Shape:
    """A square as a fan round a point that nearly lies on its side."""
    ring = [[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]]
    return shape([*ring, [2, height, 0]], [[i, (i + 1) % 4, 4] for i in range(4)])


def fan_folded_back() -> Shape:
    """A square whose fan overlaps itself: one face is turned over in its own plane."""
    ring = [[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]]
    return shape([*ring, [2, -1, 0]], [[i, (i + 1) % 4, 4] for i in range(4)])


def staircase(steps: int = 6, height: float = 0.5) -> Shape:
    """An open band of treads and risers."""
    polygons = []
    for i in range(steps):
        z = i * height
        polygons.append([(i, 0, z), (i, 0, z + height), (i, 3, z + height), (i, 3, z)])
        polygons.append([(i, 0, z + height), (i + 1, 0, z + height), (i + 1, 3, z + height), (i, 3, z + height)])
    return fan_polygons(*polygons)


def crossing_squares() -> Shape:
    """Two squares that cross without sharing a point."""
    return fan_polygons([(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)], [(0, 1, -1), (2, 1, -1), (2, 1, 1), (0, 1, 1)])


def collinear_triangle() -> Shape:
    """One face, and no area."""
    return shape([[0, 0, 0], [1, 1, 1], [3, 3, 3]], [[0, 1, 2]])


# Ways to make a shape harder


def reverse_winding(mesh: Shape) -> Shape:
    return mesh[0], mesh[1][:, ::-1]


def add_backs(mesh: Shape) -> Shape:
    """Every face a second time, the other way round."""
    return mesh[0], np.concatenate([mesh[1], mesh[1][:, ::-1]])


def unweld(mesh: Shape) -> Shape:
    """Three rows for every face."""
    return mesh[0][mesh[1]].reshape(-1, 3), np.arange(3 * len(mesh[1])).reshape(-1, 3)


def add_isolated_points(mesh: Shape) -> Shape:
    return np.concatenate([[[99.0, 99, 99]], mesh[0], [[-50.0, 0, 0]]]), mesh[1] + 1


def add_copies(mesh: Shape) -> Shape:
    """The first half of the faces twice, and one that repeats a point."""
    return mesh[0], np.concatenate([mesh[1], mesh[1][: len(mesh[1]) // 2 + 1, [1, 2, 0]], mesh[1][:1, [0, 1, 0]]])


def remove_faces(mesh: Shape, *which: int) -> Shape:
    return mesh[0], np.delete(mesh[1], which, axis=0)


def move(mesh: Shape, by: ArrayLike) -> Shape:
    return mesh[0] + np.asarray(by, float), mesh[1]


def rotate(mesh: Shape, degrees: float = 21.0) -> Shape:
    """Turned about a skew axis: nothing is exactly flat any more."""
    axis = np.array([0.2, 0.3, 1.0]) / np.linalg.norm([0.2, 0.3, 1.0])
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turn = np.radians(degrees)
    return mesh[0] @ (np.eye(3) + np.sin(turn) * cross + (1 - np.cos(turn)) * cross @ cross).T, mesh[1]


def round_to_single(mesh: Shape) -> Shape:
    """Coordinates rounded to single precision."""
    return mesh[0].astype(np.float32).astype(float), mesh[1]


def subdivide(mesh: Shape, rounds: int = 1) -> Shape:
    """Every face as four; new points halve the edges."""
    points, faces = mesh
    for _ in range(rounds):
        a, b, c = faces.T
        edges = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
        unique, edge_of = np.unique(edges, axis=0, return_inverse=True)
        p, q, r = (len(points) + edge_of.reshape(-1, 3)).T
        points = np.concatenate([points, (points[unique[:, 0]] + points[unique[:, 1]]) / 2])
        faces = np.concatenate([np.stack(f, axis=1) for f in ((a, p, r), (p, b, q), (r, q, c), (p, q, r))])
    return shape(points, faces)


def add_noise(mesh: Shape, size: float, seed: int = 0) -> Shape:
    """Every coordinate moved by at most `size`."""
    return mesh[0] + np.random.default_rng(seed).uniform(-size, size, mesh[0].shape), mesh[1]


def shuffle(mesh: Shape, seed: int = 0) -> Shape:
    """The same faces in another order, from another corner, over points in another order."""
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(mesh[0]))
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    faces = place[mesh[1]][rng.permutation(len(mesh[1]))]
    turn = (rng.integers(0, 3, len(faces))[:, None] + np.arange(3)) % 3
    return mesh[0][order], np.take_along_axis(faces, turn, axis=1)


CLOSED = {
    make.__name__: make
    for make in (
        box, gabled_house, pyramid, frame, room_with_cavity, box_within_a_box, boxes_touching_in_a_point,
        boxes_touching_in_an_edge, boxes_sharing_part_of_a_wall, rooms_back_to_back, pillow, thin_plate, inside_out_box,
    )
}  # fmt: skip
OPEN = {
    make.__name__: make
    for make in (
        square, one_triangle, open_cone, plate_with_holes, pinched_plate, bow_tie, moebius, three_leaves,
        t_junction_wall, closed_t_junction_wall, fan_with_sliver, fan_folded_back, staircase,
        crossing_squares, wall_between_two_rooms, collinear_triangle,
    )
}  # fmt: skip
SHAPES = CLOSED | OPEN
HARDER = {
    make.__name__: make
    for make in (
        reverse_winding,
        add_backs,
        unweld,
        add_isolated_points,
        add_copies,
        rotate,
        round_to_single,
        subdivide,
    )
}
