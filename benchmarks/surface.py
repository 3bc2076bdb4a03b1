"""Meshes as the benchmarks compare them: distinct points, faces, and distances by an independent library."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Surface(NamedTuple):
    """Points (n, 3) float64 that are all used, and faces (m, 3) int64."""

    points: NDArray[np.float64]
    faces: NDArray[np.int64]

    @property
    def diagonal(self) -> float:
        """Diagonal of the box of the points."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0)))


def read_surface(path: Path) -> Surface:
    """Read a file with trimesh, transforms applied, all of its meshes as one, and weld it exactly."""
    import trimesh

    points, faces, count = [], [], 0
    for part in trimesh.load_scene(path, process=False).dump():
        if isinstance(part, trimesh.Trimesh):
            points.append(np.asarray(part.vertices, np.float64))
            faces.append(np.asarray(part.faces, np.int64) + count)
            count += len(part.vertices)
    return welded(np.concatenate(points), np.concatenate(faces))


def welded(points: NDArray[np.float64], faces: NDArray[np.int64], *, one_sided: bool = False) -> Surface:
    """Weld exactly; drop faces that repeat a point, copies with the same winding, and unused points.

    Where `one_sided`, copies with the other winding go, too.
    """
    distinct, of_row = np.unique(points + 0.0, axis=0, return_inverse=True)
    faces = of_row.reshape(-1)[faces].reshape(-1, 3)
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    least_first = (np.argmin(faces, axis=1)[:, None] + np.arange(3)) % 3
    cycles = np.take_along_axis(faces, least_first, axis=1)
    _, first = np.unique(np.sort(faces, axis=1) if one_sided else cycles, axis=0, return_index=True)
    used, compact = np.unique(faces[np.sort(first)], return_inverse=True)
    return Surface(distinct[used], compact.reshape(-1, 3))


def is_watertight(faces: NDArray[np.int64]) -> bool:
    """Whether every edge is used by two faces, in opposite directions."""
    halfedges = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    keys = halfedges[:, 0] * (int(faces.max()) + 1) + halfedges[:, 1]
    back = halfedges[:, 1] * (int(faces.max()) + 1) + halfedges[:, 0]
    keys.sort()
    back.sort()
    return bool(np.array_equal(keys, back) and (keys[1:] != keys[:-1]).all())


def deviation(before: Surface, after: Surface, samples: int = 20_000) -> float:
    """Greatest distance between two surfaces, both ways, over all points and samples spread by area.

    libigl finds the nearest face. Its squared distances are no better than the square root of what double
    precision resolves, so the distance to that face is then taken again, in extended precision: it is never
    less than the distance to the surface.
    """
    if not len(after.faces):
        return float("inf")
    origin = before.points.mean(axis=0)
    before, after = (Surface(points - origin, faces) for points, faces in (before, after))
    return max(_one_way(before, after, samples), _one_way(after, before, samples))


def _one_way(source: Surface, target: Surface, samples: int) -> float:
    import igl

    sought = np.concatenate([source.points, spread(source, samples)[0]])
    points, faces = np.ascontiguousarray(target.points), np.ascontiguousarray(target.faces)
    nearest = faces[igl.point_mesh_squared_distance(sought, points, faces)[1]]
    exact = points.astype(np.longdouble)
    return float(_distances(sought.astype(np.longdouble), *(exact[corner] for corner in nearest.T)).max())


Exact = NDArray[np.longdouble]


def _distances(points: Exact, a: Exact, b: Exact, c: Exact) -> Exact:
    """Distance of each point to a triangle of its own."""
    normal = np.cross(b - a, c - a)
    area = np.sqrt(_dot(normal, normal))
    edges = [(a, b), (b, c), (c, a)]
    above = np.all([_dot(np.cross(v - u, points - u), normal) >= 0 for u, v in edges], axis=0) & (area > 0)
    distances = np.min([_distances_to_segments(points, u, v) for u, v in edges], axis=0)
    heights = np.abs(_dot(points - a, normal)) / np.where(area > 0, area, 1)
    return np.asarray(np.where(above, np.minimum(heights, distances), distances))


def _distances_to_segments(points: Exact, u: Exact, v: Exact) -> Exact:
    squared = _dot(v - u, v - u)
    along = np.clip(_dot(points - u, v - u) / np.where(squared > 0, squared, 1), 0, 1)
    off = points - (u + along[:, None] * (v - u))
    return np.sqrt(_dot(off, off))


def _dot(a: Exact, b: Exact) -> Exact:
    return np.asarray((a * b).sum(axis=1))


def spread(surface: Surface, samples: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Samples by area, and the face of each; the same for the same surface."""
    rng = np.random.default_rng(1)
    a, b, c = (surface.points[surface.faces[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    chosen = rng.choice(len(area), samples, p=area / area.sum())
    s, t = np.sqrt(rng.random((samples, 1))), rng.random((samples, 1))
    points: NDArray[np.float64] = (1 - s) * a[chosen] + s * (1 - t) * b[chosen] + s * t * c[chosen]
    return points, chosen
