"""Draw a still picture of meshes side by side: shaded, with every triangle edge drawn; no GPU, no screen.

A triangle is turned into the pixels of its bounding box, all triangles of a batch at once; the
nearest wins the pixel. Edges cost nothing more: a pixel knows how far it is from the three edges of
its own triangle, so lines need no depth bias and never show through.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bldsimp.errors import BldsimpError

if TYPE_CHECKING:
    from PIL.Image import Image

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

BATCH = 4_000_000
"""Pixels that are tested at once; bounds the memory to some hundred megabytes."""

CREASE_DEGREES = 8.0
"""Edges at which the surface bends by more are drawn as sharp ones."""


@dataclass(frozen=True)
class Style:
    """How a picture looks.

    Attributes
    ----------
    width, height : int
        Size of one view, pixels.
    azimuth, elevation : float
        Where the eye stands, seen from the model: degrees from the x axis, degrees above the ground.
    distance : float
        Distance of the eye in units of the model's diagonal; small is a strong perspective.
    line, crease : float
        Width of edges inside a flat facet and of sharp ones, pixels; 0 draws none.
    samples : int
        Samples per pixel along each axis.
    zoom : float
        So many times larger than fits into the view.
    aim : tuple of float
        What stands in the middle, as shares of the model's picture from its left and from its foot.
    gap : int
        Columns that stay blank on both sides of a view, pixels.
    """

    width: int = 900
    height: int = 760
    azimuth: float = -56.0
    elevation: float = 17.0
    distance: float = 2.2
    line: float = 1.0
    crease: float = 1.7
    samples: int = 3
    zoom: float = 1.0
    aim: tuple[float, float] = (0.5, 0.5)
    gap: int = 0
    wall: tuple[float, float, float] = (0.93, 0.90, 0.85)
    ink: tuple[float, float, float] = (0.13, 0.20, 0.30)
    paper: tuple[float, float, float] = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class View:
    """One mesh and the words below it.

    Attributes
    ----------
    points : (n, 3) float64
        Model units, z upwards.
    faces : (m, 3) int
    caption : str
        At most two lines.
    """

    points: Floats
    faces: Integers
    caption: str


def draw_picture(views: Sequence[View], style: Style | None = None, columns: int | None = None) -> Image:
    """Draw views of equal size in rows, all with the camera that fits the first.

    Parameters
    ----------
    views : sequence of View
        Usually two: before and after.
    style : Style, optional
    columns : int, optional
        So many views stand in a row; all where left out.

    Returns
    -------
    PIL.Image.Image
        RGB, ``columns * style.width`` wide.

    Raises
    ------
    BldsimpError
        If Pillow is not installed, or a view has no faces.

    Notes
    -----
    Linear in the triangles and in the pixels that they cover; the same input gives the same picture.
    """
    try:
        from PIL import Image as Images
    except ImportError as error:
        raise BldsimpError("pictures need Pillow: pip install 'bldsimp[pictures]'") from error
    if not views or any(len(view.faces) == 0 for view in views):
        raise BldsimpError("nothing to draw: a view has no faces")
    style = style or Style()
    camera = Camera.fit(views[0], style)
    panels = crop([shade(view, camera, style) for view in views])
    columns = columns or len(views)
    height, margin = panels[0].shape[0], 90
    rows = -(-len(views) // columns)
    sheet = Images.new("RGB", (columns * style.width, rows * (height + margin)), to_bytes(style.paper))
    for k, (view, panel) in enumerate(zip(views, panels, strict=True)):
        row, column = divmod(k, columns)
        top = row * (height + margin)
        sheet.paste(Images.fromarray(panel), (column * style.width, top))
        write_caption(sheet, view.caption, (column + 0.5) * style.width, top + height)
    return sheet


def crop(panels: list[NDArray[np.uint8]], margin: int = 16) -> list[NDArray[np.uint8]]:
    """Cut off the rows that are blank in all panels, except a margin."""
    drawn = np.any([(panel != panel[0, 0]).any(axis=(1, 2)) for panel in panels], axis=0)
    rows = np.flatnonzero(drawn)
    if not len(rows):
        return panels
    low, high = max(int(rows[0]) - margin, 0), int(rows[-1]) + 1 + margin
    return [panel[low:high] for panel in panels]


@dataclass(frozen=True)
class Camera:
    """A perspective: `axes` are right, up and towards the eye; then scale and shift to samples."""

    axes: Floats
    target: Floats
    distance: float
    scale: float
    shift: Floats

    @classmethod
    def fit(cls, view: View, style: Style) -> Camera:
        """Fit a camera to all of a view's faces, with a margin."""
        used = view.points[np.unique(view.faces)]
        low, high = used.min(axis=0), used.max(axis=0)
        azimuth, elevation = np.radians([style.azimuth, style.elevation])
        toward = np.array([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)])
        right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
        axes = np.stack([right, np.cross(toward, right), toward])
        distance = style.distance * float(np.linalg.norm(high - low))
        plain = cls(axes, (low + high) / 2, distance, 1.0, np.zeros(2))
        flat = plain.project(used)[:, :2]
        low2, high2 = flat.min(axis=0), flat.max(axis=0)
        size = np.array([style.width, style.height]) * style.samples
        scale = style.zoom * float((0.92 * size / (high2 - low2)).min())
        middle = low2 + np.array(style.aim) * (high2 - low2)
        return cls(axes, plain.target, distance, scale, size / 2 - scale * middle)

    def project(self, points: Floats) -> Floats:
        """Sample columns, rows (upwards) and nearness: greater is nearer, and linear on the screen."""
        local = (points - self.target) @ self.axes.T
        nearness = 1.0 / (self.distance - local[:, 2])
        flat = self.scale * self.distance * local[:, :2] * nearness[:, None] + self.shift
        return np.column_stack([flat, nearness])


