"""Rings: the closed cycles that bound a facet's triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..model import Faces


def trace_rings(triangles: Faces) -> list[NDArray[np.int32]]:
    """Closed cycles of the edges that the triangles use in one direction only.

    Parameters
    ----------
    triangles : (k, 3) int32
        Consistently oriented.

    Returns
    -------
    list of (n,) int32
        Points of each ring, the triangles on its left, from its least point on; sorted.

    Examples
    --------
    >>> trace_rings(np.array([[0, 1, 2], [0, 2, 3]], np.int32))[0].tolist()
    [0, 1, 2, 3]
    """
    edges = {(int(t[i]), int(t[(i + 1) % 3])) for t in triangles for i in range(3)}
    onward: dict[int, list[int]] = {}
    for a, b in sorted(edges, reverse=True):
        if (b, a) not in edges:
            onward.setdefault(a, []).append(b)
    rings = []
    for first in sorted(onward):
        while onward[first]:
            ring, at = [first], onward[first].pop()
            while at != first:
                ring.append(at)
                at = onward[at].pop()
            rings.append(np.array(ring, np.int32))
    return rings
