"""Draw two textured models side by side, with the edges of their triangles.

usage: render_textured.py BEFORE AFTER PICTURE.png [--azimuth DEGREES] [--elevation DEGREES] [--no-edges]
needs: pip install 'bldsimp[pictures]'

glTF, OBJ, and whatever else trimesh reads. glTF stands y up, all others z up; the second stands as the first does.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from picture import crop, to_levels, write_caption
from PIL import Image
from PIL.Image import Dither
from textured.draw import draw, place_cameras
from textured.model import Model
from textured.read import is_gltf, read_model

SIZE = 880
CAPTION = 90
"""Side of a picture, and the rows below it; pixels."""


def write_model_caption(title: str, path: Path, model: Model) -> str:
    """Write the caption of a picture; a mesh that is used twice is drawn twice."""
    points = len(np.unique(model.corners.reshape(-1, 3), axis=0))
    size = path.stat().st_size / 1000
    return f"{title}\n{points:,} points and {len(model.corners):,} triangles drawn, {size:,.0f} kB with pictures"


def main() -> None:
    """Read, draw, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("target", type=Path)
    parser.add_argument("--azimuth", type=float, default=-64.0)
    parser.add_argument("--elevation", type=float, default=12.0)
    parser.add_argument("--no-edges", action="store_true")
    options = parser.parse_args()
    models = [read_model(options.before), read_model(options.after, y_up=is_gltf(options.before))]
    ((camera, style),) = place_cameras(models[0], SIZE, [(options.azimuth, options.elevation)], samples=3)
    panels = crop([to_levels(draw(model, camera, style, edges=not options.no_edges)) for model in models])
    height = panels[0].shape[0]
    sheet = Image.new("RGB", (len(models) * SIZE, height + CAPTION), "white")
    for k, (title, path) in enumerate((("before", options.before), ("after", options.after))):
        sheet.paste(Image.fromarray(panels[k]), (k * SIZE, 0))
        write_caption(sheet, write_model_caption(title, path, models[k]), (k + 0.5) * SIZE, height)
    sheet.quantize(240, dither=Dither.NONE).save(options.target, optimize=True)


if __name__ == "__main__":
    main()
