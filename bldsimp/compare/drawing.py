"""Write shapes as SVG, or as PNG through matplotlib, which the extra ``plots`` installs."""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

from ..display import sanitize_line

PIXELS_PER_INCH = 96.0
"""Of the units of a drawing, as in CSS."""

DOTS_PER_INCH = 200
"""Of a PNG."""

FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'DejaVu Sans', Arial, sans-serif"

LETTER = 0.58
"""Width of a letter, as a share of the size of its font: the mean of a wide font."""


@dataclass(frozen=True)
class Path:
    """A line through points, or the outline of an area where it is filled; dashes are in units of the width."""

    points: Sequence[tuple[float, float]]
    color: str
    width: float = 1.0
    dashes: Sequence[float] = ()
    fill: str = "none"


@dataclass(frozen=True)
class Text:
    """Words on a base line; `anchor` is ``start``, ``middle`` or ``end``. A halo sets them apart from lines below."""

    x: float
    y: float
    words: str
    size: float = 12.0
    color: str = "#5b6775"
    anchor: str = "start"
    weight: str = "normal"
    halo: bool = False


@dataclass(frozen=True)
class ShapeGroup:
    """Shapes about a place; on a page a title shows under the pointer, and a number names the row to choose."""

    x: float
    y: float
    shapes: Sequence[Shape]
    title: str = ""
    number: int | None = None


Shape = Path | Text | ShapeGroup


@dataclass(frozen=True)
class Drawing:
    """Shapes on a white sheet; all lengths are CSS pixels."""

    width: float
    height: float
    shapes: Sequence[Shape]


def measure_words(words: str, size: float) -> float:
    """Estimate the width of words."""
    return LETTER * size * len(words)


def format_svg(drawing: Drawing, label: str) -> str:
    """Write a drawing as an SVG element, which a page can embed; `label` is for those who cannot see it."""
    size = f'width="{drawing.width:g}" height="{drawing.height:g}"'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} viewBox="0 0 {drawing.width:g} {drawing.height:g}"'
        f' role="img" aria-label="{escape(sanitize_line(label))}" font-family="{FONT}">'
        f'<rect {size} fill="#fff"/>{"".join(map(_format_shape, drawing.shapes))}</svg>'
    )


def _format_shape(shape: Shape) -> str:
    """Write one shape as SVG."""
    if isinstance(shape, Path):
        line = "L".join(f"{x:.4g} {y:.4g}" for x, y in shape.points)
        dashes = " ".join(f"{part * shape.width:g}" for part in shape.dashes)
        style = f'stroke="{shape.color}" stroke-width="{shape.width:g}" fill="{shape.fill}"'
        style += f' stroke-dasharray="{dashes}"' if dashes else ""
        return f'<path d="M{line}{"" if shape.fill == "none" else "Z"}" {style}/>'
    if isinstance(shape, Text):
        style = f'font-size="{shape.size:g}" fill="{shape.color}" text-anchor="{shape.anchor}"'
        style += f' font-weight="{shape.weight}"'
        style += ' stroke="#fff" stroke-width="3" paint-order="stroke"' if shape.halo else ""
        return f'<text x="{shape.x:.4g}" y="{shape.y:.4g}" {style}>{escape(sanitize_line(shape.words))}</text>'
    inside = "".join(map(_format_shape, shape.shapes))
    if shape.title:
        inside = f"<title>{escape(sanitize_line(shape.title))}</title>{inside}"
    chosen = ""
    if shape.number is not None:
        chosen = f' class="mark" data-row="{shape.number}"'
        inside = f'<circle class="hit" r="11" fill="#fff0"/><circle class="ring" r="9" fill="none"/>{inside}'
    return f'<g{chosen} transform="translate({shape.x:.4g} {shape.y:.4g})">{inside}</g>'


def render_png(drawing: Drawing) -> bytes:
    """Draw by matplotlib; the same drawing gives the same bytes, whatever the user's own settings are."""
    import matplotlib

    with matplotlib.rc_context(), warnings.catch_warnings():
        # A name in a script that the font lacks shows as boxes: no warning needed.
        warnings.filterwarnings("ignore", r"Glyph \d+")
        matplotlib.rcdefaults()
        stream = io.BytesIO()
        # Without the versions that matplotlib would write.
        build_figure(drawing).savefig(stream, format="png", dpi=DOTS_PER_INCH, metadata={"Software": None})
        return stream.getvalue()


def build_figure(drawing: Drawing) -> Any:
    """Build the matplotlib figure of a drawing."""
    from matplotlib.figure import Figure
    from matplotlib.patches import Polygon
    from matplotlib.transforms import Affine2D

    figure = Figure(figsize=(drawing.width / PIXELS_PER_INCH, drawing.height / PIXELS_PER_INCH))
    # From pixels downwards to shares upwards.
    transform = Affine2D().scale(1 / drawing.width, -1 / drawing.height).translate(0, 1) + figure.transFigure
    points = 72.0 / PIXELS_PER_INCH
    for x, y, shape in _flatten(drawing.shapes, 0.0, 0.0):
        if isinstance(shape, Path):
            closed = shape.fill != "none"
            line = Polygon([(x + u, y + v) for u, v in shape.points], closed=closed, fill=closed, transform=transform)
            line.set(edgecolor=shape.color, linewidth=shape.width * points, facecolor=shape.fill, capstyle="butt")
            # matplotlib takes dashes in units of the width, too.
            line.set_linestyle((0, tuple(shape.dashes)) if shape.dashes else "solid")
            figure.add_artist(line)
        else:
            anchor = {"start": "left", "middle": "center", "end": "right"}[shape.anchor]
            box = {"facecolor": "white", "edgecolor": "none", "pad": 0.4, "alpha": 0.8} if shape.halo else None
            figure.text(
                x + shape.x, y + shape.y, sanitize_line(shape.words), transform=transform, fontsize=shape.size * points,
                color=shape.color, weight=shape.weight, ha=anchor, va="baseline", bbox=box, parse_math=False,
            )  # fmt: skip
    return figure


def _flatten(shapes: Sequence[Shape], x: float, y: float) -> Iterator[tuple[float, float, Path | Text]]:
    """Yield the shapes of all groups with the place of their group."""
    for shape in shapes:
        if isinstance(shape, ShapeGroup):
            yield from _flatten(shape.shapes, x + shape.x, y + shape.y)
        else:
            yield x, y, shape
