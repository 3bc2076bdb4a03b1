"""`bldsimp batch`: many files, each alone."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import click

from ..display import parse_bytes, sanitize_line
from ..errors import InputError, UsageError
from ..options import BATCH_NAME, BATCH_TIMEOUT, Options
from .options import FILE, FROM, add_options, make_options, parse_with
from .paths import check_format, check_standard_output, normalize_format, read_standard_input
from .signals import GracefulInterrupt, raise_on_signals

if TYPE_CHECKING:
    from ..batch.inputs import OutputLayout
    from ..batch.run import RunSettings

_EXAMPLES = """
\b
Examples:
  bldsimp batch models/ results/ --to glb -j 8
  bldsimp batch 'tiles/**/*.obj' results/ --tolerance 0.05 --resume
  find . -name '*.ply' -print0 | bldsimp batch - results/
  bldsimp batch models/ results/ --scheduler tcp://head:8786
  bldsimp batch --summary results/manifest.jsonl
"""

MANIFEST = "manifest.jsonl"

MOST_SECONDS = 1e6
"""Upper limit of the operating system's wait call, about 12 days."""


def _parse_timeout(text: str) -> float:
    """Parse seconds; nan fails, too."""
    try:
        if 0 < float(text) <= MOST_SECONDS:
            return float(text)
    except ValueError:
        pass
    raise UsageError(f"'{text}': give a number above 0 and at most {MOST_SECONDS:,.0f} seconds")


@click.command(epilog=_EXAMPLES)
@click.argument("sources", metavar="IN...", nargs=-1, type=click.Path(readable=False))
@click.argument("target", metavar="OUT", required=False, type=click.Path(file_okay=False, readable=False))
@add_options
@FROM
@click.option("--to", metavar="FORMAT", help="Format of the results.  [default: that of each input]")
@click.option(
    "--name",
    default=BATCH_NAME,
    metavar="TEMPLATE",
    help="Name of each result: {stem} and {from} of the input, {ext} of the result.",
)
@click.option(
    "-j", "--jobs", type=click.IntRange(1), metavar="N", help="Number of processes.  [default: one for each core]"
)
@click.option(
    "--memory",
    callback=parse_with(parse_bytes),
    metavar="BYTES",
    help="Memory limit of all processes together, such as 8G; files that do not fit at the same time wait. With"
    " --scheduler: limit for each file.  [default: 80 % of the free memory; with --scheduler: no limit]",
)
@click.option(
    "--timeout",
    callback=parse_with(_parse_timeout),
    default=f"{BATCH_TIMEOUT:g}",
    metavar="SECONDS",
    help="Time limit for each file.",
)
@click.option("--manifest", type=FILE, metavar="FILE", help=f"Where to record each file.  [default: OUT/{MANIFEST}]")
@click.option("--resume", is_flag=True, help="Skip files that the manifest records as done and that have not changed.")
@click.option("--verify", is_flag=True, help="With --resume: compare the hashes of all files.")
@click.option("--overwrite", is_flag=True, help="Replace files that exist; without --resume also the manifest.")
@click.option("--scheduler", metavar="ADDRESS", help="Run on a Dask cluster; needs bldsimp[dask].")
@click.option("--summary", type=FILE, metavar="MANIFEST", help="Only print the totals of a manifest.")
@click.option("-q", "--quiet", is_flag=True, help="Print no progress and no summary.")
def batch(
    *,
    sources: tuple[str, ...],
    target: str | None,
    to: str | None,
    from_: str | None,
    name: str,
    manifest: str | None,
    summary: str | None,
    quiet: bool,
    **values: Any,
) -> None:
    """Simplify many files. One bad file does not stop the others.

    IN is a folder, a glob in quotes ('**' stands for any folders), a file, or '-' for a list of files on standard
    input. OUT mirrors the folders of the inputs. Paths may be URLs that fsspec supports.

    The manifest gets one line of JSON for each file, and --resume continues from it. Ctrl-C finishes the files that
    are running; press it twice to stop now. The exit code is 1 if a file failed.
    """
    if summary is not None:
        if target:
            raise UsageError("--summary: takes no other files")
        _summarize(summary)
        return
    if os.name != "posix":
        raise UsageError("batch needs Linux or macOS: on Windows use it in WSL")
    if target is None or not sources:
        raise UsageError("give the files to simplify, and a folder for the results (try 'bldsimp batch --help')")
    if values["verify"] and not values["resume"]:
        raise UsageError("--verify: needs --resume")
    from ..batch.inputs import OutputLayout
    from ..batch.run import RunSettings
    from ..batch.storage import join_path, make_absolute

    settings = RunSettings(**{each.name: values.pop(each.name) for each in fields(RunSettings)})
    layout = OutputLayout(make_absolute(target), name, to and normalize_format(to), from_ and check_format(from_))
    where = manifest or join_path(layout.root, MANIFEST)
    _run(sources, layout, where, make_options(**values), settings, quiet)


def _run(
    sources: Sequence[str], layout: OutputLayout, where: str, options: Options, settings: RunSettings, quiet: bool
) -> None:
    """Plan, run, and print the totals."""
    from ..batch.inputs import find_inputs, plan_tasks
    from ..batch.manifest import open_manifest
    from ..batch.run import make_pool, run_batch, skip_done
    from ..batch.totals import Totals
    from .progress import show_batch_progress
    from .summary import describe_totals

    plan = plan_tasks(find_inputs(_expand_list(sources), layout.root), layout)
    totals = Totals()
    pool = make_pool(options, settings)
    log = open_manifest(where, resume=settings.resume, overwrite=settings.overwrite)
    try:
        skip_done(plan, log, layout.root, options, settings, totals)
        raise_on_signals()
        interrupt = GracefulInterrupt(pool.stop)
        with show_batch_progress(plan, totals, quiet=quiet) as show:
            run_batch(plan, options, pool, log, totals, show)
    finally:
        log.close()
    if not quiet:
        click.echo(describe_totals(totals), err=True)
        click.echo(f"manifest   {sanitize_line(where)}", err=True)
    if interrupt.came:
        raise KeyboardInterrupt
    if totals.failed:
        raise InputError(f"{totals.failed:,} of {totals.failed + totals.done:,} files failed: see {where}")


def _expand_list(sources: Sequence[str]) -> list[str]:
    """Replace '-' by the sources that standard input lists."""
    from ..batch.inputs import parse_names

    if sources.count("-") > 1:
        raise UsageError("IN: '-' can be read only once")
    return [name for source in sources for name in (parse_names(read_standard_input()) if source == "-" else [source])]


def _summarize(manifest: str) -> None:
    """Print the totals of a manifest."""
    from ..batch.manifest import read_manifest
    from ..batch.totals import sum_rows
    from .summary import describe_totals

    check_standard_output()
    click.echo(describe_totals(sum_rows(read_manifest(manifest))))
