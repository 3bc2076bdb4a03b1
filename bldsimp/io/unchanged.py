"""Whether a mesh has become no lighter: it is then better left as it is stored."""

from __future__ import annotations

import numpy as np

from ..model import Faces, Mesh, Points, Scene, SimplifiedMesh
from ..options import Options
from ..stages.normals import compute_face_normals
from ..unique_rows import find_unique_rows
from .warnings import dropped


def is_better_as_read(scene: Scene, lights: list[SimplifiedMesh], options: Options, size: int) -> bool:
    """Whether an OBJ file has become no lighter, and its new text, of this size, no smaller.

    A file of which reading left anything out, or of which the user wants other normals or fewer attributes, is not.
    """
    if scene.format != "obj" or len(scene.source) > size or scene.warnings:
        return False
    if options.normals != "auto" or dropped(scene, options):
        return False
    mesh, light = scene.meshes[0], lights[0]
    return is_no_lighter(mesh, light, list(range(len(mesh.parts))))


def is_no_lighter(mesh: Mesh, light: SimplifiedMesh, parts: list[int]) -> bool:
    """Whether parts have as many faces as before on the same points, of the same area and outside, and none of no area.

    Which diagonals cut a flat piece does not matter.
    """
    if light.changed or any(
        np.count_nonzero(mesh.part_of_face == part) != np.count_nonzero(light.part_of_face == part) for part in parts
    ):
        return False
    chosen = np.isin(light.part_of_face, parts)
    old, new = mesh.faces[np.isin(mesh.part_of_face, parts)], light.faces[chosen]
    if (light.points[new] != mesh.points[light.row[new]]).any():
        return False
    if _count(mesh.points, old) != _count(light.points, new):
        return False
    # So that no product of coordinates leaves the range of double precision.
    unit = float(np.abs(mesh.points[old]).max()) or 1.0
    before, after = compute_face_normals(mesh.points / unit, old), compute_face_normals(light.points / unit, new)
    areas = np.linalg.norm(before, axis=1)
    sides = (after * compute_face_normals(mesh.points / unit, mesh.faces[light.face[chosen]])).sum(axis=1)
    same = np.isclose(areas.sum(), np.linalg.norm(after, axis=1).sum(), rtol=1e-9, atol=0.0)
    return bool(same and (areas > 0.0).all() and (sides > 0.0).all())


def _count(points: Points, faces: Faces) -> int:
    """Number of distinct points that faces use."""
    return len(find_unique_rows(points[np.unique(faces)])[0])
