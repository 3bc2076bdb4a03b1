"""Place the meshes of a scene in the world and weld them: every method starts from this surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..model import Faces, Points, Scene, SimplifiedMesh, cast_indices
from ..tolerance import transform_points
from ..unique_rows import find_unique_rows


@dataclass(frozen=True)
class PlacedSurface:
    """Triangles over welded points.

    Attributes
    ----------
    points : (n, 3) float64
        Model units, world space; distinct, each used by a face.
    faces : (m, 3) int32
        No face repeats a point, and no two faces with the same winding are equal.
    """

    points: Points
    faces: Faces


def place_scene(scene: Scene, results: list[SimplifiedMesh] | None = None) -> PlacedSurface:
    """Join all instances of all meshes of a scene, or of their results, to one surface.

    Parameters
    ----------
    scene : Scene
    results : list of SimplifiedMesh, optional
        One per mesh; without them the scene's own faces.
    """
    own = scene.meshes if results is None else results
    return place_meshes(scene, [one.points for one in own], [one.faces for one in own])


def place_meshes(scene: Scene, points: list[Points], faces: list[Faces]) -> PlacedSurface:
    """Join all instances of other meshes, each in the place of one of the scene's, to one surface.

    Parameters
    ----------
    scene : Scene
        Places the meshes.
    points : list of (n, 3) float64
        For each mesh of the scene, in that mesh's own frame.
    faces : list of (m, 3) int32
    """
    all_points, all_faces, count = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], 0
    for mesh, own, corners in zip(scene.meshes, points, faces, strict=True):
        for transform in mesh.transforms:
            still = np.array_equal(transform, np.eye(4))
            all_points.append(own if still else transform_points(own, transform))
            # A mirrored instance has the opposite winding.
            turned = corners[:, ::-1] if np.linalg.det(transform[:3, :3]) < 0 else corners
            all_faces.append(turned.astype(np.int64) + count)
            count += len(own)
    return weld_surface(np.concatenate(all_points), np.concatenate(all_faces))


def weld_surface(points: Points, faces: Faces) -> PlacedSurface:
    """Weld equal points; drop unused points, faces that repeat a point, and copies with the same winding."""
    used, compact = np.unique(faces, return_inverse=True)
    first, position = find_unique_rows(points[used])
    corners = position[compact.reshape(-1)].reshape(-1, 3)
    a, b, c = corners.T
    corners = corners[(a != b) & (b != c) & (a != c)]
    least = np.argmin(corners, axis=1)[:, None]
    turned = np.take_along_axis(corners, (least + np.arange(3)) % 3, axis=1)
    corners = corners[find_unique_rows(turned)[0]]
    kept, compact = np.unique(corners, return_inverse=True)
    return PlacedSurface(np.ascontiguousarray(points[used][first][kept]), cast_indices(compact.reshape(-1, 3)))
