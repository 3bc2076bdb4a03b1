"""Read any file into a scene."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import unquote

from ..errors import InputError
from .file_scene import FileScene
from .gltf.decode import decode_document
from .gltf.document import parse_gltf
from .gltf.read import read_meshes
from .input_folder import InputFolder
from .obj import read_obj
from .off import read_off
from .ply import read_ply
from .trimesh_reader import read_by_trimesh

SUFFIXES = ("obj", "ply", "off", "glb", "gltf", "stl")
"""Formats that bldsimp reads and writes."""


def read(source: Path | bytes, format_: str) -> FileScene:
    """Read a file.

    Parameters
    ----------
    source : Path or bytes
        Bytes, if they come from a pipe; files next to it are then not found.
    format_ : str
        Suffix without the dot, in lower case.

    Returns
    -------
    FileScene

    Raises
    ------
    InputError
        If the file is missing, damaged, without faces, or contains data that no surface can have.
    """
    path = source if isinstance(source, Path) else None
    name = str(path) if path else "standard input"
    folder = InputFolder(path.parent if path else None)
    try:
        data = source if isinstance(source, bytes) else source.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{name}: no such file") from None
    except OSError as error:
        raise InputError(f"{name}: cannot be read: {error.strerror}") from None
    scene = FileScene(path, format_, [], len(data), data=data)
    try:
        if not data.strip():
            raise InputError("the file is empty")
        if format_ in ("glb", "gltf"):
            _read_gltf(scene, folder)
        else:
            _read_plain_file(scene, folder)
    except InputError as error:
        raise InputError(f"{name}: {error}") from error.__cause__
    scene.size += folder.size
    scene.beside = folder.names
    return scene


def _read_gltf(scene: FileScene, folder: InputFolder) -> None:
    """Read the meshes of a glTF document."""
    try:
        scene.document = decode_document(parse_gltf(scene.data, folder.load), scene.warnings)
        scene.meshes = read_meshes(scene.document, folder.load_image, scene.warnings)
        # The result gets the images that no material shows, too.
        for uri in (image.get("uri") for image in scene.document.items("images")):
            if isinstance(uri, str) and not uri.startswith("data:"):
                folder.has(unquote(uri))
    except (AttributeError, IndexError, KeyError, OverflowError, TypeError, ValueError) as error:
        # JSON may hold anything anywhere; all that the format does not foresee ends here.
        cause = f"{type(error).__name__}: {error}"
        raise InputError(f"the glTF JSON does not follow the format ({cause}): the file is damaged") from error


def _read_plain_file(scene: FileScene, folder: InputFolder) -> None:
    """Read the meshes of a file of any other format."""
    data, warnings = scene.data.removeprefix(b"\xef\xbb\xbf"), scene.warnings
    if scene.format in ("obj", "off") and b"\n" not in data:
        data = data.replace(b"\r", b"\n")
    if scene.format == "obj":
        mesh, scene.obj = read_obj(data, folder, warnings)
    elif scene.format == "ply":
        mesh, scene.ply = read_ply(data, folder, warnings)
    elif scene.format == "off":
        mesh, scene.off = read_off(data, warnings)
    else:
        scene.meshes = read_by_trimesh(data, scene.format, scene.path, warnings)
        return
    scene.meshes = [mesh]
