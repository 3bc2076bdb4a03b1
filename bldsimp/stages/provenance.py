"""Corners: which row of the file each corner of the result reads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .. import _core
from ..model import Faces, Flags, Indices, Mesh, SimplifiedMesh
from .attributes import Surface


@dataclass
class Owners:
    """What faces and facets belong to; a group is what no facet may leave."""

    facet_of_face: Indices
    part_of_facet: Indices
    group_of_facet: Indices


def owners_of(facet_of_face: Indices, part: Indices, group: Indices, count: int) -> Owners:
    """What facets belong to, by what their faces, all of one part and one group, do."""
    part_of_facet, group_of_facet = np.zeros(count, np.int32), np.zeros(count, np.int32)
    part_of_facet[facet_of_face] = part
    group_of_facet[facet_of_face] = group
    return Owners(facet_of_face, part_of_facet, group_of_facet)


def in_rows(
    mesh: Mesh,
    triangles: Faces,
    facet: Indices,
    unchanged: Flags,
    kept: Flags,
    surface: Surface,
    owners: Owners,
) -> tuple[SimplifiedMesh, Indices, Indices]:
    """Tell a result in rows of the mesh; parts that are passed on keep their faces to the letter.

    Parameters
    ----------
    mesh : Mesh
    triangles : (k, 3) int32
    facet : (k,) int32
        Of each triangle.
    unchanged : (f,) uint8
        Facets whose faces keep the rows that they have.
    kept : (n,) uint8
        Points that triangles use.
    surface : Surface
    owners : Owners

    Returns
    -------
    light : SimplifiedMesh
    facet : (k,) int32
        Of its faces.
    foreign : (j,) int32
        Corners whose rows are those of another group.
    """
    found, foreign = _core.find_rows(
        triangles, facet, surface.faces, surface.rows, owners.facet_of_face, owners.group_of_facet,
        owners.part_of_facet, unchanged, kept,
    )  # fmt: skip
    face_of_facet = np.zeros(len(owners.part_of_facet), np.int32)
    face_of_facet[owners.facet_of_face] = surface.source
    row = np.arange(len(mesh.points), dtype=np.int32)
    part = owners.part_of_facet[facet]
    if not mesh.passed_on.any():
        return SimplifiedMesh(mesh.points, found, part, row, face_of_facet[facet]), facet, foreign
    fresh = ~mesh.passed_on[part]
    place = np.cumsum(fresh) - 1
    foreign = foreign[fresh[foreign // 3]]
    foreign = (3 * place[foreign // 3] + foreign % 3).astype(np.int32)
    untouched = mesh.passed_on[mesh.part_of_face]
    facet_of_input = np.full(len(mesh.faces), -1, np.int32)
    facet_of_input[surface.source] = owners.facet_of_face
    light = SimplifiedMesh(
        mesh.points,
        np.concatenate([found[fresh], mesh.faces[untouched]]),
        np.concatenate([part[fresh], mesh.part_of_face[untouched]]),
        row,
        np.concatenate([face_of_facet[facet[fresh]], np.flatnonzero(untouched).astype(np.int32)]),
    )
    return light, np.concatenate([facet[fresh], facet_of_input[untouched]]), foreign
