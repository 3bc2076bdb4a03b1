"""The peers on one mesh: fast-simplification and the other tools that are installed, as `bldsimp compare` asks them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from surface import Surface, read_surface, welded

from bldsimp.compare.rows import BORDER, PLAIN, VARIANTS
from bldsimp.compare.decimate import Decimator
from bldsimp.compare.measure import Judge
from bldsimp.compare.peers import installed_peers
from bldsimp.compare.placement import Surface as Compared


def read_model(path: Path) -> Surface:
    """A model welded exactly, without faces that repeat a point and copies of faces, with whichever winding."""
    return welded(*read_surface(path), one_sided=True)


def judge_of(mesh: Surface) -> Judge:
    """What measures results against a mesh."""
    return Judge(Compared(np.ascontiguousarray(mesh.points), np.ascontiguousarray(mesh.faces, np.int32)))


def decimators(judge: Judge) -> dict[str, Decimator]:
    """What decimates the judge's original, by the name of the tool; none is loaded yet."""
    variants = (PLAIN, BORDER) if judge.has_border else (PLAIN,)
    own = {name: Decimator(judge, VARIANTS[name]) for name in variants}
    return own | {peer.name: Decimator(judge, peer.decimate, most=peer.most) for peer in installed_peers()}


def as_surface(found: Compared) -> Surface:
    """A surface of `compare` as the benchmarks have it."""
    return Surface(found.points, found.faces.astype(np.int64))
