"""What rows and faces carry beside the surface, as attributes of a mesh."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .scene import Attribute, Mesh

LEVELS = 255.0
"""Levels of a colour that can be told apart."""

CUSTOM_STEPS = 1e5
"""Steps that can be told apart of what else is interpolated, at its greatest magnitude."""

FACE = "FACE_"
"""Names of what faces carry begin with this."""


def color_attribute(values: NDArray[np.float64], mesh: Mesh, *, on_faces: bool = False) -> Attribute:
    """Colours of rows or faces, (n, 3 or 4) in 0..1, NaN where one has none."""
    name = FACE + "COLOR_0" if on_faces else "COLOR_0"
    return Attribute(name, "color", values, np.full((len(mesh.parts), values.shape[1]), LEVELS), on_faces)


def custom_attribute(name: str, values: NDArray[np.float64], mesh: Mesh, *, whole: bool, on_faces: bool) -> Attribute:
    """What else rows or faces carry: whole numbers that are the same all over a face name something.

    Parameters
    ----------
    name : str
        Without `FACE`.
    values : (n, k) or (m, k) float64
    mesh : Mesh
    whole : bool
        They are stored as whole numbers.
    on_faces : bool
    """
    label = whole and (on_faces or bool(np.all(values[mesh.faces] == values[mesh.faces[:, :1]])))
    greatest = float(np.abs(values[np.isfinite(values)]).max(initial=0.0)) or 1.0
    steps = np.full((len(mesh.parts), values.shape[1]), 1.0 if label else CUSTOM_STEPS / greatest)
    return Attribute((FACE if on_faces else "") + name, "feature" if label else "color", values, steps, on_faces)


def carry(mesh: Mesh, attributes: list[Attribute]) -> None:
    """Give a mesh what its rows and faces carry, as far as any has it, and name it for each part."""
    for one in attributes:
        blank = np.asarray(np.isnan(one.values).all(axis=1))
        of_face = ~(blank if one.on_faces else blank[mesh.faces].all(axis=1))
        if of_face.any():
            mesh.attributes.append(one)
            for part in np.unique(mesh.part_of_face[of_face]):
                mesh.parts[part].attributes += (one.name,)
