"""Textures come out where they went in, through every format that stores them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import painted
import pytest
from painted import IMAGE, ROOF, WALL, check_uv, side_areas, textured, values
from PIL import Image
from shapes import Gltf, fine_box, split_glb, write
from test_carried import LIBRARY, check_textures, mesh_of, simplify_to, write_house

from bldsimp import Options, Tolerance
from bldsimp.io import read
from bldsimp.io import write as write_scene
from bldsimp.scene import simplify_scene


@pytest.fixture
def house(tmp_path: Path) -> Path:
    """The painted box as OBJ, with its library and images."""
    return write_house(tmp_path)


class TestTextures:
    @pytest.mark.parametrize("suffix", ["obj", "ply", "glb", "gltf"])
    def test_of_an_obj_stay_on_their_sides(self, house: Path, tmp_path: Path, suffix: str) -> None:
        written = simplify_to(house, tmp_path / "new" / f"out.{suffix}")
        check_textures(tmp_path / "new" / f"out.{suffix}")
        assert not any("no file" in warning or "texture coordinates" in warning for warning in written.warnings)

    @pytest.mark.parametrize("middle", ["glb", "gltf", "ply"])
    @pytest.mark.parametrize("suffix", ["obj", "ply", "glb"])
    def test_survive_two_conversions(self, house: Path, tmp_path: Path, middle: str, suffix: str) -> None:
        simplify_to(house, tmp_path / "mid" / f"mid.{middle}")
        simplify_to(tmp_path / "mid" / f"mid.{middle}", tmp_path / "new" / f"out.{suffix}")
        check_textures(tmp_path / "new" / f"out.{suffix}")

    def test_image_sizes_are_the_steps_of_uv(self, house: Path) -> None:
        assert mesh_of(house).attributes[0].steps.tolist() == [[512, 256], [64, 64]]

    def test_repeated_textures_have_more_texels(self, house: Path, tmp_path: Path) -> None:
        write(tmp_path / "m.mtl", LIBRARY.replace("map_Kd wall.png", "map_Kd -o 0 0 0 -s 4 2 1 -clamp on wall.png"))
        assert mesh_of(house).attributes[0].steps[0].tolist() == [4 * 512, 2 * 256]

    def test_equal_coordinates_are_written_once(self, house: Path, tmp_path: Path) -> None:
        simplify_to(house, tmp_path / "out.obj")
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
        simplify_to(house, tmp_path / "new" / "out.obj")
        new = {p.relative_to(tmp_path / "new").as_posix(): p for p in (tmp_path / "new").rglob("*") if p.is_file()}
        assert set(new) == {"out.obj", "m.mtl", "wall.png", "roof.png", "maps/bump map.bmp", "maps/glow.bmp"}
        assert new["m.mtl"].read_text() == library
        assert new["maps/bump map.bmp"].read_bytes() == bump
        assert new["maps/glow.bmp"].read_bytes() == glow

    def test_beside_the_input_nothing_is_written_twice(self, house: Path, tmp_path: Path) -> None:
        before = {p: p.stat().st_mtime_ns for p in tmp_path.iterdir()}
        simplify_to(house, tmp_path / "out.obj")
        assert {p: p.stat().st_mtime_ns for p in tmp_path.iterdir() if p.name != "out.obj"} == before

    def test_a_texture_that_is_missing_is_told(self, house: Path, tmp_path: Path) -> None:
        (tmp_path / "wall.png").unlink()
        for suffix in ("obj", "ply", "glb"):
            written = simplify_to(house, tmp_path / suffix / f"out.{suffix}")
            assert any("'wall.png'" in warning for warning in written.warnings)

    @pytest.mark.parametrize("name", ["gone.mtl", "../m.mtl", "gone.mtl other.mtl"])
    def test_a_library_that_is_missing_is_told_once(self, house: Path, tmp_path: Path, name: str) -> None:
        (tmp_path / "below").mkdir()
        source = write(tmp_path / "below" / "in.obj", painted.obj(library=name))
        for suffix in ("obj", "ply", "glb", "gltf"):
            written = simplify_to(source, tmp_path / suffix / f"out.{suffix}")
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
        written = simplify_to(write(tmp_path / "in.obj", text), tmp_path / "new" / f"out.{suffix}")
        check_textures(tmp_path / "new" / f"out.{suffix}")
        assert ["'gone.mtl'" in warning for warning in written.warnings if ".mtl" in warning] == [True]

    def test_a_library_in_a_folder_of_its_own_names_textures_there(self, tmp_path: Path) -> None:
        (tmp_path / "mats").mkdir()
        write(tmp_path / "mats" / "wall.png", WALL)
        write(tmp_path / "mats" / "roof.png", ROOF)
        write(tmp_path / "mats" / "m.mtl", LIBRARY)
        source = write(tmp_path / "in.obj", painted.obj(library="mats/m.mtl"))
        simplify_to(source, tmp_path / "new" / "out.obj")
        check_textures(tmp_path / "new" / "out.obj")
        simplify_to(source, tmp_path / "new" / "out.glb")
        assert len(split_glb((tmp_path / "new" / "out.glb").read_bytes())[0]["images"]) == 2

    def test_a_wide_tolerance_moves_no_picture(self, house: Path, tmp_path: Path) -> None:
        simplify_to(house, tmp_path / "new" / "out.obj", Options(tolerance=Tolerance(0.1, "length")))
        check_textures(tmp_path / "new" / "out.obj")

    def test_geometry_alone_on_request(self, house: Path, tmp_path: Path) -> None:
        written = simplify_to(house, tmp_path / "out.ply", Options(delimit=frozenset()))
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
        written = simplify_to(tmp_path / "in.glb", tmp_path / "new" / f"out.{suffix}")
        mesh = mesh_of(tmp_path / "new" / f"out.{suffix}")
        assert len(mesh.faces) == 12
        check_uv(mesh)
        assert (tmp_path / "new" / "wall.png").read_bytes() == WALL
        told = "MTL cannot store doubleSided of materials: lost" if suffix == "obj" else "PLY cannot store parts"
        assert any(told in warning for warning in written.warnings)

    @pytest.mark.parametrize("suffix", ["obj", "ply", "glb"])
    def test_scale_and_offset_of_an_mtl_texture_are_applied(self, house: Path, tmp_path: Path, suffix: str) -> None:
        write(tmp_path / "m.mtl", LIBRARY.replace("map_Kd wall", "map_Kd -s 4 2 1 -o 0.5 0.25 0 -clamp on wall"))
        simplify_to(house, tmp_path / "new" / f"out.{suffix}")
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
        simplify_to(house, tmp_path / "new" / "out.glb")
        json_ = split_glb((tmp_path / "new" / "out.glb").read_bytes())[0]
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
        told = simplify_to(house, tmp_path / "new" / "out.glb").warnings
        assert told == ["glTF cannot store illum, Ns, Ks, map_d of materials: lost"]
        json_ = split_glb((tmp_path / "new" / "out.glb").read_bytes())[0]
        wall, roof = json_["materials"]
        assert wall["pbrMetallicRoughness"]["metallicFactor"] == 0.75
        assert wall["pbrMetallicRoughness"]["roughnessFactor"] == 0.25
        assert wall["emissiveFactor"] == [0.0, 1.0, 0.5]
        assert wall["extensions"] == {"KHR_materials_emissive_strength": {"emissiveStrength": 3.0}}
        assert "emissiveFactor" not in roof
        assert not simplify_to(house, tmp_path / "new" / "out.obj").warnings

    def test_light_that_a_texture_bounds_is_not_given_by_the_whole(self, house: Path, tmp_path: Path) -> None:
        write(tmp_path / "m.mtl", LIBRARY.replace("map_Kd wall", "Ke 1 1 1\nmap_Ke roof.png\nmap_Kd wall"))
        told = simplify_to(house, tmp_path / "new" / "out.glb").warnings
        assert told == ["glTF cannot store Ke, map_Ke of materials: lost"]
        assert not any("emissiveFactor" in entry for entry in
                       split_glb((tmp_path / "new" / "out.glb").read_bytes())[0]["materials"])  # fmt: skip

    def test_a_part_without_texture_has_none_in_ply(self, house: Path, tmp_path: Path) -> None:
        write(tmp_path / "m.mtl", LIBRARY.replace("map_Kd roof.png", ""))
        simplify_to(house, tmp_path / "new" / "out.ply")
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
        simplify_to(write(tmp_path / "in.obj", "\n".join(lines)), tmp_path / "new" / "out.ply")
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
        simplify_to(house, tmp_path / "mid.gltf")
        text = (tmp_path / "mid.gltf").read_text().replace('"name": "roof"', '"name": "wall"')
        write(tmp_path / "mid.gltf", text)
        simplify_to(tmp_path / "mid.gltf", tmp_path / "new" / "out.obj")
        check_textures(tmp_path / "new" / "out.obj")
