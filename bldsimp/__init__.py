"""bldsimp makes 3D building models light: fewest points, no crack, a certified error."""

from .errors import BldsimpError, InputError, InternalError, OutputError, TopologyError, UsageError
from .options import Options, Tolerance
from .report import Report
from .scene import Light, Mesh, Part, Scene
from .simplified import Facet, Simplified, simplify, simplify_scene
from .triangulation import Triangulation, triangulate

__version__ = "0.1.0"

__all__ = [
    "BldsimpError",
    "Facet",
    "InputError",
    "InternalError",
    "Light",
    "Mesh",
    "Options",
    "OutputError",
    "Part",
    "Report",
    "Scene",
    "Simplified",
    "Tolerance",
    "TopologyError",
    "Triangulation",
    "UsageError",
    "simplify",
    "simplify_scene",
    "triangulate",
]
