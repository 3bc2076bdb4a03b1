"""`bldsimp.simplify` of a `trimesh.Trimesh` that is textured or colored: it comes back so."""

from __future__ import annotations

import numpy as np
import painted
import trimesh
from painted import IMAGE, textured
from shapes import fine_box

import bldsimp


def make_plain() -> trimesh.Trimesh:
    return trimesh.Trimesh(*fine_box(), process=False)


def test_a_texture_stays_on_its_sides() -> None:
    given = textured()
    light = bldsimp.simplify(given)
    mesh = light.mesh
    assert light.report.after.points == 8
    assert len(mesh.faces) == 12
    # Three islands meet at each corner.
    assert len(mesh.vertices) == 24
    assert np.array_equal(mesh.visual.uv[mesh.faces], painted.uv_of(mesh.vertices[mesh.faces]))
    assert mesh.visual.material is given.visual.material
    assert mesh.visual.material.image.tobytes() == IMAGE.tobytes()


def test_rings_are_still_rows_of_the_result() -> None:
    light = bldsimp.simplify(textured())
    assert len(light.facets) == 6
    for facet in light.facets:
        (ring,) = facet.rings
        assert len(ring) == 4
        heights = light.mesh.vertices[ring] @ facet.normal
        assert np.ptp(heights) == 0.0


def test_colors_of_vertices() -> None:
    given = make_plain()
    levels = np.rint(painted.color_of(given.vertices) * 255).astype(np.uint8)
    given.visual = trimesh.visual.ColorVisuals(given, vertex_colors=levels)
    mesh = bldsimp.simplify(given).mesh
    assert len(mesh.vertices) == 8
    assert mesh.visual.kind == "vertex"
    assert np.array_equal(mesh.visual.vertex_colors[:, :3], np.rint(painted.color_of(mesh.vertices) * 255))


def test_colors_of_faces() -> None:
    given = make_plain()
    side = painted.side_of(given.triangles)
    given.visual = trimesh.visual.ColorVisuals(given, face_colors=np.stack([side * 40, side, side, 255 - side], axis=1))
    mesh = bldsimp.simplify(given).mesh
    assert (len(mesh.vertices), len(mesh.faces)) == (8, 12)
    assert mesh.visual.kind == "face"
    side = painted.side_of(mesh.triangles)
    assert np.array_equal(mesh.visual.face_colors, np.stack([side * 40, side, side, 255 - side], axis=1))


def test_arrays_of_vertices_and_faces_keep_shape_and_type() -> None:
    given = make_plain()
    given.vertex_attributes["height"] = given.vertices[:, 2].astype(np.float32)
    given.face_attributes["wall"] = painted.side_of(given.triangles).astype(np.int16)
    given.vertex_attributes["names"] = np.array(["a"] * len(given.vertices))
    mesh = bldsimp.simplify(given).mesh
    assert mesh.vertex_attributes["height"].dtype == np.float32
    assert np.array_equal(mesh.vertex_attributes["height"], mesh.vertices[:, 2])
    assert mesh.face_attributes["wall"].dtype == np.int16
    assert np.array_equal(mesh.face_attributes["wall"], painted.side_of(mesh.triangles))
    assert "names" not in mesh.vertex_attributes


def test_what_is_given_stays_as_it_is() -> None:
    given = textured()
    before = given.visual.uv.copy(), given.vertices.copy(), given.faces.copy()
    bldsimp.simplify(given, "1%")
    assert np.array_equal(given.visual.uv, before[0])
    assert np.array_equal(given.vertices, before[1])
    assert np.array_equal(given.faces, before[2])


def test_without_anything_carried_nothing_is_repeated() -> None:
    mesh = bldsimp.simplify(make_plain()).mesh
    assert len(mesh.vertices) == 8
    assert not mesh.visual.defined


def test_several_materials_stay_on_their_faces() -> None:
    given = textured()
    number = (given.triangles_center[:, 0] > painted.SIZE / 2).astype(np.int32)
    materials = trimesh.visual.material.MultiMaterial([given.visual.material, trimesh.visual.material.PBRMaterial()])
    given.visual = trimesh.visual.TextureVisuals(uv=given.visual.uv, material=materials, face_materials=number)
    mesh = bldsimp.simplify(given).mesh
    assert mesh.visual.material is materials
    # Four sides are cut in halves.
    assert len(mesh.faces) == 20
    assert np.array_equal(mesh.visual.face_materials, mesh.triangles_center[:, 0] > painted.SIZE / 2)
    flat = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], process=False)
    flat.visual = trimesh.visual.TextureVisuals(uv=np.zeros((3, 2)), material=materials, face_materials=[1])
    assert bldsimp.simplify(flat).mesh.visual.material is materials


def test_a_material_without_uv_and_metadata_stay() -> None:
    given = make_plain()
    given.metadata["name"] = ["tower"]
    given.visual = trimesh.visual.TextureVisuals(material=trimesh.visual.material.PBRMaterial(name="brick"))
    mesh = bldsimp.simplify(given).mesh
    assert len(mesh.vertices) == 8
    assert mesh.visual.material is given.visual.material
    assert mesh.visual.uv is None
    assert mesh.metadata == given.metadata
    assert mesh.metadata is not given.metadata
