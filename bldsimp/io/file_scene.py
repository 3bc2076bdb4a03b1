"""Define a scene that remembers the file it was read from, and the figures of a file that is written."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..model import Scene
from ..report import Counts
from .gltf.document import Document
from .obj import ObjStyle
from .off import OffStyle
from .ply import PlyStyle


@dataclass
class FileScene(Scene):
    """A scene, and the properties of its file that a result in the same format keeps.

    Attributes
    ----------
    data : bytes
        The file itself.
    obj : ObjStyle
    ply : PlyStyle
    off : OffStyle
        Defaults, unless the file is of that format.
    document : Document or None
        The glTF document, if it is one.
    """

    data: bytes = b""
    obj: ObjStyle = field(default_factory=ObjStyle)
    ply: PlyStyle = field(default_factory=PlyStyle)
    off: OffStyle = field(default_factory=OffStyle)
    document: Document | None = None


@dataclass
class Written:
    """Figures of what was written.

    Attributes
    ----------
    bytes : int
        Of the file, and of buffers and material libraries next to it; images do not count.
    vertices : int
        Distinct positions with normal and attributes.
    rounding : float
        Greatest distance by which storing moved a point, model units in world space; infinite if one is out of range.
    merged_points : int
        Points that are no longer distinct.
    after : Counts or None
        Counts of what is stored, if there are merged points.
    warnings : list of str
    """

    bytes: int = 0
    vertices: int = 0
    rounding: float = 0.0
    merged_points: int = 0
    after: Counts | None = None
    warnings: list[str] = field(default_factory=list)
