"""What rows and faces carry beside the surface, as attributes of a mesh."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .options import COLOR_LEVELS, CUSTOM_LEVELS
from .scene import Attribute, Mesh

FACE = "FACE_"
"""Names of what faces carry begin with this."""


def color_attribute(
    values: NDArray[np.float64], mesh: Mesh, *, name: str = "COLOR_0", on_faces: bool = False
) -> Attribute:
    """Colours of rows or faces, (n, 3 or 4) in 0..1, NaN where one has none."""
    return _attribute(name, "color", values, mesh, COLOR_LEVELS, on_faces)


def custom_attribute(name: str, values: NDArray[np.float64], mesh: Mesh, *, whole: bool, on_faces: bool) -> Attribute:
    """What else rows or faces carry: whole numbers that are the same all over each face name something.

    Parameters
    ----------
    name : str
        Without `FACE`.
    values : (n, k) or (m, k) float64
        NaN where a row or face has none.
    mesh : Mesh
    whole : bool
        They are stored as whole numbers.
    on_faces : bool
    """
    if whole and (on_faces or _are_same_over_faces(values[mesh.faces])):
        return label_attribute(name, values, mesh, on_faces=on_faces)
    greatest = float(np.abs(values[np.isfinite(values)]).max(initial=0.0)) or 1.0
    return _attribute(name, "color", values, mesh, CUSTOM_LEVELS / greatest, on_faces)


def label_attribute(name: str, values: NDArray[np.float64], mesh: Mesh, *, on_faces: bool = False) -> Attribute:
    """What names something, and has nothing between two values."""
    return _attribute(name, "feature", values, mesh, 1.0, on_faces)


def _attribute(name: str, kind: str, values: NDArray[np.float64], mesh: Mesh, step: float, on_faces: bool) -> Attribute:
    steps = np.full((len(mesh.parts), values.shape[1]), step)
    return Attribute((FACE if on_faces else "") + name, kind, values, steps, on_faces)


def _are_same_over_faces(corners: NDArray[np.float64]) -> bool:
    return bool(np.all((corners == corners[:, :1]) | np.isnan(corners)))


def carry(mesh: Mesh, attributes: list[Attribute]) -> None:
    """Give a mesh what its rows and faces carry, as far as any has it, and name it for each part."""
    for one in attributes:
        blank = np.asarray(np.isnan(one.values).all(axis=1))
        of_face = ~(blank if one.on_faces else blank[mesh.faces].all(axis=1))
        if of_face.any():
            mesh.attributes.append(one)
            for part in np.unique(mesh.part_of_face[of_face]):
                mesh.parts[part].attributes += (one.name,)
