"""An independent judge of textures: how far they have moved on their walls; plain numpy, nothing of bldsimp's kernels.

A point of one surface is held against the faces of the other that lie within reach and carry the same names (part and
feature ids). What is interpolated there may differ by so many texels, or levels, and by no more. Where no such face is,
a facet has crossed a change. Both ways, so that nothing is lost either.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bldsimp.model import Mesh, SimplifiedMesh

Array = NDArray[np.float64]
INTERPOLATED = ("uv", "color")
BLOCK = 200
"""Samples that are held against faces at once."""


@dataclass(frozen=True)
class Dressed:
    """Faces and what they carry.

    Attributes
    ----------
    corners : (m, 3, 3) float64
    values : (m, 3, k) float64
        All that is interpolated, in texels and levels.
    names : (m, j) float64
        Part and feature ids.
    torn : int
        Faces whose feature ids differ from corner to corner.
    """

    corners: Array
    values: Array
    names: Array
    torn: int


def dress(mesh: Mesh, light: SimplifiedMesh | None = None, kinds: tuple[str, ...] = INTERPOLATED) -> Dressed:
    """A mesh, or what was made of it; of what is interpolated only some kinds."""
    shown = mesh if light is None else light
    points, faces, part = shown.points, shown.faces, shown.part_of_face
    values, names = [np.empty((len(faces), 3, 0))], [part[:, None, None].repeat(3, axis=1).astype(float)]
    for attribute in mesh.attributes:
        own = (attribute.values if light is None else light.values(attribute))[faces]
        if attribute.kind in kinds:
            values.append(own * attribute.steps[part][:, None])
        elif attribute.kind not in INTERPOLATED:
            names.append(own)
    named = np.concatenate(names, axis=2)
    torn = int((named != named[:, :1]).any(axis=(1, 2)).sum())
    return Dressed(points[faces], np.concatenate(values, axis=2), named[:, 0], torn)


def sample_faces(surface: Dressed, rng: np.random.Generator, count: int) -> tuple[Array, Array, Array]:
    """Points on faces, corners and middles of sides among them: where, what is there, and its names."""
    fixed = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0.5, 0], [0, 0.5, 0.5], [0.5, 0, 0.5]])
    weight = np.concatenate([np.tile(fixed, (len(surface.corners), 1, 1)),
                             rng.dirichlet(np.ones(3), (len(surface.corners), count))], axis=1)  # fmt: skip
    places, values = (np.einsum("msc,mck->msk", weight, each) for each in (surface.corners, surface.values))
    names = np.repeat(surface.names, weight.shape[1], axis=0)
    return places.reshape(-1, 3), values.reshape(len(names), -1), names


def measure_displacement(of: Dressed, on: Dressed, reach: float, rng: np.random.Generator, count: int = 6) -> Array:
    """For each sample of one surface, how far it is off the other where that is nearest in what it shows.

    Infinite where nothing of the same names lies within reach.
    """
    places, values, names = sample_faces(of, rng, count)
    low, high = on.corners.min(axis=1) - reach, on.corners.max(axis=1) + reach
    found = np.full(len(places), np.inf)
    order = np.argsort(places[:, np.argmax(np.ptp(places, axis=0))], kind="stable")
    for block in np.split(order, np.arange(BLOCK, len(order), BLOCK)):
        own = places[block]
        # Few faces reach into a block's slab.
        some = np.flatnonzero(((low <= own.max(axis=0)) & (high >= own.min(axis=0))).all(axis=1))
        near = np.all((own[:, None] >= low[some]) & (own[:, None] <= high[some]), axis=2)
        near &= np.all(names[block, None] == on.names[some], axis=2)
        sample, face = np.nonzero(near)
        off, apart = compare_with_face(own[sample], values[block[sample]], on, some[face])
        within = apart <= reach
        np.minimum.at(found, block[sample[within]], off[within])
    return found


def compare_with_face(places: Array, values: Array, on: Dressed, face: NDArray[np.int64]) -> tuple[Array, Array]:
    """How far the values of sample i are off what face i shows there, and how far the sample is from the face."""
    corners = on.corners[face]
    weight = find_nearest_weights(places, corners)
    apart = np.linalg.norm(np.einsum("ic,ick->ik", weight, corners) - places, axis=1)
    # A wall may end a little later than it did: its map goes on.
    beyond = find_inner_weights(places, corners)
    weight = np.where(np.isnan(beyond), weight, beyond)
    shown = np.einsum("ic,ick->ik", weight, on.values[face])
    return np.abs(shown - values).max(axis=1, initial=0.0), apart


def find_nearest_weights(points: Array, corners: Array) -> Array:
    """Weights of the corners of face i at its point nearest to point i, (n, 3)."""
    best, weight = np.full(len(points), np.inf), np.zeros((len(points), 3))
    for k in range(3):
        a, b = corners[:, k], corners[:, (k + 1) % 3]
        along = b - a
        square = np.einsum("ij,ij->i", along, along)
        share = np.einsum("ij,ij->i", points - a, along) / np.where(square > 0, square, 1.0)
        share = np.clip(share, 0.0, 1.0)
        apart = np.linalg.norm(a + share[:, None] * along - points, axis=1)
        nearer = np.flatnonzero(apart < best)
        best[nearer], weight[nearer] = apart[nearer], 0.0
        weight[nearer, k], weight[nearer, (k + 1) % 3] = 1.0 - share[nearer], share[nearer]
    inner = find_inner_weights(points, corners)
    inside = (inner >= 0).all(axis=1)  # not where there is no number
    weight[inside] = inner[inside]
    return weight


def find_inner_weights(points: Array, corners: Array) -> Array:
    """Weights at the foot of point i in the plane of face i, not within the face only; NaN where it has no plane."""
    a, b, c = (corners[:, k] for k in range(3))
    normal = np.cross(b - a, c - a)
    square = np.einsum("ij,ij->i", normal, normal)
    flat = square > 0
    square[~flat] = 1.0
    second = np.einsum("ij,ij->i", np.cross(points - a, c - a), normal) / square
    third = np.einsum("ij,ij->i", np.cross(b - a, points - a), normal) / square
    found = np.stack([1.0 - second - third, second, third], axis=1)
    found[~flat] = np.nan
    return found
