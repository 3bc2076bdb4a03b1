"""What the vertices of simplified glTF primitives hold: numbers as stored, changed ones rounded to the stored type."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...model import Mesh, Points, SimplifiedMesh
from ...options import Options
from .document import Document
from .vertices import Rows


@dataclass
class Column:
    """Values of one attribute.

    Attributes
    ----------
    name : str
    values : (n, k) array
        Of the component type in which the file stores them.
    normalized : bool
    """

    name: str
    values: NDArray[Any]
    normalized: bool


def columns(
    document: Document,
    mesh: Mesh,
    light: SimplifiedMesh,
    group: Rows,
    used: NDArray[np.int64],
    normals: Points | None,
    options: Options,
) -> list[Column]:
    """All attributes of primitives that share vertices.

    Parameters
    ----------
    document : Document
    mesh : Mesh
    light : SimplifiedMesh
    group : Rows
        The primitives' vertices before.
    used : (n,) int64
        Rows of the result that the primitives use.
    normals : (r, 3) float64 or None
        One for each row of the result, see `shaded`.
    options : Options
    """
    row = light.row[used]
    kinds = {attribute.name: attribute.kind for attribute in mesh.attributes}
    names = [name for name, _ in group.accessors if name not in kinds or options.keeps(kinds[name])]
    if normals is None and "TANGENT" in names and mesh.normals is not None and options.normals == "auto":
        # Tangents say nothing without normals.
        normals = mesh.normals[light.row]
    wanted = {"POSITION": (light.points[used], mesh.points[row])}
    if normals is not None and normals[used].any():
        own = normals[used]
        wanted["NORMAL"] = own, np.zeros_like(own) if mesh.normals is None else mesh.normals[row]
    for attribute in mesh.attributes:
        wanted[attribute.name] = light.values(attribute)[used], attribute.values[row]
    if "NORMAL" in wanted and "NORMAL" not in names:
        names.append("NORMAL")
    elif "NORMAL" not in wanted:
        names = [name for name in names if name not in ("NORMAL", "TANGENT")]
    return [_column(document, name, group, row, *wanted[name]) for name in names]


def _column(
    document: Document,
    name: str,
    group: Rows,
    row: NDArray[np.int32],
    wanted: NDArray[np.float64],
    read: NDArray[np.float64],
) -> Column:
    """One attribute: what the file stores for each row, but for rows of other primitives and changed values."""
    number = group.accessor(name)
    if number is None:
        return Column(name, _in_format(_as_stored(name, wanted), np.dtype("f4"), False), False)
    stored, normalized = document.accessor(number), bool(document.items("accessors")[number].get("normalized"))
    place = row - group.start
    inside = (place >= 0) & (place < group.count)
    values = stored[np.where(inside, place, 0)]
    same = (wanted == read) | (np.isnan(wanted) & np.isnan(read))
    fresh = np.flatnonzero(~(inside & same.all(axis=1)))
    if len(fresh):
        # Points that are welded, or moved, may take rows of another primitive.
        taken = _as_stored(name, wanted[fresh])[:, : values.shape[1]]
        values[fresh, : taken.shape[1]] = _in_format(taken, values.dtype, normalized)
    return Column(name, values, normalized)


def _as_stored(name: str, numbers: NDArray[np.float64]) -> NDArray[np.float64]:
    """Numbers as glTF has them: v downwards, nothing missing."""
    if name.startswith("TEXCOORD_"):
        numbers = np.stack([numbers[:, 0], 1.0 - numbers[:, 1]], axis=1)
    elif name == "NORMAL":
        return np.where(numbers.any(axis=1, keepdims=True), numbers, (0.0, 0.0, 1.0))
    return np.where(np.isnan(numbers), 1.0 if name.startswith("COLOR_") else 0.0, numbers)


def _in_format(numbers: NDArray[np.float64], kind: np.dtype[Any], normalized: bool) -> NDArray[Any]:
    """Numbers in a component type."""
    if kind.kind == "f":
        return numbers.astype(kind)
    range_ = np.iinfo(kind)
    return np.clip(np.rint(numbers * range_.max if normalized else numbers), range_.min, range_.max).astype(kind)
