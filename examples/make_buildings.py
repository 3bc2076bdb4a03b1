"""Make the two buildings in data/: a gabled house (A) and a tower with a round stair (B).

usage: make_buildings.py [FOLDER]
needs: numpy

Both are made from scratch, closed, and over-sampled as real exports are: their flat walls carry
many points that no corner needs. The script prints, for each, the counts and the fewest points that
hold the same shape. It writes the same bytes on every machine.
"""

from __future__ import annotations

import json
import struct
import sys
from pathlib import Path

import numpy as np
from buildings.facet_model import Model
from buildings.house import house
from buildings.tessellate import Faces, Points, tessellate
from buildings.tower import tower

DECIMALS = 6
"""Coordinates are written to the micrometre, so their rounding is below single precision's at 60 m."""


def write_obj(path: Path, points: Points, faces: Faces) -> None:
    """Wavefront OBJ, z upwards."""
    lines = [f"o {path.stem}"]
    lines += [f"v {x:.{DECIMALS}f} {y:.{DECIMALS}f} {z:.{DECIMALS}f}" for x, y, z in points]
    lines += [f"f {a} {b} {c}" for a, b, c in faces + 1]
    path.write_text("\n".join(lines) + "\n", encoding="ascii", newline="\n")


def write_glb(path: Path, points: Points, faces: Faces) -> None:
    """Binary glTF with the OBJ's numbers in single precision; its node turns z up to glTF's y up."""
    positions = points.astype("<f4")
    indices = faces.astype("<u2" if len(points) < 65535 else "<u4").ravel()
    parts = [positions.tobytes(), indices.tobytes()]
    parts[1] += b"\0" * (-len(parts[1]) % 4)
    root = 0.5**0.5
    document = {
        "asset": {"version": "2.0", "generator": "make_buildings.py"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": path.stem, "mesh": 0, "rotation": [-root, 0, 0, root]}],
        "meshes": [{"name": path.stem, "primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": 5126,
                "count": len(points),
                "type": "VEC3",
                "min": [float(value) for value in positions.min(axis=0)],
                "max": [float(value) for value in positions.max(axis=0)],
            },
            {
                "bufferView": 1,
                "componentType": 5123 if indices.itemsize == 2 else 5125,
                "count": len(indices),
                "type": "SCALAR",
            },
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(parts[0]), "target": 34962},
            {"buffer": 0, "byteOffset": len(parts[0]), "byteLength": indices.nbytes, "target": 34963},
        ],
        "buffers": [{"byteLength": sum(map(len, parts))}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary = b"".join(parts)
    chunks = (
        struct.pack("<II", len(text), 0x4E4F534A)
        + text
        + struct.pack("<II", len(binary), 0x004E4942)
        + binary
    )
    path.write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks)


def describe(model: Model, points: Points, faces: Faces) -> str:
    """Counts of a mesh, and the fewest that its model needs."""
    ends, uses = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)), axis=0, return_counts=True)
    euler = len(points) - len(ends) + len(faces)
    watertight = "watertight" if np.all(uses == 2) else "open"
    fewest = f"{model.corners()} points, {model.fewest_triangles()} triangles"
    return f"{len(points)} points, {len(faces)} triangles, {watertight}, Euler {euler}; fewest: {fewest}"


EDGE = {"building_a": 0.2, "building_b": 0.7}
"""Length above which edges of the buildings are cut; metres."""


def main(folder: Path) -> None:
    """Write both buildings in both formats."""
    for name, make in (("building_a", house), ("building_b", tower)):
        model = make()
        points, faces = tessellate(model, EDGE[name])
        points = np.round(points, DECIMALS) + 0.0
        write_obj(folder / f"{name}.obj", points, faces)
        write_glb(folder / f"{name}.glb", points, faces)
        print(f"{name}: {describe(model, points, faces)}")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[1] / "data")
