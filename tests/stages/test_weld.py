"""Near points joined on request: what is written is closed, also beside parts that are passed on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from shapes import Gltf, fine_box, read_values, split_glb

from bldsimp import Options, Report, Tolerance, _core
from bldsimp.inspection import count_defects
from bldsimp.io import read
from bldsimp.io import write as write_scene
from bldsimp.model import Mesh, Part, Scene, SimplifiedMesh
from bldsimp.scene import simplify_scene

WELD = Options(weld=0.05, tolerance=Tolerance(0.1, "length"))


def halves(seed: int, amount: float = 0.01) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A fine box of two parts with points of their own, those of the second strayed; rows in any order."""
    random = np.random.default_rng(seed)
    points, faces = fine_box()
    part = (points[faces].mean(axis=1)[:, 0] > 1).astype(np.int32)
    both = np.vstack([points, points + random.uniform(-amount, amount, points.shape)]).astype(np.float32)
    order = random.permutation(len(both))
    faces = np.argsort(order)[faces + part[:, None] * len(points)]
    return both[order].astype(float), faces.astype(np.int32), part


def simplified(seed: int, carried: tuple[tuple[str, ...], tuple[str, ...]]) -> tuple[Mesh, SimplifiedMesh, Report]:
    points, faces, part = halves(seed)
    parts = [Part(str(number), fixed=names) for number, names in enumerate(carried)]
    mesh = Mesh("box", points, faces, part, parts)
    lights, report = simplify_scene(Scene(None, "arrays", [mesh], 0), WELD)
    return mesh, lights[0], report


@pytest.mark.parametrize("carried", [((), ()), ((), ("vt",)), (("vt",), ()), (("vt",), ("vt",))])
@pytest.mark.parametrize("seed", range(4))
def test_a_report_of_no_crack_is_true(seed: int, carried: tuple[tuple[str, ...], tuple[str, ...]]) -> None:
    mesh, light, report = simplified(seed, carried)
    surface = count_defects(mesh.points, light.faces)
    assert (surface.open_edges, surface.points) == (report.after.open_edges, report.after.points)
    assert report.deviation <= 0.1
    # Where nothing may move, what was open stays so.
    assert surface.watertight is (carried != (("vt",), ("vt",)))
    for number, names in enumerate(carried):
        if names:
            assert np.array_equal(light.faces[light.part_of_face == number], mesh.faces[mesh.part_of_face == number])


@pytest.mark.parametrize("seed", range(4))
def test_the_deviation_bounds_what_welding_moved(seed: int) -> None:
    mesh, light, report = simplified(seed, ((), ("vt",)))
    corners = mesh.points[np.unique(light.faces)]
    sides = np.minimum(np.abs(corners), np.abs(corners - 2.0)).min(axis=1)
    assert 0.0 < sides.max() <= report.deviation


def test_order_does_not_matter() -> None:
    first, second = (simplified(0, ((), ("vt",))) for _ in range(2))
    points, faces, part = halves(0)
    order = np.random.default_rng(9).permutation(len(points))
    mesh = Mesh("box", points[order], np.argsort(order)[faces].astype(np.int32), part, first[0].parts)
    lights, _ = simplify_scene(Scene(None, "arrays", [mesh], 0), WELD)
    assert np.array_equal(first[0].points[first[1].faces], second[0].points[second[1].faces])
    assert np.array_equal(first[0].points[first[1].faces], mesh.points[lights[0].faces])


