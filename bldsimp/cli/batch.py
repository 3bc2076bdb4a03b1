"""`bldsimp batch`: many files, each alone."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

from ..errors import InputError, UsageError
from ..options import BATCH_NAME, BATCH_TIMEOUT, DEFAULTS, Options
from .chosen import chosen
from .paths import check_format, check_open, plain_format, standard_input
from .signals import first_interrupt, unwind

if TYPE_CHECKING:
    from ..batch.engine import Engine
    from ..batch.inputs import Layout, Plan
    from ..batch.manifest import Manifest
    from ..batch.summary import Totals

_EXAMPLES = """
\b
Examples:
  bldsimp batch models/ light/ --to glb -j 8
  bldsimp batch 'tiles/**/*.obj' light/ --tolerance 0.05 --resume
  find . -name '*.ply' -print0 | bldsimp batch - light/
  bldsimp batch models/ light/ --scheduler tcp://head:8786
  bldsimp batch --summary light/manifest.jsonl
"""

MANIFEST = "manifest.jsonl"

MOST_SECONDS = 1e6
"""Twelve days; not much more than this can a system wait for a file at all."""


@dataclass(frozen=True)
class Wishes:
    """How a batch is to run, beside what is to be done to each file."""

    overwrite: bool
    resume: bool
    verify: bool
    jobs: int
    memory: int | None
    timeout: float | None
    scheduler: str | None
    quiet: bool


@click.command(epilog=_EXAMPLES)
@click.argument("paths", metavar="IN... OUT", nargs=-1)
@click.option("--to", metavar="FORMAT", help="Format of the results.  [default: that of each input]")
@click.option("--from", "from_", metavar="FORMAT", help="Format of the inputs, where their suffix does not tell.")
@click.option(
    "--name",
    default=BATCH_NAME,
    metavar="TEMPLATE",
    help="Name of each result: {stem} and {from} of the input, {ext} of the result.  [default: " + BATCH_NAME + "]",
)
@click.option("-j", "--jobs", type=click.IntRange(1), metavar="N", help="Processes.  [default: one for each core]")
@click.option(
    "--memory",
    metavar="BYTES",
    help="Most that all processes may take together, say 8G; files that would not fit together wait. With --scheduler:"
    " most for each file.  [default: 80 % of what is free; with --scheduler: no limit]",
)
@click.option(
    "--timeout",
    type=float,
    callback=lambda context, option, seconds: _check_timeout(seconds),
    default=BATCH_TIMEOUT,
    metavar="SECONDS",
    help=f"Most for each file.  [default: {BATCH_TIMEOUT:g}]",
)
@click.option("--manifest", metavar="FILE", help="Where each file's row goes.  [default: OUT/" + MANIFEST + "]")
@click.option("--resume", is_flag=True, help="Go on: skip what the manifest records as done and what has not changed.")
@click.option("--verify", is_flag=True, help="With --resume: tell what has changed by hashes of all files.")
@click.option("--overwrite", is_flag=True, help="Replace files that exist; without --resume the manifest, too.")
@click.option("--scheduler", metavar="ADDRESS", help="Run on a cluster of Dask's; wants bldsimp[dask].")
@click.option("--summary", metavar="MANIFEST", help="Only tell what a manifest holds.")
@click.option("-q", "--quiet", is_flag=True, help="No progress and no summary.")
def batch(
    paths: tuple[str, ...],
    to: str | None,
    from_: str | None,
    name: str,
    jobs: int | None,
    memory: str | None,
    timeout: float,
    manifest: str | None,
    resume: bool,
    verify: bool,
    overwrite: bool,
    scheduler: str | None,
    summary: str | None,
    quiet: bool,
    **options: Any,
) -> None:
    """Simplify many files, each alone: a bad one costs no other.

    IN is a folder, a glob in quotes ('**' stands for any folders), a file, or '-' for a list of files on standard
    input. OUT mirrors the folders of the inputs. Paths may be URLs that fsspec knows.

    One line of JSON for each file goes to a manifest, which --resume goes on from. Ctrl-C finishes what is running;
    twice stops now. The exit code is 1 where a file failed.
    """
    if summary is not None:
        if paths:
            raise UsageError("--summary: takes no other files")
        _summarize(summary)
        return
    if os.name != "posix":
        raise UsageError("batch needs Linux or macOS: on Windows use it in WSL")
    if len(paths) < 2:
        raise UsageError("give the files to simplify, and a folder for the results (try 'bldsimp batch --help')")
    if verify and not resume:
        raise UsageError("--verify: goes with --resume")
    from ..batch.inputs import Layout
    from ..batch.memory import free_memory, jobs_for, parse_bytes
    from ..batch.storage import whole

    most = parse_bytes(memory) if memory else None if scheduler else free_memory()
    jobs = jobs or jobs_for(most or free_memory(), _cores())
    wishes = Wishes(overwrite, resume, verify, jobs, most, timeout, scheduler, quiet)
    layout = Layout(whole(paths[-1]), name, to and plain_format(to), from_ and check_format(from_))
    _run(paths[:-1], layout, manifest, chosen(**options), wishes)


def take_options(command: click.Command) -> None:
    """Let `batch` take the options of `simplify` that choose what is done to a file."""
    fields = vars(DEFAULTS).keys() - {"baseline"}
    batch.params += [option for option in command.params if option.name in fields]


def _run(sources: Sequence[str], layout: Layout, manifest: str | None, options: Options, wishes: Wishes) -> None:
    """Plan, run, tell."""
    from ..batch.inputs import find_inputs, plan
    from ..batch.manifest import open_manifest
    from ..batch.run import run_batch
    from ..batch.storage import join
    from ..batch.summary import Totals, totals_text
    from ..report import one_line
    from .batch_progress import BatchProgress

    todo = plan(find_inputs(_listed(sources), layout.root), layout)
    where = manifest or join(layout.root, MANIFEST)
    totals = Totals()
    engine = _engine(options, wishes)
    log = open_manifest(where, resume=wishes.resume, overwrite=wishes.overwrite)
    try:
        _skip(todo, log, layout.root, options, wishes, totals)
        unwind()
        interruption = first_interrupt(engine.stop)
        with BatchProgress(todo, quiet=wishes.quiet) as progress:
            run_batch(todo, options, engine, log, totals, progress.tell)
    finally:
        log.close()
    if not wishes.quiet:
        click.echo(totals_text(totals), err=True)
        click.echo(f"manifest   {one_line(where)}", err=True)
    if interruption.came:
        raise KeyboardInterrupt
    if totals.failed:
        raise InputError(f"{totals.failed:,} of {totals.failed + totals.done:,} files failed: see {where}")


def _check_timeout(seconds: float) -> float:
    # Written so that what is no number fails, too.
    if not 0 < seconds <= MOST_SECONDS:
        raise click.BadParameter(f"{seconds:g} is not above 0 and at most {MOST_SECONDS:,.0f} seconds")
    return seconds


def _listed(sources: Sequence[str]) -> list[str]:
    """The sources; instead of '-' those that standard input lists."""
    from ..batch.inputs import names_in

    if sources.count("-") > 1:
        raise UsageError("IN: '-' can be read once only")
    listed = []
    for source in sources:
        listed += names_in(standard_input()) if source == "-" else [source]
    return listed


def _skip(todo: Plan, log: Manifest, root: str, options: Options, wishes: Wishes, totals: Totals) -> None:
    """Take out of a plan what is done already; without a manifest, nothing may be there."""
    from ..batch.resume import check_new, finished, unfinished
    from ..batch.run import clear

    if not log.empty:
        left = unfinished(todo.tasks, finished(log.rows(), options), root, verify=wishes.verify, jobs=wishes.jobs)
        totals.skipped = len(todo.tasks) - len(left)
        todo.tasks = left
        clear(todo)
    elif not wishes.overwrite:
        check_new(todo.tasks, root)


def _engine(options: Options, wishes: Wishes) -> Engine:
    """What runs the tasks."""
    if wishes.scheduler is not None:
        from ..batch.dask import DaskPool

        return DaskPool(
            wishes.scheduler, options, overwrite=wishes.overwrite, memory=wishes.memory, timeout=wishes.timeout
        )
    from ..batch.pool import Pool

    assert wishes.memory is not None

    return Pool(
        options,
        overwrite=wishes.overwrite,
        jobs=wishes.jobs,
        memory=wishes.memory,
        timeout=wishes.timeout,
    )


def _summarize(manifest: str) -> None:
    from ..batch.manifest import read_manifest
    from ..batch.summary import totals_of, totals_text

    check_open(sys.stdout, "standard output")
    click.echo(totals_text(totals_of(read_manifest(manifest))))


def _cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
