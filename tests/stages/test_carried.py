"""Textures, colours and labels come out where they went in, through every format that holds them."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import painted
import pytest
from painted import IMAGE, ROOF, WALL, check_uv, side_areas, textured, values
from PIL import Image
from shapes import Gltf, fine_box, glb_parts, stl_bytes, write
from textured_shapes import textured_shape

from bldsimp import Options, Tolerance
from bldsimp.inspection import count_defects
from bldsimp.io import FileScene, Written, read
from bldsimp.io import write as write_scene
from bldsimp.io.warnings import describe_attribute
from bldsimp.model import Mesh
from bldsimp.scene import simplify_scene

LIBRARY = "# by hand\nnewmtl wall\nKd 1 1 1\nmap_Kd wall.png\nillum 2\nnewmtl roof\nKd 1 1 1\nmap_Kd roof.png\n"


def light(source: Path, target: Path, options: Options | None = None) -> Written:
    """Simplify a file into another."""
    scene = read(source, source.suffix[1:])
    lights, _ = simplify_scene(scene, options or Options())
    target.parent.mkdir(exist_ok=True)
    return write_scene(scene, lights, target, target.suffix[1:], options or Options())


def mesh_of(path: Path) -> Mesh:
    (mesh,) = read(path, path.suffix[1:]).meshes
    return mesh


@pytest.fixture
def house(tmp_path: Path) -> Path:
    """The painted box as OBJ, with its library and images."""
    write(tmp_path / "wall.png", WALL)
    write(tmp_path / "roof.png", ROOF)
    write(tmp_path / "m.mtl", LIBRARY)
    return write(tmp_path / "in.obj", painted.obj())


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


class TestTextures:
    @pytest.mark.parametrize("suffix", ["obj", "ply", "glb", "gltf"])
    def test_of_an_obj_stay_on_their_sides(self, house: Path, tmp_path: Path, suffix: str) -> None:
        written = light(house, tmp_path / "new" / f"out.{suffix}")
        check_textures(tmp_path / "new" / f"out.{suffix}")
        assert not any("no file" in warning or "texture coordinates" in warning for warning in written.warnings)

    @pytest.mark.parametrize("middle", ["glb", "gltf", "ply"])
    @pytest.mark.parametrize("suffix", ["obj", "ply", "glb"])
    def test_survive_two_conversions(self, house: Path, tmp_path: Path, middle: str, suffix: str) -> None:
        light(house, tmp_path / "mid" / f"mid.{middle}")
        light(tmp_path / "mid" / f"mid.{middle}", tmp_path / "new" / f"out.{suffix}")
        check_textures(tmp_path / "new" / f"out.{suffix}")

    def test_image_sizes_are_the_steps_of_uv(self, house: Path) -> None:
        assert mesh_of(house).attributes[0].steps.tolist() == [[512, 256], [64, 64]]

    def test_repeated_textures_have_more_texels(self, house: Path, tmp_path: Path) -> None:
        write(tmp_path / "m.mtl", LIBRARY.replace("map_Kd wall.png", "map_Kd -o 0 0 0 -s 4 2 1 -clamp on wall.png"))
        assert mesh_of(house).attributes[0].steps[0].tolist() == [4 * 512, 2 * 256]

    def test_equal_coordinates_are_written_once(self, house: Path, tmp_path: Path) -> None:
        light(house, tmp_path / "out.obj")
        lines = [line for line in (tmp_path / "out.obj").read_text().splitlines() if line.startswith("vt ")]
        assert len(lines) == len(set(lines)) <= 24
        assert sum(line.startswith("v ") for line in (tmp_path / "out.obj").read_text().splitlines()) == 8

    def test_an_obj_takes_library_and_every_map_along(self, house: Path, tmp_path: Path) -> None:
        (tmp_path / "maps").mkdir()
        bump, glow = b"BM bump", b"BM glow"
        write(tmp_path / "maps" / "bump map.bmp", bump)
        write(tmp_path / "maps" / "glow.bmp", glow)
        library = LIBRARY + "map_Bump -bm 0.5 maps/bump map.bmp\nnewmtl unused\nmap_Ke maps\\glow.bmp\n"
        write(tmp_path / "m.mtl", library)
        light(house, tmp_path / "new" / "out.obj")
        new = {p.relative_to(tmp_path / "new").as_posix(): p for p in (tmp_path / "new").rglob("*") if p.is_file()}
        assert set(new) == {"out.obj", "m.mtl", "wall.png", "roof.png", "maps/bump map.bmp", "maps/glow.bmp"}
        assert new["m.mtl"].read_text() == library
        assert new["maps/bump map.bmp"].read_bytes() == bump
        assert new["maps/glow.bmp"].read_bytes() == glow

    def test_beside_the_input_nothing_is_written_twice(self, house: Path, tmp_path: Path) -> None:
        before = {p: p.stat().st_mtime_ns for p in tmp_path.iterdir()}
        light(house, tmp_path / "out.obj")
        assert {p: p.stat().st_mtime_ns for p in tmp_path.iterdir() if p.name != "out.obj"} == before

    def test_a_texture_that_is_missing_is_told(self, house: Path, tmp_path: Path) -> None:
        (tmp_path / "wall.png").unlink()
        for suffix in ("obj", "ply", "glb"):
            written = light(house, tmp_path / suffix / f"out.{suffix}")
            assert any("'wall.png'" in warning for warning in written.warnings)

    @pytest.mark.parametrize("name", ["gone.mtl", "../m.mtl", "gone.mtl other.mtl"])
    def test_a_library_that_is_missing_is_told_once(self, house: Path, tmp_path: Path, name: str) -> None:
        (tmp_path / "below").mkdir()
        source = write(tmp_path / "below" / "in.obj", painted.obj(library=name))
        for suffix in ("obj", "ply", "glb", "gltf"):
            written = light(source, tmp_path / suffix / f"out.{suffix}")
            assert sum(f"'{name}'" in warning for warning in written.warnings) == 1

    def test_a_library_is_missing_where_the_model_comes_from_a_pipe(self, house: Path, tmp_path: Path) -> None:
        scene = read(house.read_bytes(), "obj")
        lights, _ = simplify_scene(scene, Options())
        written = write_scene(scene, lights, tmp_path / "out.glb", "glb", Options())
        assert any("'m.mtl'" in warning for warning in written.warnings)

    @pytest.mark.parametrize("suffix", ["obj", "ply", "glb"])
    def test_one_line_may_name_several_libraries(self, tmp_path: Path, suffix: str) -> None:
        wall, roof = LIBRARY.split("newmtl roof")
        write(tmp_path / "wall.mtl", wall)
        write(tmp_path / "my roof.mtl", "newmtl nothing\n")
        write(tmp_path / "roof.mtl", "newmtl roof" + roof)
        write(tmp_path / "wall.png", WALL)
        write(tmp_path / "roof.png", ROOF)
        text = painted.obj(library="wall.mtl roof.mtl gone.mtl\nmtllib my roof.mtl")
        written = light(write(tmp_path / "in.obj", text), tmp_path / "new" / f"out.{suffix}")
        check_textures(tmp_path / "new" / f"out.{suffix}")
        assert ["'gone.mtl'" in warning for warning in written.warnings if ".mtl" in warning] == [True]

    def test_a_library_in_a_folder_of_its_own_names_textures_there(self, tmp_path: Path) -> None:
        (tmp_path / "mats").mkdir()
        write(tmp_path / "mats" / "wall.png", WALL)
        write(tmp_path / "mats" / "roof.png", ROOF)
        write(tmp_path / "mats" / "m.mtl", LIBRARY)
        source = write(tmp_path / "in.obj", painted.obj(library="mats/m.mtl"))
        light(source, tmp_path / "new" / "out.obj")
        check_textures(tmp_path / "new" / "out.obj")
        light(source, tmp_path / "new" / "out.glb")
        assert len(glb_parts((tmp_path / "new" / "out.glb").read_bytes())[0]["images"]) == 2

    def test_a_wide_tolerance_moves_no_picture(self, house: Path, tmp_path: Path) -> None:
        light(house, tmp_path / "new" / "out.obj", Options(tolerance=Tolerance(0.1, "length")))
        check_textures(tmp_path / "new" / "out.obj")

    def test_geometry_alone_on_request(self, house: Path, tmp_path: Path) -> None:
        written = light(house, tmp_path / "out.ply", Options(delimit=frozenset()))
        assert written.warnings[0] == "removed as requested, from 2 parts: texture coordinates"
        assert mesh_of(tmp_path / "out.ply").attributes == []

    @pytest.mark.parametrize("suffix", ["obj", "ply"])
    def test_the_set_and_the_transform_of_a_gltf_texture_are_applied(self, tmp_path: Path, suffix: str) -> None:
        points, faces = fine_box()
        corners = points[faces]
        document = Gltf()
        # The texture shows (4 u + 1/8, v / 2) of its second set, v downwards.
        uv = painted.uv_of(corners).reshape(-1, 2)
        stored = np.stack([(uv[:, 0] - 0.125) / 4, (1 - uv[:, 1]) * 2], axis=1)
        attributes = {"TEXCOORD_0": document.accessor(np.zeros_like(uv)), "TEXCOORD_1": document.accessor(stored)}
        attributes["POSITION"] = document.accessor(corners.reshape(-1, 3))
        transform = {"offset": [0.125, 0], "scale": [4, 0.5], "texCoord": 1}
        info = {"index": 0, "extensions": {"KHR_texture_transform": transform}}
        document.mesh({"attributes": attributes, "material": 0})
        document.json["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": info}, "doubleSided": True}]
        document.json["textures"] = [{"source": 0}]
        document.json["images"] = [{"uri": "wall.png"}]
        write(tmp_path / "wall.png", WALL)
        write(tmp_path / "in.glb", document.glb())
        written = light(tmp_path / "in.glb", tmp_path / "new" / f"out.{suffix}")
        mesh = mesh_of(tmp_path / "new" / f"out.{suffix}")
        assert len(mesh.faces) == 12
        check_uv(mesh)
        assert (tmp_path / "new" / "wall.png").read_bytes() == WALL
        told = "MTL cannot store doubleSided of materials: lost" if suffix == "obj" else "PLY cannot store parts"
        assert any(told in warning for warning in written.warnings)

    @pytest.mark.parametrize("suffix", ["obj", "ply", "glb"])
    def test_scale_and_offset_of_an_mtl_texture_are_applied(self, house: Path, tmp_path: Path, suffix: str) -> None:
        write(tmp_path / "m.mtl", LIBRARY.replace("map_Kd wall", "map_Kd -s 4 2 1 -o 0.5 0.25 0 -clamp on wall"))
        light(house, tmp_path / "new" / f"out.{suffix}")
        mesh = mesh_of(tmp_path / "new" / f"out.{suffix}")
        side = painted.side_of(mesh.points[mesh.faces])
        stored = values(mesh, "TEXCOORD_0")[mesh.faces]
        shown = np.empty_like(stored)
        for number, part in enumerate(mesh.parts):
            material = part.material
            assert material is not None
            own = mesh.part_of_face == number
            scale_u, _, du, _, scale_v, dv = material.uv_map.matrix
            shown[own] = stored[own] * (scale_u, scale_v) + (du, dv)
        wanted = painted.uv_of(mesh.points[mesh.faces])
        wanted[side >= 2] = wanted[side >= 2] * (4, 2) + (0.5, 0.25)
        assert np.allclose(shown, wanted, rtol=0, atol=1e-6)

    def test_in_gltf_they_are_a_transform_with_v_downwards_and_a_sampler(self, house: Path, tmp_path: Path) -> None:
        write(tmp_path / "m.mtl", LIBRARY.replace("map_Kd wall", "map_Kd -s 4 2 1 -o 0.5 0.25 0 -clamp on wall"))
        light(house, tmp_path / "new" / "out.glb")
        json_ = glb_parts((tmp_path / "new" / "out.glb").read_bytes())[0]
        wall, roof = (entry["pbrMetallicRoughness"]["baseColorTexture"] for entry in json_["materials"])
        assert wall["extensions"] == {"KHR_texture_transform": {"scale": [4.0, 2.0], "offset": [0.5, -1.25]}}
        assert json_["extensionsUsed"] == ["KHR_texture_transform"]
        sampler = json_["samplers"][json_["textures"][wall["index"]]["sampler"]]
        assert sampler == {"wrapS": 33071, "wrapT": 33071}
        assert "extensions" not in roof
        assert "sampler" not in json_["textures"][roof["index"]]

    def test_what_else_a_library_says_goes_to_gltf_or_is_told(self, house: Path, tmp_path: Path) -> None:
        wall = "illum 0\nNs 96\nKs 0.5 0.5 0.5\nKe 0 3 1.5\nPm 0.75\nPr 0.25\nTf 0 0 0\nmap_d wall.png\nmap_Kd wall"
        write(tmp_path / "m.mtl", LIBRARY.replace("map_Kd wall", wall))
        told = light(house, tmp_path / "new" / "out.glb").warnings
        assert told == ["glTF cannot store illum, Ns, Ks, map_d of materials: lost"]
        json_ = glb_parts((tmp_path / "new" / "out.glb").read_bytes())[0]
        wall, roof = json_["materials"]
        assert wall["pbrMetallicRoughness"]["metallicFactor"] == 0.75
        assert wall["pbrMetallicRoughness"]["roughnessFactor"] == 0.25
        assert wall["emissiveFactor"] == [0.0, 1.0, 0.5]
        assert wall["extensions"] == {"KHR_materials_emissive_strength": {"emissiveStrength": 3.0}}
        assert "emissiveFactor" not in roof
        assert not light(house, tmp_path / "new" / "out.obj").warnings

    def test_light_that_a_texture_bounds_is_not_given_by_the_whole(self, house: Path, tmp_path: Path) -> None:
        write(tmp_path / "m.mtl", LIBRARY.replace("map_Kd wall", "Ke 1 1 1\nmap_Ke roof.png\nmap_Kd wall"))
        told = light(house, tmp_path / "new" / "out.glb").warnings
        assert told == ["glTF cannot store Ke, map_Ke of materials: lost"]
        assert not any("emissiveFactor" in entry for entry in
                       glb_parts((tmp_path / "new" / "out.glb").read_bytes())[0]["materials"])  # fmt: skip

    def test_a_part_without_texture_has_none_in_ply(self, house: Path, tmp_path: Path) -> None:
        write(tmp_path / "m.mtl", LIBRARY.replace("map_Kd roof.png", ""))
        light(house, tmp_path / "new" / "out.ply")
        mesh = mesh_of(tmp_path / "new" / "out.ply")
        textures = [None if (own := part.material) is None else own.texture for part in mesh.parts]
        assert sorted(map(str, textures)) == ["None", "wall.png"]
        assert side_areas(mesh, mesh.part_of_face == textures.index("wall.png")) == [0, 0, 4, 4, 4, 4]
        assert b"texnumber" in (tmp_path / "new" / "out.ply").read_bytes()

    def test_a_face_without_coordinates_has_no_texture_in_ply(self, tmp_path: Path) -> None:
        points, faces = fine_box()
        side = painted.side_of(points[faces])
        write(tmp_path / "m.mtl", LIBRARY)
        write(tmp_path / "wall.png", WALL)
        lines = ["mtllib m.mtl", *(f"v {x} {y} {z}" for x, y, z in points), *(f"vt {x} {z}" for x, _, z in points)]
        lines += ["usemtl wall", *(f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in faces[side >= 2] + 1)]
        lines += [f"f {a} {b} {c}" for a, b, c in faces[side < 2] + 1]
        light(write(tmp_path / "in.obj", "\n".join(lines)), tmp_path / "new" / "out.ply")
        mesh = mesh_of(tmp_path / "new" / "out.ply")
        textures = [None if (own := part.material) is None else own.texture for part in mesh.parts]
        assert sorted(map(str, textures)) == ["None", "wall.png"]
        assert side_areas(mesh, mesh.part_of_face == textures.index("wall.png")) == [0, 0, 4, 4, 4, 4]

    def test_pixels_of_other_formats_are_stored_without_loss(self, tmp_path: Path, monkeypatch) -> None:
        monkeypatch.setattr("trimesh.load_scene", lambda *_, **__: textured().scene())
        scene = read(write(tmp_path / "in.3mf", b"whatever"), "3mf")
        lights, _ = simplify_scene(scene, Options())
        write_scene(scene, lights, tmp_path / "out.obj", "obj", Options())
        check_uv(mesh_of(tmp_path / "out.obj"))
        stored = Image.open(tmp_path / "wall.png")
        assert (stored.size, stored.tobytes()) == (IMAGE.size, IMAGE.tobytes())
        assert mesh_of(tmp_path / "out.obj").attributes[0].steps.tolist() == [list(IMAGE.size)]

    def test_materials_of_one_name_stay_two(self, house: Path, tmp_path: Path) -> None:
        light(house, tmp_path / "mid.gltf")
        text = (tmp_path / "mid.gltf").read_text().replace('"name": "roof"', '"name": "wall"')
        write(tmp_path / "mid.gltf", text)
        light(tmp_path / "mid.gltf", tmp_path / "new" / "out.obj")
        check_textures(tmp_path / "new" / "out.obj")


class TestColors:
    @pytest.mark.parametrize("suffix", ["obj", "ply", "glb", "off"])
    def test_of_an_obj_are_those_of_the_place(self, house: Path, tmp_path: Path, suffix: str) -> None:
        write(house, painted.obj(colors=True))
        light(house, tmp_path / "new" / f"out.{suffix}")
        mesh = mesh_of(tmp_path / "new" / f"out.{suffix}")
        assert len(mesh.faces) == 12
        assert np.allclose(values(mesh, "COLOR_0")[:, :3], painted.color_of(mesh.points), rtol=0, atol=1e-7)

    @pytest.mark.parametrize("suffix", ["obj", "ply"])
    def test_of_an_obj_in_levels_stay_levels(self, tmp_path: Path, suffix: str) -> None:
        points, faces = fine_box()
        rows = np.hstack([points, painted.color_of(points) * 255]).tolist()
        lines = ["v " + " ".join(map(repr, row)) for row in rows] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
        light(write(tmp_path / "in.obj", "\n".join(lines)), tmp_path / f"out.{suffix}")
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
        light(source, tmp_path / "out.ply")
        assert properties(tmp_path / "out.ply") == properties(source)
        mesh = mesh_of(tmp_path / "out.ply")
        assert len(mesh.points) == 8
        assert np.allclose(values(mesh, "COLOR_0"), painted.color_of(mesh.points), rtol=0, atol=1e-7)

    def test_a_colour_that_changes_unevenly_stops_a_facet(self, tmp_path: Path) -> None:
        points, faces = fine_box()
        colors = np.where(points[:, :1] > 0.9, (255, 0, 0), (0, 0, 255))
        table = [(points, "float", "x y z"), (colors, "uchar", "red green blue")]
        source = write(tmp_path / "in.ply", ply(table, faces))
        light(source, tmp_path / "out.ply")
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
        light(source, tmp_path / f"out.{suffix}")
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
        light(write(tmp_path / "in.off", "\n".join(lines) + "\n"), tmp_path / "out.off")
        before, after = mesh_of(tmp_path / "in.off"), mesh_of(tmp_path / "out.off")
        assert np.allclose(values(after, "COLOR_0"), painted.color_of(after.points), atol=1e-12)
        # Every other face is of another colour: none can go.
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
        light(source, tmp_path / "out.ply")
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
        light(write(tmp_path / "in.stl", bytes(data)), tmp_path / "out.stl")
        mesh = mesh_of(tmp_path / "out.stl")
        assert len(mesh.faces) == 12
        assert np.array_equal(values(mesh, "FACE__stl")[:, 0], 1000 + painted.side_of(mesh.points[mesh.faces]))

    def test_go_to_glb_and_back(self, tmp_path: Path) -> None:
        points, faces = fine_box()
        table = [(points, "float", "x y z"), (points[:, :1] * 3.5, "float", "heat")]
        light(write(tmp_path / "in.ply", ply(table, faces)), tmp_path / "mid.glb")
        light(tmp_path / "mid.glb", tmp_path / "out.ply")
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
        light(write(tmp_path / "in.ply", data), tmp_path / "new" / "out.ply")
        check_textures(tmp_path / "new" / "out.ply")
        assert b"element vertex 8\n" in (tmp_path / "new" / "out.ply").read_bytes()
        light(tmp_path / "in.ply", tmp_path / "new" / "out.obj")
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
        # PLY colours are bytes; OBJ ones have no alpha.
        allowed = 0.5 / 255 if one.name == "COLOR_0" and suffix == "ply" else 0.0
        wanted = wanted[:, :, : own.shape[2]]
        assert np.allclose(own, wanted, rtol=1e-6, atol=allowed + 1e-7), f"{story}: {one.name}"
