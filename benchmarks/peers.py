"""Run peers on one mesh: fast-simplification and the other installed tools, as `bldsimp compare` runs them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from surface import Surface, read_surface, weld_surface

from bldsimp.compare.decimate import Decimator
from bldsimp.compare.measure import Judge
from bldsimp.compare.peers import find_peers
from bldsimp.compare.placement import PlacedSurface
from bldsimp.compare.rows import BORDER, PLAIN, VARIANTS


def read_model(path: Path) -> Surface:
    """Read a model, welded exactly, without faces that repeat a point and copies of faces, with whichever winding."""
    return weld_surface(*read_surface(path), one_sided=True)


def build_judge(mesh: Surface) -> Judge:
    """Build the judge that measures results against a mesh."""
    return Judge(PlacedSurface(np.ascontiguousarray(mesh.points), np.ascontiguousarray(mesh.faces, np.int32)))


def build_decimators(judge: Judge) -> dict[str, Decimator]:
    """Build the decimators of the judge's original, by the name of the tool, without loading any."""
    variants = (PLAIN, BORDER) if judge.has_border else (PLAIN,)
    own = {name: Decimator(judge, VARIANTS[name]) for name in variants}
    return own | {peer.name: Decimator(judge, peer.decimate, most=peer.most) for peer in find_peers()}


def convert_surface(found: PlacedSurface) -> Surface:
    """Convert a surface of `compare` to one of the benchmarks."""
    return Surface(found.points, found.faces.astype(np.int64))
