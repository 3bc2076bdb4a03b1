"""Compare one file at several tolerances by all methods: the same weld, the same measure, one row for each result."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path

from ..errors import BldsimpError, InputError, InternalError
from ..io import read
from ..model import Scene
from ..options import Options, parse_tolerance
from ..scene import simplify_meshes
from ..tolerance import measure_diagonal, resolve_tolerance
from ..triangulation import Statistics
from .decimate import Decimator, FastSimplification, RefusalError
from .measure import Judge, is_watertight
from .peers import Peer
from .placement import PlacedSurface, place_scene
from .standard import build_standard_surface

PLAIN, BORDER = "fast-simplification", "fast-simplification border"

VARIANTS = {
    PLAIN: FastSimplification(),
    BORDER: FastSimplification(preserve_border=True),
    "fast-simplification lossless": FastSimplification(lossless=True),
}
"""Each gets the deviation of `improved` as its limit; the first also its number of points."""

SAME_POINTS = "fast-simplification same points"

EXTRA_POINTS = 0.01
"""Up to this share more points than `improved` still count as the same number."""

BLUR_SHOWS = 0.01
"""Beyond this share of the deviation, the note names the rounding of single precision."""

Tick = Callable[[], None]


@dataclass
class MethodRow:
    """The result of one method for one file at one tolerance; None where there is no figure.

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
        The meaning of the figures, or the reason why there are none.
    statistics : dict of str to int or float
        Counts of the triangulation.
    surface : PlacedSurface
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
    surface: PlacedSurface | None = field(default=None, repr=False, compare=False)


COLUMNS = tuple(each.name for each in fields(MethodRow) if each.name not in ("statistics", "surface"))
"""Header of the CSV; also the keys of a row in JSON."""


@dataclass
class Comparison:
    """All rows of one file.

    Attributes
    ----------
    file : str
    original : PlacedSurface or None
        None where the file could not be read.
    diagonal : float
        Model units.
    tolerances : dict of str to float
        Model units, keyed by the user's text.
    rows : list of MethodRow
        By tolerance, in the order of the methods; a single one with the reason where the file failed.
    failed : bool
    """

    file: str
    original: PlacedSurface | None
    diagonal: float
    tolerances: dict[str, float]
    rows: list[MethodRow]
    failed: bool = False


def list_methods(peers: list[Peer]) -> list[str]:
    """Name all methods in their order."""
    return ["original", "standard", "improved", *VARIANTS, SAME_POINTS, *(peer.name for peer in peers)]


def compare_file(
    source: Path | bytes,
    format_: str,
    file: str,
    tolerances: list[str],
    peers: list[Peer] | None = None,
    tick: Tick = lambda: None,
) -> Comparison:
    """Simplify one file with every method at several tolerances, and measure the results.

    Parameters
    ----------
    source : Path or bytes
    format_ : str
    file : str
        Its name in the rows.
    tolerances : list of str
        As `bldsimp.options.parse_tolerance` reads them.
    peers : list of Peer, optional
        Other tools to run, too.
    tick : callable
        Called after each row.

    Returns
    -------
    Comparison
        With one row that says why where the file cannot be read or has no surface.

    Raises
    ------
    UsageError
        If a tolerance cannot be parsed.
    """
    wanted = {text: parse_tolerance(text) for text in tolerances}
    try:
        scene = read(source, format_)
        contest = Contest(file, scene, peers or [])
        lengths = {text: resolve_tolerance(scene, tolerance) for text, tolerance in wanted.items()}
        rows = []
        for text, length in lengths.items():
            for row in contest.run(text, Options(tolerance=wanted[text], delimit=frozenset({"material"})), length):
                rows.append(row)
                tick()
    except InternalError:
        raise
    except BldsimpError as error:
        reason = str(error).removeprefix(f"{file}: ")
        return Comparison(file, None, 0.0, {}, [MethodRow(file, "", "original", note=f"failed: {reason}")], failed=True)
    return Comparison(file, contest.judge.original, measure_diagonal(scene), lengths, rows)


