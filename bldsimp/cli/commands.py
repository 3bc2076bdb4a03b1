"""The program with all of its commands. They check options first, and load modules only when they need them."""

from __future__ import annotations

import click

from .. import __version__
from .batch import batch
from .compare import compare
from .inspect import inspect
from .simplify import simplify


@click.group(
    commands=[simplify, inspect, batch, compare],
    context_settings={"help_option_names": ["-h", "--help"], "show_default": True},
)
@click.version_option(__version__, prog_name="bldsimp", message="%(prog)s %(version)s")
def bldsimp() -> None:
    """Simplify 3D building models.

    Merges coplanar triangles, keeps textures, and reports a guaranteed error bound. Reads OBJ, PLY, OFF, STL, GLB,
    glTF and what else trimesh reads; writes the first six.

    Exit codes: 0 done, 1 a file could not be read or written, 2 wrong usage.
    """
