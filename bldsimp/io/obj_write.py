"""A result as Wavefront OBJ."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..model import Part
from ..unique_rows import find_unique_rows
from .flat_mesh import Sheet
from .obj import ObjPart, State
from .surface import Material, material_of

Index = NDArray[np.int64]


@dataclass
class Text:
    """Lines of a file and the numbers that later lines count on."""

    lines: list[str] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=lambda: {"v": 0, "vt": 0, "vn": 0})
    vertices: int = 0


def obj_text(
    sheets: list[Sheet], libraries: list[str], names: dict[Material, str], color_scale: float = 1.0
) -> tuple[bytes, int]:
    """The text of an OBJ file.

    Parameters
    ----------
    sheets : list of Sheet
    libraries : list of str
        Material libraries to name.
    names : dict of Material to str
        What the libraries call them; not asked for parts of an OBJ file.

    color_scale : float
        What is stored for a colour of 1: those of 255 get three decimals.

    Returns
    -------
    text : bytes
        Numbers are the shortest that read back exactly in double precision.
    vertices : int
        Distinct corners.
    """
    text = Text([f"mtllib {name}" for name in libraries])
    state = State()
    for one in sheets:
        columns, vertices = _columns(one, text, color_scale)
        text.vertices += vertices
        state = _faces(one, columns, text, state, names)
    return ("\n".join(text.lines) + "\n").encode("utf-8", "surrogateescape"), text.vertices


def _columns(one: Sheet, text: Text, color_scale: float) -> tuple[list[Index | None], int]:
    """Write `v`, `vt` and `vn` lines; the number of each corner in each, -1 for none; distinct corners."""
    positions = one.points
    colors = one.values("COLOR_0")
    if colors is not None:
        stored = colors[:, :3] if color_scale == 1.0 else np.round(colors[:, :3] * color_scale, 3)
        positions = np.concatenate([positions, stored], axis=1)
    columns = [
        _column("v", positions, text),
        _column("vt", one.values("TEXCOORD_0"), text),
        _column("vn", _missing_as_nan(one.normals), text),
    ]
    present = [column for column in columns if column is not None]
    vertices = len(find_unique_rows(np.stack(present, axis=1))[0])
    corners = one.faces.reshape(-1)
    return [None if column is None else column[corners] for column in columns], vertices


def _column(key: str, values: NDArray[np.float64] | None, text: Text) -> Index | None:
    """Write the distinct rows of one kind; the number of each row's."""
    if values is None:
        return None
    absent = np.isnan(values).all(axis=1)
    first, inverse = find_unique_rows(values[~absent])
    numbers = np.full(len(values), -1, np.int64)
    numbers[~absent] = inverse + text.counts[key] + 1
    text.counts[key] += len(first)
    distinct = values[~absent][first]
    if distinct.shape[1] == 3 and not np.isnan(distinct).any():
        text.lines += [f"{key} {x!r} {y!r} {z!r}" for x, y, z in distinct.tolist()]
        return numbers
    for row in distinct.tolist():
        # A point without a colour has NaN behind its position.
        text.lines.append(key + " " + " ".join(repr(value) for value in row if value == value))
    return numbers


def _missing_as_nan(normals: NDArray[np.float64] | None) -> NDArray[np.float64] | None:
    """Normals with NaN where a row is zero; None where all are."""
    if normals is None or not normals.any():
        return None
    absent = ~np.any(normals != 0.0, axis=1, keepdims=True)
    return np.where(absent, np.nan, normals)


def _faces(one: Sheet, columns: list[Index | None], text: Text, state: State, names: dict[Material, str]) -> State:
    """Write the faces part by part, and the lines that tell the parts."""
    words = np.array(_corners(columns), object).reshape(-1, 3)
    order = np.argsort(one.part, kind="stable")
    for part in np.unique(one.part):
        state = _announce(_state(one, one.parts[part], names), state, text)
        chosen = order[slice(*np.searchsorted(one.part[order], [part, part + 1]))]
        text.lines += [f"f {a} {b} {c}" for a, b, c in words[chosen].tolist()]
    return state


def _corners(columns: list[Index | None]) -> list[str]:
    """The text of every corner."""
    v, vt, vn = (None if column is None else column.tolist() for column in columns)
    assert v is not None
    if vt is None and vn is None:
        return list(map(str, v))
    blank = [-1] * len(v)
    return [_corner(*corner) for corner in zip(v, vt or blank, vn or blank, strict=True)]


def _corner(v: int, vt: int, vn: int) -> str:
    """One corner; numbers that are not positive are left out."""
    if vn > 0:
        return f"{v}/{vt}/{vn}" if vt > 0 else f"{v}//{vn}"
    return f"{v}/{vt}" if vt > 0 else str(v)


def _state(one: Sheet, part: Part, names: dict[Material, str]) -> State:
    """What to say of a part."""
    if isinstance(part.source, ObjPart):
        return part.source.state
    material = material_of(part)
    group = part.name if len(one.parts) > 1 else ""
    return State(one_word(one.name), one_word(group), "" if material is None else names[material])


def one_word(text: str) -> str:
    """A name on one line."""
    return " ".join(text.split())


def _announce(new: State, old: State, text: Text) -> State:
    """Write the lines that lead from one state to the next."""
    if new.object != old.object:
        text.lines.append(f"o {new.object}".rstrip())
    if new.group != old.group:
        text.lines.append(f"g {new.group}".rstrip())
    if new.material != old.material:
        text.lines.append(f"usemtl {new.material}".rstrip())
    if new.smoothing != old.smoothing:
        text.lines.append(f"s {new.smoothing or 'off'}")
    return new
