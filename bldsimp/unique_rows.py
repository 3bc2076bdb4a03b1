"""Rows of an array that are equal: the basis of counting points and of writing each vertex once."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

_MIX = np.uint64(0x9E3779B97F4A7C15)
_SHIFT = np.uint64(29)


def find_unique_rows(rows: NDArray[Any]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Number the distinct rows of an array in the order in which they first occur.

    Parameters
    ----------
    rows : (n, k) array of numbers
        Compared by value: -0.0 equals 0.0; a NaN equals a NaN of the same bits.

    Returns
    -------
    first : (d,) int64
        The first row of each distinct value, ascending.
    inverse : (n,) int64
        For each row its place in `first`.

    Notes
    -----
    O(n log n). Rows are sorted by a 64-bit hash, which is several times faster than to sort them by
    value; equality is then checked exactly, and a collision falls back to sorting by value.

    Examples
    --------
    >>> first, inverse = find_unique_rows(np.array([[1.0, 0.0], [2.0, 0.0], [1.0, -0.0]]))
    >>> first.tolist(), inverse.tolist()
    ([0, 1], [0, 1, 0])
    """
    bits = _bits(rows)
    key = _hash(bits)
    _, first, inverse = np.unique(key, return_index=True, return_inverse=True)
    if not np.array_equal(bits[first[inverse]], bits):
        _, first, inverse = np.unique(bits, axis=0, return_index=True, return_inverse=True)
        inverse = inverse.reshape(-1)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return first[order], rank[inverse]


def _bits(rows: NDArray[Any]) -> NDArray[np.uint64]:
    """Rows as 64-bit patterns, equal exactly where the numbers are."""
    if np.issubdtype(rows.dtype, np.floating):
        return np.ascontiguousarray(rows.astype(np.float64) + 0.0).view(np.uint64)
    return np.ascontiguousarray(rows.astype(np.int64)).view(np.uint64)


def _hash(bits: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """One well-mixed 64-bit number per row."""
    key = np.zeros(len(bits), np.uint64)
    for column in bits.T:
        key = (key ^ column) * _MIX
        key ^= key >> _SHIFT
    return key
