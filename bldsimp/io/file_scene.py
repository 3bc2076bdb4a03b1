"""Define a scene that remembers the file it was read from."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..model import Scene
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
