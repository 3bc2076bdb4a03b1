"""One file, several tolerances, all methods: the same input after the same weld, the same measure, the same run."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, replace
from functools import cached_property
from pathlib import Path

from ..errors import BldsimpError, InputError, InternalError
from ..io import read
from ..model import Scene
from ..options import Options, parse_tolerance
from ..scene import simplify_meshes
from ..tolerance import diagonal, resolve_tolerance
from ..triangulation import Statistics
from .decimate import Decimator, FastSimplification, Found, Refused
from .measure import Judge, is_watertight
from .peers import Peer
from .row import Comparison, Row
from .standard import standard_surface
from .surface import Surface, surface_of

PLAIN, BORDER = "fast-simplification", "fast-simplification border"

VARIANTS = {
    PLAIN: FastSimplification(),
    BORDER: FastSimplification(preserve_border=True),
    "fast-simplification lossless": FastSimplification(lossless=True),
}
"""Each is asked for the deviation of `improved`; the first also for its number of points."""

SAME_POINTS = "fast-simplification same points"

SPARE_POINTS = 0.01
"""So many more points than `improved`, by its own, still count as the same number."""

BLUR_SHOWS = 0.01
"""Beyond this share of the deviation, the note tells what single precision blurs."""

Tick = Callable[[], None]


def method_names(peers: list[Peer]) -> list[str]:
    """All methods in their order."""
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
        What the rows call it.
    tolerances : list of str
        As `bldsimp.options.parse_tolerance` reads them.
    peers : list of Peer, optional
        Other tools to ask, too.
    tick : callable
        Called after each row.

    Returns
    -------
    Comparison
        With one row that tells why where the file cannot be read or has no surface.

    Raises
    ------
    UsageError
        Where a tolerance is none.
    """
    wanted = {text: parse_tolerance(text) for text in tolerances}
    try:
        scene = read(source, format_)
        contest = Contest(file, scene, peers or [])
        lengths = {text: resolve_tolerance(scene, tolerance) for text, tolerance in wanted.items()}
        rows = []
        for text, length in lengths.items():
            for row in contest.rows(text, Options(tolerance=wanted[text], delimit=frozenset({"material"})), length):
                rows.append(row)
                tick()
    except InternalError:
        raise
    except BldsimpError as error:
        reason = str(error).removeprefix(f"{file}: ")
        return Comparison(file, None, 0.0, {}, [Row(file, "", "original", note=f"failed: {reason}")], failed=True)
    return Comparison(file, contest.judge.original, diagonal(scene), lengths, rows)


class Contest:
    """All methods on one scene; what they share between tolerances is made once.

    Raises
    ------
    InputError
        Where the scene has no surface.
    """

    def __init__(self, file: str, scene: Scene, peers: list[Peer]) -> None:
        original = surface_of(scene)
        if not len(original.faces):
            raise InputError("no faces that have three different points")
        self.file, self.scene, self.peers = file, scene, peers
        self.judge = Judge(original)
        self._decimators = {
            name: Decimator(self.judge, variant, aimed=not variant.lossless) for name, variant in VARIANTS.items()
        }
        if not self.judge.has_border:
            # There is nothing to preserve: the same runs, which are most of the time on a large mesh.
            self._decimators[BORDER] = self._decimators[PLAIN]
        self._asked = {peer.name: Decimator(self.judge, peer.decimate, most=peer.most) for peer in peers}

    @cached_property
    def original(self) -> Row:
        """The row of the original, but for its tolerance."""
        return self._row(Row(self.file, "", "original"), self.judge.original, 0.0, 0.0)

    def rows(self, text: str, options: Options, tolerance: float) -> Iterator[Row]:
        """The rows of one tolerance, in the order of the methods."""
        empty = Row(self.file, text, "")
        yield replace(self.original, tolerance=text)
        standard, improved = self._ours(empty, options, tolerance)
        yield standard
        yield improved
        for name, decimator in self._decimators.items():
            yield self._at_same_deviation(replace(empty, method=name), decimator, improved, tolerance)
        yield self._at_same_points(replace(empty, method=SAME_POINTS), improved, tolerance)
        for peer in self.peers:
            row = replace(empty, method=peer.name)
            yield self._at_same_deviation(row, self._asked[peer.name], improved, tolerance)

    def _ours(self, row: Row, options: Options, tolerance: float) -> tuple[Row, Row]:
        """Standard and improved, of which the first starts from what the second found."""
        outcomes, report = simplify_meshes(self.scene, options, keep_layout=True)
        improved = replace(
            row,
            method="improved",
            bound=report.deviation,
            seconds=report.seconds,
            statistics=asdict(sum((outcome.statistics for outcome in outcomes), Statistics())),
        )
        start = time.perf_counter()
        made = standard_surface(self.scene, outcomes)
        standard = replace(
            row,
            method="standard",
            # The facets that it starts from had to be found as well.
            seconds=report.seconds + time.perf_counter() - start,
            note=made.note,
            statistics=asdict(made.statistics),
        )
        light = surface_of(self.scene, [outcome.mesh for outcome in outcomes])
        return (
            self._row(standard, made.surface, self.judge.deviation(made.surface), tolerance),
            self._row(improved, light, self.judge.deviation(light), tolerance),
        )

    def _at_same_deviation(self, row: Row, decimator: Decimator, improved: Row, tolerance: float) -> Row:
        """The fewest points within the deviation of `improved`, or why there are none."""
        deviation, blur = improved.deviation or 0.0, self.judge.blur
        told = f"same deviation as improved ({deviation:.3g}"
        told += f" and {blur:.2g} that single precision blurs)" if blur > BLUR_SHOWS * deviation else ")"
        try:
            found = decimator.fewest_points(deviation + blur)
        except Refused as reason:
            return replace(row, note=f"refuses the input: {reason}")
        if found is None:
            return replace(row, note=f"no reduction within the {told}")
        return self._found(replace(row, note=told), found, tolerance)

    def _at_same_points(self, row: Row, improved: Row, tolerance: float) -> Row:
        """The deviation at the number of points of `improved`."""
        points = improved.points or 0
        found = self._decimators[PLAIN].at_points(points)
        least = len(found.surface.points)
        if least > points + math.ceil(SPARE_POINTS * points):
            return replace(row, note=f"does not get down to the {points:,} points of improved: stops at {least:,}")
        more = "" if least <= points else f" and {least - points} more, which it cannot drop"
        return self._found(replace(row, note=f"same number of points as improved{more}"), found, tolerance)

    def _found(self, row: Row, found: Found, tolerance: float) -> Row:
        return self._row(replace(row, seconds=found.seconds), found.surface, found.deviation, tolerance)

    def _row(self, row: Row, surface: Surface, deviation: float, tolerance: float) -> Row:
        """A row with what is measured on its surface."""
        return replace(
            row,
            points=len(surface.points),
            triangles=len(surface.faces),
            deviation=deviation,
            watertight=is_watertight(surface),
            border_made=self.judge.borders_made(surface, max(tolerance, deviation)),
            surface=surface,
        )
