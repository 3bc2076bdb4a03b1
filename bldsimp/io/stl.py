"""Check and write STL files; `trimesh_reader` reads them."""

from __future__ import annotations

import numpy as np

from ..errors import InputError
from ..model import FACE
from .flat_mesh import FlatMesh, join_flat_meshes, scale_to_unit

STL_BYTES = FACE + "_stl"
"""Attribute of the two bytes that an STL file stores after each face."""

_HEADER, _FACE = 84, 50
"""Bytes of the header with the number of faces, and of each face."""

_FACET = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("bytes", "<u2")])


def check_stl(data: bytes, warnings: list[str]) -> bytes:
    """Return the part of an STL file, binary or text, that contains its faces.

    trimesh, which reads it, would take a binary file of another length for text.

    Raises
    ------
    InputError
        If the file ends before the faces that it begins or promises.
    """
    head = data[: 10 * _HEADER].lstrip().lower()
    if head.startswith(b"solid") and (b"facet" in head or b"endsolid" in head):
        _check_text(data.lower())
        return data
    if len(data) < _HEADER:
        raise InputError("the STL file ends within its header: it is truncated, or no STL")
    promised, fit = int.from_bytes(data[_HEADER - 4 : _HEADER], "little"), (len(data) - _HEADER) // _FACE
    if promised > fit:
        raise InputError(
            f"the STL file's header promises {promised:,} faces, and {fit:,} fit in its {len(data):,} bytes:"
            " it is truncated, or no STL"
        )
    if not promised and fit:
        raise InputError(f"the STL file's header promises no face, though {fit:,} would fit: the file is damaged")
    end = _HEADER + _FACE * promised
    if end < len(data):
        warnings.append(f"ignored {len(data) - end:,} bytes after the {promised:,} faces of the STL file")
    return data[:end]


def _check_text(lower: bytes) -> None:
    """Refuse a text that ends within a face."""
    before, _, rest = lower.rpartition(b"endfacet")
    words = rest.split()
    cut = words and words[0] not in (b"endsolid", b"solid") if before else b"facet" in words
    if cut:
        whole = lower.count(b"endfacet")
        raise InputError(f"the STL text ends within a face, after {whole:,} whole ones: it is truncated")


def write_stl(meshes: list[FlatMesh]) -> tuple[bytes, int]:
    """Write meshes as a binary STL file; return also the number of its vertices, three for each triangle."""
    flat = join_flat_meshes(meshes)
    facets = np.zeros(len(flat.faces), _FACET)
    corners = facets["corners"] = flat.points[flat.faces]
    facets["normal"] = scale_to_unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    stored = flat.values(STL_BYTES)
    if stored is not None:
        facets["bytes"] = np.nan_to_num(stored[:, 0])
    header = b"bldsimp".ljust(80, b" ") + len(facets).to_bytes(4, "little")
    return header + facets.tobytes(), 3 * len(facets)
