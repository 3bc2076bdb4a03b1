"""Simplify 3D building models: merge coplanar faces, keep textures, and report a guaranteed error bound."""

from __future__ import annotations

import warnings
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .api import Simplified, simplify
    from .errors import BldsimpError, InputError, OutputError, TopologyError, UsageError
    from .options import Options, Tolerance
    from .report import Report
    from .triangulation import triangulate

__version__ = "0.1.0"

__all__ = [
    "BldsimpError",
    "InputError",
    "Options",
    "OutputError",
    "Report",
    "Simplified",
    "Tolerance",
    "TopologyError",
    "UsageError",
    "simplify",
    "triangulate",
]

_HOMES = {
    "api": ("Simplified", "simplify"),
    "errors": ("BldsimpError", "InputError", "OutputError", "TopologyError", "UsageError"),
    "options": ("Options", "Tolerance"),
    "report": ("Report",),
    "triangulation": ("triangulate",),
}

_MOVED = {
    "Facet": "api.Facet",
    "InternalError": "errors.InternalError",
    "Light": "model.SimplifiedMesh",
    "Mesh": "model.Mesh",
    "Part": "model.Part",
    "Scene": "model.Scene",
    "Triangulation": "triangulation.Triangulation",
    "simplify_scene": "scene.simplify_scene",
}
"""Names that were public here, and where they are now; deprecated."""


def __getattr__(name: str) -> Any:
    """Load a public name when it is asked for: the command line must be able to answer before NumPy is there."""
    for home, names in _HOMES.items():
        if name in names:
            globals()[name] = getattr(import_module(f".{home}", __name__), name)
            return globals()[name]
    if name in _MOVED:
        home, _, new = _MOVED[name].partition(".")
        warnings.warn(f"bldsimp.{name} is now bldsimp.{_MOVED[name]}", DeprecationWarning, stacklevel=2)
        return getattr(import_module(f".{home}", __name__), new)
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
