"""`bldsimp compare`: what every method makes of the same models."""

from __future__ import annotations

import io
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..errors import InputError, UsageError
from ..options import COMPARED_TOLERANCES, parse_tolerance
from .options import FILE, FROM, parse_with
from .paths import Endpoint, check_output, check_standard_output, find_input
from .signals import raise_on_signals

if TYPE_CHECKING:
    from ..compare.rows import Comparison

_EXAMPLES = """
\b
Examples:
  bldsimp compare tower.obj
  bldsimp compare a.obj b.glb --tolerances auto,0.1%,0.02 --csv rows.csv
  bldsimp compare tower.obj --peers --json - | jq '.files[].rows[].points'
"""


def _parse_tolerances(text: str) -> list[str]:
    """Split a list of tolerances as the user wrote them, each once; check each of them."""
    tolerances = list(dict.fromkeys(part.strip() for part in text.split(",")))
    for tolerance in tolerances:
        parse_tolerance(tolerance)
    return tolerances


def _output(name: str, metavar: str, words: str) -> Callable[[click.decorators.FC], click.decorators.FC]:
    """Make the option of an output that `_encode` knows."""
    return click.option(name, type=FILE, metavar=metavar, help=words)


@click.command(epilog=_EXAMPLES)
@click.argument("sources", metavar="FILE...", nargs=-1, required=True, type=FILE)
@click.option(
    "--tolerances",
    callback=parse_with(_parse_tolerances),
    default=COMPARED_TOLERANCES,
    metavar="LIST",
    help="Tolerances separated by commas, each as in `simplify`.",
)
@_output("--csv", "FILE.csv|-", "Also write the rows as CSV; '-' prints them, and no table.")
@_output("--json", "FILE.json|-", "Also write the rows as JSON; '-' prints them, and no table.")
@_output("--plot", "FILE.svg|png", "Also plot points against tolerance; PNG needs bldsimp[plots].")
@_output("--html", "FILE.html", "Also write one page that shows the surfaces in 3D, offline.")
@click.option(
    "--peers", is_flag=True, help="Also run manifold3d, meshoptimizer, open3d, pymeshlab and pyfqmr, if installed."
)
@FROM
@click.option("--overwrite", is_flag=True, help="Replace files that exist.")
@click.option("-q", "--quiet", is_flag=True, help="Print no table and no progress bar.")
def compare(
    *,
    sources: tuple[str, ...],
    tolerances: list[str],
    peers: bool,
    from_: str | None,
    overwrite: bool,
    quiet: bool,
    **outputs: str | None,
) -> None:
    """Compare methods on the same models.

    For each FILE and tolerance there is a row for each method: points, triangles, deviation, borders and time.
    "original" is the input. "standard" cuts the outlines of "improved" until every piece is a Delaunay edge by itself.
    "improved" is what `simplify` does. "fast-simplification" runs plain, with preserve_border and with lossless, once
    at the deviation that was measured for "improved" (by a search for its target), and once with as many points as
    "improved" has.

    Only geometry is compared, not textures, colors and normals. Deviations are measured both ways, from all points
    and 20,000 samples of each surface, and certified to a thousandth; the bound is certified. A border is made where
    an open edge lies on none of the original. Seconds are those of one run, without reading and searching. The
    seconds of "standard" include those of "improved", whose facets it starts from.

    A file that cannot be read gets a row that says why; the others are compared, and the exit code is 1.
    """
    endpoints = [find_input(source, from_) for source in sources]
    if sources.count("-") > 1:
        raise UsageError("FILE: '-' can be read only once")
    printed = _find_printed(outputs)
    paths = {name: Path(text) for name, text in outputs.items() if text is not None and name != printed}
    if printed or not quiet:
        check_standard_output()
    _check_outputs(paths, endpoints, overwrite)
    comparisons = _compare_files(dict(zip(sources, endpoints, strict=True)), tolerances, peers, quiet)
    from ..compare.table import format_text
    from ..io.atomic import replace_files

    files = {path: _encode(name, path, comparisons) for name, path in paths.items()}
    raise_on_signals()
    replace_files(files)
    if printed:
        click.echo(_encode(printed, Path("-"), comparisons), nl=False)
    elif not quiet:
        click.echo(format_text(comparisons))
    failed = [comparison for comparison in comparisons if comparison.failed]
    if failed:
        # The table must precede the line that reports the failure.
        sys.stdout.flush()
        names = ", ".join(comparison.file for comparison in failed)
        reason = f"{names}: {failed[0].rows[0].note}"
        raise InputError(reason if len(comparisons) == 1 else f"could not be compared: {names}")


def _find_printed(outputs: dict[str, str | None]) -> str | None:
    """Find the output that goes to standard output, if there is one.

    Raises
    ------
    UsageError
        Where there is more than one, or it is a picture or a page.
    """
    names = [name for name, text in outputs.items() if text == "-"]
    for name in names:
        if name not in ("csv", "json"):
            raise UsageError(f"--{name}: '-' works only with --csv and --json: give a file")
    if len(names) > 1:
        raise UsageError("--csv and --json: only one can go to standard output: give a file for the other")
    return names[0] if names else None


def _check_outputs(paths: dict[str, Path], endpoints: list[Endpoint], overwrite: bool) -> None:
    """Refuse files that exist, that are a model, or that are given twice, and what cannot be drawn.

    Raises
    ------
    UsageError
    """
    taken = {endpoint.path.resolve(): "a model" for endpoint in endpoints if endpoint.path is not None}
    for name, path in paths.items():
        if path.resolve() in taken:
            raise UsageError(f"--{name}: {path} is also {taken[path.resolve()]}: choose another file")
        check_output(path, f"--{name}", overwrite)
        taken[path.resolve()] = f"--{name}"
    if "plot" in paths:
        from ..compare.plot import check_plot

        check_plot(paths["plot"].suffix)


def _encode(name: str, path: Path, comparisons: list[Comparison]) -> bytes:
    """Encode the content of an output."""
    if name == "plot":
        from ..compare.plot import draw_plot

        return draw_plot(comparisons, path.suffix)
    if name == "html":
        from ..compare.page import build_page

        return build_page(comparisons)
    from ..compare.table import format_csv, format_json

    # Names of files need not be Unicode.
    return (format_csv if name == "csv" else format_json)(comparisons).encode("utf-8", "backslashreplace")


def _compare_files(files: dict[str, Endpoint], tolerances: list[str], peers: bool, quiet: bool) -> list[Comparison]:
    """Compare one file after the other."""
    from ..compare.peers import find_peers
    from ..compare.rows import compare_file, list_methods

    asked = find_peers() if peers else []
    steps = len(tolerances) * len(list_methods(asked))
    comparisons = []
    # Elsewhere than on a terminal, click prints the label.
    shown = sys.stderr if sys.stderr.isatty() and not quiet else io.StringIO()
    with click.progressbar(length=len(files) * steps, label="comparing", file=shown) as bar:
        for file, endpoint in files.items():
            comparison = compare_file(
                endpoint.get_source(), endpoint.format, file, tolerances, asked, lambda: bar.update(1)
            )
            comparisons.append(comparison)
            if comparison.failed:
                bar.update(steps)
    return comparisons
