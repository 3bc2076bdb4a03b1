"""OBJ material libraries: the colour and the textures of each material, read and written."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from .folder import Folder, beneath
from .surface import Material, UvMap

_MAPS = (
    "map_ka", "map_kd", "map_ks", "map_ke", "map_ns", "map_d", "map_tr", "map_bump", "bump", "norm", "map_kn", "disp",
    "map_disp", "decal", "refl", "map_pr", "map_pm", "map_ps", "map_rma", "map_orm",
)  # fmt: skip
"""Statements that name a texture, in lower case."""

_OPTIONS = {"-o": 3, "-s": 3, "-t": 3, "-mm": 2}
"""Options of a texture that take several numbers; all others take one word."""


_NUMBERS = {"Ke": 3, "Pm": 1, "Pr": 1}
"""Statements that glTF has a like of, and how many numbers they take."""


@dataclass
class _Draft:
    """A material while its lines are read."""

    color: tuple[float, float, float, float] | None = None
    maps: dict[str, str] = field(default_factory=dict)
    stretch: tuple[float, float] = (1.0, 1.0)
    uv_map: UvMap = field(default_factory=UvMap)
    clamp: bool = False
    numbers: dict[str, tuple[float, ...]] = field(default_factory=dict)
    left: dict[str, None] = field(default_factory=dict)

    def material(self, name: str) -> Material:
        """What the lines made."""
        color = next((value for key, value in self.maps.items() if key.lower() == "map_kd"), None)
        others = tuple((key, value) for key, value in self.maps.items() if key.lower() != "map_kd")
        numbers, left = dict(self.numbers), dict(self.left)
        if "Ke" in numbers and any(key.lower() == "map_ke" for key, _ in others):
            # Without its texture, which only MTL takes along, all of the surface would give light.
            del numbers["Ke"]
            left["Ke"] = None
        return Material(
            name, self.color, color, others, self.stretch,
            uv_map=self.uv_map, clamp=self.clamp, numbers=tuple(numbers.items()), left=tuple(left),
        )  # fmt: skip


def library_names(line: str, beside: Folder) -> list[str]:
    """Libraries that an OBJ line names: a file whose name may have blanks, or else several words."""
    words = line.split()
    several = beneath(beside.path, line) is None and any(beneath(beside.path, word) is not None for word in words)
    return words if several else [line]


def read_materials(libraries: list[str], beside: Folder) -> tuple[dict[str, Material], list[str]]:
    """Materials by name, and the libraries that are missing.

    Textures are named relative to the OBJ file. Those of a library in another folder are looked for there first.
    """
    materials: dict[str, Material] = {}
    missing: list[str] = []
    for library in libraries:
        data = beside(library)
        if data is None:
            missing.append(library)
            continue
        folder = library.replace("\\", "/").rpartition("/")[0]
        for name, draft in _drafts(data.decode("utf-8", "surrogateescape")).items():
            if folder:
                for key, texture in draft.maps.items():
                    if beside.has(f"{folder}/{texture}"):
                        draft.maps[key] = f"{folder}/{texture}"
            materials.setdefault(name, draft.material(name))
    return materials, missing


def _drafts(text: str) -> dict[str, _Draft]:
    """Materials of a library."""
    drafts: dict[str, _Draft] = {}
    current = _Draft()
    for line in text.splitlines():
        key, _, value = line.strip().replace("\t", " ").partition(" ")
        value = value.strip()
        if key == "newmtl":
            current = drafts.setdefault(value, _Draft())
        elif key == "Kd":
            red, green, blue = _floats(value.split(), 3)
            current.color = (red, green, blue, current.color[3] if current.color else 1.0)
        elif key in ("d", "Tr"):
            share = _floats(value.split()[-1:], 1)[0]
            opaque = share if key == "d" else 1.0 - share
            current.color = (*(current.color or (1.0, 1.0, 1.0, 1.0))[:3], opaque)
        elif key.lower() in _MAPS and value:
            _add_texture(current, key, value)
        elif key and not key.startswith("#"):
            _add_rest(current, key, value.split())
    return drafts


def _add_rest(draft: _Draft, key: str, words: list[str]) -> None:
    """Take any other statement, where it says something: noughts do not, nor that light falls as usual."""
    numeric = all(map(_is_number, words))
    if key in _NUMBERS and len(words) == _NUMBERS[key] and numeric:
        draft.numbers[key] = tuple(map(float, words))
    elif words not in (["1"], ["2"]) if key == "illum" else not numeric or any(map(float, words)):
        draft.left[key] = None


def _add_texture(draft: _Draft, key: str, value: str) -> None:
    """Take a texture statement: a texture shows `-s` times UV plus `-o`."""
    name, options = _texture(value)
    if not name:
        return
    u, v = _floats(options.get("-s", []), 2)
    draft.maps[key] = name
    draft.stretch = max(draft.stretch[0], abs(u)), max(draft.stretch[1], abs(v))
    if key.lower() == "map_kd":
        du, dv = _floats(options.get("-o", []), 2, missing=0.0)
        draft.uv_map = UvMap(0, (u, 0.0, du, 0.0, v, dv))
        draft.clamp = options.get("-clamp") == ["on"]


def _texture(value: str) -> tuple[str, dict[str, list[str]]]:
    """The file of a texture statement, and the words of its options."""
    options: dict[str, list[str]] = {}
    while value.startswith("-"):
        option, _, value = value.partition(" ")
        words: list[str] = []
        for _ in range(_OPTIONS.get(option, 1)):
            word, _, rest = value.strip().partition(" ")
            if words and not _is_number(word):
                break
            words.append(word)
            value = rest.strip()
        options[option] = words
    return value, options


def _is_number(word: str) -> bool:
    try:
        return math.isfinite(float(word))
    except ValueError:
        return False


def _floats(words: list[str], count: int, *, missing: float = 1.0) -> list[float]:
    """The first numbers of some words, and `missing` where there are fewer."""
    found = []
    for word in words[:count]:
        if not _is_number(word):
            break
        found.append(float(word))
    return found + [missing] * (count - len(found))


def material_library(materials: list[Material]) -> str:
    """The text of an MTL file."""
    lines = []
    for material in materials:
        lines.append(f"newmtl {material.name}")
        if material.color:
            lines.append("Kd " + " ".join(repr(float(value)) for value in material.color[:3]))
            if material.color[3] != 1.0:
                lines.append(f"d {material.color[3]!r}")
        if material.texture:
            lines.append(f"map_Kd {material.texture}")
        lines += [f"{key} {name}" for key, name in material.others]
    return "\n".join([*lines, ""])
