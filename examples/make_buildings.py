"""Make the buildings in data/: a gabled house (A), a tower with a round stair (B), and a textured house.

usage: make_buildings.py [FOLDER]
needs: numpy

All are made from scratch, closed, and over-sampled as real exports are: their flat walls carry
many points that no corner needs. The script prints, for A and B, the counts and the fewest points that
hold the same shape. It writes the same bytes on every machine.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from buildings.facet_model import Model
from buildings.glb import INDICES, VERTICES, Z_UP, Glb
from buildings.house import build_house
from buildings.tessellate import Faces, Points, tessellate
from buildings.textured_files import NAME, write_textured_glb, write_textured_obj
from buildings.tower import build_tower

DECIMALS = 6
"""Coordinates are written to the micrometer, so their rounding is below single precision's at 60 m."""


def write_obj(path: Path, points: Points, faces: Faces) -> None:
    """Write Wavefront OBJ, z upwards."""
    lines = [f"o {path.stem}"]
    lines += [f"v {x:.{DECIMALS}f} {y:.{DECIMALS}f} {z:.{DECIMALS}f}" for x, y, z in points]
    lines += [f"f {a} {b} {c}" for a, b, c in faces + 1]
    path.write_text("\n".join(lines) + "\n", encoding="ascii", newline="\n")


def write_glb(path: Path, points: Points, faces: Faces) -> None:
    """Write binary glTF with the OBJ's numbers in single precision; its node turns z up to glTF's y up."""
    glb = Glb()
    position = glb.add_accessor(points.astype("<f4"), VERTICES, bounded=True)
    indices = glb.add_accessor(faces.astype("<u2" if len(points) < 65535 else "<u4").ravel(), INDICES)
    glb.write(
        path,
        scene=0,
        scenes=[{"nodes": [0]}],
        nodes=[{"name": path.stem, "mesh": 0, "rotation": Z_UP}],
        meshes=[{"name": path.stem, "primitives": [{"attributes": {"POSITION": position}, "indices": indices}]}],
    )


def describe(model: Model, points: Points, faces: Faces) -> str:
    """Describe a mesh by its counts, and the fewest that its model needs."""
    ends, uses = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)), axis=0, return_counts=True)
    euler = len(points) - len(ends) + len(faces)
    watertight = "watertight" if np.all(uses == 2) else "open"
    fewest = f"{model.count_corners()} points, {model.count_fewest_triangles()} triangles"
    return f"{len(points)} points, {len(faces)} triangles, {watertight}, Euler {euler}; fewest: {fewest}"


EDGE = {"building_a": 0.2, "building_b": 0.7}
"""Length above which edges of the buildings are cut; meters."""


def main(folder: Path) -> None:
    """Write all buildings in both formats."""
    for name, make in (("building_a", build_house), ("building_b", build_tower)):
        model = make()
        points, faces = tessellate(model, EDGE[name])
        points = np.round(points, DECIMALS) + 0.0
        write_obj(folder / f"{name}.obj", points, faces)
        write_glb(folder / f"{name}.glb", points, faces)
        print(f"{name}: {describe(model, points, faces)}")
    write_textured_glb(folder / f"{NAME}.glb")
    write_textured_obj(folder)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[1] / "data")
