"""Lay out the files of a glTF document: JSON, buffer and images, inside one file or next to each other."""

from __future__ import annotations

import base64
import os
from pathlib import Path
from urllib.parse import quote, unquote

from ..file_scene import FileScene
from ..input_folder import InputFolder
from ..textures import find_media_type
from .buffers import pack_views
from .document import Json, load_uri, pack_glb, write_json


def pack_document(
    json_: Json, binary: bytes, scene: FileScene, main: Path, format_: str, *, embed: bool
) -> dict[Path, bytes]:
    """Pack a document and its buffer into files.

    Parameters
    ----------
    json_ : dict
        Changed in place.
    binary : bytes
        Data of the buffer without a URI.
    scene : FileScene
        As it was read; the document was patched from its document, if it has one.
    main : Path
        The file to write.
    format_ : str
        ``glb`` or ``gltf``; text is on one line where it was.
    embed : bool
        Put the buffer of text glTF into the file.
    """
    if format_ == "glb":
        return {main: pack_glb(json_, binary, scene.document.chunks if scene.document else [])}
    files = {}
    for number, entry in enumerate(json_.get("buffers", [])):
        if "uri" in entry:
            continue
        if embed:
            uri = "data:application/octet-stream;base64," + base64.b64encode(binary).decode()
        else:
            name = _name_buffer(json_, scene, main)
            uri, files[main.with_name(name)] = quote(name), binary
        json_["buffers"][number] = {"uri": uri, **entry}
    compact = scene.document is not None and scene.data[:4] != b"glTF" and b"\n" not in scene.data.strip()
    return {**files, main: write_json(json_, compact)}


def _name_buffer(json_: Json, scene: FileScene, main: Path) -> str:
    """Name the buffer's file: as before if the document is written over itself, else as no file that must stay."""
    name, source = main.stem + ".bin", scene.path
    if scene.document is None:
        return name
    before, kept = _list_files(scene.document.json), _list_files(json_)
    taken = {(main.parent / one).resolve() for one in kept}
    if source is not None and source.resolve() == main.resolve():
        gone = [one for one in before if one not in kept]
        if len(gone) == 1 and "/" not in gone[0]:
            return gone[0]
    elif source is not None:
        # The input must still be whole afterwards.
        taken |= {(source.parent / one).resolve() for one in before}
    while main.with_name(name).resolve() in taken:
        name = f"light_{name}"
    return name


def _list_files(json_: Json) -> list[str]:
    """List the files of a document's buffers and images."""
    uris = [str(entry.get("uri", "")) for key in ("buffers", "images") for entry in json_.get(key, [])]
    return [unquote(uri) for uri in uris if uri and not uri.startswith("data:")]


def copy_files(json_: Json, source: Path | None, target: Path, warnings: list[str]) -> dict[Path, bytes]:
    """Copy the images and buffers that a document names from its folder to the one that it moves to.

    Each keeps its name and its folder there. A reference out of the folder is made relative to the new one instead.
    """
    if source is None or source.resolve() == target.resolve():
        return {}
    folder = InputFolder(source)
    found: dict[Path, bytes] = {}
    for kind in ("image", "buffer"):
        for entry in json_.get(f"{kind}s", []):
            uri = entry.get("uri", "")
            if not uri or uri.startswith("data:") or "://" in uri:
                continue
            name = Path(unquote(uri).replace("\\", "/"))
            if name.is_absolute() or ".." in name.parts:
                entry["uri"] = quote(Path(os.path.relpath(source / name, target)).as_posix())
                continue
            data = folder.load_image(unquote(uri))
            if data is None:
                warnings.append(_describe_missing(kind, uri))
            else:
                found[target / name] = data
    return found


def embed_images(json_: Json, binary: bytes, source: Path | None, format_: str, warnings: list[str]) -> bytes:
    """Put the images of a document's folder into it; return the new buffer."""
    folder = InputFolder(source)
    extra: list[tuple[Json, bytes]] = []
    for image in json_.get("images", []):
        uri = image.get("uri", "")
        if not uri or "://" in uri:
            continue
        data = load_uri(uri, folder.load_image)
        if data is None:
            # Reading warned of a data URI that cannot be decoded.
            warnings += [] if uri.startswith("data:") else [_describe_missing("image", uri)]
            continue
        media = image.get("mimeType", find_media_type(data))
        if format_ == "gltf":
            image["uri"] = f"data:{media};base64," + base64.b64encode(data).decode()
            continue
        del image["uri"]
        image["mimeType"] = media
        views = json_.setdefault("bufferViews", [])
        image["bufferView"] = len(views)
        views.append({})
        extra.append((views[-1], data))
    if not extra:
        return binary
    start = len(binary) + -len(binary) % 8
    joined = binary.ljust(start, b"\0") + pack_views(extra)
    for view, _ in extra:
        view["byteOffset"] += start
    json_.setdefault("buffers", [{}])[0]["byteLength"] = len(joined)
    return joined


def _describe_missing(kind: str, uri: str) -> str:
    return f"the {kind} '{unquote(uri)[:80]}' is not a file beneath the input's folder"
