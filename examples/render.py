"""Draw two models side by side, with their counts: the picture in the README.

usage: render.py BEFORE AFTER PICTURE.png [--azimuth DEGREES] [--elevation DEGREES]
needs: pip install 'bldsimp[pictures]'

Any two files that trimesh reads will do. glTF stands y up, all others z up.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import trimesh
from picture import Style, View, draw_picture
from PIL.Image import Dither

GLTF_TO_Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


def read_view(path: Path, title: str) -> View:
    """Read a model as it stands in the world, z upwards."""
    mesh = trimesh.load_mesh(path, process=False)
    points, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    if path.suffix.lower() in (".glb", ".gltf"):
        points = points @ GLTF_TO_Z_UP.T
    count = len(np.unique(points[np.unique(faces)], axis=0))
    size = path.stat().st_size / 1000
    return View(points, faces, f"{title}\n{count:,} points, {len(faces):,} triangles, {size:,.0f} kB")


def main() -> None:
    """Read, draw, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("target", type=Path)
    parser.add_argument("--azimuth", type=float, default=Style.azimuth)
    parser.add_argument("--elevation", type=float, default=Style.elevation)
    options = parser.parse_args()
    style = Style(azimuth=options.azimuth, elevation=options.elevation)
    views = [read_view(options.before, "before"), read_view(options.after, "after")]
    # A palette makes the file a third as large; the shades of flat facets are few.
    draw_picture(views, style).quantize(128, dither=Dither.NONE).save(options.target, optimize=True)


if __name__ == "__main__":
    main()
