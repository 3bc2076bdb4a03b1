"""`bldsimp simplify`: one file."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import UsageError
from .options import FILE, FROM, TO, add_options, make_options
from .paths import Endpoint, check_output, check_standard_output, find_input, find_output
from .signals import raise_on_signals

if TYPE_CHECKING:
    from ..job import FileResult, Work
    from ..model import SimplifiedMesh
    from ..options import Options
    from ..report import Report

_EXAMPLES = """
\b
Examples:
  bldsimp simplify in.obj out.glb
  bldsimp simplify tower.ply simple.ply --tolerance 0.02 --report tower.json
  cat in.obj | bldsimp simplify - - --from obj --to glb > out.glb
"""


@click.command(epilog=_EXAMPLES)
@click.argument("source", metavar="IN", type=FILE)
@click.argument("target", metavar="OUT", type=FILE)
@add_options
@click.option("--report", metavar="FILE.json", type=FILE, help="Also write a report as JSON; '-' is standard output.")
@click.option(
    "--baseline", is_flag=True, help="Also report how many points fast-simplification needs for the same deviation."
)
@FROM
@TO
@click.option("--overwrite", is_flag=True, help="Replace OUT if it exists; it may be IN.")
@click.option("-q", "--quiet", is_flag=True, help="Print no summary.")
@click.option("-v", "--verbose", is_flag=True, help="Also print details of the input, and timings.")
def simplify(
    *,
    source: str,
    target: str,
    report: str | None,
    from_: str | None,
    to: str | None,
    overwrite: bool,
    quiet: bool,
    verbose: bool,
    **values: Any,
) -> None:
    """Simplify one file.

    Reads the model in IN and writes the result to OUT; '-' is standard input or output. The summary goes to standard
    error.
    """
    if quiet and verbose:
        raise UsageError("--quiet and --verbose exclude each other")
    options = make_options(**values)
    read_from = find_input(source, from_)
    write_to = find_output(target, to, overwrite)
    if report is not None:
        _check_report(report, read_from, write_to)
    if "-" in (target, report):
        check_standard_output()
    start = time.perf_counter()
    result = _simplify(read_from, write_to, options, overwrite=overwrite, quiet=quiet)
    result.report.seconds = time.perf_counter() - start
    _write_report(result.report, report)
    if verbose:
        _print_details(result)
    if not quiet:
        from .summary import describe_report

        click.echo(describe_report(result.report), err=True)


def _simplify(read_from: Endpoint, write_to: Endpoint, options: Options, *, overwrite: bool, quiet: bool) -> FileResult:
    """Read, simplify and write, with a progress bar."""
    from ..job import simplify_file
    from .progress import run_with_progress

    def watch(work: Work, points: int) -> tuple[list[SimplifiedMesh], Report]:
        done = run_with_progress(work, points, quiet=quiet)
        raise_on_signals()
        return done

    target = sys.stdout.buffer if write_to.path is None else write_to.path
    return simplify_file(
        read_from.get_source(), read_from.format, target, write_to.format, options, overwrite=overwrite, watch=watch
    )


def _write_report(report: Report, target: str | None) -> None:
    """Write the report to a file; '-' is standard output."""
    from ..io.atomic import replace_files

    if target == "-":
        click.echo(report.to_json(), nl=False)
    elif target is not None:
        replace_files({Path(target): report.to_json().encode("utf-8")})


def _print_details(result: FileResult) -> None:
    """Print the meshes of the input, and how long each step took."""
    from ..display import sanitize_line
    from ..inspection import describe_numbers

    for mesh in result.scene.meshes:
        text = f"input      {mesh.name or 'mesh'}: {len(mesh.parts)} parts, {describe_numbers(mesh)}"
        click.echo(sanitize_line(text), err=True)
    times = ", ".join(f"{stage} {seconds:.2f}" for stage, seconds in result.seconds.items())
    click.echo(f"time       {times} s", err=True)


def _check_report(report: str, read_from: Endpoint, write_to: Endpoint) -> None:
    """Refuse a report that cannot be written, or would replace a model."""
    if report == "-":
        if write_to.path is None:
            raise UsageError("--report -: OUT is standard output, too: give a file for one of them")
        return
    path = Path(report)
    check_output(path, "--report", overwrite=True)
    for endpoint in (read_from, write_to):
        # The material library and the buffer of a model have its name.
        own = [] if endpoint.path is None else [endpoint.path, *map(endpoint.path.with_suffix, (".mtl", ".bin"))]
        if os.path.realpath(path) in map(os.path.realpath, own):
            raise UsageError(f"--report: {path} is also a model, or belongs to one: choose another file")