def shade(view: View, camera: Camera, style: Style) -> NDArray[np.uint8]:
    """Draw one view, (height, width, 3)."""
    columns, rows = style.width * style.samples, style.height * style.samples
    corners = camera.project(view.points)[view.faces]
    owner = find_nearest_faces(corners, columns, rows)
    color = np.empty((rows * columns, 3), dtype=np.float32)
    color[:] = style.paper
    pixels = np.flatnonzero(owner >= 0)
    face = owner[pixels]
    color[pixels] = light_faces(view, camera, style)[face]
    apart = measure_edge_distances(corners[:, :, :2], face, pixels % columns, pixels // columns)
    crease = find_creases(view)[face]
    for k in range(3):
        width = np.where(crease[:, k], style.crease, style.line) * style.samples / 2
        strength = np.where(crease[:, k], 0.9, 0.45) * np.clip(width + 0.5 - apart[k], 0.0, 1.0) * (width > 0)
        color[pixels] += (np.array(style.ink) - color[pixels]) * strength[:, None]
    blank = style.gap * style.samples
    sides = color.reshape(rows, columns, 3)
    sides[:, :blank] = sides[:, columns - blank :] = style.paper
    blocks = color.reshape(style.height, style.samples, style.width, style.samples, 3)
    return to_levels(blocks.mean(axis=(1, 3))[::-1])


def find_normals(view: View) -> Floats:
    """Return the unit normal of each face, zero where it has no area."""
    a, b, c = (view.points[view.faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    return np.asarray(normal / np.where(length > 0, length, 1.0)[:, None])


def light_faces(view: View, camera: Camera, style: Style) -> Floats:
    """Color each face: a warm sun from the upper left, a cool sky, and a little from the ground."""
    normal = find_normals(view)
    # A face seen from behind (an open or badly turned mesh) is lit as if it were turned.
    eye = camera.target + camera.distance * camera.axes[2]
    behind = np.einsum("ij,ij->i", normal, eye - view.points[view.faces[:, 0]]) < 0
    normal[behind] *= -1
    right, _, toward = camera.axes
    sun = -0.35 * right + 0.62 * toward + np.array([0.0, 0.0, 0.45])
    sun /= np.linalg.norm(sun)
    direct = np.clip(normal @ sun, 0.0, 1.0)[:, None] * np.array([0.53, 0.49, 0.42])
    sky = (0.5 + 0.5 * normal[:, 2:]) * np.array([0.12, 0.14, 0.18])
    return np.asarray(np.clip((0.45 + direct + sky) * np.array(style.wall), 0.0, 1.0))


def find_creases(view: View) -> NDArray[np.bool_]:
    """Return per face whether its three edges are sharp, open, or shared by more than two faces; (m, 3)."""
    places = np.unique(view.points, axis=0, return_inverse=True)[1].reshape(-1)[view.faces]
    halfedges = np.sort(np.stack([places, np.roll(places, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    edge, uses = np.unique(halfedges, axis=0, return_inverse=True, return_counts=True)[1:]
    edge = edge.reshape(-1)
    order = np.argsort(edge, kind="stable")
    starts = np.cumsum(uses) - uses
    first, last = order[starts] // 3, order[starts + uses - 1] // 3
    normal = find_normals(view)
    bend = np.einsum("ij,ij->i", normal[first], normal[last])
    sharp = (uses != 2) | (np.abs(bend) < np.cos(np.radians(CREASE_DEGREES)))
    return np.asarray(sharp[edge].reshape(-1, 3))


def find_nearest_faces(corners: Floats, columns: int, rows: int) -> Integers:
    """Find for each sample the face in front there, -1 for none; `corners` are projected, (m, 3, 3)."""
    first = np.maximum(np.ceil(corners[:, :, :2].min(axis=1) - 0.5).astype(np.int64), 0)
    last = np.floor(corners[:, :, :2].max(axis=1) - 0.5).astype(np.int64)
    last = np.minimum(last, [columns - 1, rows - 1])
    spans = np.maximum(last - first + 1, 0)
    counts = spans.prod(axis=1)
    nearness = np.full(columns * rows, -np.inf)
    owner = np.full(columns * rows, -1, dtype=np.int64)
    faces = np.flatnonzero(counts)
    ends = np.cumsum(counts[faces])
    for batch in np.split(faces, np.searchsorted(ends, np.arange(BATCH, ends[-1] if len(ends) else 0, BATCH))):
        if len(batch):
            draw_batch(corners, batch, (first, spans), columns, (nearness, owner))
    return owner


def draw_batch(
    corners: Floats,
    batch: Integers,
    boxes: tuple[Integers, Integers],
    columns: int,
    seen: tuple[Floats, Integers],
) -> None:
    """Test the samples in the boxes of a batch of faces; enter the nearest into nearness and owner of each sample."""
    (first, spans), (nearness, owner) = boxes, seen
    counts = spans[batch].prod(axis=1)
    face = np.repeat(batch, counts)
    rank = np.arange(len(face)) - np.repeat(np.cumsum(counts) - counts, counts)
    x = first[face, 0] + rank % spans[face, 0]
    y = first[face, 1] + rank // spans[face, 0]
    weights = [evaluate_edge(corners, face, k, x, y) for k in range(3)]
    total = weights[0] + weights[1] + weights[2]
    sign = np.sign(total)
    hit = np.flatnonzero((sign != 0) & np.all([weight * sign >= 0 for weight in weights], axis=0))
    face, total = face[hit], total[hit]
    near = np.zeros(len(hit))
    for k in range(3):
        # The weight of a corner is the edge function of the edge opposite to it.
        near += weights[(k + 1) % 3][hit] * corners[face, k, 2]
    near /= total
    sample = y[hit] * columns + x[hit]
    # Of several hits of a sample keep the nearest, of equal ones the lowest face.
    order = np.lexsort((-face, near, sample))
    final = order[np.append(sample[order][1:] != sample[order][:-1], True)] if len(order) else order
    final = final[near[final] > nearness[sample[final]]]
    nearness[sample[final]] = near[final]
    owner[sample[final]] = face[final]


def evaluate_edge(corners: Floats, face: Integers, k: int, x: Integers, y: Integers) -> Floats:
    """Return twice the area between the k-th edge of each face and a sample's center."""
    a, b = corners[:, k, :2], corners[:, (k + 1) % 3, :2]
    along = b - a
    offset_x, offset_y = x + 0.5 - a[face, 0], y + 0.5 - a[face, 1]
    area: Floats = along[face, 0] * offset_y - along[face, 1] * offset_x
    return area


def measure_edge_distances(flat: Floats, face: Integers, x: Integers, y: Integers) -> list[Floats]:
    """Measure the distance of each sample's center to the three edges of its face, in samples."""
    found = []
    for k in range(3):
        length = np.linalg.norm(flat[:, (k + 1) % 3] - flat[:, k], axis=1)
        length[length == 0] = 1.0
        found.append(np.abs(evaluate_edge(flat, face, k, x, y)) / length[face])
    return found


def write_caption(sheet: Image, caption: str, middle: float, top: int) -> None:
    """Write up to two centered lines, the first one larger."""
    from PIL import ImageDraw, ImageFont

    pen = ImageDraw.Draw(sheet)
    for k, line in enumerate(caption.splitlines()[:2]):
        font = ImageFont.load_default(size=(30, 22)[k])
        pen.text((middle, top + (6, 46)[k]), line, fill=((30, 36, 44), (90, 98, 108))[k], font=font, anchor="ma")


def to_levels(color: Floats) -> NDArray[np.uint8]:
    """Scale colors from 0..1 to 0..255."""
    return np.round(np.clip(color, 0.0, 1.0) * 255).astype(np.uint8)


def to_bytes(color: tuple[float, float, float]) -> tuple[int, int, int]:
    """Scale one color from 0..1 to 0..255."""
    red, green, blue = (round(255 * value) for value in color)
    return red, green, blue
