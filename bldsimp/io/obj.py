"""Wavefront OBJ: objects, groups and materials are parts of one mesh; polygons stay polygons."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..model import Mesh, Part, attach_attributes, color_attribute
from ..unique_rows import find_unique_rows
from .folder import Folder
from .mtl import library_names, read_materials
from .surface import Material, Polygons, polygon_mesh, shown, uv_attribute
from .text import numbers, ragged, table

Index = NDArray[np.int64]

_STATE = (b"o", b"g", b"usemtl", b"s")
_ROUND = (b"", b"#", b"v", b"vt", b"vn", b"f", b"mtllib", *_STATE)


@dataclass(frozen=True)
class State:
    """What the lines before a face say of it, as they are written; "" where nothing is said."""

    object: str = ""
    group: str = ""
    material: str = ""
    smoothing: str = ""

    def name(self) -> str:
        """The part as the user knows it."""
        return " / ".join(shown(text) for text in (self.object, self.group, self.material) if text) or "mesh"


@dataclass
class ObjPart:
    """`Part.source` of a part read from an OBJ file."""

    state: State
    material: Material | None


@dataclass
class ObjFormat:
    """`Mesh.source` of a mesh read from an OBJ file.

    Attributes
    ----------
    libraries : list of str
        Material libraries, as the file names them.
    textures : list of str
        What the libraries name, relative to the OBJ file.
    missing : list of str
        Libraries that are not there.
    color_scale : float
        What is stored for a colour of 1.
    """

    libraries: list[str]
    textures: list[str]
    missing: list[str]
    color_scale: float = 1.0


def read_obj(data: bytes, beside: Folder, warnings: list[str]) -> list[Mesh]:
    """Read an OBJ file into one mesh.

    Parameters
    ----------
    data : bytes
    beside : Folder
        Where the OBJ file is.
    warnings : list of str
        Told what is left out.

    Raises
    ------
    InputError
    """
    if b"\\" in data:
        data = data.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ")
    lines = [line.strip() for line in data.split(b"\n")]
    if b"\t" in data:
        lines = [line.replace(b"\t", b" ") for line in lines]
    keys = np.array([line.partition(b" ")[0][:20] for line in lines])
    _warn_of_rest(keys, warnings)
    positions, colors = _positions([lines[i][2:] for i in np.flatnonzero(keys == b"v")], warnings)
    where_faces = np.flatnonzero(keys == b"f")
    sizes, triples = _corners([lines[i][2:] for i in where_faces])
    counts = [len(positions), int(np.sum(keys == b"vt")), int(np.sum(keys == b"vn"))]
    _absolute(triples, sizes, where_faces, keys, counts)
    textures = table([lines[i][3:] for i in np.flatnonzero(keys == b"vt")])
    if np.any(np.nan_to_num(textures[:, 2:])):
        warnings.append("the third of three OBJ texture coordinates was left out")
    normals = _wide(table([lines[i][3:] for i in np.flatnonzero(keys == b"vn")]), 3)
    states, part = _states(lines, keys, where_faces)
    row_triples, corners = _rows(triples, len(positions))
    named = [lines[i][7:].strip().decode("utf-8", "surrogateescape") for i in np.flatnonzero(keys == b"mtllib")]
    libraries = list(dict.fromkeys(name for line in named for name in library_names(line, beside)))
    materials, missing = read_materials(libraries, beside)
    parts = [Part(state.name(), source=ObjPart(state, materials.get(state.material))) for state in states]
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32)
    mesh, _ = polygon_mesh(
        shown(states[0].object) if states else "",
        positions[row_triples[:, 0]],
        Polygons(offsets, corners.astype(np.int32), part),
        parts,
        warnings,
    )
    textured = (name for material in materials.values() for name in material.textures)
    mesh.source = ObjFormat(libraries, list(dict.fromkeys(textured)), missing)
    for texture in mesh.source.textures:
        beside.has(texture)
    attributes = []
    if np.any(row_triples[:, 1] >= 0):
        attributes.append(uv_attribute(_taken(_wide(textures, 2), row_triples[:, 1]), parts, beside.picture))
    if colors is not None:
        mesh.source.color_scale = 255.0 if np.nanmax(colors, initial=0.0) > 1.0 else 1.0
        attributes.append(color_attribute(colors[row_triples[:, 0]] / mesh.source.color_scale, mesh))
    attach_attributes(mesh, attributes)
    if np.any(row_triples[:, 2] >= 0):
        mesh.normals = np.nan_to_num(_taken(normals, row_triples[:, 2]))
    return [mesh]


def _warn_of_rest(keys: NDArray[np.bytes_], warnings: list[str]) -> None:
    """Name the statements that are not read."""
    for key, count in zip(*np.unique(keys, return_counts=True), strict=True):
        if key not in _ROUND and not key.startswith(b"#"):
            text = key[:20].decode(errors="replace")
            warnings.append(f"{count:,} OBJ lines that start with '{text}' were left out")


def _positions(lines: list[bytes], warnings: list[str]) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """Positions, and colours where six or seven numbers follow a `v`."""
    if not lines:
        return np.empty((0, 3)), None
    values, sizes = table(lines), None
    if np.isnan(values).any() or values.shape[1] not in (3, 4, 6, 7):
        values, sizes = ragged(lines)
        if sizes.min() < 3:
            raise InputError(f"vertex {int(np.argmin(sizes)) + 1} of the OBJ has fewer than three coordinates")
    width = values.shape[1]
    if width in (4, 7):
        weights = values[:, 3]
        if width == 4 and np.any(np.isfinite(weights) & (weights != 1.0)):
            warnings.append("the weights of rational OBJ points were left out")
    if width < 6:
        return np.ascontiguousarray(values[:, :3]), None
    colors = values[:, width - 3 : width].copy()
    colored = np.full(len(colors), True) if sizes is None else sizes >= 6
    broken = colored & ~np.isfinite(colors).all(axis=1)
    if broken.any():
        warnings.append(f"the colours of {int(broken.sum()):,} OBJ points are no numbers: left out")
    colors[broken | ~colored] = np.nan
    return np.ascontiguousarray(values[:, :3]), colors


def _corners(lines: list[bytes]) -> tuple[Index, Index]:
    """Corners per face, and (c, 3) numbers v, vt, vn as written, 0 where left out."""
    if not lines:
        return np.zeros(0, np.int64), np.zeros((0, 3), np.int64)
    text = b"\n".join(lines) + b"\n"
    raw = np.frombuffer(text, np.uint8)
    blank = (raw == 32) | (raw == 10)
    start = ~blank & np.concatenate([[True], blank[:-1]])
    starts = np.flatnonzero(start)
    line_ends = np.searchsorted(starts, np.flatnonzero(raw == 10))
    sizes = np.diff(np.concatenate([[0], line_ends]))
    # Stored column by column, since each column is worked on by itself.
    triples = np.zeros((len(starts), 3), np.int64, order="F")
    if b"/" not in text:
        triples[:, 0] = numbers(text, np.int64)
        return sizes, triples
    owner = np.searchsorted(starts, np.flatnonzero(raw == 47), side="right") - 1
    slashes = np.bincount(owner, minlength=len(starts))
    if slashes.max() > 2:
        raise InputError("an OBJ face has a corner with more than two slashes: the file is damaged")
    text = text.replace(b"//", b"/0/").replace(b"/ ", b"/0 ").replace(b"/\n", b"/0\n")
    flat = numbers(text.replace(b"/", b" "), np.int64)
    if len(flat) != len(starts) + slashes.sum():
        raise InputError("an OBJ face has a corner without a vertex number: the file is damaged")
    first = np.concatenate([[0], np.cumsum(slashes + 1)[:-1]]).astype(np.int64)
    for column in range(3):
        has = slashes >= column
        triples[has, column] = flat[first[has] + column]
    return sizes, triples


def _absolute(triples: Index, sizes: Index, where_faces: Index, keys: NDArray[np.bytes_], counts: list[int]) -> None:
    """Make numbers count from 0, in place, with -1 for those left out; refuse those out of range."""
    for column, key in enumerate((b"v", b"vt", b"vn")):
        numbers_ = triples[:, column]
        negative = numbers_ < 0
        if negative.any():
            so_far = np.cumsum(keys == key)[where_faces]
            numbers_[negative] += np.repeat(so_far, sizes)[negative] + 1
            if np.any(numbers_[negative] <= 0):
                numbers_[negative & (numbers_ <= 0)] = counts[column] + 1
        numbers_ -= 1
        wrong = (numbers_ >= counts[column]) | ((numbers_ < 0) if column == 0 else False)
        if np.any(wrong):
            face = int(np.searchsorted(np.cumsum(sizes), np.flatnonzero(wrong)[0], side="right"))
            raise InputError(
                f"line {int(where_faces[face]) + 1} of the OBJ names a '{key.decode()}' that does not exist"
                f" (there are {counts[column]:,}): the file is damaged"
            )


def _rows(triples: Index, count: int) -> tuple[Index, Index]:
    """Distinct corners as rows, and the row of each corner; every point is a row where that suffices."""
    if not np.any(triples[:, 1:] >= 0):
        rows = np.full((count, 3), -1, np.int64)
        rows[:, 0] = np.arange(count)
        return rows, triples[:, 0]
    v = triples[:, 0]
    # Where every point has but one texture coordinate and normal, which is common, no search is needed.
    only = np.full((count, 3), -1, np.int64, order="F")
    only[v] = triples
    if all(np.array_equal(only[v, column], triples[:, column]) for column in (1, 2)):
        only[:, 0] = np.arange(count)
        return only, v
    first, inverse = find_unique_rows(triples)
    return triples[first], inverse


def _states(lines: list[bytes], keys: NDArray[np.bytes_], where_faces: Index) -> tuple[list[State], NDArray[np.int32]]:
    """The distinct states that faces are in, and the state of each face."""
    where = np.flatnonzero(np.isin(keys, _STATE))
    words = dict(zip(_STATE, ("object", "group", "material", "smoothing"), strict=True))
    current = dict.fromkeys(words.values(), "")
    states: dict[State, int] = {}
    of_run = np.zeros(len(where) + 1, np.int32)
    runs = np.searchsorted(where, where_faces)
    used = np.zeros(len(where) + 1, bool)
    used[runs] = True
    for run in range(len(where) + 1):
        if run:
            key, _, value = lines[where[run - 1]].partition(b" ")
            text = value.strip().decode("utf-8", "surrogateescape")
            current[words[key]] = "" if key == b"s" and text in ("off", "0") else text
        if used[run]:
            of_run[run] = states.setdefault(State(**current), len(states))
    return list(states), of_run[runs]


def _wide(values: NDArray[np.float64], width: int) -> NDArray[np.float64]:
    """So many columns; numbers that a line leaves out are 0, as OBJ has it for texture coordinates."""
    full = np.zeros((len(values), width))
    shared = min(width, values.shape[1])
    full[:, :shared] = np.nan_to_num(values[:, :shared], posinf=0.0, neginf=0.0)
    return full


def _taken(values: NDArray[np.float64], index: Index) -> NDArray[np.float64]:
    """Rows of an array, NaN where the index is -1."""
    taken = values[np.maximum(index, 0)].astype(np.float64)
    taken[index < 0] = np.nan
    return taken
