"""What a climb of the ladder gives: facets put together again, and how much of each had to stay."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model import Faces, Flags, Indices
from ..triangulation import Statistics


class Rung(IntEnum):
    """How much of a facet had to stay."""

    SIMPLIFIED = 0
    POINTS_PUT_BACK = 1
    SOME_FACES_KEPT = 2
    OUTLINE_PUT_BACK = 3
    FACES_KEPT = 4
    PASSED_ON = 5


class Cause(IntEnum):
    """Why a facet stepped down; the first four are the kernel's outcomes."""

    NONE = 0
    UNCHANGED = 1
    CROSSING = 2
    MISMATCH = 3
    CLASH = 4
    MISFIT = 5
    LITTLE_GAIN = 6
    PIERCED = 7


@dataclass(frozen=True)
class Layout:
    """What the last round triangulated: parts of facets, where single faces were kept.

    Attributes
    ----------
    planes : (p, 5) float64
        Of each part.
    outlines : _core.Outlines
    pieces : _core.Pieces
        Of the thinned chains.
    keep : (p,) uint8
        Parts whose faces stayed.
    triangles : (k, 3) int32
    part_of_triangle : (k,) int32
    """

    planes: NDArray[np.float64]
    outlines: _core.Outlines
    pieces: _core.Pieces
    keep: Flags
    triangles: Faces
    part_of_triangle: Indices


@dataclass
class Assembled:
    """Facets put together again.

    Attributes
    ----------
    triangles : (k, 3) int32
    facet_of_triangle : (k,) int32
    kept : (n,) uint8
        Points that the result uses, or that no chain decided on.
    rung, unchanged : (f,) uint8
        `Rung` of each facet; whether its own faces stayed.
    deviation : (f,) float64
        Certified bound of each facet.
    healed : int
        Edges where two borders were laid on one another.
    touching : int
        Points that stay only since sheets meet there inside of facets.
    causes : Counter
        Facets below the first rung, by `Cause`.
    statistics : Statistics
        Of all triangulations on the way.
    layout : Layout
    """

    triangles: Faces
    facet_of_triangle: Indices
    kept: Flags
    rung: Flags
    unchanged: Flags
    deviation: NDArray[np.float64]
    healed: int
    touching: int
    causes: Counter[Cause]
    statistics: Statistics
    layout: Layout

    def point_count(self) -> int:
        """Points that the result uses."""
        return len(np.unique(self.triangles))

    def followed_by(self, second: Assembled) -> Assembled:
        """What two passes did together, of which the second worked on the result of the first."""
        return Assembled(
            triangles=second.triangles,
            facet_of_triangle=second.facet_of_triangle,
            kept=second.kept,
            rung=np.maximum(self.rung, second.rung),
            unchanged=self.unchanged & second.unchanged,
            deviation=np.maximum(self.deviation, second.deviation),
            healed=self.healed + second.healed,
            touching=second.touching,
            causes=self.causes | second.causes,
            statistics=self.statistics + second.statistics,
            layout=second.layout,
        )
