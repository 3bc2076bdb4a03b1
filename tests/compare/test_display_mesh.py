"""The triangles and samples of a page: few enough, and on the surface."""

from __future__ import annotations

import numpy as np
import pytest
from pages import make_hill

from bldsimp import _core
from bldsimp.compare.display_mesh import choose_display, weigh_lattice
from bldsimp.compare.placement import weld_surface


@pytest.mark.parametrize("k", [1, 2, 3, 7])
def test_a_lattice_is_numbered_as_the_shader_looks_it_up(k: int) -> None:
    shares = weigh_lattice(k)
    assert len(shares) == (k + 1) * (k + 2) // 2
    for j in range(k + 1):
        for i in range(k + 1 - j):
            found = shares[j * (k + 1) - j * (j - 1) // 2 + i]
            np.testing.assert_allclose(found, [(k - i - j) / k, i / k, j / k])


def test_samples_lie_on_the_surface_and_within_their_number() -> None:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [50, 50, 3]])
    surface = weld_surface(corners, np.array([[0, 1, 2], [1, 3, 2]]))
    shown = choose_display(surface)
    assert shown.steps[1] > shown.steps[0] > 100
    samples = shown.place_samples()
    assert 20_000 < len(samples) <= 40_000 + 4
    assert _core.FaceTree(surface.points, surface.faces).distances(samples).max() < 1e-13


def test_a_thinned_surface_keeps_points_of_its_own() -> None:
    surface = make_hill(100)
    shown = choose_display(surface, triangles=2_000)
    assert shown.thinned
    assert len(shown.faces) <= 2_000
    own = {tuple(point) for point in surface.points.tolist()}
    assert all(tuple(point) in own for point in shown.points.tolist())
    assert len(shown.place_samples()) == len(shown.points)
    # Close to the whole, at its border, too.
    assert _core.FaceTree(shown.points, shown.faces).distances(surface.points).max() < 0.03
    assert not choose_display(surface).thinned
