"""Time a textured GLB from start to end in a fresh process, beside one that only loads it with trimesh and exports it.

usage: python benchmarks/textured.py [MESH] [--triangles N] [--runs R]
needs: pip install bldsimp pillow

MESH is simplified first, over-sampled to N triangles, and textured: each wall by the two axes that it faces least.
Both programs read the same file and write GLB, in turns; the ratio is that of the medians. The stages are those of one
more run, in this process. Everything is printed as Markdown.
"""

from __future__ import annotations

import argparse
import itertools
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from oversample import oversample, simplify_model
from startup import LIMIT, run_ours, run_theirs
from surface import ROOT, Surface
from table import format_table, format_time, time_in_turns

from bldsimp import Options
from bldsimp.io import read, write
from bldsimp.scene import simplify_scene

TILES = 0.5
"""Times that the texture repeats within a model unit."""

PIXELS = 1024


def map_texture(mesh: Surface) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float64]]:
    """Map a texture: points, faces and UV, with a vertex for each side that meets at a point."""
    a, b, c = (mesh.points[mesh.faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    axis = np.argmax(np.abs(normals), axis=1)
    # The six sides of a box, so that opposite walls share no vertex.
    side = 2 * axis + (np.take_along_axis(normals, axis[:, None], axis=1)[:, 0] > 0)
    key, corners = np.unique(6 * mesh.faces + side[:, None], return_inverse=True)
    points = mesh.points[key // 6]
    others = np.array([[1, 2], [0, 2], [0, 1]])[key % 6 // 2]
    return points, corners.reshape(-1, 3), TILES * np.take_along_axis(points, others, axis=1)


def save(mesh: Surface, path: Path) -> None:
    """Write the textured mesh, as trimesh does."""
    import trimesh
    from PIL import Image

    points, faces, uv = map_texture(mesh)
    noise = np.random.default_rng(0).integers(0, 255, (PIXELS, PIXELS, 3), np.uint8)
    looks: Any = trimesh.visual
    material = looks.material.PBRMaterial(baseColorTexture=Image.fromarray(noise))
    visual = looks.TextureVisuals(uv=uv, material=material)
    trimesh.Trimesh(points, faces, visual=visual, process=False).export(path)


def time_io(source: Path, target: Path) -> list[list[object]]:
    """Time reading, simplifying and writing."""
    clock = [time.perf_counter()]
    scene = read(source, "glb")
    clock.append(time.perf_counter())
    results, report = simplify_scene(scene, Options())
    clock.append(time.perf_counter())
    written = write(scene, results, target, "glb", Options())
    clock.append(time.perf_counter())
    spent = [format_time(end - start) for start, end in itertools.pairwise(clock)]
    return [[f"{report.before.points:,} -> {report.after.points:,}", report.before.vertices, written.vertices, *spent]]


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", nargs="?", type=Path, default=ROOT / "data" / "building_a.obj", metavar="MESH")
    parser.add_argument("--triangles", type=int, default=1_000_000, metavar="N")
    parser.add_argument("--runs", type=int, default=3)
    args = parser.parse_args()
    mesh = oversample(simplify_model(args.mesh), args.triangles)
    with tempfile.TemporaryDirectory() as scratch:
        source, target = Path(scratch) / "fine.glb", Path(scratch) / "simplified.glb"
        save(mesh, source)
        timings = time_in_turns(
            args.runs, ours=partial(run_ours, source, target), theirs=partial(run_theirs, source, target)
        )
        ratio = timings["ours"].median / timings["theirs"].median
        row = [len(mesh.faces), timings["ours"], timings["theirs"], f"{ratio:.2f} x", ratio <= LIMIT]
        print(format_table(["triangles", "bldsimp", "trimesh alone", "ratio", f"at most {LIMIT}"], [row]))
        print()
        header = ["points", "vertices", "vertices left", "reading", "simplifying", "writing"]
        print(format_table(header, time_io(source, target)))


if __name__ == "__main__":
    main()
