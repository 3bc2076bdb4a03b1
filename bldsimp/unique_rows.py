"""Find equal rows of an array: the basis of counting points and of writing each vertex once."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

_MIX = np.uint64(0x9E3779B97F4A7C15)
_SHIFT = np.uint64(29)


def find_unique_rows(rows: NDArray[Any]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Find the distinct rows of an array, numbered in the order in which they first occur.

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
    # Numbers are equal exactly where these bits are: adding zero turns -0.0 into 0.0.
    numbers = rows.astype(np.float64) + 0.0 if np.issubdtype(rows.dtype, np.floating) else rows.astype(np.int64)
    bits = np.ascontiguousarray(numbers).view(np.uint64)
    key = np.zeros(len(bits), np.uint64)
    for column in bits.T:
        key = (key ^ column) * _MIX
        key ^= key >> _SHIFT
    _, first, inverse = np.unique(key, return_index=True, return_inverse=True)
    if not np.array_equal(bits[first[inverse]], bits):
        _, first, inverse = np.unique(bits, axis=0, return_index=True, return_inverse=True)
        inverse = inverse.reshape(-1)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return first[order], rank[inverse]


def place_values(
    source: NDArray[np.integer[Any]], count: int, may_stay: NDArray[np.bool_] | None = None
) -> tuple[NDArray[np.integer[Any]], NDArray[np.integer[Any]]]:
    """Give each of some distinct values a row: the first of each source row keeps it, the others get new rows.

    Parameters
    ----------
    source : (d,) int
        The row that each value was read from.
    count : int
        How many rows there are; new ones are numbered from here on.
    may_stay : (d,) bool, optional
        Which values may keep their row; all where left out.

    Returns
    -------
    row : (d,) int
        The row of each value.
    added : (a,) int
        The source row of each new one.

    Examples
    --------
    >>> row, added = place_values(np.array([4, 7, 4]), 10)
    >>> row.tolist(), added.tolist()
    ([4, 7, 10], [4])
    """
    eligible = np.arange(len(source)) if may_stay is None else np.flatnonzero(may_stay)
    stays = np.zeros(len(source), bool)
    stays[eligible[np.unique(source[eligible], return_index=True)[1]]] = True
    row, added = source.copy(), source[~stays]
    row[~stays] = count + np.arange(len(added))
    return row, added


def join_pairs(count: int, a: NDArray[np.integer[Any]], b: NDArray[np.integer[Any]]) -> NDArray[np.int64]:
    """Label items that pairs connect.

    Parameters
    ----------
    count : int
        How many there are.
    a, b : (p,) int
        Both ends of each pair.

    Returns
    -------
    label : (count,) int64
        For each the least that it hangs together with.

    Examples
    --------
    >>> join_pairs(5, np.array([0, 4]), np.array([2, 3])).tolist()
    [0, 1, 0, 3, 3]
    """
    label = np.arange(count)
    while True:
        before = label.copy()
        least = np.minimum(label[a], label[b])
        for side in (a, b):
            np.minimum.at(label, before[side], least)
            np.minimum.at(label, side, least)
        label = label[label]
        if np.array_equal(label, before):
            return label
