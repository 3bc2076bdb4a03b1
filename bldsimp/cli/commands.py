"""The commands: options are checked before anything is read, modules loaded when they are needed."""

from __future__ import annotations

import json
import os
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import click

from .. import __version__
from ..errors import UsageError
from ..options import CREASE_DEGREES, DELIMITS, NORMALS, TEXTURE_TOLERANCE, Options
from .batch import batch, take_options
from .chosen import chosen
from .compare import compare
from .paths import Endpoint, check_open, check_output, endpoint_in, endpoint_out
from .signals import unwind

_EXAMPLES = """
\b
Examples:
  bldsimp simplify in.obj out.glb
  bldsimp simplify tower.ply light.ply --tolerance 0.02 --report tower.json
  cat in.obj | bldsimp simplify - - --from obj --to glb > out.glb
"""


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="bldsimp", message="%(prog)s %(version)s")
def bldsimp() -> None:
    """Makes 3D building models light: fewest points, no crack, a certified error.

    Reads OBJ, PLY, OFF, STL, GLB, glTF and what else trimesh reads; writes the first six.
    Exit codes: 0 done, 1 a file unreadable or not written, 2 wrong usage.
    """


@bldsimp.command(epilog=_EXAMPLES)
@click.argument("source", metavar="IN")
@click.argument("target", metavar="OUT")
@click.option(
    "--tolerance",
    default="auto",
    metavar="auto|LENGTH|PERCENT%",
    help="How far any point of the surface may move: a length in model units, a percentage of the diagonal"
    " of the model's box, or 'auto', which loses nothing that the file's own rounding has not blurred."
    " 0 drops only what is exactly in one plane or line.  [default: auto]",
)
@click.option(
    "--weld",
    default="0",
    metavar="LENGTH",
    help="Join points nearer than this, in model units.  [default: 0, exactly equal points only]",
)
@click.option(
    "--min-part",
    default="0",
    metavar="LENGTH",
    help="Drop components whose box has a smaller diagonal than this, in model units: antennas, specks. They go"
    " beyond the tolerance, and the printed deviation does not count them.  [default: 0, none]",
)
@click.option(
    "--allow-close",
    is_flag=True,
    help="Also close boundary loops (holes, cracks) where no point of what closes them is farther from the surface than"
    " the tolerance, if that is above a hundred-thousandth of the diagonal.",
)
@click.option(
    "--normals",
    type=click.Choice(NORMALS),
    default="auto",
    help="Vertex normals of the result; 'auto' keeps the input's unless they are the faces' own, 'smooth' makes them"
    " anew.  [default: auto]",
)
@click.option(
    "--crease-angle",
    default=f"{CREASE_DEGREES:g}",
    metavar="DEGREES",
    help="Edges that turn by more are hard: facets end where stored normals turn so, a moved point loses its normal"
    f" where that is farther from a face, and normals that are made are not smooth.  [default: {CREASE_DEGREES:g}]",
)
@click.option(
    "--delimit",
    default="all",
    metavar="WORDS",
    help=f"What facets may not cross, with commas between: {', '.join(DELIMITS)} (hard edges of stored normals). UV,"
    " colours, and ids and labels (feature) that they may cross are dropped; 'none' is for geometry alone."
    "  [default: all]",
)
@click.option(
    "--texture-tolerance",
    default=f"{TEXTURE_TOLERANCE:g}",
    metavar="TEXELS",
    help="How far a texture may move on its wall, in texels of the largest image of its material."
    f"  [default: {TEXTURE_TOLERANCE:g}]",
)
@click.option("--report", metavar="FILE.json", help="Also write what was done as JSON; '-' is standard output.")
@click.option(
    "--baseline",
    is_flag=True,
    help="Also tell how many points fast-simplification needs for the same deviation.",
)
@click.option("--from", "from_", metavar="FORMAT", help="Format of IN, where its suffix does not tell.")
@click.option("--to", metavar="FORMAT", help="Format of OUT, where its suffix does not tell.")
@click.option("--overwrite", is_flag=True, help="Replace OUT where it exists; it may be IN.")
@click.option("-q", "--quiet", is_flag=True, help="No summary.")
@click.option("-v", "--verbose", is_flag=True, help="More about the input and about where the time went.")
def simplify(
    source: str,
    target: str,
    tolerance: str,
    weld: str,
    min_part: str,
    allow_close: bool,
    normals: str,
    crease_angle: str,
    delimit: str,
    texture_tolerance: str,
    report: str | None,
    baseline: bool,
    from_: str | None,
    to: str | None,
    overwrite: bool,
    quiet: bool,
    verbose: bool,
) -> None:
    """Simplify the building in IN and write it to OUT; '-' is standard input or output.

    The summary goes to standard error.
    """
    if quiet and verbose:
        raise UsageError("--quiet and --verbose exclude each other")
    options = chosen(
        tolerance=tolerance,
        weld=weld,
        min_part=min_part,
        allow_close=allow_close,
        normals=normals,
        crease_angle=crease_angle,
        delimit=delimit,
        texture_tolerance=texture_tolerance,
        baseline=baseline,
    )
    read_from = endpoint_in(source, from_)
    write_to = endpoint_out(target, to, overwrite)
    if report is not None:
        _check_report(report, read_from, write_to)
    if "-" in (target, report):
        check_open(sys.stdout, "standard output")
    _run(read_from, write_to, options, Wishes(report, overwrite, quiet, verbose))


