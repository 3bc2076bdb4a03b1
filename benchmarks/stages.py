"""Where the time goes: seconds of each stage of one `simplify`, without what the stages inside it take."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import Any

from bldsimp import _core, pipeline
from bldsimp import api as simplified

REST = "Python between the stages"
PYTHON_STAGES = {
    (simplified, "_scene_of"): "check and cast the arrays",
    (simplified, "resolve_tolerance"): "resolve tolerance",
    (simplified, "diagonal"): "diagonal",
    (simplified, "_tell"): "report",
    (pipeline, "_oriented"): "turn faces",
    (pipeline, "_frame"): "frame",
    (pipeline, "climb"): "ladder, in Python",
    (pipeline, "_in_rows"): "rows, in Python",
}


def stage_seconds(run: Callable[[], object]) -> dict[str, float]:
    """Seconds of each stage during `run`, in the order in which they first ended; the sum is all of it."""
    with _watched() as seconds:
        start = time.perf_counter()
        run()
        total = time.perf_counter() - start
    seconds[REST] = total - sum(seconds.values())
    return seconds


@contextmanager
def _watched() -> Iterator[dict[str, float]]:
    """Replace the stages by ones that also keep time."""
    seconds: dict[str, float] = {}
    inner = [0.0]
    kernels = {
        (_core, name): name.replace("_", " ")
        for name in dir(_core)
        if name[0].islower() and callable(getattr(_core, name))
    }
    stages: dict[tuple[ModuleType, str], str] = {**PYTHON_STAGES, **kernels}
    originals = {place: getattr(*place) for place in stages}
    try:
        for (module, name), shown in stages.items():
            setattr(module, name, _timed(originals[module, name], shown, seconds, inner))
        yield seconds
    finally:
        for (module, name), original in originals.items():
            setattr(module, name, original)


def _timed(stage: Callable[..., Any], shown: str, seconds: dict[str, float], inner: list[float]) -> Callable[..., Any]:
    """A stage that adds its own time to `seconds`; `inner` holds what the callees of each call took."""

    def timed(*args: Any, **kwargs: Any) -> Any:
        inner.append(0.0)
        start = time.perf_counter()
        try:
            return stage(*args, **kwargs)
        finally:
            took = time.perf_counter() - start
            seconds[shown] = seconds.get(shown, 0.0) + took - inner.pop()
            inner[-1] += took

    return timed
