"""`bldsimp compare`: run every method on the same buildings."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..errors import InputError, UsageError
from ..options import COMPARED_TOLERANCES, parse_tolerance
from .paths import Endpoint, check_open, check_output, endpoint_in
from .signals import unwind

if TYPE_CHECKING:
    from ..compare.rows import Comparison

_EXAMPLES = """
\b
Examples:
  bldsimp compare tower.obj
  bldsimp compare a.obj b.glb --tolerances auto,0.1%,0.02 --csv rows.csv
  bldsimp compare tower.obj --peers --json - | jq '.files[].rows[].points'
"""


@click.command(epilog=_EXAMPLES)
@click.argument("sources", metavar="FILE...", nargs=-1, required=True)
@click.option(
    "--tolerances",
    default=COMPARED_TOLERANCES,
    metavar="LIST",
    help="Tolerances separated by commas, each as for `simplify`.  [default: " + COMPARED_TOLERANCES + "]",
)
@click.option("--csv", metavar="FILE.csv|-", help="Also write the rows as CSV; '-' prints it instead.")
@click.option("--json", "json_", metavar="FILE.json|-", help="Also write the rows as JSON; '-' prints it instead.")
@click.option("--plot", metavar="FILE.svg|png", help="Also draw points against tolerance; PNG needs bldsimp[plots].")
@click.option("--html", metavar="FILE.html", help="Also write a page that shows the surfaces in 3D, offline.")
@click.option(
    "--peers", is_flag=True, help="Also run manifold3d, meshoptimizer, open3d, pymeshlab and pyfqmr, where installed."
)
@click.option("--from", "from_", metavar="FORMAT", help="Format of the files, if their suffix does not name it.")
@click.option("--overwrite", is_flag=True, help="Replace files that exist.")
@click.option("-q", "--quiet", is_flag=True, help="No table and no progress bar.")
def compare(
    sources: tuple[str, ...],
    tolerances: str,
    csv: str | None,
    json_: str | None,
    plot: str | None,
    html: str | None,
    peers: bool,
    from_: str | None,
    overwrite: bool,
    quiet: bool,
) -> None:
    """Compare methods on the same buildings: points, triangles, deviation, borders and time.

    The methods are: the original; improved, the result of `simplify`; standard, which cuts the outlines of improved
    until every piece is a Delaunay edge by itself; and fast-simplification. The last is searched for the fewest
    points within the deviation measured for improved (plain, with preserve_border, and lossless), and for the
    deviation at the number of points of improved.

    Only geometry is compared: textures, colors and normals are ignored. Deviations are measured both ways, from
    all points and 20,000 samples of each surface; the bound is certified. "border made" counts open edges that
    lie on no open edge of the original. Seconds are those of one run, without reading and searching; standard
    includes those of improved, whose facets it starts from.

    A file that cannot be read gets a row with the reason. The other files are compared, and the exit code is 1.
    """
    texts = _tolerances(tolerances)
    endpoints = [endpoint_in(source, from_) for source in sources]
    if sum(endpoint.path is None for endpoint in endpoints) > 1:
        raise UsageError("FILE: '-' can be read once only")
    outputs = {"--csv": csv, "--json": json_, "--plot": plot, "--html": html}
    printed = _printed(outputs)
    paths = {name: Path(text) for name, text in outputs.items() if text is not None and name != printed}
    if printed or not quiet:
        check_open(sys.stdout, "standard output")
    _check_outputs(paths, endpoints, overwrite)
    if "--plot" in paths:
        from ..compare.plot import check_plot

        check_plot(paths["--plot"].suffix)
    comparisons = _compared(dict(zip(sources, endpoints, strict=True)), texts, peers, quiet)
    from ..compare.table import format_text
    from ..io.atomic import replace_files

    written = {path: _written(name, path, comparisons) for name, path in paths.items()}
    unwind()
    replace_files(written)
    if printed:
        click.echo(_written(printed, Path("-"), comparisons), nl=False)
    elif not quiet:
        click.echo(format_text(comparisons))
    failed = [comparison for comparison in comparisons if comparison.failed]
    if failed:
        # What was printed must stand before the line that tells of the failure.
        sys.stdout.flush()
        names = ", ".join(comparison.file for comparison in failed)
        reason = f"{names}: {failed[0].rows[0].note}"
        raise InputError(reason if len(comparisons) == 1 else f"could not be compared: {names}")


def _printed(outputs: dict[str, str | None]) -> str | None:
    """The option that wants its file on standard output, if there is one.

    Raises
    ------
    UsageError
        Where it is more than one, or a picture or a page.
    """
    names = [name for name, text in outputs.items() if text == "-"]
    for name in names:
        if name not in ("--csv", "--json"):
            raise UsageError(f"{name}: '-' is for --csv and --json: give a file")
    if len(names) > 1:
        raise UsageError(f"{' and '.join(names)}: standard output takes one of them: give the other a file")
    return names[0] if names else None


def _tolerances(text: str) -> list[str]:
    """The tolerances of a list as the user wrote them, each once.

    Raises
    ------
    UsageError
        Where one of them is none.
    """
    found = list(dict.fromkeys(part.strip() for part in text.split(",")))
    for one in found:
        try:
            parse_tolerance(one)
        except UsageError as error:
            raise UsageError(f"--tolerances: {error}") from None
    return found


def _check_outputs(paths: dict[str, Path], endpoints: list[Endpoint], overwrite: bool) -> None:
    """Refuse files that cannot be meant: that exist, that are a model, or that are meant twice.

    Raises
    ------
    UsageError
    """
    taken = {endpoint.path.resolve(): "a model" for endpoint in endpoints if endpoint.path is not None}
    for name, path in paths.items():
        if path.resolve() in taken:
            raise UsageError(f"{name}: {path} is also {taken[path.resolve()]}: choose another file")
        check_output(path, name, overwrite)
        taken[path.resolve()] = name


def _written(name: str, path: Path, comparisons: list[Comparison]) -> bytes:
    """What an option wants written."""
    if name == "--plot":
        from ..compare.plot import draw_plot

        return draw_plot(comparisons, path.suffix)
    if name == "--html":
        from ..compare.page import build_page

        return build_page(comparisons)
    from ..compare.table import format_csv, format_json

    # Names of files need not be Unicode.
    return (format_csv if name == "--csv" else format_json)(comparisons).encode("utf-8", "backslashreplace")


def _compared(files: dict[str, Endpoint], texts: list[str], peers: bool, quiet: bool) -> list[Comparison]:
    """Compare one file after the other."""
    from ..compare.rows import compare_file, list_methods
    from ..compare.peers import find_peers

    asked = find_peers() if peers else []
    steps = len(texts) * len(list_methods(asked))
    comparisons = []
    with _progress(len(files) * steps, quiet) as move:
        for file, endpoint in files.items():
            comparison = compare_file(endpoint.data(), endpoint.format, file, texts, asked, lambda: move(1))
            comparisons.append(comparison)
            if comparison.failed:
                move(steps)
    return comparisons


@contextmanager
def _progress(steps: int, quiet: bool) -> Iterator[Callable[[int], None]]:
    """A bar on standard error, if that is a terminal."""
    if quiet or not sys.stderr.isatty():
        yield lambda count: None
        return
    with click.progressbar(length=steps, label="comparing", file=sys.stderr) as bar:
        yield bar.update
