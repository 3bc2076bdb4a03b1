"""Any file to a scene."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import unquote

from ..errors import InputError
from ..model import Scene
from .folder import Folder
from .gltf.decode import unpacked
from .gltf.document import parse_gltf
from .gltf.read import gltf_meshes
from .loaded import read_loaded
from .obj import read_obj
from .off import read_off
from .ply import read_ply

OWN = ("obj", "ply", "off", "glb", "gltf")
"""Formats that bldsimp reads itself."""

SUFFIXES = (*OWN, "stl")
"""Formats that bldsimp reads and writes."""


def read(source: Path | bytes, format_: str) -> Scene:
    """Read a file.

    Parameters
    ----------
    source : Path or bytes
        Bytes where they come from a pipe; files beside it are then not found.
    format_ : str
        Suffix without the dot, in lower case.

    Returns
    -------
    Scene

    Raises
    ------
    InputError
        Where the file is missing, damaged, empty of faces, or holds what a surface cannot.
    """
    path = source if isinstance(source, Path) else None
    name = str(path) if path else "standard input"
    folder = Folder(path.parent if path else None)
    try:
        data = source if isinstance(source, bytes) else source.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{name}: no such file") from None
    except OSError as error:
        raise InputError(f"{name}: cannot be read: {error.strerror}") from None
    scene = Scene(path, format_, [], len(data))
    try:
        if not data.strip():
            raise InputError("the file is empty")
        _fill(scene, data, folder)
    except InputError as error:
        raise InputError(f"{name}: {error}") from error.__cause__
    scene.size += folder.size
    scene.beside = folder.names
    return scene


def _fill(scene: Scene, data: bytes, folder: Folder) -> None:
    """Read the meshes of a scene."""
    if scene.format in ("glb", "gltf"):
        try:
            scene.source = unpacked(parse_gltf(data, folder), scene.warnings)
            scene.meshes = gltf_meshes(scene.source, folder.picture, scene.warnings)
            # Also images that no material shows go into the result.
            for uri in (image.get("uri") for image in scene.source.items("images")):
                if isinstance(uri, str) and not uri.startswith("data:"):
                    folder.has(unquote(uri))
        except (AttributeError, IndexError, KeyError, OverflowError, TypeError, ValueError) as error:
            # JSON may hold anything anywhere; what the format does not foresee ends here.
            what = f"{type(error).__name__}: {error}"
            raise InputError(f"the glTF JSON is not as the format asks ({what}): the file is damaged") from error
        return
    scene.source = data
    data = data.removeprefix(b"\xef\xbb\xbf")
    if scene.format in ("obj", "off") and b"\n" not in data:
        data = data.replace(b"\r", b"\n")
    if scene.format == "obj":
        scene.meshes = read_obj(data, folder, scene.warnings)
    elif scene.format == "ply":
        scene.meshes = read_ply(data, folder, scene.warnings)
    elif scene.format == "off":
        scene.meshes = read_off(data, scene.warnings)
    else:
        scene.meshes = read_loaded(data, scene.format, scene.path, scene.warnings)
