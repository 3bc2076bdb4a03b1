"""Vertex normals of a result: smooth stays smooth, hard stays hard, and what is kept is kept to the bit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from shapes import box, fine_box, obj_text, read_values, split_glb, write

from bldsimp import Options, Tolerance
from bldsimp.io import read
from bldsimp.io import write as write_scene
from bldsimp.model import Mesh, Part, SimplifiedMesh
from bldsimp.scene import simplify_scene
from bldsimp.stages.normals import compute_face_normals, compute_smooth_normals, resolve_normals

SIDES, HEIGHT = 24, 6


def tube(rows: int = HEIGHT) -> tuple[np.ndarray, np.ndarray]:
    """A closed tube of 24 sides, its wall in rows, with flat ends."""
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points = np.vstack([np.column_stack([ring, np.full(SIDES, z)]) for z in np.linspace(0.0, 2.0, rows + 1)])
    faces = []
    for row in range(rows):
        for i in range(SIDES):
            a, b = row * SIDES + i, row * SIDES + (i + 1) % SIDES
            faces += [(a, b, b + SIDES), (a, b + SIDES, a + SIDES)]
    top = rows * SIDES
    for i in range(1, SIDES - 1):
        faces += [(0, i + 1, i), (top, top + i, top + i + 1)]
    return points, np.array(faces, np.int32)


def outward_box() -> tuple[np.ndarray, np.ndarray]:
    """A box wound outwards, as the pipeline leaves it."""
    points, faces = box()
    return points, np.ascontiguousarray(faces[:, ::-1])


def as_light(mesh: Mesh) -> SimplifiedMesh:
    """A mesh as it is, as a result."""
    rows, faces = np.arange(len(mesh.points)), np.arange(len(mesh.faces))
    return SimplifiedMesh(mesh.points, mesh.faces, mesh.part_of_face, rows.astype(np.int32), faces.astype(np.int32))


def mesh(points: np.ndarray, faces: np.ndarray, normals: np.ndarray | None = None) -> Mesh:
    return Mesh("mesh", points, faces, np.zeros(len(faces), np.int32), [Part("mesh")], normals=normals)


def shaded_tube() -> str:
    """The tube as OBJ: normals that are round on its wall, flat on its ends, both at the points of the rims."""
    points, faces = tube()
    flat = compute_face_normals(points, faces)
    end = np.abs(flat[:, 2]) > 0.0
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
    lines += [f"vn {x!r} {y!r} 0.0" for x, y in points[:, :2].tolist()] + ["vn 0 0 -1", "vn 0 0 1"]
    for face, is_end, normal in zip(faces, end, flat, strict=True):
        own = [len(points) + 1 + int(normal[2] > 0)] * 3 if is_end else [i + 1 for i in face]
        lines.append("f " + " ".join(f"{i + 1}//{n}" for i, n in zip(face, own, strict=True)))
    return "\n".join(lines) + "\n"


def split_box() -> Mesh:
    """A box that repeats its points for each face, with normals that lean a little off their faces."""
    points, faces = outward_box()
    rows = points[faces].reshape(-1, 3)
    corners = np.arange(36, dtype=np.int32).reshape(12, 3)
    normals = np.repeat(compute_face_normals(rows, corners), 3, axis=0)
    return mesh(rows, corners, normals + 0.2 * np.roll(normals, 1, axis=1))


class TestKept:
    @pytest.mark.parametrize("suffix", ["obj", "ply", "glb"])
    @pytest.mark.parametrize("tolerance", [Tolerance(), Tolerance(1e-3, "length")])
    def test_a_tube_stays_round_and_its_rims_hard(self, tmp_path: Path, suffix: str, tolerance: Tolerance) -> None:
        scene = read(write(tmp_path / "in.obj", shaded_tube()), "obj")
        options = Options(tolerance=tolerance)
        lights, _ = simplify_scene(scene, options)
        write_scene(scene, lights, tmp_path / f"out.{suffix}", suffix, options)
        (after,) = read(tmp_path / f"out.{suffix}", suffix).meshes
        assert after.normals is not None
        assert len(np.unique(after.points, axis=0)) == 2 * SIDES
        flat = compute_face_normals(after.points, after.faces)
        end = np.abs(flat[:, 2]) > 1e-6
        corners, normals = after.points[after.faces], after.normals[after.faces]
        assert np.allclose(normals[~end][:, :, :2], corners[~end][:, :, :2], atol=1e-6)
        assert np.allclose(normals[~end][:, :, 2], 0.0)
        assert np.array_equal(normals[end], np.sign(flat[end])[:, None, :].repeat(3, axis=1) * [0, 0, 1])

    def test_a_hard_point_that_moved_keeps_normals_that_fit(self) -> None:
        given = split_box()
        assert given.normals is not None
        light = as_light(given)
        light.points = 1.01 * given.points
        after, found = resolve_normals(given, light, Options(crease_angle=60.0))
        assert after is light
        assert np.array_equal(found, given.normals)

    def test_a_hard_point_that_moved_gets_normals_where_its_own_do_not_fit(self) -> None:
        given = split_box()
        assert given.normals is not None
        given.normals = -given.normals
        light = as_light(given)
        moves = np.all(given.points == given.points.max(axis=0), axis=1)
        light.points = given.points + 0.01 * moves[:, None]
        after, found = resolve_normals(given, light, Options())
        assert found is not None
        at = moves[after.row]
        assert np.array_equal(found[~at], given.normals[after.row[~at]])
        own = compute_face_normals(after.points, after.faces)
        for face, normal in zip(after.faces, own / np.linalg.norm(own, axis=1, keepdims=True), strict=True):
            assert all(np.dot(found[row], normal) > np.cos(np.radians(30)) for row in face if at[row])

    def test_a_smooth_point_that_moved_stays_smooth(self) -> None:
        points, faces = outward_box()
        given = mesh(points, faces, points - 1.0)
        light = as_light(given)
        light.points = points.copy()
        light.points[7] += 0.01
        after, found = resolve_normals(given, light, Options())
        assert found is not None
        assert len(after.points) == 8
        assert np.allclose(found[7] * np.sqrt(3), np.sign(points[7] - 1.0), atol=0.05)
        assert np.array_equal(found[:7], points[:7] - 1.0)

    @pytest.mark.parametrize("sign", [1.0, -1.0])
    def test_normals_turn_with_faces_that_were_inside_out(self, tmp_path: Path, sign: float) -> None:
        points, faces = fine_box()
        normals = sign * (points - 1.0)
        lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
        lines += [f"vn {x!r} {y!r} {z!r}" for x, y, z in normals.tolist()]
        # Wound inwards; where the normals agree with that, they must turn as well.
        lines += [f"f {a}//{a} {c}//{c} {b}//{b}" for a, b, c in (faces + 1).tolist()]
        scene = read(write(tmp_path / "in.obj", "\n".join(lines)), "obj")
        options = Options(delimit=frozenset({"material"}))
        (light,), report = simplify_scene(scene, options)
        assert report.reversed_faces == len(faces)
        _, found = resolve_normals(scene.meshes[0], light, options)
        assert found is not None
        used = np.unique(light.faces)
        assert np.array_equal(found[used], light.points[used] - 1.0)


class TestMade:
    def test_a_box_is_hard_all_over(self, tmp_path: Path) -> None:
        scene = read(write(tmp_path / "in.obj", obj_text(*fine_box())), "obj")
        lights, _ = simplify_scene(scene, Options(normals="smooth"))
        written = write_scene(scene, lights, tmp_path / "out.glb", "glb", Options(normals="smooth"))
        data = (tmp_path / "out.glb").read_bytes()
        primitive = split_glb(data)[0]["meshes"][0]["primitives"][0]
        points, normals = (read_values(data, primitive["attributes"][name]) for name in ("POSITION", "NORMAL"))
        faces = read_values(data, primitive["indices"]).reshape(-1, 3)
        assert written.vertices == len(points) == 24
        flat = compute_face_normals(points, faces)
        assert np.allclose(normals[faces], (flat / np.linalg.norm(flat, axis=1, keepdims=True))[:, None])

    @pytest.mark.parametrize(("angle", "rows"), [(10.0, 6 * SIDES), (30.0, 4 * SIDES), (100.0, 2 * SIDES)])
    def test_the_angle_tells_what_is_hard(self, angle: float, rows: int) -> None:
        points, faces = tube(1)
        given = mesh(points, faces)
        light, normals = resolve_normals(given, as_light(given), Options(normals="smooth", crease_angle=angle))
        assert normals is not None
        assert len(np.unique(light.faces)) == rows
        if angle == 30.0:
            wall = normals[light.faces[np.abs(compute_face_normals(points, faces)[:, 2]) == 0.0]]
            assert np.allclose(wall, np.column_stack([points[:, :2], np.zeros(len(points))])[faces[: 2 * SIDES]])

    def test_a_fan_round_one_point_is_one_group(self) -> None:
        count = 500
        angle = 2 * np.pi * np.arange(count) / count
        points = np.vstack([[[0, 0, 1.0]], np.column_stack([5 * np.cos(angle), 5 * np.sin(angle), np.zeros(count)])])
        order = np.random.default_rng(1).permutation(count)
        faces = np.array([(0, i + 1, (i + 1) % count + 1) for i in order], np.int32)
        group, normals = compute_smooth_normals(points, faces, 30.0)
        assert len(set(group[::3].tolist())) == 1
        assert np.allclose(normals[group[0]], [0, 0, 1])

    def test_attributes_follow_to_the_rows_that_are_added(self) -> None:
        points, faces = box()
        given = mesh(points, faces)
        light = as_light(given)
        light.changed = {"TEXCOORD_0": points[:, :2]}
        after, _ = resolve_normals(given, light, Options(normals="smooth"))
        assert len(after.points) == 24
        assert np.array_equal(after.changed["TEXCOORD_0"], after.points[:, :2])
        assert np.array_equal(points[after.row], after.points)
        assert np.array_equal(after.points[after.faces], points[faces])
        assert len(light.points) == 8

    def test_parts_that_are_passed_on_keep_theirs(self) -> None:
        points, faces = box()
        given = mesh(points, faces, np.tile([0.6, 0.0, 0.8], (8, 1)))
        given.parts = [Part("plain"), Part("skinned", fixed=("skin",))]
        given.part_of_face[:6] = 1
        after, found = resolve_normals(given, as_light(given), Options(normals="smooth"))
        assert found is not None
        assert np.array_equal(found[after.faces[:6]], np.tile([0.6, 0.0, 0.8], (6, 3, 1)))
        flat = compute_face_normals(points, faces[6:])
        assert np.allclose(found[after.faces[6:]], (flat / np.linalg.norm(flat, axis=1, keepdims=True))[:, None])
