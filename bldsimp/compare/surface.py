"""A surface in world space: what every method starts from, and what is measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..model import Faces, Points, Scene, SimplifiedMesh
from ..tolerance import transform_points
from ..unique_rows import find_unique_rows


@dataclass(frozen=True)
class Surface:
    """Triangles over welded points.

    Attributes
    ----------
    points : (n, 3) float64
        Model units, world space; distinct, each used by a face.
    faces : (m, 3) int32
        No face repeats a point, and none is there twice with the same winding.
    """

    points: Points
    faces: Faces


def surface_of(scene: Scene, lights: list[SimplifiedMesh] | None = None) -> Surface:
    """All instances of all meshes of a scene, or of what became of them, as one surface.

    Parameters
    ----------
    scene : Scene
    lights : list of SimplifiedMesh, optional
        One per mesh; without them the scene's own faces.
    """
    own = scene.meshes if lights is None else lights
    return placed_surface(scene, [one.points for one in own], [one.faces for one in own])


def placed_surface(scene: Scene, points: list[Points], faces: list[Faces]) -> Surface:
    """All instances of meshes that have become others, as one surface.

    Parameters
    ----------
    scene : Scene
        Places the meshes.
    points, faces : list
        What each mesh of the scene has become, in its own frame.
    """
    all_points, all_faces, count = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], 0
    for mesh, own, corners in zip(scene.meshes, points, faces, strict=True):
        for transform in mesh.transforms:
            still = np.array_equal(transform, np.eye(4))
            all_points.append(own if still else transform_points(own, transform))
            # A mirrored instance shows its faces the other way round.
            turned = corners[:, ::-1] if np.linalg.det(transform[:3, :3]) < 0 else corners
            all_faces.append(turned.astype(np.int64) + count)
            count += len(own)
    return welded(np.concatenate(all_points), np.concatenate(all_faces))


def welded(points: Points, faces: Faces) -> Surface:
    """A surface of points that are distinct and used, and of faces that are proper and distinct."""
    used, compact = np.unique(faces, return_inverse=True)
    first, position = find_unique_rows(points[used])
    corners = position[compact.reshape(-1)].reshape(-1, 3)
    a, b, c = corners.T
    corners = corners[(a != b) & (b != c) & (a != c)]
    least = np.argmin(corners, axis=1)[:, None]
    turned = np.take_along_axis(corners, (least + np.arange(3)) % 3, axis=1)
    corners = corners[find_unique_rows(turned)[0]]
    left, compact = np.unique(corners, return_inverse=True)
    return Surface(
        np.ascontiguousarray(points[used][first][left]),
        np.ascontiguousarray(compact.reshape(-1, 3), np.int32),
    )
