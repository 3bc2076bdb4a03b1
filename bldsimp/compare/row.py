"""What a comparison gives: one row per file, tolerance and method."""

from __future__ import annotations

from dataclasses import dataclass, field

from .surface import Surface

COLUMNS = (
    "file", "tolerance", "method", "points", "triangles", "deviation", "bound", "watertight",
    "border_made", "seconds", "note",
)  # fmt: skip
"""Header of the CSV; also the keys of a row in JSON."""


@dataclass
class Row:
    """What one method made of one file at one tolerance; None where there is no figure.

    Attributes
    ----------
    file, tolerance : str
        As the user wrote them.
    method : str
    points, triangles : int
        Of the welded result.
    deviation : float
        Measured both ways, model units.
    bound : float
        Certified deviation, model units, of methods that have one.
    watertight : bool
    border_made : int
        Open edges of the result that lie on no open edge of the original.
    seconds : float
    note : str
        What the figures mean, or why there are none.
    statistics : dict of str to int or float
        What the triangulation did.
    surface : Surface
        The result.
    """

    file: str
    tolerance: str
    method: str
    points: int | None = None
    triangles: int | None = None
    deviation: float | None = None
    bound: float | None = None
    watertight: bool | None = None
    border_made: int | None = None
    seconds: float | None = None
    note: str = ""
    statistics: dict[str, float] = field(default_factory=dict)
    surface: Surface | None = field(default=None, repr=False, compare=False)


@dataclass
class Comparison:
    """All rows of one file.

    Attributes
    ----------
    file : str
    original : Surface or None
        None where the file could not be read.
    diagonal : float
        Model units.
    tolerances : dict of str to float
        Model units, by what the user wrote.
    rows : list of Row
        By tolerance, in the order of the methods; a single one with the reason where the file failed.
    failed : bool
    """

    file: str
    original: Surface | None
    diagonal: float
    tolerances: dict[str, float]
    rows: list[Row]
    failed: bool = False
