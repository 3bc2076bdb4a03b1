"""The examples in docstrings run, and every public name has one."""

from __future__ import annotations

import doctest
import importlib
import pkgutil

import pytest

import bldsimp

MODULES = sorted(one.name for one in pkgutil.walk_packages(bldsimp.__path__, "bldsimp.") if "dask" not in one.name)


@pytest.mark.parametrize("name", MODULES)
def test_examples_run(name: str) -> None:
    module = importlib.import_module(name)
    assert doctest.testmod(module, optionflags=doctest.NORMALIZE_WHITESPACE).failed == 0


def test_public_names_are_few_and_each_has_an_example() -> None:
    # `compare`, `lod` and `inspect` are to come.
    assert len(bldsimp.__all__) <= 12
    for name in bldsimp.__all__:
        assert ">>>" in (getattr(bldsimp, name).__doc__ or ""), name


@pytest.mark.parametrize("name", sorted(bldsimp._MOVED))
def test_names_that_moved_are_there_and_say_so(name: str) -> None:
    with pytest.deprecated_call(match=f"bldsimp.{name} is now bldsimp"):
        assert getattr(bldsimp, name)
