"""Convert tolerances to model units, and measure the precision of the stored numbers."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .errors import InputError
from .model import Mesh, Points, Scene
from .options import AUTO_DIAGONAL, AUTO_SPACINGS, SIGNIFICANT_DIGITS, Tolerance

READ_BACK = 1e-15
"""Relative error of a number written with sixteen digits."""


def resolve_tolerance(scene: Scene, tolerance: Tolerance) -> float:
    """Convert a tolerance to model units, in world space.

    Parameters
    ----------
    scene : Scene
    tolerance : Tolerance

    Returns
    -------
    float
        For ``auto`` the lesser of `AUTO_SPACINGS` spacings of the stored numbers and `AUTO_DIAGONAL`
        of the diagonal.
    """
    if tolerance.unit == "length":
        return tolerance.value
    if tolerance.unit == "percent":
        return tolerance.value / 100.0 * measure_diagonal(scene)
    return min(AUTO_SPACINGS * measure_epsilon(scene), AUTO_DIAGONAL * measure_diagonal(scene))


def measure_epsilon(scene: Scene) -> float:
    """Return the spacing of the stored numbers, in world space: the coarsest of the scene's meshes."""
    return max((measure_spacing(mesh) * measure_scale(mesh) for mesh in scene.meshes), default=0.0)


def measure_blur(scene: Scene) -> float:
    """Return the coarsest spacing that the scene's numbers ever had, in world space: see `measure_rounding_spacing`."""
    return max((measure_rounding_spacing(mesh) * measure_scale(mesh) for mesh in scene.meshes), default=0.0)


def measure_spacing(mesh: Mesh) -> float:
    """Return the distance between neighboring stored numbers at a mesh's largest coordinate, in its own frame.

    Single precision where every stored value is exactly single, else double; the unit of the last
    decimal digit where that is coarser (see `Mesh.rounding`).
    """
    if not len(mesh.used_points):
        return 0.0
    largest = float(np.abs(mesh.box).max())
    binary = float(np.spacing(np.float32(largest))) if mesh.single else float(np.spacing(largest))
    return max(binary, 2.0 * mesh.rounding)


def measure_rounding_spacing(mesh: Mesh) -> float:
    """Return the coarsest spacing that the numbers of a mesh ever had, in its own frame.

    Decimals that equal single-precision numbers and have more digits than those were once stored in
    single precision. Its spacing is then the precision of the mesh; `spacing` returns less.
    """
    used, stored, largest = mesh.used_points, measure_spacing(mesh), float(np.abs(mesh.box).max())
    # The box of a mesh without points is infinite.
    if mesh.single or largest > float(np.finfo(np.float32).max):
        return stored
    digits = np.maximum(mesh.rounding, READ_BACK * np.abs(used))
    single = float(np.spacing(np.float32(largest)))
    were_single = np.all(np.abs(used.astype(np.float32).astype(np.float64) - used) <= digits * (1.0 + 1e-6))
    return single if were_single and 20.0 * mesh.rounding <= single else stored


def measure_scale(mesh: Mesh) -> float:
    """Return the greatest factor by which any instance of a mesh stretches a length."""
    linear = mesh.transforms[:, :3, :3]
    if not len(linear):
        return 1.0
    if all(np.array_equal(one, np.eye(3)) for one in linear):
        return 1.0
    return max(_stretch(one) for one in linear)


def measure_diagonal(scene: Scene) -> float:
    """Return the diagonal of the box of all points that a face uses, in world space, over all instances.

    Raises
    ------
    InputError
        Where the diagonal is not a finite number.
    """
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for mesh in scene.meshes:
        if not len(mesh.used_points):
            continue
        for transform in mesh.transforms:
            still = np.array_equal(transform, np.eye(4))
            world = mesh.box if still else transform_points(mesh.used_points, transform)
            low, high = np.minimum(low, world.min(axis=0)), np.maximum(high, world.max(axis=0))
    if not np.all(low <= high):
        return 0.0
    length = math.dist(low, high)
    if not math.isfinite(length):
        raise InputError("the model is too large: the diagonal of its box is not a finite number")
    return length


def transform_points(points: Points, transform: Points) -> Points:
    """Move points, (n, 3), by a 4 x 4 transform, summed in a fixed order: the same bits on every machine."""
    x, y, z = points.T
    return np.stack([row[0] * x + row[1] * y + row[2] * z + row[3] for row in transform[:3]], axis=1)


def _stretch(linear: Points) -> float:
    """Return the greatest singular value of a 3 x 3 matrix, by Jacobi rotations of its Gram matrix."""
    size = float(np.abs(linear).max())
    if size == 0.0:
        return 0.0
    # Brought near one by a power of two, so that no square leaves the range of double precision.
    unit = math.ldexp(1.0, math.frexp(size)[1])
    m = (linear / unit).tolist()
    a = [[sum(m[k][i] * m[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
    for _ in range(12):
        for p, q in ((0, 1), (0, 2), (1, 2)):
            if a[p][q] == 0.0:
                continue
            theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q])
            t = math.copysign(1.0, theta) / (abs(theta) + math.hypot(theta, 1.0))
            c = 1.0 / math.hypot(t, 1.0)
            _rotate(a, p, q, c, t * c)
    return unit * math.sqrt(max(a[0][0], a[1][1], a[2][2], 0.0))


def _rotate(a: list[list[float]], p: int, q: int, c: float, s: float) -> None:
    """One Jacobi rotation of a symmetric matrix, in place."""
    for k in range(3):
        a[k][p], a[k][q] = c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]
    for k in range(3):
        a[p][k], a[q][k] = c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]
    a[p][q] = a[q][p] = 0.0


def measure_frame(box: Points) -> tuple[tuple[float, float, float], float, float]:
    """Return the middle and the diagonal of a box, and the most by which rounding changes a distance there."""
    if not np.isfinite(box).all():
        return (0.0, 0.0, 0.0), 0.0, 0.0
    low, high = box
    x, y, z = (float(v) for v in low + (high - low) / 2)
    return (x, y, z), math.dist(low, high), 2 * float(np.spacing(np.abs(box).max()))


def find_number_format(used: Points) -> tuple[bool, float]:
    """Find how finely the used points are stored: see `Mesh.single` and `Mesh.rounding`.

    The values alone decide, so that the same numbers give the same answer in text and binary.
    """
    values = used.ravel()
    with np.errstate(over="ignore", under="ignore"):
        nearest = values.astype(np.float32).astype(np.float64)
    if np.array_equal(nearest, values):
        return True, 0.0
    decimals = _decimals(values)
    if decimals is None:
        return False, 0.0
    largest = float(np.abs(values).max())
    unit = 10.0**-decimals
    coarse = unit > np.spacing(largest) and largest / unit >= 10.0 ** (SIGNIFICANT_DIGITS - 1)
    return False, unit / 2.0 if coarse else 0.0


def _decimals(values: NDArray[np.float64]) -> int | None:
    """Count the fewest decimal digits that give back every value; None where fifteen do not."""
    sample = values[:: max(1, len(values) // 1000)]
    for decimals in range(16):
        if np.array_equal(np.round(sample, decimals), sample) and np.array_equal(np.round(values, decimals), values):
            return decimals
    return None
