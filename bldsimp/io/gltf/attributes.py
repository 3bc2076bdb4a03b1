"""What the vertices of a glTF mesh carry beside position and normal, and what of it no simplified mesh can follow."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...model import Attribute, Mesh, color_attribute, custom_attribute, label_attribute
from ...options import UNKNOWN_TEXELS
from .document import Document
from .references import FEATURES, METADATA, VARIANTS
from .textures import Texels
from .vertices import Rows

HARMLESS = {VARIANTS, FEATURES, METADATA}
"""Extensions of a primitive that speak of its vertices, if at all, through attributes and textures."""

_VECTORS = ("SCALAR", "VEC2", "VEC3", "VEC4")
_OWN_FIELDS = ("POSITION", "NORMAL")
_SKIN = ("JOINTS_", "WEIGHTS_")
_UV = "TEXCOORD_"


def carried_names(primitive: dict[str, Any]) -> tuple[str, ...]:
    """Names of what a primitive carries beside position and normal."""
    names = [name for name in primitive["attributes"] if name not in _OWN_FIELDS]
    return *names, *(name for name in primitive.get("extensions", {}) if name in (FEATURES, METADATA))


def fixed_names(document: Document, primitive: dict[str, Any], count: int) -> tuple[str, ...]:
    """What of a primitive with `count` vertices cannot follow a change of its faces."""
    found = []
    for name, number in primitive["attributes"].items():
        accessor = document.items("accessors")[number]
        if name.startswith(_SKIN):
            found.append("skin")
        elif accessor["type"] not in (("VEC2",) if name.startswith(_UV) else _VECTORS):
            found.append(f"{name} of type {accessor['type']}")
        elif accessor["count"] != count:
            found.append(f"{name} of another length than its positions")
    if primitive.get("targets"):
        found.append("morph targets")
    extensions = primitive.get("extensions", {})
    ids = extensions.get(FEATURES, {}).get("featureIds", [])
    if any("attribute" not in one and "texture" not in one for one in ids):
        found.append("implicit feature ids")
    found += [name for name in extensions if name not in HARMLESS]
    return tuple(dict.fromkeys(found))


def attributes(document: Document, rows: list[Rows], mesh: Mesh, texels: list[dict[int, Texels]]) -> list[Attribute]:
    """All that the rows of a mesh carry, but for what belongs to a skin.

    Parameters
    ----------
    document : Document
    rows : list of Rows
    mesh : Mesh
    texels : list of dict
        For each part what `Textures.texels` tells.
    """
    names = dict.fromkeys(name for group in rows for name, _ in group.accessors)
    found = []
    for name in names:
        users = [(group, group.accessor(name)) for group in rows]
        own = [(group, number) for group, number in users if number is not None and _followed(document, name, number)]
        if own:
            values = _values(document, name, own, len(mesh.points))
            whole = all(document.step(number) == 1.0 for _, number in own)
            found.append(_attribute(name, values, mesh, texels, whole))
    return found


def _followed(document: Document, name: str, number: int) -> bool:
    return (
        name not in _OWN_FIELDS
        and not name.startswith(_SKIN)
        and document.items("accessors")[number].get("type") in _VECTORS[name.startswith(_UV) :]
    )


def _values(document: Document, name: str, own: list[tuple[Rows, int]], count: int) -> NDArray[np.float64]:
    """Values of all rows, UV as u and v upwards, and colours with alpha where some have it."""
    most = 2 if name.startswith(_UV) else None
    blocks = [(group, document.numbers(number)[:, :most]) for group, number in own]
    values = np.full((count, max(block.shape[1] for _, block in blocks)), np.nan)
    for group, block in blocks:
        taken = block[: group.count]
        values[group.start : group.start + len(taken), : taken.shape[1]] = taken
        if name.startswith("COLOR_") and taken.shape[1] == 3 < values.shape[1]:
            values[group.start : group.start + len(taken), 3] = 1.0
    if name.startswith(_UV):
        values[:, 1] = 1.0 - values[:, 1]
    return values


def _attribute(
    name: str, values: NDArray[np.float64], mesh: Mesh, texels: list[dict[int, Texels]], whole: bool
) -> Attribute:
    """An attribute of the kind that its name tells; one of our users' own may name something, as feature ids do."""
    if name.startswith(_UV):
        unknown = float(UNKNOWN_TEXELS), float(UNKNOWN_TEXELS)
        number = int(name.removeprefix(_UV))
        return Attribute(name, "uv", values, np.array([part.get(number, unknown) for part in texels]))
    if name == "TANGENT":
        return Attribute(name, "tangent", values, np.ones((len(texels), values.shape[1])))
    if name.startswith(("_FEATURE_ID_", "_BATCHID")):
        return label_attribute(name, values, mesh)
    if name.startswith("COLOR_"):
        return color_attribute(values, mesh, name=name)
    return custom_attribute(name, values, mesh, whole=whole and name.startswith("_"), on_faces=False)
