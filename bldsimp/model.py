"""Define scenes, meshes and attributes: readers build them, stages simplify them, writers store them."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from .errors import InputError
from .material import Material
from .options import COLOR_LEVELS, CUSTOM_LEVELS

Points = NDArray[np.float64]
Faces = NDArray[np.int32]
Indices = NDArray[np.int32]
Flags = NDArray[np.uint8]
Values = NDArray[np.float64]

FACE = "FACE_"
"""Names of face attributes begin with this."""

MOST_NAMED = 10
"""So many names a message gives at most."""

LARGEST_COORDINATE = 1e100
"""Beyond this, products of coordinates leave the range of double precision."""


@dataclass
class Part:
    """A glTF primitive, or an OBJ object, group or material; no facet leaves its part.

    Attributes
    ----------
    name : str
        As the user knows it, for messages.
    attributes : tuple of str
        Names of the attributes of the part other than position and normal (``TEXCOORD_0``, ``COLOR_0`` ...).
    fixed : tuple of str
        Names of its data that cannot be updated (a skin, morph targets, an unknown extension): a part with any
        stays unchanged.
    one_sided : bool
        Its faces are seen from the front only.
    material : Material or None
    """

    name: str
    attributes: tuple[str, ...] = ()
    fixed: tuple[str, ...] = ()
    one_sided: bool = False
    material: Material | None = None


@dataclass
class Attribute:
    """An attribute of a mesh: one value for each row of its points, or for each face.

    Attributes
    ----------
    name : str
        As glTF calls it: ``TEXCOORD_0``, ``COLOR_0``, ``_FEATURE_ID_0`` ...
    kind : str
        ``uv``, ``color`` (whatever is interpolated over a face), ``feature`` (numbers that name something, the same all
        over a face) or ``tangent`` (follows from UV and normals).
    values : (n, k) or (m, k) float64
        NaN where a row or face has none. UV have v upwards, colors are in 0..1.
    steps : (p, k) float64
        For each part, how many steps that can be told apart a unit is worth: texels of the largest image that reads
        these UV, levels of a color.
    on_faces : bool
        One value for each face instead of each row.
    """

    name: str
    kind: str
    values: NDArray[np.float64]
    steps: NDArray[np.float64]
    on_faces: bool = False


@dataclass
class Mesh:
    """One problem: parts that share points and are simplified together.

    Attributes
    ----------
    name : str
    points : (n, 3) float64
        Stored positions, one row per vertex of the file (repeated where the file repeats them), in
        the mesh's own frame, model units.
    faces : (m, 3) int32
        Rows of `points`; polygons are already triangulated.
    part_of_face : (m,) int32
        Index into `parts`.
    parts : list of Part
    transforms : (k, 4, 4) float64
        World transform of each instance: one identity where the format has no scene graph; none where the scene
        does not show the mesh, which is then simplified in its own frame.
    normals : (n, 3) float64 or None
        Stored vertex normals, one row per vertex.
    attributes : list of Attribute
    single : bool
        Every stored coordinate is exactly a single-precision number.
    rounding : float
        Half a unit of the last written decimal digit where the file's numbers are decimal with six
        significant digits or more, else 0; model units.
    quantized : bool
        Points are stored as integers: none can move.
    number : int
        Place of the mesh among those of its file.
    """

    name: str
    points: Points
    faces: Faces
    part_of_face: NDArray[np.int32]
    parts: list[Part]
    transforms: NDArray[np.float64] = field(default_factory=lambda: np.eye(4)[None])
    normals: NDArray[np.float64] | None = None
    attributes: list[Attribute] = field(default_factory=list)
    single: bool = False
    rounding: float = 0.0
    quantized: bool = False
    number: int = 0

    @cached_property
    def passed_on(self) -> NDArray[np.bool_]:
        """Whether each part stays unchanged, (p,) bool."""
        return np.array([bool(part.fixed) for part in self.parts], bool)

    @cached_property
    def used_points(self) -> Points:
        """Rows of `points` that a face uses."""
        used = _core.mark_used(self.faces, len(self.points)).view(bool)
        return self.points if used.all() else self.points[used]

    @cached_property
    def box(self) -> Points:
        """Least and greatest coordinates of the used points, (2, 3); infinite where there are none."""
        return measure_box(self.used_points)


@dataclass
class Scene:
    """All meshes of one file.

    Attributes
    ----------
    path : Path or None
        None for standard input.
    format : str
        Suffix without the dot, in lower case.
    meshes : list of Mesh
    size : int
        Bytes of the file and of its separate buffers.
    warnings : list of str
    beside : list of str
        Names, beneath the file's folder, of the buffers, material libraries and images that the file names and that
        exist: the result depends on them.
    """

    path: Path | None
    format: str
    meshes: list[Mesh]
    size: int
    warnings: list[str] = field(default_factory=list)
    beside: list[str] = field(default_factory=list)

    @property
    def parts(self) -> list[Part]:
        """Parts of all meshes."""
        return [part for mesh in self.meshes for part in mesh.parts]


@dataclass
class SimplifiedMesh:
    """A simplified mesh, stored in rows of its input mesh.

    Attributes
    ----------
    points : (n, 3) float64
        ``Mesh.points``, where a wide tolerance moved none; all rows at one position moved together. Rows that needed
        a copy (two textures on a point that moved, two normals) have theirs at the end.
    faces : (k, 3) int32
        Per corner a row of `points`; where a position is stored in several rows, one that a
        face of the same facet uses, so that its normal, UV and colors are the right ones.
    part_of_face : (k,) int32
        Index into ``Mesh.parts``.
    row : (n,) int32
        The row of the mesh that each row was.
    face : (k,) int32
        A face of the mesh in the same facet, whose face attributes are those of the triangle.
    changed : dict of str to (n, k) float64
        Values, by name, of the attributes that differ from the mesh's at some row.
    """

    points: Points
    faces: Faces
    part_of_face: NDArray[np.int32]
    row: NDArray[np.int32]
    face: NDArray[np.int32]
    changed: dict[str, NDArray[np.float64]] = field(default_factory=dict)

    def add_rows(self, added: NDArray[np.integer[Any]]) -> None:
        """Add copies of some rows at the end."""
        self.points = np.concatenate([self.points, self.points[added]])
        self.row = np.concatenate([self.row, self.row[added]])
        self.changed = {name: np.concatenate([old, old[added]]) for name, old in self.changed.items()}

    def values(self, attribute: Attribute) -> NDArray[np.float64]:
        """Return the values of an attribute of the mesh, one for each row, or for each face."""
        if attribute.on_faces:
            return attribute.values[self.face]
        changed = self.changed.get(attribute.name)
        return attribute.values[self.row] if changed is None else changed


def measure_box(points: Points) -> Points:
    """Return the least and greatest coordinates of points, (2, 3); infinite where there are none."""
    columns = points.T
    low = [column.min(initial=np.inf) for column in columns]
    return np.array([low, [column.max(initial=-np.inf) for column in columns]])


def cast_indices(values: ArrayLike) -> Indices:
    """Cast whole numbers to the contiguous int32 array that kernels take."""
    return np.ascontiguousarray(values, np.int32)


def check_indices(corners: NDArray[Any], count: int) -> None:
    """Refuse corners that name no point.

    Raises
    ------
    InputError
        Names the first wrong index.
    """
    wrong = np.flatnonzero((corners < 0) | (corners >= count))
    if len(wrong):
        raise InputError(
            f"{len(wrong):,} corners name points that do not exist (there are {count:,}),"
            f" the first is index {int(corners[wrong[0]])}, counted from 0: the file is damaged"
        )


def check_finite(points: Points, corners: NDArray[Any]) -> None:
    """Refuse points that a face uses and that are not finite numbers, or beyond `LARGEST_COORDINATE`.

    Raises
    ------
    InputError
        Names the first rows.
    """
    # A comparison with NaN is false.
    good = np.abs(points) <= LARGEST_COORDINATE
    if good.all():
        return
    bad = ~good.all(axis=1)
    used = np.zeros(len(points), bool)
    used[corners] = True
    named = np.flatnonzero(bad & used)
    if len(named):
        some = ", ".join(str(i) for i in named[:MOST_NAMED])
        raise InputError(
            f"{len(named):,} points that a face uses are not finite numbers (or beyond 1e100),"
            f" counted from 0: {some}{' ...' if len(named) > MOST_NAMED else ''}: repair or remove them"
        )


def make_attribute(
    name: str, values: Values, mesh: Mesh, *, on_faces: bool = False, whole: bool = False, label: bool = False
) -> Attribute:
    """Make an attribute of rows or faces: of colors, of other numbers, or of numbers that name something.

    Parameters
    ----------
    name : str
        Without `FACE`.
    values : (n, k) or (m, k) float64
        NaN where a row or face has none.
    mesh : Mesh
    on_faces : bool
    whole : bool
        They are stored as whole numbers: those that are equal all over each face name something.
    label : bool
        They name something, whatever they are, and have nothing between two values.
    """
    kind, step = "color", float(COLOR_LEVELS)
    if label or (whole and (on_faces or _are_same_over_faces(values[mesh.faces]))):
        kind, step = "feature", 1.0
    elif not name.startswith("COLOR_"):
        step = CUSTOM_LEVELS / (float(np.abs(values[np.isfinite(values)]).max(initial=0.0)) or 1.0)
    steps = np.full((len(mesh.parts), values.shape[1]), step)
    return Attribute(FACE + name if on_faces else name, kind, values, steps, on_faces)


def _are_same_over_faces(corners: NDArray[np.float64]) -> bool:
    return bool(np.all((corners == corners[:, :1]) | np.isnan(corners)))


def attach_attributes(mesh: Mesh, attributes: list[Attribute]) -> None:
    """Add attributes to a mesh, except those without any value, and name them in each part that has them."""
    for one in attributes:
        blank = np.asarray(np.isnan(one.values).all(axis=1))
        of_face = ~(blank if one.on_faces else blank[mesh.faces].all(axis=1))
        if of_face.any():
            mesh.attributes.append(one)
            for part in np.unique(mesh.part_of_face[of_face]):
                mesh.parts[part].attributes += (one.name,)
