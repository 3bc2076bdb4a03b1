"""A scene and what became of its meshes, to any file."""

from __future__ import annotations

import base64
import dataclasses
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO
from urllib.parse import quote, unquote

from ..errors import OutputError, UsageError
from ..model import Scene, SimplifiedMesh
from ..options import AUTO_DIAGONAL, Options
from ..report import Counts
from ..tolerance import diagonal, epsilon
from .atomic import replace_files
from .flat_mesh import Sheet, as_shown, instance, sheet, spread
from .gltf.build import new_document
from .gltf.check import check_rest
from .gltf.document import Document, gltf_text, pack_glb
from .gltf.patch import patched
from .mtl import material_library
from .obj import ObjFormat
from .obj_write import obj_text
from .off import OffFormat
from .plain_write import off_text, ply_bytes, stl_bytes
from .ply import PlyFormat
from .rounding import counts_in_single, fallen_together, single_rounding
from .sidecars import Pictured, copies, embedded_images
from .unchanged import is_better_as_read
from .warnings import dropped, gltf_losses, hidden, losses

WRITABLE = ("glb", "gltf", "obj", "ply", "off", "stl")
"""Formats that bldsimp writes."""


@dataclass
class Written:
    """What writing did.

    Attributes
    ----------
    bytes : int
        Of the file, and of buffers and material libraries beside it.
    vertices : int
        Distinct positions with normal and attributes.
    rounding : float
        Greatest distance by which a point moved, model units in world space.
    after : Counts or None
        Of what is stored, where points fell together on writing; None where they did not.
    warnings : list of str
    """

    bytes: int = 0
    vertices: int = 0
    rounding: float = 0.0
    after: Counts | None = None
    warnings: list[str] = field(default_factory=list)


def write(
    scene: Scene,
    lights: list[SimplifiedMesh],
    target: Path | BinaryIO,
    format_: str,
    options: Options,
    *,
    overwrite: bool = True,
) -> Written:
    """Write a result.

    Parameters
    ----------
    scene : Scene
        As it was read.
    lights : list of SimplifiedMesh
        One per mesh of the scene.
    target : Path or binary stream
        A file appears whole or not at all.
    format_ : str
        One of `WRITABLE`.
    options : Options
        `normals`, `crease_angle` and `delimit`.
    overwrite : bool
        Whether files beside the target that differ may be replaced.

    Raises
    ------
    OutputError
    """
    if format_ not in WRITABLE:
        raise UsageError(f"'{format_}' cannot be written: choose one of {', '.join(WRITABLE)}")
    path = target if isinstance(target, Path) else None
    written = Written()
    if not any(len(light.faces) for light in lights):
        raise OutputError("nothing is left to write: the input has no area")
    files = _files(scene, lights, path, format_, options, written)
    main = Path("-") if path is None else path
    if path is None:
        assert not isinstance(target, Path)
        _to_stream(target, files.pop(main))
        written.warnings += [f"'{extra.name}' is not written to a pipe" for extra in files]
        return written
    fresh = {extra: data for extra, data in files.items() if extra == main or _differs(extra, data)}
    for extra in fresh:
        if extra != main and extra.exists() and not overwrite:
            raise OutputError(f"{extra}: exists and differs: give --overwrite to replace it")
    try:
        for extra in fresh:
            if main.parent.is_dir() and extra != main:
                extra.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{extra.parent}: cannot be made: {error.strerror}") from None
    replace_files(fresh)
    return written


