"""How finely numbers are stored: what the default tolerance is derived from."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .options import SIGNIFICANT_DIGITS
from .scene import Points


def number_format(used: Points) -> tuple[bool, float]:
    """How finely the numbers of the points that are used are stored: see `Mesh.single` and `Mesh.rounding`.

    Told from the values alone, so that the same numbers give the same answer in text and binary.
    """
    values = used.ravel()
    with np.errstate(over="ignore", under="ignore"):
        nearest = values.astype(np.float32).astype(np.float64)
    if np.array_equal(nearest, values):
        return True, 0.0
    decimals = _decimals(values)
    if decimals is None:
        return False, 0.0
    largest = float(np.abs(values).max())
    unit = 10.0**-decimals
    coarse = unit > np.spacing(largest) and largest / unit >= 10.0 ** (SIGNIFICANT_DIGITS - 1)
    return False, unit / 2.0 if coarse else 0.0


def _decimals(values: NDArray[np.float64]) -> int | None:
    """Fewest decimal digits that give back every value, or None where fifteen do not."""
    sample = values[:: max(1, len(values) // 1000)]
    for decimals in range(16):
        if np.array_equal(np.round(sample, decimals), sample) and np.array_equal(np.round(values, decimals), values):
            return decimals
    return None
