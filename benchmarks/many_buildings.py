"""Make many small buildings of random sizes, like the two in data/."""

from __future__ import annotations

import random
import sys
from pathlib import Path

import numpy as np
from surface import ROOT

sys.path.insert(0, str(ROOT / "examples"))

from buildings.house import build_house
from buildings.tessellate import tessellate
from buildings.tower import build_tower
from make_buildings import write_glb, write_obj

HOUSES = (1.0, 1.3, 1.8, 2.5, 4.0)
TOWERS = (3.0, 8.0)
"""Lengths of edges, meters: the longer, the fewer points."""

TOWER_SHARE = 0.1
A_FOLDER = 1000


def make_buildings(folder: Path, count: int) -> None:
    """Write so many buildings, as OBJ and GLB in turns, in folders of a thousand.

    Each is one of a few over-sampled meshes, stretched by a random factor along each axis: flat walls stay flat.
    """
    houses = [tessellate(build_house(), edge) for edge in HOUSES]
    towers = [tessellate(build_tower(), edge) for edge in TOWERS]
    chance = random.Random(0)
    for i in range(count):
        points, faces = chance.choice(towers if chance.random() < TOWER_SHARE else houses)
        sizes = np.array([chance.uniform(0.6, 1.6) for _ in range(3)])
        district = folder / f"{i // A_FOLDER:04}"
        district.mkdir(parents=True, exist_ok=True)
        name = district / f"building_{i:06}"
        stretched = np.round(points * sizes, 6)
        if i % 2:
            write_glb(name.with_suffix(".glb"), stretched, faces)
        else:
            write_obj(name.with_suffix(".obj"), stretched, faces)