def _files(
    scene: Scene, lights: list[SimplifiedMesh], path: Path | None, format_: str, options: Options, written: Written
) -> dict[Path, bytes]:
    """Every file to write, the main one last."""
    written.warnings += dropped(scene, options) + hidden(scene, options, format_)
    main = Path("-") if path is None else path
    if format_ in ("glb", "gltf"):
        return _gltf_files(scene, lights, main, format_, options, written)
    instances = [
        [instance(sheet(mesh, light, options), transform) for transform in mesh.transforms]
        for mesh, light in zip(scene.meshes, lights, strict=True)
        if len(light.faces) and len(mesh.transforms)
    ]
    sheets = [one for placed in instances for one in placed]
    if format_ == "obj":
        files = _obj_files(scene, sheets, main, written)
        if is_better_as_read(scene, lights, options, len(files[main])):
            written.bytes += len(scene.source) - len(files[main])
            files[main] = scene.source
        return files
    written.warnings += losses(scene, sheets, format_)
    if format_ == "ply":
        pictured = Pictured(scene, main, written.warnings)
        sheets = [as_shown(one) for one in sheets]
        textures = pictured.textures(sheets)
        data, written.vertices = ply_bytes(sheets, _ply_format(scene, sheets, written), textures)
        written.bytes = len(data)
        return {**pictured.files, main: data}
    if format_ == "off":
        source = scene.meshes[0].source
        data, written.vertices = off_text(sheets, source if isinstance(source, OffFormat) else None)
    else:
        written.rounding = max(single_rounding(one.points) for one in sheets)
        fallen = sum(fallen_together(one.points) for one in sheets)
        if fallen:
            written.after = counts_in_single(
                [[(one.points, one.faces, None) for one in placed] for placed in instances]
            )
        _warn_of_rounding(scene, "STL", fallen, written)
        data, written.vertices = stl_bytes(sheets)
    written.bytes = len(data)
    return {main: data}


def _gltf_files(
    scene: Scene, lights: list[SimplifiedMesh], main: Path, format_: str, options: Options, written: Written
) -> dict[Path, bytes]:
    """A document, and its buffer and images where they stand beside it."""
    piped = main == Path("-")
    beside: dict[Path, bytes] = {}
    chunks: list[tuple[int, bytes]] = []
    embedded = piped
    if isinstance(scene.source, Document):
        inside = piped or (format_ == "glb" and scene.format == "gltf")
        check_rest(scene.source)
        json_, binary, written.vertices = patched(
            scene, lights, options, written.warnings, whole=inside, first=format_ == "glb"
        )
        chunks = scene.source.chunks
        embedded |= scene.source.embedded
        if inside:
            binary = embedded_images(json_, binary, scene.path, format_, written.warnings)
        else:
            beside = copies(json_, scene.path, main, written.warnings)
    else:
        images = Pictured(scene, main, written.warnings).inside()
        json_, binary, made = new_document(scene, lights, options, images)
        written.vertices, written.rounding, written.after = made.vertices, made.rounding, made.after
        _warn_of_rounding(scene, "glTF", made.fallen, written)
        written.warnings += gltf_losses(scene)
    # Pictures beside the document count neither before nor after.
    others = [entry for entry in json_.get("buffers", []) if "uri" in entry and not _is_inside(entry)]
    stays = sum(entry.get("byteLength", 0) for entry in others)
    if isinstance(scene.source, Document) and format_ == scene.format and scene.source.is_same(json_, binary):
        written.bytes = len(scene.source.data) + stays
        return {**beside, main: scene.source.data}
    if format_ == "glb":
        data = pack_glb(json_, binary, chunks)
        written.bytes = len(data) + stays
        return {**beside, main: data}
    if chunks:
        written.warnings.append("chunks of the GLB file beside JSON and BIN have no place in text glTF")
    for number, entry in enumerate(json_.get("buffers", [])):
        if "uri" in entry:
            continue
        name = _buffer_name(scene, main, json_)
        uri = "data:application/octet-stream;base64," + base64.b64encode(binary).decode() if embedded else quote(name)
        json_["buffers"][number] = {"uri": uri, **entry}
        if not embedded:
            beside[main.with_name(name)] = binary
    data = gltf_text(json_, compact=isinstance(scene.source, Document) and scene.source.is_compact)
    written.bytes = len(data) + stays + (0 if embedded else len(binary))
    return {**beside, main: data}


def _is_inside(buffer: dict[str, Any]) -> bool:
    return str(buffer["uri"]).startswith("data:")


