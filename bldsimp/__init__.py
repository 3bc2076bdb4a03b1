"""bldsimp makes 3D building models light: fewest points, no crack, a certified error."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .api import Facet, Simplified, simplify
    from .errors import BldsimpError, InputError, InternalError, OutputError, TopologyError, UsageError
    from .model import Mesh, Part, Scene, SimplifiedMesh
    from .options import Options, Tolerance
    from .report import Report
    from .scene import simplify_scene
    from .triangulation import Triangulation, triangulate

__version__ = "0.1.0"

__all__ = [
    "BldsimpError",
    "Facet",
    "InputError",
    "InternalError",
    "Mesh",
    "Options",
    "OutputError",
    "Part",
    "Report",
    "Scene",
    "Simplified",
    "SimplifiedMesh",
    "Tolerance",
    "TopologyError",
    "Triangulation",
    "UsageError",
    "simplify",
    "simplify_scene",
    "triangulate",
]

_HOMES = {
    "errors": ("BldsimpError", "InputError", "InternalError", "OutputError", "TopologyError", "UsageError"),
    "options": ("Options", "Tolerance"),
    "report": ("Report",),
    "model": ("SimplifiedMesh", "Mesh", "Part", "Scene"),
    "api": ("Facet", "Simplified", "simplify"),
    "scene": ("simplify_scene",),
    "triangulation": ("Triangulation", "triangulate"),
}


def __getattr__(name: str) -> Any:
    """Load a public name when it is asked for: the command line must be able to answer before NumPy is there."""
    for home, names in _HOMES.items():
        if name in names:
            globals()[name] = getattr(import_module(f".{home}", __name__), name)
            return globals()[name]
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
