"""Options that commands share, and values that bldsimp's own functions parse."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

from ..errors import UsageError
from ..options import (
    DEFAULTS,
    DELIMITS,
    NORMALS,
    Options,
    parse_delimit,
    parse_length,
    parse_tolerance,
)

FILE = click.Path(dir_okay=False, readable=False, allow_dash=True)
"""A file to read or write; shells complete its name. Later checks say whether it can be read or written."""


def parse_with(parse: Callable[[str], Any]) -> Callable[[click.Context, click.Parameter, str | None], Any]:
    """Make the callback of an option whose value a function parses; it raises `UsageError` where the text is wrong."""

    def parse_value(context: click.Context, option: click.Parameter, text: str | None) -> Any:
        try:
            return None if text is None else parse(text)
        except UsageError as error:
            raise click.BadParameter(str(error), context, option) from None

    return parse_value


def _length_option(name: str, metavar: str, words: str) -> Callable[[click.decorators.FC], click.decorators.FC]:
    """Make an option whose value is a length, with the default of `Options`."""
    default = getattr(DEFAULTS, name.removeprefix("--").replace("-", "_"))
    return click.option(name, callback=parse_with(parse_length), default=f"{default:g}", metavar=metavar, help=words)


FROM = click.option("--from", "from_", metavar="FORMAT", help="Format of the input, where its suffix does not tell.")
TO = click.option("--to", metavar="FORMAT", help="Format of the result, where its suffix does not tell.")

_OPTIONS = [
    click.option(
        "--tolerance",
        callback=parse_with(parse_tolerance),
        default="auto",
        metavar="auto|LENGTH|PERCENT%",
        help="How far any point of the surface may move: a length in model units, a percentage of the diagonal of the"
        " model's bounding box, or 'auto', the precision of the file's own coordinates, so that no detail is lost. 0"
        " removes only what is exactly coplanar or collinear.",
    ),
    _length_option(
        "--weld", "LENGTH", "Merge points closer than this, in model units; 0 merges identical points only."
    ),
    _length_option(
        "--min-component",
        "LENGTH",
        "Remove components whose bounding box has a smaller diagonal than this, in model units, such as antennas."
        " The tolerance does not limit this, and the deviation does not include it.",
    ),
    click.option("--min-part", callback=parse_with(parse_length), hidden=True),
    click.option(
        "--keep-topology",
        is_flag=True,
        help="Keep every passage and boundary loop. Without it a tolerance above a hundred-thousandth of the diagonal"
        " closes those that are as small as it, such as window openings and vents.",
    ),
    click.option("--allow-close", is_flag=True, hidden=True),
    click.option(
        "--normals",
        type=click.Choice(NORMALS),
        default="auto",
        help="Vertex normals of the result. 'auto' keeps the input's normals unless they equal the face normals;"
        " 'smooth' computes new ones.",
    ),
    _length_option(
        "--crease-angle",
        "DEGREES",
        "Edges that turn by more than this are hard: facets end where stored normals do, and new normals are not"
        " smooth there. Recompute normals that deviate more than this from a face.",
    ),
    click.option(
        "--delimit",
        callback=parse_with(parse_delimit),
        default="all",
        metavar="WORDS",
        help=f"Attributes that facets may not cross, separated by commas: {', '.join(DELIMITS)}. 'crease' means hard"
        " edges of stored normals, 'feature' means ids and labels. UV, colors and features that you leave out are"
        " removed; 'none' keeps only the geometry.",
    ),
    _length_option(
        "--texture-tolerance",
        "TEXELS",
        "How far a texture may move on its wall, in texels of the largest image of its material.",
    ),
]


def add_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options that choose how a file is simplified; `make_options` takes their values."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def make_options(min_part: float | None = None, **values: Any) -> Options:
    """Make `Options` of parsed values; `min_part` is the deprecated name of `min_component`."""
    if min_part is not None:
        click.echo("warning    --min-part is deprecated: use --min-component", err=True)
        values["min_component"] = min_part
    if values.get("allow_close"):
        click.echo("warning    --allow-close does nothing any more: a wide tolerance closes what is as small", err=True)
    return Options(**values)
