"""Lay out the files of a glTF document: JSON, buffer and images, inside one file or next to each other."""

from __future__ import annotations

import base64
import os
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote, unquote

from ..input_folder import InputFolder
from ..textures import find_media_type
from .buffers import pack_views
from .document import Document, Json, load_uri, pack_glb, write_json


@dataclass
class Placement:
    """Where a document comes from and where it goes.

    Attributes
    ----------
    source : Path or None
        None for standard input.
    main : Path
        The file to write.
    format : str
        ``glb`` or ``gltf``.
    """

    source: Path | None
    main: Path
    format: str


def pack_document(
    json_: Json, binary: bytes, document: Document | None, place: Placement, *, embed: bool, compact: bool
) -> dict[Path, bytes]:
    """Pack a document and its buffer into files.

    Parameters
    ----------
    json_ : dict
        Changed in place.
    binary : bytes
        Data of the buffer without a URI.
    document : Document or None
        The document that it was patched from.
    place : Placement
    embed : bool
        Put the buffer of text glTF into the file.
    compact : bool
        Write text glTF on one line.
    """
    if place.format == "glb":
        return {place.main: pack_glb(json_, binary, document.chunks if document else [])}
    files = {}
    for number, entry in enumerate(json_.get("buffers", [])):
        if "uri" in entry:
            continue
        if embed:
            uri = "data:application/octet-stream;base64," + base64.b64encode(binary).decode()
        else:
            name = _name_buffer(json_, document, place)
            uri, files[place.main.with_name(name)] = quote(name), binary
        json_["buffers"][number] = {"uri": uri, **entry}
    return {**files, place.main: write_json(json_, compact)}


def _name_buffer(json_: Json, document: Document | None, place: Placement) -> str:
    """Name the buffer's file: as before if the document is written over itself, else as no file that must stay."""
    name, source, main = place.main.stem + ".bin", place.source, place.main
    if document is None:
        return name
    before, kept = _list_files(document.json), _list_files(json_)
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


def copy_files(json_: Json, place: Placement, warnings: list[str]) -> dict[Path, bytes]:
    """Copy the images and buffers that a document names to the folder that it moves to.

    Each keeps its name and its folder there. A reference out of the folder is made relative to the new one instead.
    """
    source, target = place.source and place.source.parent, place.main.parent
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


def embed_images(json_: Json, binary: bytes, place: Placement, warnings: list[str]) -> bytes:
    """Put the images next to a document into it; return the new buffer."""
    folder = InputFolder(place.source and place.source.parent)
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
        if place.format == "gltf":
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
