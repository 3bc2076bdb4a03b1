"""What the kernels do at their boundary: arrays that are cast, arguments that are refused, invariants that break."""

from __future__ import annotations

import numpy as np
import pytest

from bldsimp import _core

POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)
FACES = np.array([[0, 1, 2]], np.int32)


def trace_outlines() -> _core.Outlines:
    """Outlines of a single triangle."""
    halfedges = _core.pair_halfedges(POINTS, FACES, None, 0.0)
    facets = _core.find_facets(POINTS, FACES, halfedges, np.zeros(1, np.int32), (0.0, 0.0, 0.0), 0.0, 0.0, 0.0)
    return _core.trace_outlines(FACES, 3, halfedges, facets, np.zeros(1, np.uint8))


def test_a_broken_invariant_names_its_stage():
    outlines = trace_outlines()
    assert len(_core.lay_pieces(POINTS, outlines, np.ones(3, np.uint8)).begin) == 3
    with pytest.raises(_core.KernelError, match=r"^lay_pieces: an end of a chain is not kept$"):
        _core.lay_pieces(POINTS, outlines, np.zeros(3, np.uint8))


def test_arrays_of_another_type_or_layout_are_cast():
    welded = _core.weld(np.asfortranarray(POINTS.astype(np.float32)), FACES.astype(np.int64), 0.0)
    assert (welded.points == _core.weld(POINTS, FACES, 0.0).points).all()
    assert len(welded.faces) == 1


@pytest.mark.parametrize("bad", [None, POINTS[:, :2], "points"])
def test_what_is_no_array_of_the_right_shape_is_refused(bad: object):
    with pytest.raises(TypeError, match="incompatible function arguments"):
        _core.find_bodies(bad, FACES)


def test_results_keep_what_their_arrays_look_at_alive():
    points = _core.weld(POINTS, FACES, 0.0).points
    chains = trace_outlines().chain_points
    assert not points.flags.writeable
    assert chains.tolist() == [0, 1, 2, 0]
    assert points.tolist() == sorted(POINTS.tolist())
