"""Every file in corpus/ is a shape that once broke a promise; adding a file adds a test.

A file has `points`, `faces`, `tolerance` (a length; null is `auto`), `why`, what went wrong, and
`mended`: a case that is not mended yet must fail, so that the mark goes when it is.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import solids
from judged import find_broken, simplify_and_judge

CORPUS = sorted((Path(__file__).parent / "corpus").glob("*.json"))


@pytest.mark.parametrize("path", CORPUS, ids=lambda path: path.stem)
def test_what_broke_once_stays_mended(path: Path, request: pytest.FixtureRequest) -> None:
    case = json.loads(path.read_text())
    if not case["mended"]:
        request.applymarker(pytest.mark.xfail(strict=True, reason=case["why"]))
    mesh = solids.shape(case["points"], case["faces"])
    for tolerance in {case["tolerance"], None, 0.0}:
        first = simplify_and_judge(mesh, tolerance)
        assert find_broken(first, 1000) == [], f"{case['why']} (tolerance {tolerance})"
        for seed in range(4):
            other = simplify_and_judge(solids.shuffle(mesh, seed), tolerance)
            assert np.array_equal(first.result[0], other.result[0])
            assert np.array_equal(first.result[1], other.result[1])
