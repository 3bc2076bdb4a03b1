"""Write a scene and its results to any file."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import BinaryIO

from ..errors import OutputError, UsageError
from ..model import SimplifiedMesh
from ..options import AUTO_DIAGONAL, Options
from ..tolerance import measure_diagonal, measure_epsilon
from .atomic import replace_files, write_stream
from .file_scene import FileScene, Written
from .flat_mesh import FlatMesh, apply_uv_maps, flatten_result, has_same_surface, place_instance, spread_face_values
from .gltf.build import build_document
from .gltf.check import check_document
from .gltf.patch import patch_document
from .gltf.write import copy_files, embed_images, pack_document
from .obj import make_states, write_obj
from .off import write_off
from .ply import PlyStyle, write_ply
from .sidecars import Sidecars
from .single_precision import count_after_rounding, count_merged_points, measure_rounding
from .stl import write_stl
from .warnings import list_gltf_losses, list_hidden_values, list_losses, list_removed_attributes

WRITABLE = ("glb", "gltf", "obj", "ply", "off", "stl")
"""Formats that bldsimp writes."""

_PIPE = Path("-")


def write(
    scene: FileScene,
    results: list[SimplifiedMesh],
    target: Path | BinaryIO,
    format_: str,
    options: Options,
    *,
    overwrite: bool = True,
) -> Written:
    """Write a result.

    Parameters
    ----------
    scene : FileScene
        As it was read.
    results : list of SimplifiedMesh
        One per mesh of the scene.
    target : Path or binary stream
        A file appears whole or not at all.
    format_ : str
        One of `WRITABLE`.
    options : Options
        `normals`, `crease_angle` and `delimit`.
    overwrite : bool
        Whether to replace files next to the target that differ.

    Raises
    ------
    OutputError
        If nothing is left, the format cannot store the coordinates, or a file cannot be written.
    """
    if format_ not in WRITABLE:
        raise UsageError(f"'{format_}' cannot be written: choose one of {', '.join(WRITABLE)}")
    if not any(len(result.faces) for result in results):
        raise OutputError("nothing is left to write: the input has no area")
    output = _Output(scene, results, target if isinstance(target, Path) else _PIPE, format_, options)
    files, written = output.make_files(), output.written
    if not isinstance(target, Path):
        write_stream(target, files.pop(_PIPE))
        written.warnings += [f"'{extra.name}' cannot be written to a pipe" for extra in files]
        return written
    _replace_differing(files, target, overwrite)
    return written


def _replace_differing(files: dict[Path, bytes], main: Path, overwrite: bool) -> None:
    """Replace files that differ, in folders that are made for them."""
    fresh = {}
    for path, data in files.items():
        if path == main or not path.exists() or path.read_bytes() != data:
            if path != main and path.exists() and not overwrite:
                raise OutputError(f"{path}: exists and differs: give --overwrite to replace it")
            fresh[path] = data
    for path in fresh:
        if main.parent.is_dir() and path != main:
            try:
                path.parent.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise OutputError(f"{path.parent}: cannot be made: {error.strerror}") from None
    replace_files(fresh)


@dataclass
class _Output:
    """A result on its way to files."""

    scene: FileScene
    results: list[SimplifiedMesh]
    main: Path
    format: str
    options: Options
    written: Written = field(default_factory=Written)

    def make_files(self) -> dict[Path, bytes]:
        """Return the contents of all files to write, the main one last."""
        scene, written = self.scene, self.written
        written.warnings += list_removed_attributes(scene, self.options)
        written.warnings += list_hidden_values(scene, self.options, self.format)
        if self.format in ("glb", "gltf"):
            return self._make_gltf()
        instances = [
            [place_instance(flatten_result(mesh, result, self.options), transform) for transform in mesh.transforms]
            for mesh, result in zip(scene.meshes, self.results, strict=True)
            if len(result.faces) and len(mesh.transforms)
        ]
        meshes = [one for placed in instances for one in placed]
        if self.format == "obj":
            return self._make_obj(meshes)
        written.warnings += list_losses(scene, meshes, self.format)
        files: dict[Path, bytes] = {}
        if self.format == "ply":
            sidecars = Sidecars(scene, self.main, written.warnings)
            meshes = [apply_uv_maps(one) for one in meshes]
            textures, files = sidecars.add_color_textures(meshes), sidecars.files
            data, written.vertices = write_ply(meshes, self._choose_ply_style(meshes), textures)
        elif self.format == "off":
            data, written.vertices = write_off(meshes, scene.off)
        else:
            written.rounding = max(measure_rounding(one.points) for one in meshes)
            written.merged_points = sum(count_merged_points(one.points) for one in meshes)
            if written.merged_points:
                stored = [[(one.points, one.faces) for one in placed] for placed in instances]
                written.after = count_after_rounding(stored)
            self._warn_of_rounding("STL")
            data, written.vertices = write_stl(meshes)
        written.bytes = len(data)
        return {**files, self.main: data}

    def _make_gltf(self) -> dict[Path, bytes]:
        """Patch or build a document, with its buffer and images inside or next to it."""
        scene, written, document = self.scene, self.written, self.scene.document
        folder, piped = scene.path and scene.path.parent, self.main == _PIPE
        files: dict[Path, bytes] = {}
        if document is None:
            images = Sidecars(scene, self.main, written.warnings).load_textures()
            json_, binary = build_document(scene, self.results, self.options, images, written)
            self._warn_of_rounding("glTF")
            written.warnings += list_gltf_losses(scene)
        else:
            inside = piped or (self.format == "glb" and scene.format == "gltf")
            check_document(document)
            json_, binary, written.vertices = patch_document(
                document, scene, self.results, self.options, written.warnings, whole=inside, first=self.format == "glb"
            )
            if inside:
                binary = embed_images(json_, binary, folder, self.format, written.warnings)
            else:
                files = copy_files(json_, folder, self.main.parent, written.warnings)
        uris = [(str(entry.get("uri", "data:")), entry) for entry in json_.get("buffers", [])]
        written.bytes = sum(entry.get("byteLength", 0) for uri, entry in uris if not uri.startswith("data:"))
        same_format = self.format == scene.format and document is not None and not document.decoded
        if document is not None and same_format and json_ == document.json and binary == document.join_own_buffers():
            written.bytes += len(scene.data)
            return {**files, self.main: scene.data}
        if document is not None and document.chunks and self.format == "gltf":
            written.warnings.append("text glTF cannot store the GLB file's chunks other than JSON and BIN: lost")
        embed = piped or (document is not None and document.embedded)
        packed = pack_document(json_, binary, scene, self.main, self.format, embed=embed)
        written.bytes += sum(map(len, packed.values()))
        return {**files, **packed}

    def _make_obj(self, meshes: list[FlatMesh]) -> dict[Path, bytes]:
        """Write an OBJ file, and the material library and textures next to it."""
        scene, written = self.scene, self.written
        sidecars = Sidecars(scene, self.main, written.warnings)
        if scene.format == "obj":
            # The file's own library comes along as it is, and maps UV itself.
            libraries, states = sidecars.copy_libraries(), [scene.obj.states] * len(meshes)
        else:
            meshes = [apply_uv_maps(one) for one in meshes]
            libraries, names = sidecars.add_library(meshes)
            states = [make_states(one, names) for one in meshes]
        meshes = [spread_face_values(one) for one in meshes]
        data, written.vertices = write_obj(meshes, states, libraries, scene.obj.color_scale)
        written.warnings += list_losses(scene, meshes, "obj")
        if self._is_better_as_read(len(data)):
            data = scene.data
        # Images do not count.
        copied = [library for path, library in sidecars.files.items() if path.suffix == ".mtl"]
        written.bytes = len(data) + sum(map(len, copied))
        return {**sidecars.files, self.main: data}

    def _is_better_as_read(self, size: int) -> bool:
        """Tell whether an OBJ file is no simpler, and its new text of this size no smaller.

        Not if reading ignored anything, or if the user asks for other normals or fewer attributes.
        """
        scene, options = self.scene, self.options
        if scene.format != "obj" or len(scene.data) > size or scene.warnings or options.normals != "auto":
            return False
        mesh = scene.meshes[0]
        return not list_removed_attributes(scene, options) and has_same_surface(
            mesh, self.results[0], list(range(len(mesh.parts)))
        )

    def _choose_ply_style(self, meshes: list[FlatMesh]) -> PlyStyle:
        """Choose single precision, unless that moves a point by more than epsilon or onto another; else as read."""
        style = self.scene.ply
        if style.double or style.encoding == "ascii":
            return style
        moved = max(measure_rounding(one.points) for one in meshes)
        double = moved > measure_epsilon(self.scene) or any(count_merged_points(one.points) for one in meshes if moved)
        self.written.rounding = 0.0 if double else moved
        return replace(style, double=double)

    def _warn_of_rounding(self, format_name: str) -> None:
        """Describe how single precision changed the points, if it did so more than the file's own numbers do."""
        written, after = self.written, self.written.after
        if not math.isfinite(written.rounding):
            raise OutputError(f"the coordinates are too large for {format_name}: write PLY, OBJ or OFF")
        if after is not None:
            written.warnings.append(
                f"the single precision of {format_name} merged {written.merged_points:,} points: {after.points:,} are"
                f" left, with {after.open_edges:,} open and {after.nonmanifold_edges:,} non-manifold edges"
            )
        if written.rounding > max(measure_epsilon(self.scene), AUTO_DIAGONAL * measure_diagonal(self.scene)):
            written.warnings.append(
                f"{format_name} stores single precision: points moved by up to {written.rounding:.3g};"
                " PLY, OBJ and OFF keep such coordinates"
            )
