"""The triangulation core on the graphs and polygons that break triangulators: adding a file adds a test."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from conftest import models_folder
from planar import check, compute_area, cross, rings

from bldsimp import TopologyError


def even_odd_area(outlines) -> float:
    """Area of rings nested in each other, by their signs from outside in."""
    signed = []
    for outline in outlines:
        x, y = np.array(outline, float).T
        signed.append(0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))))
    return signed[0] - sum(signed[1:])


def corpus(kind: str) -> list[Path]:
    return sorted((models_folder() / "cdt" / kind).glob("[!_]*.*"))


def read_graph(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Header of two counts, points, segments."""
    words = path.read_text().split()
    n, m = int(words[0]), int(words[1])
    points = np.array(words[2 : 2 + 2 * n], float).reshape(-1, 2)
    return points, np.array(words[2 + 2 * n : 2 + 2 * n + 2 * m], int).reshape(-1, 2)


@pytest.mark.parametrize("path", corpus("artemogre"), ids=lambda p: p.stem)
def test_graph_corpus(path, models):
    points, segments = read_graph(path)
    for carve in (False, True):
        check(points, segments, carve=carve, split_crossings=True)
    try:
        plain = check(points, segments, carve=False)
    except TopologyError as error:
        named = error.segments
    else:
        assert len(plain.points) == len(points)
        return
    assert named is not None
    assert cross(points, *(segments[i] for i in named))


@pytest.mark.parametrize("path", corpus("earcut"), ids=lambda p: p.stem)
def test_ring_corpus(path, models):
    outlines = json.loads(path.read_text())
    points, segments = rings(*outlines)
    result = check(points, segments, split_crossings=True)
    check(points, segments, carve=False, split_crossings=True)
    expected = json.loads((path.parent / "_expected.json").read_text())
    deviation = expected.get("errors", {}).get(path.stem, 0)
    # Where rings cross, overlap, or the first one is not the outer one, conventions differ.
    if len(result.points) == len(points) and deviation == 0 and expected["triangles"].get(path.stem, 0):
        assert compute_area(result) == pytest.approx(even_odd_area(outlines), rel=1e-9)


def read_polygons(path: Path) -> dict[str, list[list[list[float]]]]:
    """Per polygon: name, count, precision, number of rings; per ring its count and points."""
    words = iter(path.read_text().split())
    polygons: dict[str, list[list[list[float]]]] = {}
    for name in words:
        next(words), next(words)
        polygons[name] = [
            [[float(next(words)), float(next(words))] for _ in range(int(next(words)))] for _ in range(int(next(words)))
        ]
    return polygons


def test_polygon_corpus(models):
    polygons = read_polygons(models / "cdt" / "manifold_polygon_corpus.txt")
    assert len(polygons) > 20
    for outlines in polygons.values():
        points, segments = rings(*outlines)
        for carve in (False, True):
            check(points, segments, carve=carve, split_crossings=True)
