"""Vertices that glTF primitives share, and what a mesh read from glTF remembers for the writer."""

from __future__ import annotations

from dataclasses import dataclass

from ..surface import Material


@dataclass(frozen=True)
class Rows:
    """Rows of a mesh that are the vertices of one or more primitives.

    Attributes
    ----------
    accessors : tuple of (str, int)
        Names of all their attributes, and the accessors that hold them.
    start, count : int
    """

    accessors: tuple[tuple[str, int], ...]
    start: int
    count: int

    @property
    def position(self) -> int:
        """The accessor of the positions."""
        return dict(self.accessors)["POSITION"]

    def accessor(self, name: str) -> int | None:
        """The accessor of an attribute, None where the rows have none."""
        return dict(self.accessors).get(name)


@dataclass
class Primitive:
    """`Part.source` of a part read from glTF."""

    index: int
    rows: Rows
    material: Material | None


@dataclass
class GltfMesh:
    """`Mesh.source` of a mesh read from glTF."""

    index: int
    rows: list[Rows]
