"""Looks: what facets may not cross so that a wall looks as it did, and what moves along with a point.

A texture, or a colour that changes over a wall, is one affine map of the wall's plane, or the wall is cut where it is
not. Then whatever points of the wall go, the picture stays where it is.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model import Attribute, Faces, Indices, Mesh, Points, SimplifiedMesh
from ..options import COLOR_TOLERANCE, Options
from ..unique_rows import find_unique_rows

INTERPOLATED = ("uv", "color")
"""Kinds of attributes that change over a face."""


@dataclass
class Surface:
    """A welded and oriented mesh, with the rows that its corners read.

    Attributes
    ----------
    points : (n, 3) float64
    faces : (m, 3) int32
    halfedges : Halfedges
    rows : Rows
    source : (m,) int32
        Input face of each face.
    part : (m,) int32
    """

    points: Points
    faces: Faces
    halfedges: _core.Halfedges
    rows: _core.Rows
    source: Indices
    part: Indices


@dataclass
class Charted:
    """Faces by charts, on each of which all that is interpolated is one affine map of the position.

    Attributes
    ----------
    of_face : (m,) int32
    maps : (c, k, 4) float64
        Of each interpolated column its change along x, y and z, and its value where all are 0.
    texels : (c,) float64
        How far UV are off the map at most, from least to greatest.
    """

    of_face: Indices
    maps: NDArray[np.float64]
    texels: NDArray[np.float64]


class Looks:
    """What a mesh carries beside its surface, as far as it is kept."""

    def __init__(self, mesh: Mesh, options: Options) -> None:
        self.mesh, self.options = mesh, options
        self.kept = [one for one in mesh.attributes if options.keeps(one.kind)]
        self.interpolated = [one for one in self.kept if one.kind in INTERPOLATED and not one.on_faces]
        widths = [one.values.shape[1] for one in self.interpolated]
        self._is_uv = np.repeat([one.kind == "uv" for one in self.interpolated], widths).astype(bool)
        self._limits = np.where(self._is_uv, options.texture_tolerance, COLOR_TOLERANCE)
        self._constant = [one for one in self.kept if one.kind == "feature" and not one.on_faces]
        self._values = _side_by_side([one.values for one in self.interpolated], len(mesh.points))
        self._names = _side_by_side([one.values for one in self._constant], len(mesh.points))
        self._steps = _side_by_side([one.steps for one in self.interpolated], len(mesh.parts))

    def labels(self, surface: Surface, pinned: NDArray[np.bool_], needle: float) -> Indices:
        """One number for each face, other for faces that no facet may join; -1 for pinned ones.

        Parameters
        ----------
        surface : Surface
        pinned : (m,) bool
            Faces that stay.
        needle : float
            A face no higher than this has no normal worth regarding; model units.
        """
        columns: list[NDArray[Any]] = [surface.part] if "material" in self.options.delimit else []
        corners = self.mesh.faces[surface.source]
        for one in self.kept:
            columns += _told_apart(one, surface.source, corners)
        if "crease" in self.options.delimit and self.mesh.normals is not None:
            cosine = math.cos(math.radians(min(self.options.crease_angle, 180.0)))
            normals = np.ascontiguousarray(self.mesh.normals, np.float64)
            columns.append(
                _core.find_smooth(
                    surface.points, surface.faces, surface.halfedges, surface.rows, normals, cosine, needle
                )
            )
        columns = [column for column in columns if len(column) and (column != column[0]).any()]
        label = np.zeros(len(surface.faces), np.int32)
        if len(columns) == 1 and columns[0].dtype == np.int32:
            label = columns[0].copy()
        elif columns:
            label = find_unique_rows(np.stack(columns, axis=1).astype(np.float64))[1].astype(np.int32)
        label[pinned] = -1
        return label

    def charts(self, surface: Surface, start: Indices, order: Indices) -> Charted | None:
        """Cut groups of faces where what is interpolated is not one map; None where nothing is.

        Parameters
        ----------
        surface : Surface
        start, order : int32
            Faces group by group, and where each group starts.
        """
        if not self.interpolated:
            return None
        found = _core.find_charts(
            surface.points, surface.faces, surface.halfedges, start, order, surface.rows, surface.part,
            np.nan_to_num(self._values), self._steps, self._limits,
        )  # fmt: skip
        columns = len(self._limits)
        spans = found.spans.reshape(-1, columns)
        return Charted(
            found.chart_of_face,
            found.maps.reshape(-1, columns, 4),
            np.where(self._is_uv, spans, 0.0).max(axis=1, initial=0.0),
        )

    def layers(self) -> Indices | None:
        """A number for each face of the mesh, other where a copy of another face is a layer on it; None without any."""
        textured = self.textured()
        if np.count_nonzero(textured) == 0 or len(textured) == 1:
            return None
        return np.where(textured, np.arange(len(textured), dtype=np.int32), np.int32(-1))[self.mesh.part_of_face]

    def textured(self) -> NDArray[np.bool_]:
        """Which parts carry what their faces would be missed for."""
        kinds = {one.name for one in self.kept if one.kind in INTERPOLATED}
        return np.array([not kinds.isdisjoint(part.attributes) for part in self.mesh.parts], bool)

    def carried_along(self, surface: Surface, point_of_row: Indices, charted: Charted) -> float:
        """How far a weld has moved a texture at most: corners that it moves take their UV along; texels."""
        farthest = 0.0
        for row in self.mesh.faces[surface.source].T:
            moves = surface.points[point_of_row[row]] - self.mesh.points[row]
            steps = np.abs(_product(charted.maps[charted.of_face], moves)) * self._steps[surface.part]
            farthest = max(farthest, float(np.where(self._is_uv, steps, 0.0).max(initial=0.0)))
        return farthest

    def follow(
        self,
        light: SimplifiedMesh,
        before: Points,
        foreign: Indices,
        chart_of_triangle: Indices,
        charted: Charted | None,
    ) -> None:
        """Set what corners carry whose points have moved, or whose rows are those of another chart.

        Rows are added where charts do not agree on one.

        Parameters
        ----------
        light : SimplifiedMesh
            Changed in place.
        before : (n, 3) float64
            Where each row was.
        foreign : (j,) int32
            Corners whose rows are those of another chart.
        chart_of_triangle : (k,) int32
        charted : Charted or None
            None where nothing is interpolated.
        """
        corners = light.faces.reshape(-1).copy()
        strange = np.zeros(len(corners), bool)
        strange[foreign] = True
        moves = light.points - before
        chosen = np.flatnonzero(strange | moves[corners].any(axis=1))
        if not len(chosen) or not self.interpolated + self._constant:
            return
        row, strange = corners[chosen], strange[chosen]
        values, names = self._values[row], self._names[row]
        # A row of the facet tells what it carries at all.
        own = self.mesh.faces[light.face[chosen[strange] // 3], 0]
        names[strange] = self._names[own]
        if charted is not None:
            maps = charted.maps[np.repeat(chart_of_triangle, 3)[chosen]]
            values += _product(maps, moves[row])
            anew = _product(maps[strange], light.points[row[strange]]) + maps[strange, :, 3]
            values[strange] = np.where(np.isnan(self._values[own]), np.nan, anew)
        # The first of a moved row's values stays in it; others get rows of their own.
        distinct, place = find_unique_rows(np.hstack([row[:, None], strange[:, None], values, names]))
        stays = np.zeros(len(distinct), bool)
        moved = np.flatnonzero(~strange[distinct])
        stays[moved[np.unique(row[distinct[moved]], return_index=True)[1]]] = True
        target, added = row[distinct], row[distinct][~stays]
        target[~stays] = len(light.row) + np.arange(len(added))
        corners[chosen] = target[place]
        light.faces = corners.reshape(-1, 3)
        light.points = np.concatenate([light.points, light.points[added]])
        light.row = np.concatenate([light.row, light.row[added]])
        for kept, old, new in ((self.interpolated, self._values, values), (self._constant, self._names, names)):
            every = np.concatenate([old, old[added]])
            every[target] = new[distinct]
            _set(light, kept, every)


def left(mesh: Mesh, light: SimplifiedMesh) -> Mesh:
    """What is left of a mesh, as a mesh."""
    return dataclasses.replace(
        mesh,
        points=light.points,
        faces=light.faces,
        part_of_face=light.part_of_face,
        normals=None if mesh.normals is None else mesh.normals[light.row],
        attributes=[dataclasses.replace(one, values=light.values(one)) for one in mesh.attributes],
    )


def followed(first: SimplifiedMesh, second: SimplifiedMesh) -> SimplifiedMesh:
    """A light of what is `left` of another, in rows of the mesh that the other came from."""
    changed = {name: values[second.row] for name, values in first.changed.items()} | second.changed
    return SimplifiedMesh(
        second.points, second.faces, second.part_of_face, first.row[second.row], first.face[second.face], changed
    )


def _told_apart(one: Attribute, source: Indices, corners: Faces) -> list[NDArray[np.float64]]:
    """Columns, one value for each face, that differ where faces look different because of an attribute."""
    if one.on_faces:
        return list(one.values[source].T)
    if one.kind == "feature":
        names = np.sort(one.values[corners], axis=1)
        return list(names.reshape(len(corners), names.shape[1] * names.shape[2]).T)
    missing = np.asarray(np.isnan(one.values).any(axis=1))
    if not missing.any():
        return []
    return [missing[corners].sum(axis=1).astype(np.float64)]


def _product(maps: NDArray[np.float64], vectors: Points) -> NDArray[np.float64]:
    """Change of each column along vectors, summed in a fixed order."""
    x, y, z = (maps[:, :, axis] * vectors[:, None, axis] for axis in range(3))
    return np.asarray(x + y + z)


def _side_by_side(columns: list[NDArray[np.float64]], count: int) -> NDArray[np.float64]:
    """Columns of several arrays in one."""
    return np.ascontiguousarray(np.hstack([np.empty((count, 0)), *columns]))


def _set(light: SimplifiedMesh, kept: list[Attribute], every: NDArray[np.float64]) -> None:
    """Hand columns back to the attributes that they belong to."""
    start = 0
    for one in kept:
        end = start + one.values.shape[1]
        values = every[:, start:end]
        if one.name.startswith("COLOR_"):
            values = np.clip(values, 0.0, 1.0)
        light.changed[one.name] = values
        start = end