def _buffer_name(scene: Scene, main: Path, json_: dict[str, Any]) -> str:
    """The buffer's file: the source's own where the document is written over itself, else one that is not there yet."""
    own = main.stem + ".bin"
    if not isinstance(scene.source, Document):
        return own
    before, kept = _beside(scene.source.json), _beside(json_)
    taken = {(main.parent / name).resolve() for name in kept}
    if scene.path is not None and scene.path.resolve() == main.resolve():
        gone = [name for name in before if name not in kept]
        if len(gone) == 1 and "/" not in gone[0]:
            return gone[0]
    elif scene.path is not None:
        # The input must still be whole afterwards.
        taken |= {(scene.path.parent / name).resolve() for name in before}
    while main.with_name(own).resolve() in taken:
        own = f"light_{own}"
    return own


def _beside(json_: dict[str, Any]) -> list[str]:
    """Files of a document's buffers and images."""
    uris = [str(entry.get("uri", "")) for key in ("buffers", "images") for entry in json_.get(key, [])]
    return [unquote(uri) for uri in uris if uri and not uri.startswith("data:")]


def _obj_files(scene: Scene, sheets: list[Sheet], main: Path, written: Written) -> dict[Path, bytes]:
    """An OBJ file, and the material library and textures beside it."""
    pictured = Pictured(scene, main, written.warnings)
    stored = scene.meshes[0].source
    color_scale = stored.color_scale if isinstance(stored, ObjFormat) else 1.0
    # The library of an OBJ file comes along as it is, and maps UV itself.
    sheets = [spread(one if isinstance(stored, ObjFormat) else as_shown(one)) for one in sheets]
    data, written.vertices = obj_text(sheets, *pictured.libraries(sheets, material_library), color_scale)
    written.warnings += losses(scene, sheets, "obj")
    # Pictures count neither before nor after.
    libraries = [library for path, library in pictured.files.items() if path.suffix == ".mtl"]
    written.bytes = len(data) + sum(map(len, libraries))
    return {**pictured.files, main: data}


def _ply_format(scene: Scene, sheets: list[Sheet], written: Written) -> PlyFormat:
    """Single unless that moves a point by more than epsilon, or onto another; from PLY as the source has it."""
    stored = scene.meshes[0].source
    format_ = stored if isinstance(stored, PlyFormat) else PlyFormat("binary_little_endian", False)
    if format_.double or format_.encoding == "ascii":
        return format_
    moved = max(single_rounding(one.points) for one in sheets)
    double = moved > epsilon(scene) or any(fallen_together(one.points) for one in sheets if moved)
    written.rounding = 0.0 if double else moved
    return dataclasses.replace(format_, double=double)


def _warn_of_rounding(scene: Scene, format_: str, fallen: int, written: Written) -> None:
    """Say what single precision did to the points, where that is more than the file's own numbers do."""
    if not math.isfinite(written.rounding):
        raise OutputError(f"the coordinates are too large for {format_}: write PLY, OBJ or OFF")
    if written.after is not None:
        written.warnings.append(
            f"{fallen:,} points fell together in the single precision of {format_}: {written.after.points:,} are"
            f" left, with {written.after.open_edges:,} open and {written.after.nonmanifold_edges:,}"
            " non-manifold edges"
        )
    if written.rounding > max(epsilon(scene), AUTO_DIAGONAL * diagonal(scene)):
        written.warnings.append(
            f"{format_} stores single precision: points moved by up to {written.rounding:.3g};"
            " PLY, OBJ and OFF keep such coordinates"
        )


def _differs(path: Path, data: bytes) -> bool:
    """Whether a file is not there, or holds something else."""
    try:
        return path.read_bytes() != data
    except FileNotFoundError:
        return True


def _to_stream(stream: BinaryIO, data: bytes) -> None:
    """Write all of it: an unbuffered pipe takes only as much as it has room for."""
    rest = memoryview(data)
    try:
        while len(rest):
            rest = rest[stream.write(rest) :]
        stream.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OutputError(f"standard output cannot be written: {error.strerror}") from None
