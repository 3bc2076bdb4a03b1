"""Keep textures, colors and labels: label what facets may not cross, and update the values of moved points.

On each chart a texture or color is one affine map of the position. So the picture does not move on the wall,
whichever points of the wall are dropped.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model import Attribute, Faces, Flags, Indices, Mesh, Points, SimplifiedMesh, Values, cast_indices
from ..options import COLOR_TOLERANCE, Options
from ..unique_rows import find_unique_rows, place_values
from .facets import Limits, find_facets
from .surface import Surface
from .weld import WeldedMesh

INTERPOLATED = ("uv", "color")
"""Kinds of attributes that change over a face."""


@dataclass
class AttributeCharts:
    """Charts: sets of faces over which each interpolated attribute is one affine map of the position.

    Attributes
    ----------
    of_face : (m,) int32
    maps : (c, k, 4) float64
        Of each interpolated column its change along x, y and z, and its value where all are 0.
    texels : (c,) float64
        How far UV are off the map at most, from least to greatest.
    """

    of_face: Indices
    maps: Values
    texels: Values

    def widen(self, wider: AttributeCharts) -> AttributeCharts:
        """Replace the charts that lie whole in one of some wider charts by that one.

        A wider chart may end in the middle of a wall, where a face of the next one happens to fit it; there this wall
        keeps the charts that it has.
        """
        least, greatest = np.full(len(self.maps), len(wider.maps)), np.full(len(self.maps), -1)
        np.minimum.at(least, self.of_face, wider.of_face)
        np.maximum.at(greatest, self.of_face, wider.of_face)
        lies_whole = (least == greatest)[self.of_face]
        chart = np.where(lies_whole, wider.of_face, len(wider.maps) + self.of_face)
        chosen, of_face = np.unique(chart, return_inverse=True)
        maps = np.concatenate([wider.maps, self.maps])[chosen]
        return AttributeCharts(cast_indices(of_face), maps, np.concatenate([wider.texels, self.texels])[chosen])


class KeptAttributes:
    """The attributes of a mesh that the options keep.

    Parameters
    ----------
    mesh : Mesh
    options : Options
        `delimit`, `texture_tolerance` and `crease_angle`.
    """

    def __init__(self, mesh: Mesh, options: Options) -> None:
        self.mesh, self.options = mesh, options
        self.kept = [one for one in mesh.attributes if options.keeps(one.kind)]
        self.interpolated = [one for one in self.kept if one.kind in INTERPOLATED and not one.on_faces]
        widths = [one.values.shape[1] for one in self.interpolated]
        self._is_uv = np.repeat([one.kind == "uv" for one in self.interpolated], widths).astype(bool)
        self._limits = np.where(self._is_uv, options.texture_tolerance, COLOR_TOLERANCE)
        self._constant = [one for one in self.kept if one.kind == "feature" and not one.on_faces]
        self._values = _join_columns([one.values for one in self.interpolated], len(mesh.points))
        self._names = _join_columns([one.values for one in self._constant], len(mesh.points))
        self._steps = _join_columns([one.steps for one in self.interpolated], len(mesh.parts))

    def find_layers(self) -> Indices | None:
        """Return the layer of each face, a number: copies with different pictures differ. None without layers."""
        textured = self.find_textured_parts()
        if np.count_nonzero(textured) == 0 or len(textured) == 1:
            return None
        return np.where(textured, np.arange(len(textured), dtype=np.int32), np.int32(-1))[self.mesh.part_of_face]

    def find_textured_parts(self) -> NDArray[np.bool_]:
        """Find parts whose faces have a picture, or colors that change."""
        names = {one.name for one in self.kept if one.kind in INTERPOLATED}
        return np.array([not names.isdisjoint(part.attributes) for part in self.mesh.parts], bool)

    def label_faces(
        self, welded: WeldedMesh, halfedges: _core.Halfedges, pinned: NDArray[np.bool_], needle: float
    ) -> Indices:
        """Give faces that no facet may join different numbers; -1 to pinned ones.

        Parameters
        ----------
        welded : WeldedMesh
        halfedges : Halfedges
        pinned : (m,) bool
            Faces that stay.
        needle : float
            A face no higher than this has no normal that counts; model units.
        """
        mesh, delimit = self.mesh, self.options.delimit
        columns: list[NDArray[Any]] = [mesh.part_of_face[welded.source]] if "material" in delimit else []
        corners = mesh.faces[welded.source]
        for one in self.kept:
            columns += _tell_apart(one, welded.source, corners)
        if "crease" in delimit and mesh.normals is not None:
            cosine = math.cos(math.radians(min(self.options.crease_angle, 180.0)))
            normals = np.ascontiguousarray(mesh.normals, np.float64)
            columns.append(
                _core.find_smooth(welded.points, welded.faces, halfedges, welded.rows, normals, cosine, needle)
            )
        columns = [column for column in columns if len(column) and (column != column[0]).any()]
        label = np.zeros(len(welded.faces), np.int32)
        if len(columns) == 1 and columns[0].dtype == np.int32:
            label = columns[0].copy()
        elif columns:
            label = cast_indices(find_unique_rows(np.stack(columns, axis=1).astype(np.float64))[1])
        label[pinned] = -1
        return label

    def find_charts(
        self, welded: WeldedMesh, halfedges: _core.Halfedges, start: Indices, order: Indices
    ) -> AttributeCharts:
        """Cut groups of faces into charts, where one affine map is not enough.

        Parameters
        ----------
        welded : WeldedMesh
        halfedges : Halfedges
        start, order : int32
            Faces group by group, and where each group starts.
        """
        part = self.mesh.part_of_face[welded.source]
        values, columns = np.nan_to_num(self._values), len(self._limits)
        found = _core.find_charts(
            welded.points, welded.faces, halfedges, start, order, welded.rows, part, values, self._steps, self._limits
        )
        texels = np.where(self._is_uv, found.spans.reshape(-1, columns), 0.0).max(axis=1, initial=0.0)
        return AttributeCharts(found.chart_of_face, found.maps.reshape(-1, columns, 4), texels)

    def bound_weld_shift(self, welded: WeldedMesh, charts: AttributeCharts) -> float:
        """Bound how far welding moved a texture: corners that it moves take their UV along; texels."""
        farthest, steps = 0.0, self._steps[self.mesh.part_of_face[welded.source]]
        for row in self.mesh.faces[welded.source].T:
            moves = welded.points[welded.point_of_row[row]] - self.mesh.points[row]
            shift = np.abs(_multiply(charts.maps[charts.of_face], moves)) * steps
            farthest = max(farthest, float(np.where(self._is_uv, shift, 0.0).max(initial=0.0)))
        return farthest

    def update_values(
        self,
        result: SimplifiedMesh,
        before: Points,
        foreign: Indices,
        chart_of_triangle: Indices,
        charts: AttributeCharts | None,
    ) -> None:
        """Update the attributes of corners whose points moved, or whose rows belong to another chart.

        Rows are added where charts do not agree on one.

        Parameters
        ----------
        result : SimplifiedMesh
            Changed in place.
        before : (n, 3) float64
            Where each row was.
        foreign : (j,) int32
            Corners whose rows are those of another chart.
        chart_of_triangle : (k,) int32
        charts : AttributeCharts or None
            None where nothing is interpolated.
        """
        corners = result.faces.reshape(-1).copy()
        strange = np.zeros(len(corners), bool)
        strange[foreign] = True
        moves = result.points - before
        chosen = np.flatnonzero(strange | moves[corners].any(axis=1))
        if not len(chosen) or not self.interpolated + self._constant:
            return
        row, strange = corners[chosen], strange[chosen]
        values, names = self._values[row], self._names[row]
        # A row of the facet tells what it has at all.
        own = self.mesh.faces[result.face[chosen[strange] // 3], 0]
        names[strange] = self._names[own]
        if charts is not None:
            maps = charts.maps[np.repeat(chart_of_triangle, 3)[chosen]]
            values += _multiply(maps, moves[row])
            anew = _multiply(maps[strange], result.points[row[strange]]) + maps[strange, :, 3]
            values[strange] = np.where(np.isnan(self._values[own]), np.nan, anew)
        # The first of a moved row's values stays in it; others get rows of their own.
        distinct, place = find_unique_rows(np.hstack([row[:, None], strange[:, None], values, names]))
        target, added = place_values(row[distinct], len(result.row), ~strange[distinct])
        corners[chosen] = target[place]
        result.faces = corners.reshape(-1, 3)
        result.add_rows(added)
        for kept, old, new in ((self.interpolated, self._values, values), (self._constant, self._names, names)):
            every = np.concatenate([old, old[added]])
            every[target] = new[distinct]
            _set_columns(result, kept, every)


def label_surface(
    attributes: KeptAttributes,
    welded: WeldedMesh,
    halfedges: _core.Halfedges,
    decided: Flags,
    limits: Limits,
    *,
    across_facets: bool,
) -> tuple[Surface, _core.Facets, AttributeCharts | None]:
    """Label the faces of a welded mesh by what they look like, and find its facets within the labels.

    Parameters
    ----------
    attributes : KeptAttributes
    welded : WeldedMesh
        Oriented.
    halfedges : Halfedges
    decided : (n,) uint8
        As in `Surface`.
    limits : Limits
    across_facets : bool
        Whether a chart may span facets, as edge collapses need it, or is cut within each.

    Returns
    -------
    surface : Surface
        Its labels tell what no facet may cross.
    facets : Facets
    charts : AttributeCharts or None
        None where nothing is interpolated; else labels are charts.
    """
    points, faces = welded.points, welded.faces
    pinned = attributes.mesh.passed_on[attributes.mesh.part_of_face[welded.source]]
    label = attributes.label_faces(welded, halfedges, pinned, limits.needle)
    facets, charts = find_facets(points, faces, halfedges, label, limits), None
    if attributes.interpolated:
        charts = attributes.find_charts(welded, halfedges, *_core.group_faces(facets))
        if across_facets:
            charts = charts.widen(attributes.find_charts(welded, halfedges, *_group_by_label(label)))
        label = np.where(pinned, np.int32(-1), charts.of_face)
        if across_facets or len(charts.maps) > len(facets.planes):
            facets = find_facets(points, faces, halfedges, label, limits)
    origin = np.arange(len(points), dtype=np.int32)
    return Surface(points, faces, label, welded.source, None, origin, decided), facets, charts


def _group_by_label(label: Indices) -> tuple[Indices, Indices]:
    """Return where each label starts, and the faces label by label."""
    order = np.argsort(label, kind="stable")
    labels = np.arange(label.min(initial=0), label.max(initial=0) + 2)
    return cast_indices(np.searchsorted(label[order], labels)), cast_indices(order)


def _tell_apart(one: Attribute, source: Indices, corners: Faces) -> list[Values]:
    """Return columns, one value for each face, that differ where faces look different because of an attribute."""
    if one.on_faces:
        return list(one.values[source].T)
    if one.kind == "feature":
        names = np.sort(one.values[corners], axis=1)
        return list(names.reshape(len(corners), names.shape[1] * names.shape[2]).T)
    missing = np.asarray(np.isnan(one.values).any(axis=1))
    if not missing.any():
        return []
    return [missing[corners].sum(axis=1).astype(np.float64)]


def _multiply(maps: Values, vectors: Points) -> Values:
    """Return the change of each column along vectors, summed in a fixed order."""
    x, y, z = (maps[:, :, axis] * vectors[:, None, axis] for axis in range(3))
    return np.asarray(x + y + z)


def _join_columns(columns: list[Values], count: int) -> Values:
    """Put the columns of several arrays side by side."""
    return np.ascontiguousarray(np.hstack([np.empty((count, 0)), *columns]))


def _set_columns(result: SimplifiedMesh, kept: list[Attribute], every: Values) -> None:
    """Hand columns back to the attributes that they belong to."""
    start = 0
    for one in kept:
        end = start + one.values.shape[1]
        values = every[:, start:end]
        if one.name.startswith("COLOR_"):
            values = np.clip(values, 0.0, 1.0)
        result.changed[one.name] = values
        start = end
