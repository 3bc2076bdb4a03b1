"""The article's eight steps, word for word, in slow and exact Python: the oracle of the C++ core.

"Morphological recognition optimization of 3D building simplification by Delaunay algorithm". Numbers
in comments are the steps of the core. A net is a dictionary of directed edges: ``apex[a, b]`` is the
third vertex of the triangle on the left of a-b. Points are `Fraction` pairs; every test is exact.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from fractions import Fraction

Point = tuple[Fraction, Fraction]
Edge = tuple[int, int]
Triangle = tuple[int, int, int]


def make_exact(points: Iterable[Sequence[float]]) -> list[Point]:
    """The points as fractions."""
    return [(Fraction(float(x)), Fraction(float(y))) for x, y in points]


def sign(value: Fraction) -> int:
    return (value > 0) - (value < 0)


def orient2d(a: Point, b: Point, c: Point) -> int:
    return sign((a[0] - c[0]) * (b[1] - c[1]) - (a[1] - c[1]) * (b[0] - c[0]))


def incircle(a: Point, b: Point, c: Point, d: Point) -> int:
    (ax, ay), (bx, by), (cx, cy) = ((p[0] - d[0], p[1] - d[1]) for p in (a, b, c))
    return sign(
        (ax * ax + ay * ay) * (bx * cy - cx * by)
        + (bx * bx + by * by) * (cx * ay - ax * cy)
        + (cx * cx + cy * cy) * (ax * by - bx * ay)
    )


# 2. Direction by poles.


def direction_by_poles(a: Point, b: Point, c: Point) -> int:
    """1 counter-clockwise, -1 clockwise, 0 where two vertices hold all four poles."""
    vertices = [a, b, c]
    left = min(vertices, key=lambda p: (p[0], p[1]))
    bottom = min(vertices, key=lambda p: (p[1], -p[0]))
    right = max(vertices, key=lambda p: (p[0], p[1]))
    top = max(vertices, key=lambda p: (p[1], -p[0]))
    poles = list(dict.fromkeys([left, bottom, right, top]))
    if len(poles) < 3:
        return 0
    first, second = vertices.index(poles[0]), vertices.index(poles[1])
    return 1 if (first + 1) % 3 == second else -1


def direction(a: Point, b: Point, m: Point) -> int:
    """Direction of the triangle a, b, m: the poles first, the determinant where they cannot tell."""
    return direction_by_poles(a, b, m) or orient2d(a, b, m)


def lies_between(a: Point, b: Point, m: Point) -> bool:
    """Formulas (2) and (3) for m on the line a-b, made right for edges parallel to an axis."""
    return all(min(p, q) < x < max(p, q) if p != q else x == p for p, q, x in zip(a, b, m, strict=True)) and m not in (
        a,
        b,
    )


class Net:
    """Triangles of some points, and the segments among their edges."""

    def __init__(self, points: list[Point]) -> None:
        self.points = points
        self.apex: dict[Edge, int] = {}
        self.uses: Counter[Edge] = Counter()  # of each undirected edge, by segments

    def triangles(self) -> set[Triangle]:
        """Each triangle once, its least index first, counter-clockwise."""
        return {(a, b, c) for (a, b), c in self.apex.items() if a == min(a, b, c)}

    def add(self, a: int, b: int, c: int) -> None:
        self.apex[a, b], self.apex[b, c], self.apex[c, a] = c, a, b

    def remove(self, a: int, b: int, c: int) -> None:
        del self.apex[a, b], self.apex[b, c], self.apex[c, a]

    def turn(self, a: int, b: int, c: int) -> int:
        return orient2d(self.points[a], self.points[b], self.points[c])

    def swap(self, a: int, b: int) -> Edge:
        """Swap the diagonal a-b of its two triangles; returns the new one."""
        c, d = self.apex[a, b], self.apex[b, a]
        self.remove(a, b, c)
        self.remove(b, a, d)
        self.add(c, d, b)
        self.add(d, c, a)
        return c, d

    # 3. Point location by direction search.

    def locate(self, m: int) -> tuple[Triangle | None, Edge | None]:
        """The triangle that m is in, or the edge it is on or, without a triangle, sees from outside."""
        a, b = next(iter(self.apex))
        while True:
            c = self.apex[a, b]
            on: Edge | None = None
            for edge in ((a, b), (b, c), (c, a)):
                at = direction(self.points[edge[0]], self.points[edge[1]], self.points[m])
                if at < 0:
                    break
                if at == 0 and lies_between(self.points[edge[0]], self.points[edge[1]], self.points[m]):
                    on = edge
            else:
                return (a, b, c), on
            b, a = edge
            if (a, b) not in self.apex:
                return None, (b, a)

    # 4. Insertion with Lawson flips.

    def insert(self, m: int) -> None:
        triangle, edge = self.locate(m)
        if triangle is None:
            self.insert_outside(m)
        elif edge is None:
            self.remove(*triangle)
            self.join(m, [(triangle[i], triangle[(i + 1) % 3]) for i in range(3)])
        else:
            rim = []
            for a, b in (edge, edge[::-1]):
                if (a, b) in self.apex:
                    c = self.apex[a, b]
                    self.remove(a, b, c)
                    rim += [(b, c), (c, a)]
            self.join(m, rim)

    def insert_outside(self, m: int) -> None:
        hull = [(b, a) for a, b in self.apex if (b, a) not in self.apex]
        self.join(m, [(a, b) for a, b in hull if self.turn(a, b, m) > 0])

    def join(self, m: int, rim: list[Edge]) -> None:
        for a, b in rim:
            self.add(a, b, m)
        self.legalize(rim)

    def legalize(self, edges: list[Edge]) -> None:
        """Swap diagonals until the edges, and those that swaps put in doubt, are Delaunay."""
        while edges:
            a, b = edges.pop()
            if (a, b) not in self.apex or (b, a) not in self.apex or self.uses[min(a, b), max(a, b)]:
                continue
            c, d = self.apex[a, b], self.apex[b, a]
            if incircle(*(self.points[i] for i in (a, b, c, d))) > 0:
                self.swap(a, b)
                edges += [(a, d), (d, b), (b, c), (c, a)]

    # 5. Constraints: influence domain, then swaps.

    def constrain(self, a: int, b: int) -> None:
        while a != b:
            stop = self.first_point(a, b)
            crossing = self.influence_domain(a, stop)
            fresh: list[Edge] = []
            while crossing:
                u, w = crossing.pop(0)
                c, d = self.apex[u, w], self.apex[w, u]
                if self.turn(d, w, c) <= 0 or self.turn(c, u, d) <= 0:
                    crossing.append((u, w))  # not convex yet
                    continue
                new = self.swap(u, w)
                (crossing if self.crosses(a, stop, *new) else fresh).append(new)
            self.uses[min(a, stop), max(a, stop)] += 1
            self.legalize(fresh)
            a = stop

    def first_point(self, a: int, b: int) -> int:
        """The first vertex after a on the segment a-b."""
        on = [
            i
            for i in {v for edge in self.apex for v in edge}
            if self.turn(a, b, i) == 0 and lies_between(self.points[a], self.points[b], self.points[i])
        ]
        return min(
            on,
            key=lambda i: sum(abs(x - y) for x, y in zip(self.points[a], self.points[i], strict=True)),
            default=b,
        )

    def crosses(self, a: int, b: int, u: int, w: int) -> bool:
        return self.turn(a, b, u) * self.turn(a, b, w) < 0 and self.turn(u, w, a) * self.turn(u, w, b) < 0

    def influence_domain(self, a: int, b: int) -> list[Edge]:
        """The edges that a-b crosses."""
        return [(u, w) for u, w in self.apex if u < w and self.crosses(a, b, u, w)]


def triangulate(points: Sequence[Sequence[float]], segments: Sequence[Edge], carve: bool) -> Net:
    """Steps 1 to 6. Points must differ, and segments must not cross."""
    net = Net(make_exact(points))
    # 1. The ends of every segment are points, inserted one by one.
    third = next((i for i in range(2, len(points)) if net.turn(0, 1, i) != 0), None)
    if third is None:
        return net
    net.add(*((0, 1, third) if net.turn(0, 1, third) > 0 else (1, 0, third)))
    for i in range(2, len(points)):
        if i != third:
            net.insert(i)
    for a, b in segments:
        net.constrain(a, b)
    if carve:
        carve_outside(net, segments)
    return net


# 6. Carve by the midpoint of a median.


def find_median_midpoint(a: Point, b: Point, c: Point) -> Point:
    return (2 * a[0] + b[0] + c[0]) / 4, (2 * a[1] + b[1] + c[1]) / 4


def is_inside(m: Point, points: list[Point], segments: Iterable[Edge]) -> bool:
    """Whether a ray from m to the right crosses an odd number of segments."""
    inside = False
    for i, j in segments:
        a, b = sorted((points[i], points[j]), key=lambda p: p[1])
        if a[1] <= m[1] < b[1] and orient2d(a, b, m) > 0:
            inside = not inside
    return inside


def carve_outside(net: Net, segments: Sequence[Edge]) -> None:
    for triangle in net.triangles():
        if not is_inside(find_median_midpoint(*(net.points[i] for i in triangle)), net.points, segments):
            net.remove(*triangle)


# 7. Orient, in space.

Vector = tuple[Fraction, Fraction, Fraction]


def normal(points: Sequence[Vector], triangle: Triangle) -> Vector:
    """Twice the area vector of a triangle."""
    a, b, c = (points[i] for i in triangle)
    u, v = ([q - p for p, q in zip(a, end, strict=True)] for end in (b, c))
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


def dot(u: Sequence[Fraction], v: Sequence[Fraction]) -> Fraction:
    return sum((x * y for x, y in zip(u, v, strict=True)), Fraction(0))


def orient(points: Sequence[Vector], triangles: Iterable[Triangle], facet_normal: Vector) -> list[Triangle]:
    """Swap the first and the third edge of every triangle whose normal opposes its facet's."""
    return [(a, c, b) if dot(normal(points, (a, b, c)), facet_normal) < 0 else (a, b, c) for a, b, c in triangles]


# 8. Vertex normals.


def compute_vertex_normals(points: Sequence[Vector], facets: Iterable[list[Triangle]]) -> list[dict[int, Vector]]:
    """Per facet and point the facet's normal: flat across creases. Not of unit length."""
    result = []
    for triangles in facets:
        parts = [normal(points, triangle) for triangle in triangles]
        total = (sum(p[0] for p in parts), sum(p[1] for p in parts), sum(p[2] for p in parts))
        result.append({i: total for triangle in triangles for i in triangle})
    return result
