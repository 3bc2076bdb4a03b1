"""Read the attributes of a glTF mesh, and return values of a result in the types that the file stores them in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...model import Attribute, Indices, Mesh, Values, make_attribute
from ...options import UNKNOWN_TEXELS
from .document import Document, Json
from .materials import Texels
from .references import FEATURES, METADATA, VARIANTS

HARMLESS = {VARIANTS, FEATURES, METADATA}
"""Extensions of a primitive that name its vertices, if at all, through attributes and textures."""

TRIANGLES, STRIP, FAN = 4, 5, 6

_VECTORS = ("SCALAR", "VEC2", "VEC3", "VEC4")
_OWN_FIELDS = ("POSITION", "NORMAL")
_SKIN = ("JOINTS_", "WEIGHTS_")
_UV = "TEXCOORD_"


@dataclass(frozen=True, eq=False)
class SharedVertices:
    """Rows of a mesh that are the vertices of one or more primitives.

    Attributes
    ----------
    accessors : dict of str to int
        By name of each of their attributes, the accessor that holds it.
    start, count : int
    """

    accessors: dict[str, int]
    start: int
    count: int


def list_primitives(document: Document, number: int) -> list[tuple[int, Json, SharedVertices]]:
    """List the triangle primitives of a mesh by number, each with its vertices."""
    shared: dict[tuple[tuple[str, int], ...], SharedVertices] = {}
    found, start = [], 0
    for index, primitive in enumerate(document.items("meshes")[number].get("primitives", [])):
        own = primitive.get("attributes", {})
        if primitive.get("mode", TRIANGLES) not in (TRIANGLES, STRIP, FAN) or "POSITION" not in own:
            continue
        # Two primitives share vertices only if all their attributes are the same.
        key = tuple(sorted(own.items()))
        if key not in shared:
            shared[key] = SharedVertices(own, start, len(document.read_accessor(own["POSITION"])))
            start += shared[key].count
        found.append((index, primitive, shared[key]))
    return found


def list_attribute_names(primitive: Json) -> tuple[str, ...]:
    """List the attributes of a primitive other than position and normal."""
    names = [name for name in primitive["attributes"] if name not in _OWN_FIELDS]
    return *names, *(name for name in primitive.get("extensions", {}) if name in (FEATURES, METADATA))


def list_fixed_names(document: Document, primitive: Json, count: int) -> tuple[str, ...]:
    """List what of a primitive with `count` vertices cannot follow a change of its faces."""
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


def read_attributes(
    document: Document, groups: list[SharedVertices], mesh: Mesh, texels: list[dict[int, Texels]]
) -> list[Attribute]:
    """Read the attributes of a mesh, except those of a skin.

    Parameters
    ----------
    document : Document
    groups : list of SharedVertices
        All rows of the mesh.
    mesh : Mesh
    texels : list of dict
        For each part the result of `TextureSizes.measure`.
    """
    found = []
    for name in dict.fromkeys(name for group in groups for name in group.accessors):
        users = [(group, group.accessors[name]) for group in groups if name in group.accessors]
        own = [(group, number) for group, number in users if _is_read(document, name, number)]
        if own:
            values = _read_values(document, name, own, len(mesh.points))
            whole = all(document.find_step(number) == 1.0 for _, number in own)
            found.append(_make_attribute(name, values, mesh, texels, whole))
    return found


def _is_read(document: Document, name: str, number: int) -> bool:
    """Tell whether an attribute follows a change of faces."""
    return (
        name not in _OWN_FIELDS
        and not name.startswith(_SKIN)
        and document.items("accessors")[number].get("type") in _VECTORS[name.startswith(_UV) :]
    )


def _read_values(document: Document, name: str, own: list[tuple[SharedVertices, int]], count: int) -> Values:
    """Read the values of all rows: UV with v upwards, and colors with alpha if some have it."""
    most = 2 if name.startswith(_UV) else None
    blocks = [(group, document.read_numbers(number)[:, :most]) for group, number in own]
    values = np.full((count, max(block.shape[1] for _, block in blocks)), np.nan)
    for group, block in blocks:
        taken = block[: group.count]
        rows = values[group.start : group.start + len(taken)]
        rows[:, : taken.shape[1]] = taken
        if name.startswith("COLOR_") and taken.shape[1] == 3:
            rows[:, 3:] = 1.0
    if name.startswith(_UV):
        values[:, 1] = 1.0 - values[:, 1]
    return values


def _make_attribute(name: str, values: Values, mesh: Mesh, texels: list[dict[int, Texels]], whole: bool) -> Attribute:
    """Make an attribute of the kind that its name tells; one of a user's own may be a label, as feature ids are."""
    if name.startswith(_UV):
        unknown = float(UNKNOWN_TEXELS), float(UNKNOWN_TEXELS)
        number = int(name.removeprefix(_UV))
        return Attribute(name, "uv", values, np.array([part.get(number, unknown) for part in texels]))
    if name == "TANGENT":
        return Attribute(name, "tangent", values, np.ones((len(texels), values.shape[1])))
    label = name.startswith(("_FEATURE_ID_", "_BATCHID"))
    return make_attribute(name, values, mesh, whole=whole and name.startswith("_"), label=label)


def store_column(
    document: Document, name: str, group: SharedVertices, row: Indices, wanted: Values, read: Values
) -> NDArray[Any]:
    """Take the stored values of one attribute, except in rows of other primitives and where they changed."""
    number = group.accessors.get(name)
    if number is None:
        return to_gltf(name, wanted).astype(np.float32)
    stored, normalized = document.read_accessor(number), document.items("accessors")[number].get("normalized")
    place = row - group.start
    inside = (place >= 0) & (place < group.count)
    values = stored[np.where(inside, place, 0)]
    same = (wanted == read) | (np.isnan(wanted) & np.isnan(read))
    fresh = np.flatnonzero(~(inside & same.all(axis=1)))
    if len(fresh):
        # Points that are welded or moved may take rows of another primitive.
        taken = to_gltf(name, wanted[fresh])[:, : values.shape[1]]
        values[fresh, : taken.shape[1]] = _to_component(taken, values.dtype, normalized)
    return values


def to_gltf(name: str, numbers: Values) -> Values:
    """Return numbers as glTF has them: v downwards, nothing missing, not even the normals of some rows."""
    if name.startswith(_UV):
        numbers = np.stack([numbers[:, 0], 1.0 - numbers[:, 1]], axis=1)
    elif name == "NORMAL":
        return np.where(numbers.any(axis=1, keepdims=True), numbers, (0.0, 0.0, 1.0))
    return np.where(np.isnan(numbers), 1.0 if name.startswith("COLOR_") else 0.0, numbers)


def _to_component(numbers: Values, kind: np.dtype[Any], normalized: Any) -> NDArray[Any]:
    """Round numbers to a component type."""
    if kind.kind == "f":
        return numbers.astype(kind)
    limits = np.iinfo(kind)
    return np.clip(np.rint(numbers * limits.max if normalized else numbers), limits.min, limits.max).astype(kind)