class Contest:
    """All methods on one scene; tolerances share the measure and the runs of decimators.

    Raises
    ------
    InputError
        If the scene has no surface.
    """

    def __init__(self, file: str, scene: Scene, peers: list[Peer]) -> None:
        original = place_scene(scene)
        if not len(original.faces):
            raise InputError("no faces that have three different points")
        self.file, self.scene = file, scene
        self.judge = Judge(original)
        self._decimators = {
            name: Decimator(self.judge, variant, aimed=not variant.lossless) for name, variant in VARIANTS.items()
        }
        if not self.judge.has_border:
            # There is nothing to preserve: the same runs, which are most of the time on a large mesh.
            self._decimators[BORDER] = self._decimators[PLAIN]
        self._peers = {peer.name: Decimator(self.judge, peer.decimate, most=peer.most) for peer in peers}
        self._original = self._measure(MethodRow(file, "", "original"), original, 0.0, deviation=0.0)

    def run(self, text: str, options: Options, tolerance: float) -> Iterator[MethodRow]:
        """Run all methods at one tolerance; yield a row for each, in their order."""
        empty = MethodRow(self.file, text, "")
        yield replace(self._original, tolerance=text)
        standard, improved = self._run_ours(empty, options, tolerance)
        yield standard
        yield improved
        for name, decimator in self._decimators.items():
            yield self._match_deviation(replace(empty, method=name), decimator, improved, tolerance)
        yield self._match_points(replace(empty, method=SAME_POINTS), improved, tolerance)
        for name, decimator in self._peers.items():
            yield self._match_deviation(replace(empty, method=name), decimator, improved, tolerance)

    def _run_ours(self, row: MethodRow, options: Options, tolerance: float) -> tuple[MethodRow, MethodRow]:
        """Run `standard` and `improved`; the first starts from the facets of the second."""
        results, report = simplify_meshes(self.scene, options, keep_layout=True)
        statistics = asdict(sum((result.statistics for result in results), Statistics()))
        improved = replace(
            row, method="improved", bound=report.deviation, seconds=report.seconds, statistics=statistics
        )
        start = time.perf_counter()
        made = build_standard_surface(self.scene, results)
        # Finding the facets that it starts from took time as well.
        seconds = report.seconds + time.perf_counter() - start
        standard = replace(row, method="standard", seconds=seconds, note=made.note, statistics=asdict(made.statistics))
        simplified = place_scene(self.scene, [result.mesh for result in results])
        return self._measure(standard, made.surface, tolerance), self._measure(improved, simplified, tolerance)

    def _match_deviation(
        self, row: MethodRow, decimator: Decimator, improved: MethodRow, tolerance: float
    ) -> MethodRow:
        """Find the fewest points within the deviation of `improved`, or note why there are none."""
        deviation, blur = improved.deviation or 0.0, self.judge.blur
        limit = f"same deviation as improved ({deviation:.3g}"
        limit += f" plus {blur:.2g} for single precision)" if blur > BLUR_SHOWS * deviation else ")"
        try:
            found = decimator.find_fewest_points(deviation + blur)
        except RefusalError as reason:
            return replace(row, note=f"refuses the input: {reason}")
        if found is None:
            return replace(row, note=f"no reduction within the {limit}")
        return self._measure(replace(row, note=limit, seconds=found.seconds), found.surface, tolerance, found.deviation)

    def _match_points(self, row: MethodRow, improved: MethodRow, tolerance: float) -> MethodRow:
        """Find the deviation at the number of points of `improved`."""
        points = improved.points or 0
        found = self._decimators[PLAIN].find_point_count(points)
        least = len(found.surface.points)
        if least > points + math.ceil(EXTRA_POINTS * points):
            return replace(row, note=f"does not reach the {points:,} points of improved: stops at {least:,}")
        more = "" if least <= points else f" plus {least - points}, which it cannot remove"
        row = replace(row, note=f"same number of points as improved{more}", seconds=found.seconds)
        return self._measure(row, found.surface, tolerance, found.deviation)

    def _measure(
        self, row: MethodRow, surface: PlacedSurface, tolerance: float, deviation: float | None = None
    ) -> MethodRow:
        """Complete a row by the figures of its surface, whose deviation may be known."""
        deviation = self.judge.measure_deviation(surface) if deviation is None else deviation
        return replace(
            row,
            points=len(surface.points),
            triangles=len(surface.faces),
            deviation=deviation,
            watertight=is_watertight(surface),
            border_made=self.judge.count_new_borders(surface, max(tolerance, deviation)),
            surface=surface,
        )
