"""Draw a textured model from any side: texture times color, lit from the eye, behind a perspective camera.

Module `picture` finds the face in front. One layer of faces that are not opaque is drawn over the rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from picture import Camera, Style, View, evaluate_edge, find_nearest_faces, measure_edge_distances

from textured.model import Floats, Integers, Model

AMBIENT = 0.35
"""Brightness of faces seen from the side, as a share of those seen face on."""

SIDES = tuple((45.0 * k + 20.0, (18.0, 50.0, 18.0, -25.0)[k % 4]) for k in range(8))
"""Azimuth and elevation of the eight views, degrees: all around, from above and from below."""


def make_style(side: tuple[float, float], size: int, samples: int) -> Style:
    """Make the style of a square view from a side."""
    return Style(width=size, height=size, azimuth=side[0], elevation=side[1], samples=samples)


def place_cameras(
    model: Model, size: int, sides: Sequence[tuple[float, float]] = SIDES, samples: int = 2
) -> list[tuple[Camera, Style]]:
    """Place cameras that show all of a model."""
    points = model.corners.reshape(-1, 3)
    view = View(points, np.arange(len(points)).reshape(-1, 3), "")
    return [(Camera.fit(view, each), each) for each in (make_style(side, size, samples) for side in sides)]


def draw(model: Model, camera: Camera, style: Style, *, edges: bool = False) -> Floats:
    """Draw a model, (height, width, 3) in 0..1; with the edges of its triangles, if asked."""
    columns, rows = style.width * style.samples, style.height * style.samples
    projected = camera.project(model.corners.reshape(-1, 3)).reshape(-1, 3, 3)
    two_sided = np.array([material.two_sided for material in model.materials])[model.material]
    seen = two_sided | (measure_turn(projected) > 0)
    solid = np.array([material.alpha == "OPAQUE" for material in model.materials])[model.material]
    color = np.tile(np.asarray(style.paper, float), (rows * columns, 1))
    front = np.full(rows * columns, -np.inf)
    for faces in (np.flatnonzero(seen & solid), np.flatnonzero(seen & ~solid)):
        owner = find_nearest_faces(projected[faces], columns, rows)
        pixels = np.flatnonzero(owner >= 0)
        hits = Hits.find(projected, faces[owner[pixels]], pixels % columns, pixels // columns)
        nearer = np.flatnonzero(hits.nearness >= front[pixels])
        pixels, hits = pixels[nearer], hits.select(nearer)
        shade = resolve_normals(model, hits, camera)
        if edges:
            darken(shade, projected, hits, style)
        color[pixels] += (shade[:, :3] - color[pixels]) * shade[:, 3:]
        front[pixels] = hits.nearness
    blocks = color.reshape(style.height, style.samples, style.width, style.samples, 3)
    return np.asarray(blocks.mean(axis=(1, 3))[::-1])


def measure_turn(projected: Floats) -> Floats:
    """Measure twice the signed area of faces on the screen: positive where their front is seen."""
    first, second = (projected[:, k, :2] - projected[:, 0, :2] for k in (1, 2))
    return np.asarray(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])


@dataclass(frozen=True)
class Hits:
    """Samples on faces: where each is, and how much of each corner it has."""

    face: Integers
    x: Integers
    y: Integers
    weight: Floats
    nearness: Floats

    @classmethod
    def find(cls, projected: Floats, face: Integers, x: Integers, y: Integers) -> Hits:
        """Find the perspective-correct weights of the corners of each sample's face."""
        # The weight of a corner is the edge function of the edge opposite to it.
        on_screen = np.stack([evaluate_edge(projected, face, k, x, y) for k in (1, 2, 0)], axis=1)
        on_screen /= on_screen.sum(axis=1, keepdims=True)
        weight = on_screen * projected[face, :, 2]
        nearness = weight.sum(axis=1)
        return cls(face, x, y, weight / nearness[:, None], nearness)

    def select(self, chosen: Integers) -> Hits:
        """Select some of the samples."""
        places = (self.face[chosen], self.x[chosen], self.y[chosen])
        return Hits(*places, self.weight[chosen], self.nearness[chosen])

    def mix(self, corners: Floats) -> Floats:
        """Mix values of corners, (m, 3, k), at the samples, (n, k)."""
        return np.asarray(np.einsum("ij,ijk->ik", self.weight, corners[self.face]))


def resolve_normals(model: Model, hits: Hits, camera: Camera) -> Floats:
    """Return RGBA of samples."""
    color = np.clip(hits.mix(model.colors), 0.0, 1.0)
    normal = hits.mix(model.normals)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    toward = camera.target + camera.distance * camera.axes[2] - hits.mix(model.corners)
    toward /= np.linalg.norm(toward, axis=1, keepdims=True)
    lit = AMBIENT + (1 - AMBIENT) * np.abs(np.einsum("ij,ij->i", normal, toward))
    maps = {name: hits.mix(uv) for name, uv in model.uv.items()}
    owner = model.material[hits.face]
    for number, material in enumerate(model.materials):
        own = np.flatnonzero(owner == number)
        if material.picture is not None:
            color[own] *= material.picture.sample(maps["picture"][own])
        if material.occlusion is not None:
            lit[own] *= material.occlusion.sample(maps["occlusion"][own])[:, 0]
        if material.alpha == "OPAQUE":
            color[own, 3] = 1.0
        elif material.alpha == "MASK":
            color[own, 3] = color[own, 3] >= material.cutoff
    color[:, :3] *= lit[:, None]
    return color


def darken(shade: Floats, projected: Floats, hits: Hits, style: Style) -> None:
    """Draw the edges of triangles into RGBA of samples."""
    apart = np.min(measure_edge_distances(projected[:, :, :2], hits.face, hits.x, hits.y), axis=0)
    strength = 0.7 * np.clip(style.line * style.samples / 2 + 0.5 - apart, 0.0, 1.0)
    shade[:, :3] += (np.array(style.ink) - shade[:, :3]) * strength[:, None]
