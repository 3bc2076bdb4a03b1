"""How many random examples a test tries."""

from __future__ import annotations

from typing import Any

from hypothesis import settings


def try_examples(count: int, **others: Any) -> settings:
    """Return settings for `count` examples in a slow run, and for a share of them, as the profile says, in a quick one."""
    return settings(max_examples=max(1, count * settings().max_examples // 100), deadline=None, **others)
