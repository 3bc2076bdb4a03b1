"""OBJ material libraries: the colour and the texture of each material, read and written."""

from __future__ import annotations

from collections.abc import Callable

from .surface import Material


def read_materials(libraries: list[str], beside: Callable[[str], bytes | None]) -> dict[str, Material]:
    """Materials by name; a library that is missing has none."""
    materials: dict[str, Material] = {}
    for library in libraries:
        data = beside(library)
        if data is not None:
            _read_library(data.decode("utf-8", "surrogateescape"), materials)
    return materials


def _read_library(text: str, materials: dict[str, Material]) -> None:
    current = Material("")
    for line in text.splitlines():
        key, _, value = line.strip().partition(" ")
        value = value.strip()
        if key == "newmtl":
            current = materials.setdefault(value, Material(value))
        elif key == "Kd":
            red, green, blue = _floats(value, 3)
            current.color = (red, green, blue, current.color[3] if current.color else 1.0)
        elif key == "d":
            current.color = (*(current.color or (1.0, 1.0, 1.0, 1.0))[:3], _floats(value, 1)[0])
        elif key == "map_Kd":
            current.texture = value.split()[-1] if value.startswith("-") else value


def _floats(text: str, count: int) -> list[float]:
    """The first numbers of a text; 1 where it has fewer."""
    found = []
    for word in text.split()[:count]:
        try:
            found.append(float(word))
        except ValueError:
            break
    return found + [1.0] * (count - len(found))


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
    return "\n".join([*lines, ""])
