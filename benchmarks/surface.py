"""Read meshes and measure their distances by an independent library, as the benchmarks compare them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parents[1]


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
    return weld_surface(np.concatenate(points), np.concatenate(faces))


def weld_surface(points: NDArray[np.float64], faces: NDArray[np.int64], *, one_sided: bool = False) -> Surface:
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
    """Return whether every edge is used by two faces, in opposite directions."""
    halfedges = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    keys = halfedges[:, 0] * (int(faces.max()) + 1) + halfedges[:, 1]
    back = halfedges[:, 1] * (int(faces.max()) + 1) + halfedges[:, 0]
    keys.sort()
    back.sort()
    return bool(np.array_equal(keys, back) and (keys[1:] != keys[:-1]).all())


def measure_deviation(before: Surface, after: Surface, samples: int = 20_000) -> float:
    """Measure the greatest distance between two surfaces, both ways, over all points and samples spread by area.

    libigl finds the nearest face. Its squared distances are no better than the square root of what double
    precision resolves, so the distance to that face is then taken again, in extended precision: it is never
    less than the distance to the surface.
    """
    if not len(after.faces):
        return float("inf")
    origin = before.points.mean(axis=0)
    before, after = (Surface(points - origin, faces) for points, faces in (before, after))
    return max(_measure_one_way(before, after, samples), _measure_one_way(after, before, samples))


def _measure_one_way(source: Surface, target: Surface, samples: int) -> float:
    import igl

    sought = np.concatenate([source.points, spread_samples(source, samples)[0]])
    points, faces = np.ascontiguousarray(target.points), np.ascontiguousarray(target.faces)
    nearest = faces[igl.point_mesh_squared_distance(sought, points, faces)[1]]
    exact = points.astype(np.longdouble)
    return float(_measure_distances(sought.astype(np.longdouble), *(exact[corner] for corner in nearest.T)).max())


Exact = NDArray[np.longdouble]


def _measure_distances(points: Exact, a: Exact, b: Exact, c: Exact) -> Exact:
    """Measure the distance of each point to a triangle of its own."""
    normal = np.cross(b - a, c - a)
    area = np.sqrt(_multiply(normal, normal))
    edges = [(a, b), (b, c), (c, a)]
    above = np.all([_multiply(np.cross(v - u, points - u), normal) >= 0 for u, v in edges], axis=0) & (area > 0)
    distances = np.min([_measure_segment_distances(points, u, v) for u, v in edges], axis=0)
    heights = np.abs(_multiply(points - a, normal)) / np.where(area > 0, area, 1)
    return np.asarray(np.where(above, np.minimum(heights, distances), distances))


def _measure_segment_distances(points: Exact, u: Exact, v: Exact) -> Exact:
    squared = _multiply(v - u, v - u)
    along = np.clip(_multiply(points - u, v - u) / np.where(squared > 0, squared, 1), 0, 1)
    off = points - (u + along[:, None] * (v - u))
    return np.sqrt(_multiply(off, off))


def _multiply(a: Exact, b: Exact) -> Exact:
    return np.asarray((a * b).sum(axis=1))


def spread_samples(surface: Surface, samples: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Spread samples by area; return them and the face of each; the same for the same surface."""
    rng = np.random.default_rng(1)
    a, b, c = (surface.points[surface.faces[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    chosen = rng.choice(len(area), samples, p=area / area.sum())
    s, t = np.sqrt(rng.random((samples, 1))), rng.random((samples, 1))
    points: NDArray[np.float64] = (1 - s) * a[chosen] + s * (1 - t) * b[chosen] + s * t * c[chosen]
    return points, chosen


def find_models() -> Path:
    """Find the folder of the models: BLDSIMP_MODELS, or `../shared/models` beside the checkout.

    Raises
    ------
    SystemExit
        If it is missing; says what to do.
    """
    folder = Path(os.environ.get("BLDSIMP_MODELS") or ROOT.parent / "shared" / "models")
    if not folder.is_dir():
        raise SystemExit(f"{folder}: no such folder: set BLDSIMP_MODELS to that of the third-party models")
    return folder
