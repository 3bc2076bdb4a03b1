"""Read and write Wavefront OBJ: objects, groups and materials are parts of one mesh; polygons stay polygons."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..material import Material
from ..model import Indices, Mesh, Part, Values, attach_attributes, cast_indices, make_attribute
from ..unique_rows import find_unique_rows
from .flat_mesh import FlatMesh
from .input_folder import InputFolder
from .mtl import read_materials, replace_bad_bytes, split_library_names
from .polygons import Polygons, build_mesh
from .text_numbers import parse_numbers, parse_rows
from .textures import make_uv_attribute

Numbers = NDArray[np.int64]

_STATE = {b"o": "object", b"g": "group", b"usemtl": "material", b"s": "smoothing"}
_KNOWN = (b"", b"#", b"v", b"vt", b"vn", b"f", b"mtllib", *_STATE)


@dataclass(frozen=True)
class ObjState:
    """Values that the lines before a face set for it, as they are written; "" where nothing is set."""

    object: str = ""
    group: str = ""
    material: str = ""
    smoothing: str = ""

    def describe(self) -> str:
        """Name the part as the user knows it."""
        texts = filter(None, (self.object, self.group, self.material))
        return " / ".join(map(replace_bad_bytes, texts)) or "mesh"


@dataclass
class ObjStyle:
    """Properties of an OBJ file that its result keeps.

    Attributes
    ----------
    states : list of ObjState
        One for each part.
    libraries : list of str
        Material libraries, as the file names them.
    textures : list of str
        Files that the libraries name, relative to the OBJ file.
    missing : list of str
        Libraries that do not exist.
    color_scale : float
        The number that is stored for a color of 1.
    """

    states: list[ObjState] = field(default_factory=list)
    libraries: list[str] = field(default_factory=list)
    textures: list[str] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)
    color_scale: float = 1.0


def read_obj(data: bytes, folder: InputFolder, warnings: list[str]) -> tuple[Mesh, ObjStyle]:
    """Read an OBJ file.

    Parameters
    ----------
    data : bytes
    folder : InputFolder
        The folder of the OBJ file.
    warnings : list of str
        Receives a message about each kind of data that is ignored.

    Raises
    ------
    InputError
        If the file is damaged, or has no faces.
    """
    if b"\\" in data:
        data = data.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ")
    lines = [line.strip() for line in data.split(b"\n")]
    if b"\t" in data:
        lines = [line.replace(b"\t", b" ") for line in lines]
    keys = np.array([line.partition(b" ")[0][:20] for line in lines])
    _warn_of_ignored_lines(keys, warnings)

    def values_of(key: bytes) -> list[bytes]:
        return [lines[i][len(key) + 1 :] for i in np.flatnonzero(keys == key)]

    positions, colors = _read_positions(values_of(b"v"), warnings)
    textures, _ = parse_rows(values_of(b"vt"))
    if np.any(np.nan_to_num(textures[:, 2:])):
        warnings.append("ignored the third of three OBJ texture coordinates")
    normals, _ = parse_rows(values_of(b"vn"))
    face_lines = np.flatnonzero(keys == b"f")
    sizes, triples = _read_corners(values_of(b"f"))
    _resolve_numbers(triples, sizes, face_lines, keys, (len(positions), len(textures), len(normals)))
    rows, corners = _number_rows(triples, len(positions))
    states, part = _read_states(lines, keys, face_lines)
    named = [line.strip().decode("utf-8", "surrogateescape") for line in values_of(b"mtllib")]
    libraries = list(dict.fromkeys(name for line in named for name in split_library_names(line, folder)))
    materials, missing = read_materials(libraries, folder)
    used = list(dict.fromkeys(name for material in materials.values() for name in material.textures))
    for texture in used:
        folder.has(texture)
    parts = [Part(state.describe(), material=materials.get(state.material)) for state in states]
    name = replace_bad_bytes(states[0].object) if states else ""
    polygons = Polygons(sizes, cast_indices(corners), part)
    mesh, _ = build_mesh(name, positions[rows[:, 0]], polygons, parts, warnings)
    style = ObjStyle(states, libraries, used, missing)
    attributes = []
    if np.any(rows[:, 1] >= 0):
        attributes.append(make_uv_attribute(_take_rows(textures, rows[:, 1], 2), parts, folder.load_image))
    if colors is not None:
        style.color_scale = 255.0 if np.nanmax(colors, initial=0.0) > 1.0 else 1.0
        attributes.append(make_attribute("COLOR_0", colors[rows[:, 0]] / style.color_scale, mesh))
    attach_attributes(mesh, attributes)
    if np.any(rows[:, 2] >= 0):
        mesh.normals = np.nan_to_num(_take_rows(normals, rows[:, 2], 3))
    return mesh, style


def _warn_of_ignored_lines(keys: NDArray[np.bytes_], warnings: list[str]) -> None:
    """Name the statements that are not read."""
    for key, count in zip(*np.unique(keys, return_counts=True), strict=True):
        if key not in _KNOWN and not key.startswith(b"#"):
            warnings.append(f"ignored {count:,} OBJ lines that start with '{key[:20].decode(errors='replace')}'")


def _read_positions(lines: list[bytes], warnings: list[str]) -> tuple[Values, Values | None]:
    """Read positions, and colors where six or seven numbers follow a `v`."""
    if not lines:
        return np.empty((0, 3)), None
    values, sizes = parse_rows(lines)
    if sizes.min() < 3:
        raise InputError(f"vertex {int(np.argmin(sizes)) + 1} of the OBJ has fewer than three coordinates")
    width = values.shape[1]
    if width == 4 and np.any(np.isfinite(values[:, 3]) & (values[:, 3] != 1.0)):
        warnings.append("ignored the weights of rational OBJ points")
    if width < 6:
        return np.ascontiguousarray(values[:, :3]), None
    colors = values[:, width - 3 : width].copy()
    broken = (sizes >= 6) & ~np.isfinite(colors).all(axis=1)
    if broken.any():
        warnings.append(f"ignored the colors of {int(broken.sum()):,} OBJ points, which are no numbers")
    colors[broken | (sizes < 6)] = np.nan
    return np.ascontiguousarray(values[:, :3]), colors


def _read_corners(lines: list[bytes]) -> tuple[Numbers, Numbers]:
    """Read corners per face, and (c, 3) numbers v, vt, vn as written, 0 where left out."""
    if not lines:
        return np.zeros(0, np.int64), np.zeros((0, 3), np.int64)
    text = b"\n".join(lines) + b"\n"
    raw = np.frombuffer(text, np.uint8)
    blank = (raw == 32) | (raw == 10)
    starts = np.flatnonzero(~blank & np.concatenate([[True], blank[:-1]]))
    sizes = np.diff(np.searchsorted(starts, np.flatnonzero(raw == 10)), prepend=0)
    # Stored column by column, since each column is worked on by itself.
    triples = np.zeros((len(starts), 3), np.int64, order="F")
    owner = np.searchsorted(starts, np.flatnonzero(raw == 47), side="right") - 1
    slashes = np.bincount(owner, minlength=len(starts))
    if slashes.max(initial=0) > 2:
        raise InputError("an OBJ face has a corner with more than two slashes: the file is damaged")
    text = text.replace(b"//", b"/0/").replace(b"/ ", b"/0 ").replace(b"/\n", b"/0\n")
    flat = parse_numbers(text.replace(b"/", b" "), np.int64)
    if len(flat) != len(starts) + slashes.sum():
        raise InputError("an OBJ face has a corner without a vertex number: the file is damaged")
    first = np.cumsum(slashes + 1) - (slashes + 1)
    for column in range(3):
        has = slashes >= column
        triples[has, column] = flat[first[has] + column]
    return sizes, triples


def _resolve_numbers(
    triples: Numbers, sizes: Numbers, face_lines: Numbers, keys: NDArray[np.bytes_], counts: Sequence[int]
) -> None:
    """Make numbers count from 0, in place, with -1 for those left out; refuse those out of range."""
    for key, numbers, count in zip((b"v", b"vt", b"vn"), triples.T, counts, strict=True):
        negative = numbers < 0
        if negative.any():
            so_far = np.cumsum(keys == key)[face_lines]
            numbers[negative] += np.repeat(so_far, sizes)[negative] + 1
            numbers[negative & (numbers <= 0)] = count + 1
        numbers -= 1
        wrong = numbers >= count
        if key == b"v":
            wrong |= numbers < 0
        if np.any(wrong):
            face = int(np.searchsorted(np.cumsum(sizes), np.flatnonzero(wrong)[0], side="right"))
            raise InputError(
                f"line {int(face_lines[face]) + 1} of the OBJ names a '{key.decode()}' that does not exist"
                f" (there are {count:,}): the file is damaged"
            )


def _number_rows(triples: Numbers, count: int) -> tuple[Numbers, Numbers]:
    """Return distinct corners as rows, and the row of each corner; every point is a row where that suffices."""
    point = triples[:, 0]
    rows = np.full((count, 3), -1, np.int64, order="F")
    # Where every point has but one texture coordinate and normal, which is common, no search is needed.
    rows[point] = triples
    if all(np.array_equal(rows[point, column], triples[:, column]) for column in (1, 2)):
        rows[:, 0] = np.arange(count)
        return rows, point
    first, inverse = find_unique_rows(triples)
    return triples[first], inverse


def _read_states(lines: list[bytes], keys: NDArray[np.bytes_], face_lines: Numbers) -> tuple[list[ObjState], Indices]:
    """Return the distinct states that faces are in, and the state of each face."""
    state_lines = np.flatnonzero(np.isin(keys, list(_STATE)))
    history = [ObjState()]
    for line in state_lines:
        key, _, value = lines[line].partition(b" ")
        text = value.strip().decode("utf-8", "surrogateescape")
        history.append(replace(history[-1], **{_STATE[key]: "" if key == b"s" and text in ("off", "0") else text}))
    runs, run_of_face = np.unique(np.searchsorted(state_lines, face_lines), return_inverse=True)
    states = {state: number for number, state in enumerate(dict.fromkeys(history[run] for run in runs))}
    state_of_run = np.array([states[history[run]] for run in runs], np.int32)
    return list(states), state_of_run[run_of_face]


def _take_rows(values: Values, index: Numbers, width: int) -> Values:
    """Return rows of so many numbers: 0 for those that a line leaves out, NaN where the index is -1."""
    taken = np.zeros((len(index), width))
    shared = min(width, values.shape[1])
    taken[:, :shared] = np.nan_to_num(values[np.maximum(index, 0), :shared], posinf=0.0, neginf=0.0)
    taken[index < 0] = np.nan
    return taken


def write_obj(
    meshes: list[FlatMesh], states: list[list[ObjState]], libraries: list[str], color_scale: float = 1.0
) -> tuple[bytes, int]:
    """Write meshes as an OBJ file.

    Parameters
    ----------
    meshes : list of FlatMesh
    states : list of list of ObjState
        For each mesh, one for each part.
    libraries : list of str
        Material libraries to name.
    color_scale : float
        The number to store for a color of 1; those of 255 get three decimals.

    Returns
    -------
    text : bytes
        Numbers are the shortest that read back exactly in double precision.
    vertices : int
        Distinct corners.
    """
    lines = [f"mtllib {name}" for name in libraries]
    counts = {"v": 0, "vt": 0, "vn": 0}
    vertices, state = 0, ObjState()
    for flat, own in zip(meshes, states, strict=True):
        # The number of each row of v, vt and vn, 0 for rows without.
        columns = np.zeros((len(flat.points), 3), np.int64)
        for column, (key, values) in zip(columns.T, _collect_rows(flat, color_scale).items(), strict=True):
            present = np.flatnonzero(~np.isnan(values).all(axis=1))
            first, inverse = find_unique_rows(values[present])
            column[present] = inverse + counts[key] + 1
            counts[key] += len(first)
            lines += _write_rows(key, values[present[first]])
        vertices += len(find_unique_rows(columns)[0])
        words = np.array(_name_corners(columns[flat.faces.reshape(-1)]), object).reshape(-1, 3)
        order = np.argsort(flat.part, kind="stable")
        parts, starts = np.unique(flat.part[order], return_index=True)
        for part, rows in zip(parts, np.split(order, starts[1:]), strict=True):
            lines += _write_changes(state, own[part])
            state = own[part]
            lines += [f"f {a} {b} {c}" for a, b, c in words[rows].tolist()]
    return ("\n".join(lines) + "\n").encode("utf-8", "surrogateescape"), vertices


def make_states(flat: FlatMesh, names: dict[Material, str]) -> list[ObjState]:
    """Return a state for each part of a mesh of another format; the names are those in the material library."""

    def one_line(text: str) -> str:
        return " ".join(text.split())

    return [
        ObjState(
            one_line(flat.name),
            one_line(part.name) if len(flat.parts) > 1 else "",
            names.get(part.material, "") if part.material else "",
        )
        for part in flat.parts
    ]


def _collect_rows(flat: FlatMesh, color_scale: float) -> dict[str, Values]:
    """Return the values of v, vt and vn for each row of a mesh, NaN where it has none."""
    positions, colors = flat.points, flat.values("COLOR_0")
    if colors is not None:
        stored = colors[:, :3] if color_scale == 1.0 else np.round(colors[:, :3] * color_scale, 3)
        positions = np.concatenate([positions, stored], axis=1)
    uv, normals, none = flat.values("TEXCOORD_0"), flat.normals, np.full((len(positions), 1), np.nan)
    if normals is not None:
        normals = np.where(normals.any(axis=1, keepdims=True), normals, np.nan)
    return {"v": positions, "vt": none if uv is None else uv, "vn": none if normals is None else normals}


def _write_rows(key: str, rows: Values) -> list[str]:
    """Return the lines of rows; a point without a color has NaN after its position."""
    if rows.shape[1] == 3 and not np.isnan(rows).any():
        return [f"{key} {x!r} {y!r} {z!r}" for x, y, z in rows.tolist()]
    return [" ".join([key, *(repr(value) for value in row if not math.isnan(value))]) for row in rows.tolist()]


def _write_changes(before: ObjState, after: ObjState) -> list[str]:
    """Return the lines that lead from one state to another."""
    changes = {
        key: getattr(after, name) for key, name in _STATE.items() if getattr(after, name) != getattr(before, name)
    }
    return [f"{key.decode()} {value or ('off' if key == b's' else '')}".rstrip() for key, value in changes.items()]


def _name_corners(columns: Numbers) -> list[str]:
    """Return the text of corners from the numbers of v, vt and vn, (c, 3), 0 for none."""
    v, vt, vn = columns.T.tolist()
    if not columns[:, 1:].any():
        return list(map(str, v))
    return [(f"{a}/{b or ''}/{c}" if c else f"{a}/{b}" if b else str(a)) for a, b, c in zip(v, vt, vn, strict=True)]
