"""Read and write OBJ material libraries: the color and the textures of each material."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from ..material import Material, UvMap
from .input_folder import InputFolder, find_beneath

_MAPS = (
    "map_ka", "map_kd", "map_ks", "map_ke", "map_ns", "map_d", "map_tr", "map_bump", "bump", "norm", "map_kn", "disp",
    "map_disp", "decal", "refl", "map_pr", "map_pm", "map_ps", "map_rma", "map_orm",
)  # fmt: skip
"""Statements that name a texture, in lower case."""

_OPTIONS = {"-o": 3, "-s": 3, "-t": 3, "-mm": 2}
"""Options of a texture that take several numbers; all others take one word."""

_NUMBERS = {"Ke": 3, "Pm": 1, "Pr": 1}
"""Statements that glTF has a counterpart of, and how many numbers they take."""


def replace_bad_bytes(name: str) -> str:
    """Return a name that every encoding takes: bytes that were no UTF-8 become replacement characters."""
    return name.encode("utf-8", "surrogateescape").decode("utf-8", "replace")


def split_library_names(line: str, folder: InputFolder) -> list[str]:
    """List the libraries that an OBJ line names: one file whose name may contain blanks, or several words."""
    words = line.split()
    several = find_beneath(folder.path, line) is None and any(find_beneath(folder.path, word) for word in words)
    return words if several else [line]


def read_materials(libraries: list[str], folder: InputFolder) -> tuple[dict[str, Material], list[str]]:
    """Read material libraries.

    Parameters
    ----------
    libraries : list of str
    folder : InputFolder
        The folder of the OBJ file.

    Returns
    -------
    materials : dict of str to Material
        By name. Textures are named relative to the OBJ file; those of a library in another folder are first looked
        for there.
    missing : list of str
        Libraries that do not exist.
    """
    materials: dict[str, Material] = {}
    missing: list[str] = []
    for library in libraries:
        data = folder.load(library)
        if data is None:
            missing.append(library)
            continue
        own = library.replace("\\", "/").rpartition("/")[0]
        for name, draft in _read_drafts(data.decode("utf-8", "surrogateescape")).items():
            for key, texture in draft.maps.items():
                if own and folder.has(f"{own}/{texture}"):
                    draft.maps[key] = f"{own}/{texture}"
            materials.setdefault(name, draft.finish(name))
    return materials, missing


def write_materials(materials: list[Material]) -> str:
    """Return the text of an MTL file."""
    lines = []
    for material in materials:
        lines.append(f"newmtl {material.name}")
        if material.color:
            lines.append("Kd " + " ".join(repr(float(value)) for value in material.color[:3]))
            if material.color[3] != 1.0:
                lines.append(f"d {material.color[3]!r}")
        if material.texture:
            lines.append(f"map_Kd {material.texture}")
        lines += [f"{key} {name}" for key, name in material.other_textures]
    return "\n".join([*lines, ""])


@dataclass
class _Draft:
    """A material while its lines are read."""

    color: tuple[float, float, float, float] | None = None
    maps: dict[str, str] = field(default_factory=dict)
    repeats: tuple[float, float] = (1.0, 1.0)
    uv_map: UvMap = field(default_factory=UvMap)
    clamp: bool = False
    numbers: dict[str, tuple[float, ...]] = field(default_factory=dict)
    unsupported: list[str] = field(default_factory=list)

    def finish(self, name: str) -> Material:
        """Return the material that the lines describe."""
        color = next((value for key, value in self.maps.items() if key.lower() == "map_kd"), None)
        others = tuple((key, value) for key, value in self.maps.items() if key.lower() != "map_kd")
        if "Ke" in self.numbers and any(key.lower() == "map_ke" for key, _ in others):
            # Without its texture, which only MTL can name, the whole surface would glow.
            del self.numbers["Ke"]
            self.unsupported.append("Ke")
        return Material(
            name, self.color, color, others, self.repeats, uv_map=self.uv_map, clamp=self.clamp,
            numbers=tuple(self.numbers.items()), unsupported=tuple(dict.fromkeys(self.unsupported)),
        )  # fmt: skip

    def add_texture(self, key: str, value: str) -> None:
        """Add a texture statement: a texture shows `-s` times UV plus `-o`."""
        name, options = _split_options(value)
        if not name:
            return
        u, v = _parse_floats(options.get("-s", []), 2)
        self.maps[key] = name
        self.repeats = max(self.repeats[0], abs(u)), max(self.repeats[1], abs(v))
        if key.lower() == "map_kd":
            du, dv = _parse_floats(options.get("-o", []), 2, missing=0.0)
            self.uv_map = UvMap(0, (u, 0.0, du, 0.0, v, dv))
            self.clamp = options.get("-clamp") == ["on"]

    def add_statement(self, key: str, words: list[str]) -> None:
        """Add any other statement, unless it states a default: zeros, or the usual `illum`."""
        numeric = all(map(_is_number, words))
        if key in _NUMBERS and len(words) == _NUMBERS[key] and numeric:
            self.numbers[key] = tuple(map(float, words))
        elif words not in (["1"], ["2"]) if key == "illum" else not numeric or any(map(float, words)):
            self.unsupported.append(key)


def _read_drafts(text: str) -> dict[str, _Draft]:
    """Read the materials of a library."""
    drafts: dict[str, _Draft] = {}
    current = _Draft()
    for line in text.splitlines():
        key, _, value = line.strip().replace("\t", " ").partition(" ")
        value = value.strip()
        if key == "newmtl":
            current = drafts.setdefault(value, _Draft())
        elif key == "Kd":
            red, green, blue = _parse_floats(value.split(), 3)
            current.color = (red, green, blue, current.color[3] if current.color else 1.0)
        elif key in ("d", "Tr"):
            share = _parse_floats(value.split()[-1:], 1)[0]
            opaque = share if key == "d" else 1.0 - share
            current.color = (*(current.color or (1.0, 1.0, 1.0, 1.0))[:3], opaque)
        elif key.lower() in _MAPS and value:
            current.add_texture(key, value)
        elif key and not key.startswith("#"):
            current.add_statement(key, value.split())
    return drafts


def _split_options(value: str) -> tuple[str, dict[str, list[str]]]:
    """Split a texture statement into the file and the words of its options."""
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


def _parse_floats(words: list[str], count: int, *, missing: float = 1.0) -> list[float]:
    """Parse so many numbers, up to the first word that is none; `missing` stands for the rest."""
    found = []
    for word in words[:count]:
        if not _is_number(word):
            break
        found.append(float(word))
    return found + [missing] * (count - len(found))
