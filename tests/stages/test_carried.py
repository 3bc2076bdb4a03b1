"""Colors and labels come out where they went in, through every format that stores them."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import painted
import pytest
from painted import ROOF, WALL, check_uv, side_areas, values
from shapes import fine_box, stl_bytes, write
from textured_shapes import textured_shape

from bldsimp import Options, Tolerance
from bldsimp.inspection import count_defects
from bldsimp.io import FileScene, Written, read
from bldsimp.io import write as write_scene
from bldsimp.io.warnings import describe_attribute
from bldsimp.model import Mesh
from bldsimp.scene import simplify_scene

LIBRARY = "# by hand\nnewmtl wall\nKd 1 1 1\nmap_Kd wall.png\nillum 2\nnewmtl roof\nKd 1 1 1\nmap_Kd roof.png\n"


def simplify_to(source: Path, target: Path, options: Options | None = None) -> Written:
    """Simplify a file into another."""
    scene = read(source, source.suffix[1:])
    lights, _ = simplify_scene(scene, options or Options())
    target.parent.mkdir(exist_ok=True)
    return write_scene(scene, lights, target, target.suffix[1:], options or Options())


def mesh_of(path: Path) -> Mesh:
    (mesh,) = read(path, path.suffix[1:]).meshes
    return mesh


def write_house(folder: Path) -> Path:
    """Write the painted box as OBJ, with its library and images."""
    write(folder / "wall.png", WALL)
    write(folder / "roof.png", ROOF)
    write(folder / "m.mtl", LIBRARY)
    return write(folder / "in.obj", painted.obj())


def check_textures(path: Path) -> None:
    """A light box has its textures by area, UV by side, and the images byte for byte."""
    mesh = mesh_of(path)
    assert (count_defects(mesh.points, mesh.faces).points, len(mesh.faces)) == (8, 12)
    check_uv(mesh)
    for part in range(len(mesh.parts)):
        material = mesh.parts[part].material
        assert material is not None
        assert material.texture is not None
        areas = side_areas(mesh, mesh.part_of_face == part)
        assert areas in ([4, 4, 0, 0, 0, 0], [0, 0, 4, 4, 4, 4])
        if path.suffix in (".obj", ".ply"):
            assert (path.parent / material.texture).read_bytes() == (ROOF if areas[0] else WALL)
    assert len(mesh.parts) == 2


class TestColors:
    @pytest.mark.parametrize("suffix", ["obj", "ply", "glb", "off"])
    def test_of_an_obj_are_those_of_the_place(self, tmp_path: Path, suffix: str) -> None:
        house = write_house(tmp_path)
        write(house, painted.obj(colors=True))
        simplify_to(house, tmp_path / "new" / f"out.{suffix}")
        mesh = mesh_of(tmp_path / "new" / f"out.{suffix}")
        assert len(mesh.faces) == 12
        assert np.allclose(values(mesh, "COLOR_0")[:, :3], painted.color_of(mesh.points), rtol=0, atol=1e-7)

    @pytest.mark.parametrize("suffix", ["obj", "ply"])
    def test_of_an_obj_in_levels_stay_levels(self, tmp_path: Path, suffix: str) -> None:
        points, faces = fine_box()
        rows = np.hstack([points, painted.color_of(points) * 255]).tolist()
        lines = ["v " + " ".join(map(repr, row)) for row in rows] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
        simplify_to(write(tmp_path / "in.obj", "\n".join(lines)), tmp_path / f"out.{suffix}")
        mesh = mesh_of(tmp_path / f"out.{suffix}")
        assert np.allclose(values(mesh, "COLOR_0"), painted.color_of(mesh.points), atol=1e-12)
        if suffix == "obj":
            stored = [line.split()[4:] for line in (tmp_path / "out.obj").read_text().splitlines() if line[:2] == "v "]
            assert {word for row in stored for word in row} == {"0.0", "204.0"}

    @pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian", "binary_big_endian"])
    @pytest.mark.parametrize("kind", ["uchar", "ushort", "float"])
    def test_of_a_ply_keep_their_type_and_value(self, tmp_path: Path, kind: str, encoding: str) -> None:
        points, faces = fine_box()
        scale = {"uchar": 255, "ushort": 65535, "float": 1.0}[kind]
        table = [(points, "float", "x y z"), (painted.color_of(points) * scale, kind, "red green blue")]
        source = write(tmp_path / "in.ply", ply(table, faces, encoding=encoding))
        simplify_to(source, tmp_path / "out.ply")
        assert properties(tmp_path / "out.ply") == properties(source)
        mesh = mesh_of(tmp_path / "out.ply")
        assert len(mesh.points) == 8
        assert np.allclose(values(mesh, "COLOR_0"), painted.color_of(mesh.points), rtol=0, atol=1e-7)

    def test_a_color_that_changes_unevenly_stops_a_facet(self, tmp_path: Path) -> None:
        points, faces = fine_box()
        colors = np.where(points[:, :1] > 0.9, (255, 0, 0), (0, 0, 255))
        table = [(points, "float", "x y z"), (colors, "uchar", "red green blue")]
        source = write(tmp_path / "in.ply", ply(table, faces))
        simplify_to(source, tmp_path / "out.ply")
        mesh = mesh_of(tmp_path / "out.ply")
        assert sorted(set(mesh.points[:, 0].tolist())) == [0.0, 0.5, 1.0, 2.0]
        wanted = np.where(mesh.points[:, :1] > 0.9, (255, 0, 0), (0, 0, 255))
        assert np.array_equal(values(mesh, "COLOR_0") * 255, wanted)

    @pytest.mark.parametrize("suffix", ["ply", "glb", "obj", "off"])
    def test_of_faces(self, tmp_path: Path, suffix: str) -> None:
        points, faces = fine_box()
        side = painted.side_of(points[faces])
        colors = np.stack([side * 51, 255 - side * 51, side * 0], axis=1)
        data = ply([(points, "float", "x y z")], faces, [(colors, "uchar", "red green blue")])
        source = write(tmp_path / "in.ply", data)
        simplify_to(source, tmp_path / f"out.{suffix}")
        mesh = mesh_of(tmp_path / f"out.{suffix}")
        assert len(mesh.faces) == 12
        side = painted.side_of(mesh.points[mesh.faces])
        if suffix in ("ply", "off"):
            found = values(mesh, "FACE_COLOR_0")
        else:
            corners = values(mesh, "COLOR_0")[mesh.faces]
            assert np.all(corners == corners[:, :1])
            found = corners[:, 0, :3]
        assert np.allclose(found * 255, np.stack([side * 51, 255 - side * 51, side * 0], axis=1), atol=1e-4)
        assert count_defects(mesh.points, mesh.faces).watertight

    def test_of_an_off_stay(self, tmp_path: Path) -> None:
        points, faces = fine_box()
        levels = np.rint(painted.color_of(points) * 255).astype(int)
        rows = [[*p, *c] for p, c in zip(points.tolist(), levels.tolist(), strict=True)]
        lines = ["COFF", f"{len(points)} {len(faces)} 0", *(" ".join(map(str, row)) for row in rows)]
        lines += [f"3 {a} {b} {c} {int(i % 2)} 7 9" for i, (a, b, c) in enumerate(faces.tolist())]
        simplify_to(write(tmp_path / "in.off", "\n".join(lines) + "\n"), tmp_path / "out.off")
        before, after = mesh_of(tmp_path / "in.off"), mesh_of(tmp_path / "out.off")
        assert np.allclose(values(after, "COLOR_0"), painted.color_of(after.points), atol=1e-12)
        # Every other face is of another color: none can go.
        assert len(after.faces) == len(before.faces)
        assert sorted(map(tuple, values(after, "FACE_COLOR_0"))) == sorted(map(tuple, values(before, "FACE_COLOR_0")))


class TestLabels:
    def test_of_faces_and_points_stop_facets_and_keep_their_type(self, tmp_path: Path) -> None:
        points, faces = fine_box()
        side = painted.side_of(points[faces])
        split = (points[faces].mean(axis=1)[:, 2] > 1.0).astype(int) + 2 * side
        storey = np.full(len(points), 7)
        table = [(points, "double", "x y z"), (points[:, :1] * 3.5, "float", "heat"), (storey, "short", "storey")]
        source = write(tmp_path / "in.ply", ply(table, faces, [(split, "int", "label")]))
        simplify_to(source, tmp_path / "out.ply")
        assert properties(tmp_path / "out.ply") == properties(source)
        mesh = mesh_of(tmp_path / "out.ply")
        kinds = {one.name: one.kind for one in mesh.attributes}
        assert kinds == {"_heat": "color", "_storey": "feature", "FACE__label": "feature"}
        assert np.array_equal(values(mesh, "_heat")[:, 0], mesh.points[:, 0] * 3.5)
        assert set(values(mesh, "_storey")[:, 0]) == {7}
        corners = mesh.points[mesh.faces]
        wanted = (corners.mean(axis=1)[:, 2] > 1.0) + 2 * painted.side_of(corners)
        assert np.array_equal(values(mesh, "FACE__label")[:, 0], wanted)
        assert len(mesh.points) == 12

    def test_stl_attribute_bytes(self, tmp_path: Path) -> None:
        points, faces = fine_box()
        data = bytearray(stl_bytes(points, faces))
        side = painted.side_of(points[faces])
        for number, own in enumerate(side.tolist()):
            data[84 + 50 * number + 48 : 84 + 50 * number + 50] = (1000 + own).to_bytes(2, "little")
        simplify_to(write(tmp_path / "in.stl", bytes(data)), tmp_path / "out.stl")
        mesh = mesh_of(tmp_path / "out.stl")
        assert len(mesh.faces) == 12
        assert np.array_equal(values(mesh, "FACE__stl")[:, 0], 1000 + painted.side_of(mesh.points[mesh.faces]))

    def test_go_to_glb_and_back(self, tmp_path: Path) -> None:
        points, faces = fine_box()
        table = [(points, "float", "x y z"), (points[:, :1] * 3.5, "float", "heat")]
        simplify_to(write(tmp_path / "in.ply", ply(table, faces)), tmp_path / "mid.glb")
        simplify_to(tmp_path / "mid.glb", tmp_path / "out.ply")
        mesh = mesh_of(tmp_path / "out.ply")
        assert np.array_equal(values(mesh, "_heat")[:, 0], mesh.points[:, 0] * 3.5)
        assert len(mesh.points) == 8


class TestWedges:
    """PLY files whose faces have the texture coordinates of their corners."""

    @pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian"])
    def test_points_stay_single(self, tmp_path: Path, encoding: str) -> None:
        points, faces = fine_box()
        uv = painted.uv_of(points[faces]).reshape(-1, 6)
        number = painted.material_of_side(painted.side_of(points[faces]))
        data = ply(
            [(points, "float", "x y z")], faces, [(number, "int", "texnumber")],
            encoding=encoding, wedges=uv, textures=("wall.png", "roof.png"),
        )  # fmt: skip
        write(tmp_path / "wall.png", WALL)
        write(tmp_path / "roof.png", ROOF)
        simplify_to(write(tmp_path / "in.ply", data), tmp_path / "new" / "out.ply")
        check_textures(tmp_path / "new" / "out.ply")
        assert b"element vertex 8\n" in (tmp_path / "new" / "out.ply").read_bytes()
        simplify_to(tmp_path / "in.ply", tmp_path / "new" / "out.obj")
        check_textures(tmp_path / "new" / "out.obj")


def ply(vertex, faces, face=(), *, encoding="binary_little_endian", wedges=None, textures=()) -> bytes:
    """A PLY file of columns: each some values, their type, and their names."""
    kinds = {"float": "f4", "double": "f8", "uchar": "u1", "ushort": "u2", "short": "i2", "int": "i4"}
    head = [f"ply\nformat {encoding} 1.0", *(f"comment TextureFile {name}" for name in textures)]
    order = ">" if "big" in encoding else "<"
    elements = []
    for name, count, table in (("vertex", len(vertex[0][0]), vertex), ("face", len(faces), face)):
        head.append(f"element {name} {count}")
        fields, columns = [], []
        if name == "face":
            head.append("property list uchar int vertex_indices")
            fields += [("n", "u1"), ("v", order + "i4", (3,))]
            columns += [np.full(count, 3), faces]
            if wedges is not None:
                head.append("property list uchar float texcoord")
                fields += [("tn", "u1"), ("t", order + "f4", (6,))]
                columns += [np.full(count, 6), wedges]
        for number, (values_, kind, names) in enumerate(table):
            for column, own in zip(np.reshape(values_, (count, -1)).T, names.split(), strict=True):
                head.append(f"property {kind} {own}")
                fields.append((f"c{number}{own}", order + kinds[kind]))
                columns.append(np.rint(column) if kind not in ("float", "double") else column)
        rows = np.empty(count, fields)
        for (own, *_), column in zip(fields, columns, strict=True):
            rows[own] = column
        elements.append(rows)
    start = ("\n".join(head) + "\nend_header\n").encode()
    if encoding != "ascii":
        return start + b"".join(rows.tobytes() for rows in elements)
    lines = [" ".join(str(v) for cell in row.tolist() for v in np.ravel(cell)) for rows in elements for row in rows]
    return start + ("\n".join(lines) + "\n").encode()


def properties(path: Path) -> list[bytes]:
    """The property lines of a PLY file."""
    return re.findall(rb"^property .*$", path.read_bytes().split(b"end_header")[0], re.MULTILINE)


@pytest.mark.parametrize("suffix", ["obj", "ply", "glb"])
@pytest.mark.parametrize("seed", range(12))
def test_what_is_written_is_read_again(tmp_path: Path, seed: int, suffix: str) -> None:
    given, story = textured_shape(seed)
    scene = FileScene(None, "arrays", [given], 0)
    options = Options(tolerance=Tolerance(1.0, "percent")) if seed % 2 else Options()
    (light_,), _ = simplify_scene(scene, options)
    written = write_scene(scene, [light_], tmp_path / f"out.{suffix}", suffix, options)
    mesh = mesh_of(tmp_path / f"out.{suffix}")
    # PLY has the faces in order, OBJ and glTF part by part.
    order = np.argsort(light_.part_of_face, kind="stable") if suffix != "ply" else np.arange(len(light_.faces))
    world = mesh.points @ mesh.transforms[0][:3, :3].T + mesh.transforms[0][:3, 3]
    assert np.allclose(world[mesh.faces], light_.points[light_.faces[order]], rtol=1e-12, atol=written.rounding), story
    found = {one.name: one.values[mesh.faces] for one in mesh.attributes}
    told = " ".join(written.warnings)
    for one in given.attributes:
        wanted = light_.values(one)[light_.faces[order]]
        if suffix == "ply" and one.name == "TEXCOORD_1":
            own = np.concatenate([found["_texcoord_1_0"], found["_texcoord_1_1"]], axis=2)
        elif suffix == "obj" and one.name not in ("TEXCOORD_0", "COLOR_0"):
            assert describe_attribute(one.name) in told
            continue
        else:
            own = found[one.name if suffix != "ply" else {"_FEATURE_ID_0": "_feature_id_0"}.get(one.name, one.name)]
        # PLY colors are bytes; OBJ ones have no alpha.
        allowed = 0.5 / 255 if one.name == "COLOR_0" and suffix == "ply" else 0.0
        wanted = wanted[:, :, : own.shape[2]]
        assert np.allclose(own, wanted, rtol=1e-6, atol=allowed + 1e-7), f"{story}: {one.name}"
