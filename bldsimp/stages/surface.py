"""Define the surface that each stage takes and returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import Faces, Flags, Indices, Points, cast_indices

FREE, STAYS, GOES = 0, 1, 2
"""The caller's decision on a point: none, keep it in place, or drop it."""


@dataclass(frozen=True)
class Surface:
    """A welded surface on its way through the stages, and where each part of it came from.

    Attributes
    ----------
    points : (n, 3) float64
        Distinct, in lexicographic order; model units of the mesh's own frame.
    faces : (m, 3) int32
        Each with its least point first, in lexicographic order.
    label : (m,) int32
        Faces of different labels never share a facet; -1 for faces that stay as they are.
    source : (m,) int32
        A face of the mesh with the same label, whose face attributes this one has.
    facet : (m,) int32 or None
        The facet of the welded mesh whose rows each face reads; None before those are found.
    origin : (n,) int32
        The point of the welded mesh that each point was.
    decided : (n,) uint8
        `FREE`, `STAYS` or `GOES`.
    """

    points: Points
    faces: Faces
    label: Indices
    source: Indices
    facet: Indices | None
    origin: Indices
    decided: Flags

    def with_faces(
        self, faces: Faces, parent: Indices, facet: Indices | None = None, points: Points | None = None
    ) -> Surface:
        """Return a surface of other faces, over the points that they use.

        Parameters
        ----------
        faces : (k, 3) int32
        parent : (k,) int32
            A face of this surface that each of them has label and attributes of.
        facet : (k,) int32, optional
            Of each of them; that of its parent where left out.
        points : (n, 3) float64, optional
            Where the points have moved to.
        """
        placed = self.points if points is None else points
        used = np.unique(faces)
        if points is not None:
            used = used[np.lexsort(placed[used].T[::-1])]
        number = np.empty(len(placed), np.int32)
        number[used] = np.arange(len(used), dtype=np.int32)
        faces, order = sort_faces(number[faces])
        own = facet if facet is not None else self.facet[parent] if self.facet is not None else None
        parent = parent[order]
        return Surface(
            np.ascontiguousarray(placed[used]),
            faces,
            self.label[parent],
            self.source[parent],
            None if own is None else own[order],
            self.origin[used],
            self.decided[used],
        )

    def without_copies(self, layer_of_face: Indices | None) -> Surface:
        """Return the surface with one face of those that copy one another within a layer of the mesh."""
        same = (self.faces[1:] == self.faces[:-1]).all(axis=1)
        if not same.any():
            return self
        layer = np.zeros(len(self.faces), np.int32) if layer_of_face is None else layer_of_face[self.source]
        first = np.sort(np.unique(np.column_stack([self.faces, layer]), axis=0, return_index=True)[1])
        return self.with_faces(self.faces[first], cast_indices(first))


def turn_faces(faces: Faces) -> tuple[Faces, NDArray[np.int64]]:
    """Turn each face so that its least point is first; return also which corner that was, (m, 1)."""
    turn = np.argmin(faces, axis=1)[:, None] if len(faces) else np.zeros((0, 1), np.int64)
    return np.take_along_axis(faces, (turn + np.arange(3)) % 3, axis=1), turn


def sort_faces(faces: Faces) -> tuple[Faces, Indices]:
    """Turn each face so that its least point is first, and sort them.

    Returns
    -------
    faces : (m, 3) int32
    order : (m,) int32
        Which face each of them was.
    """
    turned, _ = turn_faces(faces)
    order = np.lexsort((turned[:, 1], turned[:, 1:].max(axis=1), turned[:, 1:].min(axis=1), turned[:, 0]))
    return cast_indices(turned[order]), cast_indices(order)
