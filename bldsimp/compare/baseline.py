"""What a general decimator needs for the same deviation: the figure that shows what flat facets save."""

from __future__ import annotations

import dataclasses

from ..model import Scene
from .decimate import Decimator, FastSimplification
from .measure import Judge
from .surface import surface_of


def baseline_points(scene: Scene, deviation: float, warnings: list[str]) -> int | None:
    """Points that fast-simplification needs to stay within a deviation.

    Parameters
    ----------
    scene : Scene
        Of each mesh the first instance counts.
    deviation : float
        Model units, in world space.
    warnings : list of str
        Told where the deviation cannot be reached.

    Returns
    -------
    int or None
        None where fast-simplification cannot drop a triangle without going beyond the deviation.

    Notes
    -----
    The target number of triangles is bisected geometrically. A result counts if no point and no sample
    of either surface lies farther than the deviation, and what single precision blurs, from the other: so
    the figure favours the baseline.
    """
    once = [dataclasses.replace(mesh, transforms=mesh.transforms[:1]) for mesh in scene.meshes]
    judge = Judge(surface_of(dataclasses.replace(scene, meshes=once)))
    found = Decimator(judge, FastSimplification()).fewest_points(deviation + judge.blur)
    if found is None:
        warnings.append("fast-simplification drops nothing within the same deviation")
    return None if found is None else len(found.surface.points)
