"""glTF to glTF: nothing changes but what was simplified."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from gltf_cases import simplify_glb
from shapes import Gltf, box, fine_box, read_values, split_glb, write

from bldsimp import Options, Tolerance
from bldsimp.io import read
from bldsimp.io import write as write_scene
from bldsimp.scene import simplify_scene


class TestPatch:
    def test_only_the_simplified_accessors_change(self, tmp_path: Path) -> None:
        document = Gltf()
        picture = b"\x89PNG and so on"
        document.data += picture
        document.json["bufferViews"].append({"buffer": 0, "byteLength": len(picture), "name": "picture"})
        document.json["images"] = [{"bufferView": 0, "mimeType": "image/png"}]
        time = document.accessor([0.0, 1.0])
        move = document.accessor(np.eye(3)[:2])
        primitive = document.box(fine=True)
        primitive["material"] = 0
        primitive["extras"] = {"part": "walls"}
        document.mesh(primitive, name="house", extras={"id": 7}, node={"name": "at home", "translation": [1, 2, 3]})
        document.json.update(
            materials=[{"name": "brick", "extras": {"fire": False}}],
            cameras=[{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}],
            extras={"author": "us"},
            animations=[{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
                         "samplers": [{"input": time, "output": move}]}],
        )  # fmt: skip
        data = document.glb()
        _, after = simplify_glb(data, tmp_path / "out.glb")
        old, new = split_glb(data)[0], split_glb(after)[0]
        for key in ("asset", "nodes", "scenes", "scene", "materials", "cameras", "extras"):
            assert new[key] == old[key]
        primitive = new["meshes"][0].pop("primitives")[0]
        assert new["meshes"][0] == {"name": "house", "extras": {"id": 7}}
        assert {key: primitive[key] for key in ("material", "extras")} == {
            "material": 0,
            "extras": {"part": "walls"},
        }
        sampler = new["animations"][0]["samplers"][0]
        assert read_values(after, sampler["input"]).tolist() == [[0.0], [1.0]]
        assert read_values(after, sampler["output"]).tolist() == np.eye(3)[:2].tolist()
        view = new["bufferViews"][new["images"][0]["bufferView"]]
        binary = split_glb(after)[1]
        assert binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]] == picture
        position = new["accessors"][primitive["attributes"]["POSITION"]]
        assert position["count"] == 8
        assert (position["min"], position["max"]) == ([0, 0, 0], [2, 2, 2])
        assert len(new["accessors"]) == 4
        assert len(new["bufferViews"]) == 5
        assert len(binary) < len(split_glb(data)[1]) / 3

    def test_what_is_passed_on_is_the_same_to_the_byte(self, tmp_path: Path) -> None:
        document = Gltf()
        uv = document.accessor(np.random.default_rng(0).random((98, 2)))
        fixed = document.box(fine=True, TEXCOORD_0=uv)
        fixed["targets"] = [{"POSITION": document.accessor(np.ones((98, 3)))}]
        document.mesh(fixed, document.box(fine=True, shift=10.0))
        data = document.glb()
        _, after = simplify_glb(data, tmp_path / "out.glb")
        old = split_glb(data)[0]["meshes"][0]["primitives"][0]
        new = split_glb(after)[0]["meshes"][0]["primitives"][0]
        for name, number in old["attributes"].items():
            assert np.array_equal(read_values(after, new["attributes"][name]), read_values(data, number))
        assert np.array_equal(read_values(after, new["indices"]), read_values(data, old["indices"]))
        assert np.array_equal(read_values(after, new["targets"][0]["POSITION"]), np.ones((98, 3)))
        light_one = split_glb(after)[0]["meshes"][0]["primitives"][1]
        assert len(read_values(after, light_one["attributes"]["POSITION"])) == 8

    def test_a_mesh_that_goes_as_a_whole_leaves_its_nodes(self, tmp_path: Path) -> None:
        document = Gltf()
        document.mesh(document.box(fine=True), name="house")
        speck = document.mesh(document.box(size=0.1), node={"name": "speck", "children": [2]}, name="speck")
        document.mesh(document.box(size=2.5, shift=10.0), name="shed")
        document.json["scenes"][0]["nodes"].pop()
        where = document.accessor(np.array([[0, 0, 5.0], [0, 0, 6]]))
        document.json["nodes"].append({"mesh": speck, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {
            "TRANSLATION": where}}}})  # fmt: skip
        document.json["scenes"][0]["nodes"].append(3)
        _, after = simplify_glb(document.glb(), tmp_path / "out.glb", Options(min_component=0.2))
        json_, binary = split_glb(after)
        assert [mesh["name"] for mesh in json_["meshes"]] == ["house", "shed"]
        assert json_["nodes"] == [{"mesh": 0}, {"name": "speck", "children": [2]}, {"mesh": 1}, {}]
        assert len(json_["accessors"]) == 4
        assert len(read(after, "glb").meshes) == 2
        whole = simplify_glb(document.glb(), tmp_path / "all.glb")[1]
        assert len(split_glb(whole)[0]["meshes"]) == 3
        assert len(binary) < len(split_glb(whole)[1])

    @pytest.mark.parametrize("interleaved", [False, True])
    def test_a_shared_view_keeps_only_what_is_still_used(self, tmp_path: Path, interleaved: bool) -> None:
        document = Gltf()
        random = np.random.default_rng(0)
        points, faces = fine_box()
        uv = random.random((98, 2)).astype(np.float32)
        far = points + 10.0
        if interleaved:
            rows, offsets, stride = np.hstack([points, np.zeros((98, 3)), far, uv]), (0, 24, 36), 44
            shared = document.accessor(np.frombuffer(rows.astype("<f4").tobytes(), "<f4"))
        else:
            blocks = [points, np.zeros((98, 3)), far, uv]
            shared = document.accessor(np.concatenate([np.asarray(block, "<f4").ravel() for block in blocks]))
            offsets, stride = (0, 98 * 24, 98 * 36), None
        view = document.json["accessors"].pop()["bufferView"]
        assert shared == 0
        if stride:
            document.json["bufferViews"][view]["byteStride"] = stride
        for offset, kind in zip(offsets, ("VEC3", "VEC3", "VEC2"), strict=True):
            document.json["accessors"].append(
                {"bufferView": view, "byteOffset": offset, "componentType": 5126, "count": 98, "type": kind}
            )
        indices = document.accessor(faces.reshape(-1), "u2")
        if not interleaved:
            document.json["bufferViews"][view].pop("byteStride", None)
        document.mesh(
            {"attributes": {"POSITION": 0}, "indices": indices},
            {"attributes": {"POSITION": 1, "TEXCOORD_0": 2}, "indices": indices},
        )
        data = document.glb()
        _, after = simplify_glb(data, tmp_path / "out.glb")
        first, second = split_glb(after)[0]["meshes"][0]["primitives"]
        assert len(read_values(after, first["attributes"]["POSITION"])) == 8
        assert np.array_equal(read_values(after, second["attributes"]["POSITION"]), far.astype(np.float32))
        assert np.array_equal(read_values(after, second["attributes"]["TEXCOORD_0"]), uv)
        spared = len(split_glb(data)[1]) - len(split_glb(after)[1])
        assert spared > (-400 if interleaved else 98 * 24 - 400)

    def test_dropped_attributes_take_their_textures_along(self, tmp_path: Path) -> None:
        document = Gltf()
        uv = document.accessor(np.zeros((98, 2)))
        primitive = {**document.box(fine=True, TEXCOORD_0=uv), "material": 0}
        document.json["materials"] = [
            {
                "name": "wall",
                "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "roughnessFactor": 0.5},
            }
        ]
        document.mesh(primitive)
        _, after = simplify_glb(document.glb(), tmp_path / "out.glb", Options(delimit=frozenset({"material"})))
        json_ = split_glb(after)[0]
        new = json_["meshes"][0]["primitives"][0]
        assert set(new["attributes"]) == {"POSITION"}
        assert json_["materials"][new["material"]] == {
            "name": "wall",
            "pbrMetallicRoughness": {"roughnessFactor": 0.5},
        }
        assert json_["materials"][0] == document.json["materials"][0]

    def test_stored_numbers_are_identical_in_any_component_type(self, tmp_path: Path) -> None:
        points, faces = fine_box()
        document = Gltf()
        document.json["extensionsUsed"] = ["KHR_mesh_quantization"]
        position = document.accessor(points * 1000 - 700, "i2")
        document.mesh({"attributes": {"POSITION": position}, "indices": document.accessor(faces.reshape(-1), "u2")})
        _, after = simplify_glb(document.glb(), tmp_path / "out.glb", Options(tolerance=Tolerance(0.0, "length")))
        json_ = split_glb(after)[0]
        accessor = json_["accessors"][json_["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]
        assert accessor["componentType"] == 5122
        assert json_["bufferViews"][accessor["bufferView"]]["byteStride"] == 8
        values = read_values(after, json_["meshes"][0]["primitives"][0]["attributes"]["POSITION"])
        assert {tuple(row) for row in values.tolist()} == {tuple(row) for row in (box()[0] * 1000 - 700).tolist()}

    def test_map_coordinates_are_identical(self, tmp_path: Path) -> None:
        for shift in (500_000.0, 5_000_000.0):
            document = Gltf()
            points, faces = fine_box(shift=shift)
            position = document.accessor(points)
            document.mesh({"attributes": {"POSITION": position}, "indices": document.accessor(faces.reshape(-1), "u2")})
            _, after = simplify_glb(document.glb(), tmp_path / "out.glb")
            primitive = split_glb(after)[0]["meshes"][0]["primitives"][0]
            values = read_values(after, primitive["attributes"]["POSITION"])
            assert {tuple(row) for row in values.tolist()} <= {tuple(row) for row in points.astype(np.float32).tolist()}
            assert len(values) == 8

    def test_unknown_extensions_stay_and_are_named(self, tmp_path: Path) -> None:
        document = Gltf()
        document.mesh(document.box(fine=True), node={"extensions": {"ACME_sign": {"accessor": 0, "text": "hello"}}})
        document.json["extensionsUsed"] = ["ACME_sign"]
        options = Options()
        scene = read(document.glb(), "glb")
        results, _ = simplify_scene(scene, options)
        written = write_scene(scene, results, tmp_path / "out.glb", "glb", options)
        assert any("ACME_sign" in text for text in written.warnings)
        json_ = split_glb((tmp_path / "out.glb").read_bytes())[0]
        assert json_["nodes"] == document.json["nodes"]
        read(tmp_path / "out.glb", "glb")

    def test_text_gltf_keeps_its_buffer_beside_or_inside(self, tmp_path: Path) -> None:
        document = Gltf()
        document.mesh(document.box(fine=True))
        write(tmp_path / "in.bin", bytes(document.data))
        for source, beside in ((document.gltf("in.bin"), True), (document.gltf(), False)):
            path = write(tmp_path / "in.gltf", source)
            target = tmp_path / "new" / "out.gltf"
            target.parent.mkdir(exist_ok=True)
            scene = read(path, "gltf")
            results, _ = simplify_scene(scene, Options())
            write_scene(scene, results, target, "gltf", Options())
            uri = json.loads(target.read_text())["buffers"][0]["uri"]
            assert (uri == "out.bin") == beside
            assert uri.startswith("data:") != beside
            assert read(target, "gltf").meshes[0].points.shape == (8, 3)

    def test_images_come_along_to_another_folder_and_go_into_a_glb(self, tmp_path: Path, models: Path) -> None:
        source = models / "textured" / "kaykit_building_H" / "building_H.gltf"
        picture = (source.parent / "citybits_texture.png").read_bytes()
        scene = read(source, "gltf")
        results, report = simplify_scene(scene, Options())
        assert not report.unchanged_parts
        write_scene(scene, results, tmp_path / "out.gltf", "gltf", Options())
        assert (tmp_path / "citybits_texture.png").read_bytes() == picture
        write_scene(scene, results, tmp_path / "out.glb", "glb", Options())
        json_, binary = split_glb((tmp_path / "out.glb").read_bytes())
        assert "uri" not in json_["images"][0]
        view = json_["bufferViews"][json_["images"][0]["bufferView"]]
        assert binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]] == picture

    def test_the_tower_stays_one_vertex_buffer(self, tmp_path: Path, models: Path) -> None:
        scene = read(models / "exact" / "cesium_building_tower.glb", "glb")
        assert len(scene.meshes[0].points) == 119_547
        results, _ = simplify_scene(scene, Options(normals="flat"))
        write_scene(scene, results, tmp_path / "out.glb", "glb", Options(normals="flat"))
        primitives = split_glb((tmp_path / "out.glb").read_bytes())[0]["meshes"][0]["primitives"]
        assert primitives[0]["attributes"] == primitives[1]["attributes"]
