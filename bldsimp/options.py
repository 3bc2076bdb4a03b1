"""Every default of bldsimp, with its unit, in one place."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from numbers import Real
from typing import Any

from .errors import UsageError

AUTO_SPACINGS = 16.0
"""`auto` tolerance in units of the spacing of the stored numbers at the largest coordinate."""

AUTO_DIAGONAL = 1e-6
"""`auto` tolerance never exceeds this share of the diagonal of the box of all used points."""

WIDTH_SHARE = 0.95
"""Share of the tolerance that the width of a facet may use; its chains get what it leaves (squares add up)."""

NEEDLE_DIAGONAL = 1e-6
"""A face no higher than this share of the diagonal, nor than the tolerance, has no plane of its own."""

STAGED_DIAGONAL = 1e-5
"""A tolerance above this share of the diagonal is spent by collapses, on what is left at `AUTO_DIAGONAL`."""

MOVED_SHARE = 1e-3
"""Coordinates of points that a wide tolerance moves are rounded to no more than this share of it."""

SPARE_SHARE = 0.99
"""Share of a wide tolerance within which the rest must hold a body or a detail that goes; the rest may still move."""

FLAT_SHARE = 0.02
"""Details are found between facets that are flat within this share of a wide tolerance, to either side."""

LEAST_GAIN = 0.125
"""Curved surfaces of a component that would lose a smaller share of their points keep their faces, so that a
second run, which always finds another cut, finds little to do."""

FLAT_NORMALS_DEGREES = 1.0
"""Input normals within this angle of their face normals mean a flat-shaded input; degrees."""

SIGNIFICANT_DIGITS = 6
"""Decimal numbers with fewer significant digits are taken as exact, not as rounded."""

DELIMITS = ("material", "uv", "color", "feature", "crease")
"""What facets may be kept from crossing."""

TEXTURE_TOLERANCE = 0.5
"""How far a texture may move on its wall, in texels."""

COLOR_TOLERANCE = 1.5
"""How far an interpolated color may be off, in levels of 255: what their own rounding blurs, and a little more."""

COLOR_LEVELS = 255.0
"""Levels of a color that can be told apart."""

CUSTOM_LEVELS = 1e5
"""Levels, up to the greatest magnitude, that can be told apart of interpolated numbers whose meaning is not known."""

UNKNOWN_TEXELS = 4096
"""Width and height of an image of unknown size, in texels."""

CREASE_DEGREES = 30.0
"""An edge is a crease where its faces, or the normals stored at it, turn by more than this; degrees."""

COMPARED_TOLERANCES = "auto,0.1%,0.5%"
"""What `compare` takes, with commas between."""

BATCH_TIMEOUT = 3600.0
"""Seconds that `batch` gives a file."""

BATCH_MEMORY_SHARE = 0.8
"""Share of the memory free at the start that `batch` uses."""

BATCH_NAME = "{stem}.{ext}"
"""How `batch` names an output."""

UNITS = ("auto", "length", "percent")
"""What a tolerance may be given in."""

NORMALS = ("auto", "flat", "smooth", "none")
"""What vertex normals a result may get."""


def is_length(value: Any) -> bool:
    """Tell whether a value is a real number, finite and not negative; truth values are no numbers."""
    try:
        return isinstance(value, Real) and not isinstance(value, bool) and 0.0 <= float(value) < math.inf
    except OverflowError:
        return False


def check_length(name: str, value: Any) -> None:
    """Refuse a value that is not a length: a finite number that is not negative.

    Raises
    ------
    UsageError
    """
    if not is_length(value):
        raise UsageError(f"{name} {str(value)[:40]!r}: give a number that is finite and not negative")


@dataclass(frozen=True)
class Tolerance:
    """How far any point of the surface may move.

    Attributes
    ----------
    value : float
        Model units where `unit` is ``"length"``, percent of the diagonal where it is ``"percent"``;
        not used where it is ``"auto"``.
    unit : str
        ``"length"``, ``"percent"`` or ``"auto"``.

    Examples
    --------
    >>> Tolerance(0.02, "length")
    Tolerance(value=0.02, unit='length')
    """

    value: float = 0.0
    unit: str = "auto"

    def __post_init__(self) -> None:
        if self.unit not in UNITS:
            raise UsageError(f"tolerance unit {self.unit!r}: choose one of {', '.join(UNITS)}")
        check_length("tolerance", self.value)


@dataclass(frozen=True)
class Options:
    """Options of `simplify`.

    Attributes
    ----------
    tolerance : Tolerance
    weld : float
        Points nearer than this are one; model units; 0 welds exactly equal points only.
    normals : str
        ``auto``, ``flat``, ``smooth`` or ``none``.
    delimit : frozenset of str
        What facets may not cross, of `DELIMITS`; UV, colors and feature ids that they may cross are dropped.
    texture_tolerance : float
        How far a texture may move on its wall; texels.
    crease_angle : float
        Edges that turn by more are hard: facets end where stored normals do, and new normals are not smooth there.
        Normals of moved points that deviate more than this from a face are computed anew; degrees.
    baseline : bool
        Also report the points that fast-simplification needs for the same deviation.
    min_component : float
        Components whose box has a smaller diagonal than this are removed, whatever the tolerance; model units; 0 for
        none. The deprecated name is `min_part`.
    keep_topology : bool
        Keep every passage and boundary loop, whatever the tolerance.
    allow_close : bool
        Deprecated, without effect: a wide tolerance closes what is as small as it.

    Examples
    --------
    >>> options = Options(Tolerance(0.1, "percent"), delimit=frozenset({"material"}))
    >>> options.keeps("uv"), options.crease_angle
    (False, 30.0)
    """

    tolerance: Tolerance = Tolerance()
    weld: float = 0.0
    normals: str = "auto"
    delimit: frozenset[str] = frozenset(DELIMITS)
    texture_tolerance: float = TEXTURE_TOLERANCE
    crease_angle: float = CREASE_DEGREES
    baseline: bool = False
    min_component: float = 0.0
    keep_topology: bool = False
    allow_close: bool = False

    def __post_init__(self) -> None:
        if not isinstance(self.tolerance, Tolerance):
            raise UsageError(f"tolerance {self.tolerance!r}: give a Tolerance")
        if self.normals not in NORMALS:
            raise UsageError(f"normals {self.normals!r}: choose one of {', '.join(NORMALS)}")
        unknown = sorted(set(self.delimit) - set(DELIMITS))
        if unknown:
            raise UsageError(f"delimit {unknown[0]!r}: choose of {', '.join(DELIMITS)}")
        for name in ("weld", "min_component", "texture_tolerance", "crease_angle"):
            check_length(name, getattr(self, name))

    @property
    def min_part(self) -> float:
        """The deprecated name of `min_component`."""
        warnings.warn("min_part is deprecated: use min_component", DeprecationWarning, stacklevel=2)
        return self.min_component

    def keeps(self, kind: str) -> bool:
        """Tell whether attributes of a kind are kept."""
        return kind in self.delimit or (kind == "tangent" and "uv" in self.delimit)


def _accept_old_names(make: Callable[..., None]) -> Callable[..., None]:
    """Let `Options` take the deprecated name of a field, too."""

    @wraps(make)
    def make_options(self: Options, *values: Any, **named: Any) -> None:
        if "min_part" in named and "min_component" in named:
            raise TypeError("give min_component alone: min_part is its deprecated name")
        if "min_part" in named:
            warnings.warn("min_part is deprecated: use min_component", DeprecationWarning, stacklevel=2)
            named["min_component"] = named.pop("min_part")
        make(self, *values, **named)

    return make_options


Options.__init__ = _accept_old_names(Options.__init__)  # type: ignore[method-assign]

DEFAULTS = Options()


def parse_tolerance(text: str) -> Tolerance:
    """Read ``auto``, a length in model units (``0.02``) or a share of the diagonal (``0.1%``).

    Raises
    ------
    UsageError
        Where the text is none of these, or the number is negative, infinite or no number.

    Examples
    --------
    >>> parse_tolerance("0.1%")
    Tolerance(value=0.1, unit='percent')
    """
    if text.strip().lower() == "auto":
        return Tolerance()
    percent = text.strip().endswith("%")
    return Tolerance(parse_length(text.strip().removesuffix("%"), text), "percent" if percent else "length")


def parse_delimit(text: str) -> frozenset[str]:
    """Read what facets may not cross: words of `DELIMITS` with commas between, ``all`` or ``none``.

    Raises
    ------
    UsageError

    Examples
    --------
    >>> sorted(parse_delimit("uv,material"))
    ['material', 'uv']
    """
    words = {word.strip().lower() for word in text.split(",")}
    if words in ({"all"}, {"none"}):
        return frozenset(DELIMITS) if "all" in words else frozenset()
    unknown = sorted(words - set(DELIMITS))
    if unknown:
        raise UsageError(f"{unknown[0]!r} is none of {', '.join(DELIMITS)}, all, none")
    return frozenset(words)


def parse_length(text: str, shown: str | None = None) -> float:
    """Read a length: a finite number that is not negative.

    Raises
    ------
    UsageError
    """
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not is_length(value):
        raise UsageError(f"'{shown or text}' is not a length: give a number that is finite and not negative")
    return value
