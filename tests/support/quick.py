"""What a quick run leaves out, and a slow one adds: examples, seeds, and costly input."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

import pytest
from hypothesis import settings

LARGE_MODELS = (
    "broken/manifold_openscad-nonmanifold-crash.obj", "broken/pmp_fandisk.off", "broken/trimesh_busted.STL",
    "city/derived_citygml4j_lod3_building.obj", "city/derived_savenow_lod3_4018128.obj",
    "city/derived_val3dity_fzk_haus.obj", "exact/cesium_building_tower.glb",
    "exact/ifcderived_bimwhale_TallBuilding.obj", "exact/ifcderived_thatopen_duplex.obj", "exact/oversampled_100k.glb",
    "noisy/easy3d_building.off", "noisy/oversampled_10k_noise1cm.ply", "noisy/planeopt_copyroom.ply",
    "textured/kaykit_building_H/building_H.gltf", "tiles/sibbe/1.1/content/2_2_3.glb",
    "tiles/sibbe/1.1/content/2_3_2.glb",
)  # fmt: skip
"""Third-party models that take a second or more; no small one is left out of a quick run."""


def try_examples(count: int, **others: Any) -> settings:
    """Return settings for `count` random examples in a slow run, and for the profile's share of them in a quick one."""
    return settings(max_examples=max(1, count * settings().max_examples // 100), deadline=None, **others)


def defer(values: Iterable[Any], slow: Collection[Any]) -> list[Any]:
    """Return values as parameters of a test, of which those in `slow` wait for a slow run."""
    return [pytest.param(value, marks=pytest.mark.slow) if value in slow else value for value in values]


def split_seeds(few: int, count: int) -> list[Any]:
    """Return two parameters: the first seeds for a quick run, and all others up to `count` for a slow one."""
    return [pytest.param(range(few), id="few"), pytest.param(range(few, count), id="many", marks=pytest.mark.slow)]