@bldsimp.command()
@click.argument("source", metavar="IN")
@click.option("--from", "from_", metavar="FORMAT", help="Format of IN, where its suffix does not tell.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def inspect(source: str, from_: str | None, as_json: bool) -> None:
    """Tell what is in the building IN before anything is done to it; '-' is standard input."""
    check_open(sys.stdout, "standard output")
    read_from = endpoint_in(source, from_)
    from ..inspection import inspect_scene, inspection_text
    from ..io import read

    inspection = inspect_scene(read(read_from.data(), read_from.format))
    if as_json:
        click.echo(json.dumps(inspection.to_dict(), indent=2))
    else:
        click.echo(inspection_text(inspection))


take_options(simplify)
bldsimp.add_command(batch)
bldsimp.add_command(compare)


@dataclass(frozen=True)
class Wishes:
    """What a user wants beside the result; `report` is a path or '-'."""

    report: str | None
    overwrite: bool
    quiet: bool
    verbose: bool


def _run(read_from: Endpoint, write_to: Endpoint, options: Options, wishes: Wishes) -> None:
    """Read, simplify, write, report."""
    start = time.perf_counter()
    from ..io.atomic import replace_files
    from ..job import Work, simplify_file
    from ..model import SimplifiedMesh
    from ..report import Report, one_line, summary
    from .progress import watched

    def watch(work: Work, points: int) -> tuple[list[SimplifiedMesh], Report]:
        done = watched(work, points, quiet=wishes.quiet)
        unwind()
        return done

    target = sys.stdout.buffer if write_to.path is None else write_to.path
    result = simplify_file(
        read_from.data(), read_from.format, target, write_to.format, options, overwrite=wishes.overwrite, watch=watch
    )
    report = result.report
    report.seconds = time.perf_counter() - start
    if wishes.report == "-":
        click.echo(report.to_json(), nl=False)
    elif wishes.report is not None:
        replace_files({Path(wishes.report): report.to_json().encode("utf-8")})
    if wishes.verbose:
        from ..inspection import number_words

        for mesh in result.scene.meshes:
            text = f"input      {mesh.name or 'mesh'}: {len(mesh.parts)} parts, {number_words(mesh)}"
            click.echo(one_line(text), err=True)
        times = ", ".join(f"{stage} {seconds:.2f}" for stage, seconds in result.seconds.items())
        click.echo(f"time       {times} s", err=True)
    if not wishes.quiet:
        click.echo(summary(report), err=True)


def _check_report(report: str, read_from: Endpoint, write_to: Endpoint) -> None:
    """Refuse a report that cannot be written, or would fall upon a model."""
    if report == "-":
        if write_to.path is None:
            raise UsageError("--report -: OUT is standard output, too: give one of them a file")
        return
    path = Path(report)
    check_output(path, "--report", overwrite=True)
    for endpoint in (read_from, write_to):
        # A model's material library and buffer are called like it.
        own = [] if endpoint.path is None else [endpoint.path, *map(endpoint.path.with_suffix, (".mtl", ".bin"))]
        if os.path.realpath(path) in map(os.path.realpath, own):
            raise UsageError(f"--report: {path} is also a model, or belongs to one: choose another file")