@pytest.mark.parametrize("textured", [False, True])
def test_a_glb_is_closed_as_it_is_written(tmp_path: Path, textured: bool) -> None:
    points, faces, part = halves(0)
    document = Gltf()
    uv = {"TEXCOORD_0": document.accessor(points[:, :2] / 4)} if textured else {}
    document.mesh(*(
        {"attributes": {"POSITION": document.accessor(points), **more},
         "indices": document.accessor(faces[part == number].reshape(-1), "u2")}
        for number, more in enumerate(({}, uv))
    ))  # fmt: skip
    source = document.glb()
    scene = read(source, "glb")
    lights, report = simplify_scene(scene, WELD)
    write_scene(scene, lights, tmp_path / "out.glb", "glb", WELD)
    mesh = read(tmp_path / "out.glb", "glb").meshes[0]
    surface = count_defects(mesh.points, mesh.faces)
    assert (surface.watertight, surface.points) == (True, report.after.points)
    after = (tmp_path / "out.glb").read_bytes()
    primitives = split_glb(after)[0]["meshes"][0]["primitives"]
    if textured:
        attributes = primitives[1]["attributes"]
        shown, at = (read_values(after, attributes[name]) for name in ("TEXCOORD_0", "POSITION"))
        # A corner keeps what it carries where a weld moved it, by up to 0.02.
        assert np.allclose(shown, at[:, :2] / 4, atol=0.02 / 4)


def test_corners_that_stay_keep_their_own_rows() -> None:
    # Each face of a fine box has rows of its own, as a flat-shaded file has; one far point makes a weld.
    points, faces = fine_box()
    middle = points[faces].mean(axis=1)
    side = np.argmax(np.abs(middle - 1.0), axis=1) * 2 + (middle.max(axis=1) > 1.9)
    rows = points[faces].reshape(-1, 3)
    own = np.arange(len(rows), dtype=np.int32).reshape(-1, 3)
    rows[own[0, 0]] += 1e-3
    mesh = Mesh("box", rows, own, np.zeros(len(own), np.int32), [Part("box")])
    lights, _ = simplify_scene(Scene(None, "arrays", [mesh], 0), Options(weld=0.01, tolerance=Tolerance(0.1, "length")))
    light = lights[0].faces
    assert len(light) == 12
    of_row = np.repeat(side, 3)[light]
    assert (of_row == of_row[:, :1]).all()


def test_primitives_of_two_number_formats_meet_where_they_should(tmp_path: Path) -> None:
    points, faces = fine_box(size=8.0)
    part = (points[faces].mean(axis=1)[:, 0] > 4).astype(int)
    document = Gltf()
    document.json["extensionsUsed"] = ["KHR_mesh_quantization"]
    document.mesh(*(
        {"attributes": {"POSITION": document.accessor(values, kind)},
         "indices": document.accessor(faces[part == number].reshape(-1), "u2")}
        for number, (values, kind) in enumerate(((points + 0.01 * (points == 4.0), "f4"), (points, "u2")))
    ))  # fmt: skip
    scene = read(document.glb(), "glb")
    options = Options(weld=0.05, tolerance=Tolerance(0.2, "length"))
    lights, _ = simplify_scene(scene, options)
    write_scene(scene, lights, tmp_path / "out.glb", "glb", options)
    mesh = read(tmp_path / "out.glb", "glb").meshes[0]
    used = mesh.points[np.unique(mesh.faces)]
    gap = np.abs(used[:, None] - points[None]).max(axis=2).min(axis=1)
    assert gap.max() <= 0.011
    assert len(np.unique(used.round(), axis=0)) >= 8
    assert count_defects(mesh.points.round(), mesh.faces).watertight


def test_welding_beyond_a_wide_tolerance_ends_as_well_as_any() -> None:
    points, faces, part = halves(0)
    mesh = Mesh("box", points, faces, part, [Part("a"), Part("b")])
    (light,), report = simplify_scene(
        Scene(None, "arrays", [mesh], 0), Options(tolerance=Tolerance(0.005, "length"), weld=0.02)
    )
    assert 0 < len(light.faces) <= len(faces)
    assert report.after.watertight


def test_welding_nearer_than_any_number_can_tell_moves_nothing() -> None:
    points, faces, _ = halves(0)
    near, same = _core.weld(points, faces, 1e-300), _core.weld(points, faces, 0.0)
    assert near.moved == 0.0
    assert np.array_equal(near.points, same.points)
