"""`bldsimp inspect`: count what a file contains."""

from __future__ import annotations

import json

import click

from .options import FILE, FROM
from .paths import check_standard_output, find_input


@click.command()
@click.argument("source", metavar="IN", type=FILE)
@FROM
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def inspect(source: str, from_: str | None, as_json: bool) -> None:
    """Show what a file contains.

    Lists sizes, defects and attributes of IN, so that you can look before you simplify. '-' is standard input.
    """
    check_standard_output()
    endpoint = find_input(source, from_)
    from ..inspection import inspect_scene
    from ..io import read
    from .summary import describe_inspection

    inspection = inspect_scene(read(endpoint.get_source(), endpoint.format))
    click.echo(json.dumps(inspection.to_dict(), indent=2) if as_json else describe_inspection(inspection))
