"""The promises on random shapes: what hypothesis puts together shrinks; seeds that broke once are in corpus/."""

from __future__ import annotations

import judge
import numpy as np
import pytest
import random_shapes
import solids
from hypothesis import given
from hypothesis import strategies as st
from judged import find_broken, simplify_and_judge
from quick import split_seeds, try_examples
from random_shapes import PLACES, SPOILS, cut_finely, random_shape
from solids import Shape

SHARES = st.sampled_from([None, 0.0, 1e-6, 9e-6, 1e-3, 1e-2, 0.1])


@st.composite
def unions_of_cells(draw) -> Shape:
    """Boxes on a small grid, cut finely, spoilt in a few ways, put somewhere."""
    size = draw(st.tuples(*[st.integers(1, 3)] * 3))
    filled = np.array(draw(st.lists(st.booleans(), min_size=int(np.prod(size)), max_size=int(np.prod(size)))))
    filled[0] = True
    rng = np.random.default_rng(draw(st.integers(0, 2**16)))
    mesh = cut_finely(solids.voxels(filled.reshape(size)), rng)
    for spoil in draw(st.lists(st.sampled_from(SPOILS), max_size=3, unique=True)):
        mesh = spoil(mesh, rng)
    return draw(st.sampled_from(PLACES))(mesh, rng)


@try_examples(150, derandomize=True)
@given(mesh=unions_of_cells(), share=SHARES)
def test_unions_of_cells_keep_every_promise(mesh: Shape, share: float | None) -> None:
    assert find_broken(simplify_and_judge(mesh, share=share)) == []


@try_examples(60, derandomize=True)
@given(mesh=unions_of_cells(), share=SHARES, seed=st.integers(0, 9))
def test_order_does_not_matter(mesh: Shape, share: float | None, seed: int) -> None:
    first = simplify_and_judge(mesh, share=share)
    other = simplify_and_judge(solids.shuffle(mesh, seed), share=share)
    assert np.array_equal(first.result[0], other.result[0])
    assert judge.collect_triangles(first.after) == judge.collect_triangles(other.after)


@pytest.mark.parametrize("seeds", split_seeds(12, 60))
def test_random_shapes_keep_every_promise(seeds: range) -> None:
    for seed in seeds:
        mesh, story = random_shape(seed)
        for share in (None, 0.0, 9e-6, 1e-2):
            assert find_broken(simplify_and_judge(mesh, share=share), 100) == [], f"seed {seed}: {story}, share {share}"


def test_every_source_and_spoil_comes_up() -> None:
    stories = " ".join(random_shape(seed)[1] for seed in range(60)).split()
    wanted = [*random_shapes.SOURCES, *SPOILS, *PLACES]
    assert {make.__name__ for make in wanted} <= set(stories)
