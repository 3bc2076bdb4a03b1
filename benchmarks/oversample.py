"""The same shape with many more points, as careless exports have it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from surface import Surface, read_surface

import bldsimp

TURN_DEGREES = 21.0
TURN_AXIS = (0.2, 0.3, 1.0)
SHRINK = 0.95


def simplify_model(path: Path) -> Surface:
    """Simplify a model, so that over-sampling decides its number of points."""
    points, faces = bldsimp.simplify(tuple(read_surface(path))).mesh
    return Surface(points, faces.astype(np.int64))


def oversample(surface: Surface, triangles: int) -> Surface:
    """Split long edges until there are enough triangles, turn the model about a skew axis, round to single.

    An edge is split for both of its faces or for none, so closed stays closed. After the turn no wall is
    parallel to an axis, and after rounding none is exactly flat any more.
    """
    longest = float(_measure_lengths(*surface).max())
    while len(surface.faces) < triangles:
        longest *= SHRINK
        while (finer := _split_longer(surface, longest)) is not surface:
            surface = finer
    return Surface(_turn(surface.points).astype(np.float32).astype(np.float64), surface.faces)


def add_noise(surface: Surface, deviate: float) -> Surface:
    """Move every point by a normal deviate of so many model units along each axis, and round to single precision."""
    moved = surface.points + np.random.default_rng(0).normal(0.0, deviate, surface.points.shape)
    return Surface(moved.astype(np.float32).astype(np.float64), surface.faces)


def _measure_lengths(points: NDArray[np.float64], faces: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the length of the edge from each corner of a face to the next."""
    lengths: NDArray[np.float64] = np.linalg.norm(points[np.roll(faces, -1, axis=1)] - points[faces], axis=2)
    return lengths


def _split_longer(surface: Surface, longest: float) -> Surface:
    """Split every edge longer than this in its middle, once; the same object where there is none."""
    points, faces = surface
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2), axis=2)
    key = ends[..., 0] * len(points) + ends[..., 1]
    # Both faces see the same two ends in the same order, so they agree on the length to the last bit.
    long = np.linalg.norm(points[ends[..., 1]] - points[ends[..., 0]], axis=2) > longest
    if not long.any():
        return surface
    split, which = np.unique(key[long], return_inverse=True)
    middle = np.full(faces.shape, -1, np.int64)
    middle[long] = len(points) + which
    added = (points[split // len(points)] + points[split % len(points)]) / 2
    return Surface(np.concatenate([points, added]), _cut(faces, middle))


def _cut(faces: NDArray[np.int64], middle: NDArray[np.int64]) -> NDArray[np.int64]:
    """Cut faces at the middles of their edges (-1 where an edge stays)."""
    count = (middle >= 0).sum(axis=1)
    # Turn each face so that its only split edge, or the only one that is not split, comes first.
    first = np.where(count == 2, np.argmax(middle < 0, axis=1), np.argmax(middle >= 0, axis=1))
    order = (first[:, None] + np.arange(3)) % 3
    (a, b, c), (ab, bc, ca) = (np.take_along_axis(each, order, axis=1).T for each in (faces, middle))
    whole, one, two, three = (count == n for n in range(4))
    pieces = [
        (whole, a, b, c),
        (one, a, ab, c), (one, ab, b, c),
        (two, a, b, bc), (two, a, bc, ca), (two, ca, bc, c),
        (three, a, ab, ca), (three, ab, b, bc), (three, ca, bc, c), (three, ab, bc, ca),
    ]  # fmt: skip
    return np.concatenate([np.stack([u[m], v[m], w[m]], axis=1) for m, u, v, w in pieces])


def _turn(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Turn points about the skew axis (Rodrigues' formula)."""
    axis = np.array(TURN_AXIS) / np.linalg.norm(TURN_AXIS)
    angle = np.radians(TURN_DEGREES)
    along = np.outer((points * axis).sum(axis=1), axis)
    across = points - along
    turned: NDArray[np.float64] = along + np.cos(angle) * across + np.sin(angle) * np.cross(axis, across)
    return turned
