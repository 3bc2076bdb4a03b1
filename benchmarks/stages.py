"""Measure where the time goes: seconds of each kernel and stage of a run, without those of the stages inside it."""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FunctionType
from typing import Any

from bldsimp import _core

REST = "Python between the stages"

STAGES = "bldsimp.stages."
"""Public functions of these modules are stages."""

Place = tuple[Any, str]
"""A module, and a name in it."""


def time_stages(run: Callable[[], object]) -> dict[str, float]:
    """Return the seconds of each stage during `run`, in the order in which they first ended; the sum is all of it."""
    seconds: dict[str, float] = {}
    inner = [0.0]

    def time_stage(name: str, stage: Callable[..., Any]) -> Callable[..., Any]:
        """Add the stage's own time to `seconds`; `inner` keeps the time of the callees of each call."""

        def timed(*args: Any, **kwargs: Any) -> Any:
            inner.append(0.0)
            start = time.perf_counter()
            try:
                return stage(*args, **kwargs)
            finally:
                took = time.perf_counter() - start
                seconds[name] = seconds.get(name, 0.0) + took - inner.pop()
                inner[-1] += took

        return timed

    with replace_all(find_kernels() | find_stages(), time_stage):
        start = time.perf_counter()
        run()
        total = time.perf_counter() - start
    seconds[REST] = total - sum(seconds.values())
    return seconds


def count_calls(run: Callable[[], object]) -> Counter[str]:
    """Count the calls of each kernel during `run`."""
    calls: Counter[str] = Counter()

    def count(name: str, kernel: Callable[..., Any]) -> Callable[..., Any]:
        def counted(*args: Any, **kwargs: Any) -> Any:
            calls[name] += 1
            return kernel(*args, **kwargs)

        return counted

    with replace_all(find_kernels(), count):
        run()
    return calls


def find_kernels() -> dict[Place, str]:
    """Find the functions of the compiled core, with their names."""
    names = [name for name in dir(_core) if name[0].islower() and callable(getattr(_core, name))]
    return {(_core, name): name.replace("_", " ") for name in names}


def find_stages() -> dict[Place, str]:
    """Find every place in the package that refers to a public function of a stage, with the stage's name."""
    found: dict[Place, str] = {}
    for name, module in list(sys.modules.items()):
        for key, value in list(vars(module).items()) if name.startswith("bldsimp") else ():
            home = value.__module__ if isinstance(value, FunctionType) else ""
            if home.startswith(STAGES) and not key.startswith("_"):
                found[module, key] = f"{home.removeprefix(STAGES)}, in Python"
    return found


@contextmanager
def replace_all(
    places: dict[Place, str], wrap: Callable[[str, Callable[..., Any]], Callable[..., Any]]
) -> Iterator[None]:
    """Replace functions by wrapped ones for a while."""
    originals = {(module, name): getattr(module, name) for module, name in places}
    try:
        for (module, name), shown in places.items():
            setattr(module, name, wrap(shown, originals[module, name]))
        yield
    finally:
        for (module, name), original in originals.items():
            setattr(module, name, original)
