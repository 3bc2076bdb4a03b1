"""glTF: read by its own rules, and written back with nothing changed but what was simplified."""

from __future__ import annotations

import io
import json
import os
import sys
from pathlib import Path

import numpy as np
import pytest
from shapes import Gltf, box, fine_box, glb_parts, glb_values, triangle_set, write

from bldsimp import InputError, Options, OutputError, Scene, Tolerance, simplify_scene
from bldsimp.io import read
from bldsimp.io import write as write_scene
from bldsimp.tolerance import diagonal, resolve_tolerance, spacing


def light(data: bytes, path: Path, options: Options = Options()) -> tuple[Scene, bytes]:  # noqa: B008
    """Simplify a GLB and give back what was written."""
    scene = read(data, "glb")
    lights, _ = simplify_scene(scene, options)
    write_scene(scene, lights, path, "glb", options)
    return scene, path.read_bytes()


def glb_of(primitive: dict, document: Gltf, **more) -> bytes:
    document.mesh(primitive, **more)
    return document.glb()


class TestRead:
    def test_strips_and_fans_are_the_same_box(self) -> None:
        points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 2, 0]], float)
        expected = {
            ((0, 0, 0), (1, 0, 0), (0, 1, 0)),
            ((0, 1, 0), (1, 0, 0), (1, 1, 0)),
            ((0, 1, 0), (1, 1, 0), (0, 2, 0)),
        }
        strip, fan, plain = Gltf(), Gltf(), Gltf()
        strip.mesh({"attributes": {"POSITION": strip.accessor(points)}, "mode": 5})
        fan_points = points[[2, 0, 1, 3, 4]]
        fan.mesh({"attributes": {"POSITION": fan.accessor(fan_points)}, "mode": 6})
        loose = points[[0, 1, 2, 2, 1, 3, 2, 3, 4]]
        plain.mesh({"attributes": {"POSITION": plain.accessor(loose)}})
        for document in (strip, fan, plain):
            mesh = read(document.glb(), "glb").meshes[0]
            assert triangle_set(mesh.points, mesh.faces) == expected

    def test_sparse_values_and_an_accessor_without_a_view(self) -> None:
        document = Gltf()
        points, faces = box()
        where = document.accessor(np.arange(8), "u2")
        what = document.accessor(points)
        accessors = document.json["accessors"]
        accessors.append({
            "componentType": 5126, "count": 8, "type": "VEC3",
            "sparse": {"count": 8,
                       "indices": {"bufferView": accessors[where]["bufferView"], "componentType": 5123},
                       "values": {"bufferView": accessors[what]["bufferView"]}},
        })  # fmt: skip
        document.mesh({"attributes": {"POSITION": 2}, "indices": document.accessor(faces.reshape(-1), "u1")})
        mesh = read(document.glb(), "glb").meshes[0]
        assert triangle_set(mesh.points, mesh.faces) == triangle_set(points, faces)

    def test_quantized_positions_have_the_spacing_of_their_integers(self) -> None:
        document = Gltf()
        points, faces = box(1000)
        document.json["extensionsUsed"] = ["KHR_mesh_quantization"]
        position = document.accessor(points, "u2")
        document.mesh(
            {"attributes": {"POSITION": position}, "indices": document.accessor(faces.reshape(-1), "u2")}
        )
        mesh = read(document.glb(), "glb").meshes[0]
        assert mesh.points.max() == 1000.0
        assert spacing(mesh) == 1.0
        document.json["accessors"][position]["normalized"] = True
        mesh = read(document.glb(), "glb").meshes[0]
        assert mesh.points.max() == 1000.0 / 65535.0
        assert spacing(mesh) == 1.0 / 65535.0

    def test_interleaved_attributes(self) -> None:
        document = Gltf()
        points, faces = box()
        both = document.accessor(np.hstack([points, np.tile([0.0], (8, 1))]))  # four floats a row
        view = document.json["accessors"][both]["bufferView"]
        document.json["bufferViews"][view]["byteStride"] = 16
        document.json["accessors"][both]["type"] = "VEC3"
        document.mesh(
            {"attributes": {"POSITION": both}, "indices": document.accessor(faces.reshape(-1), "u4")}
        )
        mesh = read(document.glb(), "glb").meshes[0]
        assert triangle_set(mesh.points, mesh.faces) == triangle_set(points, faces)

    def test_primitives_that_share_positions_are_one_problem(self) -> None:
        document = Gltf()
        points, faces = box()
        position = document.accessor(points)
        halves = [
            {"attributes": {"POSITION": position}, "indices": document.accessor(half.reshape(-1), "u2")}
            for half in (faces[:6], faces[6:])
        ]
        document.mesh(*halves)
        mesh = read(document.glb(), "glb").meshes[0]
        assert len(mesh.points) == 8
        assert len(mesh.parts) == 2
        assert np.bincount(mesh.part_of_face).tolist() == [6, 6]

    def test_transforms_of_all_instances_and_the_tolerance_they_leave(self) -> None:
        document = Gltf()
        number = document.mesh(document.box(), node={"scale": [3, 1, 1], "translation": [10, 0, 0]})
        half = np.sqrt(0.5)
        document.json["nodes"].append({"mesh": number, "rotation": [0, 0, half, half]})
        document.json["nodes"].append(
            {"children": [1], "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1]}
        )
        document.json["scenes"][0]["nodes"].append(2)
        scene = read(document.glb(), "glb")
        assert np.allclose(
            scene.meshes[0].transforms[0], [[3, 0, 0, 10], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
        )
        assert np.allclose(
            scene.meshes[0].transforms[1], [[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 5], [0, 0, 0, 1]]
        )
        assert diagonal(scene) == pytest.approx(np.sqrt(18**2 + 2**2 + 7**2))
        assert resolve_tolerance(scene, Tolerance(1.0, "percent")) == pytest.approx(diagonal(scene) / 100)

    def test_gpu_instances(self, models: Path) -> None:
        scene = read(models / "textured" / "khronos_SimpleInstancing.glb", "glb")
        assert len(scene.meshes[0].transforms) == 125

    @pytest.mark.parametrize("name", ["TEXCOORD_0", "COLOR_0", "_FEATURE_ID_0", "TANGENT"])
    def test_attributes_are_named(self, name: str) -> None:
        document = Gltf()
        extra = document.accessor(np.zeros((8, 4)))
        scene = read(glb_of(document.box(**{name: extra}), document), "glb")
        assert scene.meshes[0].parts[0].attributes == (name,)


def _spoilt(change) -> bytes:
    document = Gltf()
    document.mesh(document.box())
    change(document)
    return document.glb()


BROKEN = {
    "an index out of range": (
        lambda d: d.json["accessors"][1].update(count=7),
        "names a vertex that does not exist",
    ),
    "an accessor beyond its view": (
        lambda d: d.json["accessors"][0].update(count=99),
        "beyond its buffer view",
    ),
    "a view beyond its buffer": (lambda d: d.json["bufferViews"][0].update(byteLength=10**6), "truncated"),
    "no such accessor": (lambda d: d.json["meshes"][0]["primitives"][0].update(indices=77), "no entry 77"),
    "a ring of nodes": (lambda d: d.json["nodes"][0].update(children=[0]), "not a tree"),
    "no triangles": (lambda d: d.json["meshes"][0]["primitives"][0].update(mode=1), "no triangles"),
    "glTF 1": (lambda d: d.json["asset"].update(version="1.0"), "glTF 1.0"),
    "a node of a mesh that is not there": (lambda d: d.json["nodes"][0].update(mesh=7), "node 0 names mesh 7"),
    "a node of no number": (lambda d: d.json["nodes"][0].update(mesh="box"), "node 0 names mesh box"),
    "a stride of zero": (lambda d: d.json["bufferViews"][1].update(byteStride=0), "stride of 0 for elements of 12"),
    "a stride within a number": (lambda d: d.json["bufferViews"][1].update(byteStride=13), "stride of 13"),
    "a stride within an element": (lambda d: d.json["bufferViews"][1].update(byteStride=8), "stride of 8"),
    "a stride that is a word": (lambda d: d.json["bufferViews"][1].update(byteStride="12"), "stride of 12"),
    "a buffer in another folder": (lambda d: d.at("../box.bin"), "beneath the input's folder"),
    "a buffer at the root": (lambda d: d.at("/etc/passwd"), "beneath the input's folder"),
    "a buffer by a scheme": (lambda d: d.at("file:///etc/passwd"), "beneath the input's folder"),
    "a number that is none": (lambda d: d.json["nodes"][0].update(scale=[np.nan, 1, 1]), "holds NaN"),
    "nodes that scale without end": (
        lambda d: d.json.update(
            nodes=[{"children": [i + 1], "scale": [1e10] * 3} for i in range(40)] + [{"mesh": 0}]
        ),
        "beyond 1e100",
    ),
    "an image of nothing": (lambda d: d.json.update(images=[{}]), "image 0 has neither"),
    "an image of a number": (lambda d: d.json.update(images=[{"uri": 7}]), "image 0 has neither"),
    "an image of no view": (lambda d: d.json.update(images=[{"bufferView": 9}]), "no entry 9"),
    "a colour of words": (
        lambda d: (
            d.json["meshes"][0]["primitives"][0].update(material=0),
            d.json.update(materials=[{"pbrMetallicRoughness": {"baseColorFactor": ["red"] * 4}}]),
        ),
        "not as the format asks",
    ),
    "a member that is no list": (lambda d: d.json.update(cameras={}), "'cameras' is not a list"),
    "an accessor of no type": (lambda d: d.json["accessors"][0].update(type="VEC9"), "not understood"),
    "a count below zero": (lambda d: d.json["accessors"][0].update(count=-1), "negative count"),
    "no asset": (lambda d: d.json.pop("asset"), "no 'asset'"),
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("case", BROKEN)
def test_broken_documents_are_refused(case: str) -> None:
    change, told = BROKEN[case]
    with pytest.raises(InputError, match=told):
        read(_spoilt(change), "glb")


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("factor", [1e-120, 1e-30, 1e30, 1e90])
@pytest.mark.parametrize("tolerance", [Tolerance(), Tolerance(0.1, "length"), Tolerance(1.0, "percent")])
def test_odd_scales_end_in_a_result_or_one_error(factor: float, tolerance: Tolerance) -> None:
    document = Gltf()
    document.mesh(document.box(fine=True), node={"scale": [factor] * 3})
    scene = read(document.glb(), "glb")
    _, report = simplify_scene(scene, Options(tolerance=tolerance))
    assert report.after.watertight
    assert np.isfinite(report.deviation)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda d: d.json["scenes"][0].update(extras=[1e400]), "beyond double precision"),
        (lambda d: d.json["nodes"].append({"extensions": {"EXT_mesh_gpu_instancing": []}}), "not as the format asks"),
    ],
)
def test_what_no_mesh_uses_is_told_on_writing(change, told: str) -> None:
    scene = read(_spoilt(change).replace(b"Infinity", b"1e400   "), "glb")
    lights, _ = simplify_scene(scene, Options())
    with pytest.raises(OutputError, match=told):
        write_scene(scene, lights, io.BytesIO(), "glb", Options())


@pytest.mark.parametrize("suffix", ["glb", "gltf", "obj", "ply"])
def test_half_a_letter_in_a_name_can_be_written(tmp_path: Path, suffix: str) -> None:
    document = Gltf()
    document.mesh({**document.box(), "material": 0}, name="\ud800")
    document.json["materials"] = [{"name": "\udc00"}]
    scene = read(document.glb(), "glb")
    lights, _ = simplify_scene(scene, Options())
    target = tmp_path / f"out.{suffix}"
    write_scene(scene, lights, target, suffix, Options())
    assert len(read(target, suffix).meshes[0].faces) == 12


class TestBeside:
    """Only what stands beneath the file's folder is read."""

    @pytest.mark.parametrize(
        "uri", ["../box.bin", "sub/../../box.bin", "%2e%2e/box.bin", "..\\box.bin", "ABSOLUTE", "file:ABSOLUTE", "pipe"]
    )
    def test_what_is_elsewhere_is_refused(self, tmp_path: Path, uri: str) -> None:
        document = Gltf()
        document.mesh(document.box())
        outside = write(tmp_path / "box.bin", bytes(document.data))
        folder = tmp_path / "in"
        folder.mkdir()
        os.mkfifo(folder / "pipe")
        source = write(folder / "box.gltf", document.gltf(uri.replace("ABSOLUTE", str(outside))))
        with pytest.raises(InputError, match="is no file beneath the input's folder: put it there"):
            read(source, "gltf")

    @pytest.mark.parametrize("uri", ["sub/box.bin", "sub/../sub/box.bin", "sub/..b%20x.bin", "./link.bin"])
    def test_what_is_beneath_is_read(self, tmp_path: Path, uri: str) -> None:
        document = Gltf()
        document.mesh(document.box())
        (tmp_path / "sub").mkdir()
        for name in ("box.bin", "..b x.bin"):
            write(tmp_path / "sub" / name, bytes(document.data))
        (tmp_path / "link.bin").symlink_to("sub/box.bin")
        assert len(read(write(tmp_path / "box.gltf", document.gltf(uri)), "gltf").meshes[0].faces) == 12

    def test_an_image_elsewhere_is_not_put_in(self, tmp_path: Path) -> None:
        document = Gltf()
        primitive = document.box(TEXCOORD_0=document.accessor(np.zeros((8, 2))))
        document.json.update(
            images=[{"uri": "../secret.png"}], textures=[{"source": 0}],
            materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        )  # fmt: skip
        document.mesh({**primitive, "material": 0})
        write(tmp_path / "secret.png", b"\x89PNG secret")
        folder = tmp_path / "in"
        folder.mkdir()
        scene = read(write(folder / "box.gltf", document.gltf()), "gltf")
        lights, _ = simplify_scene(scene, Options())
        for suffix in ("glb", "obj"):
            written = write_scene(scene, lights, folder / f"out.{suffix}", suffix, Options())
            assert any("'../secret.png' is no file beneath" in text for text in written.warnings)
        assert not any(b"PNG secret" in path.read_bytes() for path in folder.iterdir())


def test_json_may_be_nested_as_deep_as_it_can_be_read(tmp_path: Path) -> None:
    deep: dict = {}
    for _ in range(700):
        deep = {"a": deep}
    document = Gltf()
    document.mesh({**document.box(fine=True), "material": 0})
    document.json.update(materials=[{"extensions": {"ACME_deep": deep}}], extras=deep)
    _, after = light(document.glb(), tmp_path / "out.glb")
    assert glb_parts(after)[0]["extras"] == deep


def test_work_grows_with_the_meshes_and_not_with_their_square() -> None:
    def calls(count: int) -> int:
        document = Gltf()
        for i in range(count):
            uv = document.accessor(np.zeros((16, 2)))
            points = document.accessor(np.vstack([box()[0], box()[0] + 5.0]) + 20.0 * i)
            document.json["accessors"][points]["count"] = 8
            document.json["accessors"].append({**document.json["accessors"][points], "byteOffset": 96})
            indices = document.accessor(box()[1].reshape(-1), "u2")
            document.mesh(
                {"attributes": {"POSITION": points}, "indices": indices},
                {"attributes": {"POSITION": points + 1, "TEXCOORD_0": uv}, "indices": indices},
            )
        data, told = document.glb(), 0

        def count_one(frame: object, event: str, argument: object) -> None:
            nonlocal told
            told += event in ("call", "c_call")

        sys.setprofile(count_one)
        try:
            scene = read(data, "glb")
            lights, _ = simplify_scene(scene, Options())
            write_scene(scene, lights, io.BytesIO(), "glb", Options())
        finally:
            sys.setprofile(None)
        return told

    assert calls(120) < 2.5 * calls(60)


def test_every_truncation_is_refused() -> None:
    document = Gltf()
    document.mesh(document.box())
    data = document.glb()
    for length in range(0, len(data) - 4, 13):
        with pytest.raises(InputError):
            read(data[:length], "glb")


def test_positions_that_are_not_finite_are_named() -> None:
    document = Gltf()
    points, faces = box()
    points[3] = np.nan
    primitive = {"attributes": {"POSITION": document.accessor(points)}}
    primitive["indices"] = document.accessor(faces.reshape(-1), "u2")
    with pytest.raises(InputError, match=r"not finite .*: 3:"):
        read(glb_of(primitive, document), "glb")


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
        document.mesh(
            primitive, name="house", extras={"id": 7}, node={"name": "at home", "translation": [1, 2, 3]}
        )
        document.json.update(
            materials=[{"name": "brick", "extras": {"fire": False}}],
            cameras=[{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}],
            extras={"author": "us"},
            animations=[{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
                         "samplers": [{"input": time, "output": move}]}],
        )  # fmt: skip
        data = document.glb()
        _, after = light(data, tmp_path / "out.glb")
        old, new = glb_parts(data)[0], glb_parts(after)[0]
        for key in ("asset", "nodes", "scenes", "scene", "materials", "cameras", "extras"):
            assert new[key] == old[key]
        primitive = new["meshes"][0].pop("primitives")[0]
        assert new["meshes"][0] == {"name": "house", "extras": {"id": 7}}
        assert {key: primitive[key] for key in ("material", "extras")} == {
            "material": 0,
            "extras": {"part": "walls"},
        }
        sampler = new["animations"][0]["samplers"][0]
        assert glb_values(after, sampler["input"]).tolist() == [[0.0], [1.0]]
        assert glb_values(after, sampler["output"]).tolist() == np.eye(3)[:2].tolist()
        view = new["bufferViews"][new["images"][0]["bufferView"]]
        binary = glb_parts(after)[1]
        assert binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]] == picture
        position = new["accessors"][primitive["attributes"]["POSITION"]]
        assert position["count"] == 8
        assert (position["min"], position["max"]) == ([0, 0, 0], [2, 2, 2])
        assert len(new["accessors"]) == 4
        assert len(new["bufferViews"]) == 5
        assert len(binary) < len(glb_parts(data)[1]) / 3

    def test_what_is_passed_on_is_the_same_to_the_byte(self, tmp_path: Path) -> None:
        document = Gltf()
        uv = document.accessor(np.random.default_rng(0).random((98, 2)))
        fixed = document.box(fine=True, TEXCOORD_0=uv)
        fixed["targets"] = [{"POSITION": document.accessor(np.ones((98, 3)))}]
        document.mesh(fixed, document.box(fine=True, shift=10.0))
        data = document.glb()
        _, after = light(data, tmp_path / "out.glb")
        old = glb_parts(data)[0]["meshes"][0]["primitives"][0]
        new = glb_parts(after)[0]["meshes"][0]["primitives"][0]
        for name, number in old["attributes"].items():
            assert np.array_equal(glb_values(after, new["attributes"][name]), glb_values(data, number))
        assert np.array_equal(glb_values(after, new["indices"]), glb_values(data, old["indices"]))
        assert np.array_equal(glb_values(after, new["targets"][0]["POSITION"]), np.ones((98, 3)))
        light_one = glb_parts(after)[0]["meshes"][0]["primitives"][1]
        assert len(glb_values(after, light_one["attributes"]["POSITION"])) == 8

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
        _, after = light(document.glb(), tmp_path / "out.glb", Options(min_part=0.2))
        json_, binary = glb_parts(after)
        assert [mesh["name"] for mesh in json_["meshes"]] == ["house", "shed"]
        assert json_["nodes"] == [{"mesh": 0}, {"name": "speck", "children": [2]}, {"mesh": 1}, {}]
        assert len(json_["accessors"]) == 4
        assert len(read(after, "glb").meshes) == 2
        whole = light(document.glb(), tmp_path / "all.glb")[1]
        assert len(glb_parts(whole)[0]["meshes"]) == 3
        assert len(binary) < len(glb_parts(whole)[1])

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
        _, after = light(data, tmp_path / "out.glb")
        first, second = glb_parts(after)[0]["meshes"][0]["primitives"]
        assert len(glb_values(after, first["attributes"]["POSITION"])) == 8
        assert np.array_equal(glb_values(after, second["attributes"]["POSITION"]), far.astype(np.float32))
        assert np.array_equal(glb_values(after, second["attributes"]["TEXCOORD_0"]), uv)
        spared = len(glb_parts(data)[1]) - len(glb_parts(after)[1])
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
        _, after = light(document.glb(), tmp_path / "out.glb", Options(delimit=frozenset({"material"})))
        json_ = glb_parts(after)[0]
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
        document.mesh(
            {"attributes": {"POSITION": position}, "indices": document.accessor(faces.reshape(-1), "u2")}
        )
        _, after = light(document.glb(), tmp_path / "out.glb", Options(tolerance=Tolerance(0.0, "length")))
        json_ = glb_parts(after)[0]
        accessor = json_["accessors"][json_["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]
        assert accessor["componentType"] == 5122
        assert json_["bufferViews"][accessor["bufferView"]]["byteStride"] == 8
        values = glb_values(after, json_["meshes"][0]["primitives"][0]["attributes"]["POSITION"])
        assert {tuple(row) for row in values.tolist()} == {
            tuple(row) for row in (box()[0] * 1000 - 700).tolist()
        }

    def test_map_coordinates_are_identical(self, tmp_path: Path) -> None:
        for shift in (500_000.0, 5_000_000.0):
            document = Gltf()
            points, faces = fine_box(shift=shift)
            position = document.accessor(points)
            document.mesh(
                {"attributes": {"POSITION": position}, "indices": document.accessor(faces.reshape(-1), "u2")}
            )
            _, after = light(document.glb(), tmp_path / "out.glb")
            primitive = glb_parts(after)[0]["meshes"][0]["primitives"][0]
            values = glb_values(after, primitive["attributes"]["POSITION"])
            assert {tuple(row) for row in values.tolist()} <= {
                tuple(row) for row in points.astype(np.float32).tolist()
            }
            assert len(values) == 8

    def test_unknown_extensions_stay_and_are_named(self, tmp_path: Path) -> None:
        document = Gltf()
        document.mesh(
            document.box(fine=True), node={"extensions": {"ACME_sign": {"accessor": 0, "text": "hello"}}}
        )
        document.json["extensionsUsed"] = ["ACME_sign"]
        options = Options()
        scene = read(document.glb(), "glb")
        lights, _ = simplify_scene(scene, options)
        written = write_scene(scene, lights, tmp_path / "out.glb", "glb", options)
        assert any("ACME_sign" in text for text in written.warnings)
        json_ = glb_parts((tmp_path / "out.glb").read_bytes())[0]
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
            lights, _ = simplify_scene(scene, Options())
            write_scene(scene, lights, target, "gltf", Options())
            uri = json.loads(target.read_text())["buffers"][0]["uri"]
            assert (uri == "out.bin") == beside
            assert uri.startswith("data:") != beside
            assert read(target, "gltf").meshes[0].points.shape == (8, 3)

    def test_images_come_along_to_another_folder_and_go_into_a_glb(
        self, tmp_path: Path, models: Path
    ) -> None:
        source = models / "textured" / "kaykit_building_H" / "building_H.gltf"
        picture = (source.parent / "citybits_texture.png").read_bytes()
        scene = read(source, "gltf")
        lights, report = simplify_scene(scene, Options())
        assert not report.passed_on
        write_scene(scene, lights, tmp_path / "out.gltf", "gltf", Options())
        assert (tmp_path / "citybits_texture.png").read_bytes() == picture
        write_scene(scene, lights, tmp_path / "out.glb", "glb", Options())
        json_, binary = glb_parts((tmp_path / "out.glb").read_bytes())
        assert "uri" not in json_["images"][0]
        view = json_["bufferViews"][json_["images"][0]["bufferView"]]
        assert binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]] == picture

    def test_the_tower_stays_one_vertex_buffer(self, tmp_path: Path, models: Path) -> None:
        scene = read(models / "exact" / "cesium_building_tower.glb", "glb")
        assert len(scene.meshes[0].points) == 119_547
        lights, _ = simplify_scene(scene, Options(normals="flat"))
        write_scene(scene, lights, tmp_path / "out.glb", "glb", Options(normals="flat"))
        primitives = glb_parts((tmp_path / "out.glb").read_bytes())[0]["meshes"][0]["primitives"]
        assert primitives[0]["attributes"] == primitives[1]["attributes"]


class TestNormals:
    @pytest.fixture
    def shaded(self) -> Gltf:
        """A box with one vertex for each corner of each side, and the sides' normals."""
        points, faces = box()
        corners = points[faces].reshape(-1, 3)
        cross = np.cross(corners[1::3] - corners[::3], corners[2::3] - corners[::3])
        normals = np.repeat(cross / np.linalg.norm(cross, axis=1)[:, None], 3, axis=0)
        document = Gltf()
        attributes = {"POSITION": document.accessor(corners), "NORMAL": document.accessor(normals)}
        document.mesh({"attributes": attributes})
        return document

    def test_face_normals_are_dropped_and_the_points_shared(self, shaded: Gltf, tmp_path: Path) -> None:
        _, after = light(shaded.glb(), tmp_path / "out.glb")
        primitive = glb_parts(after)[0]["meshes"][0]["primitives"][0]
        assert set(primitive["attributes"]) == {"POSITION"}
        assert len(glb_values(after, primitive["attributes"]["POSITION"])) == 8

    def test_other_normals_are_kept_as_stored(self, shaded: Gltf, tmp_path: Path) -> None:
        view = shaded.json["bufferViews"][1]
        tilted = np.tile(np.array([[0.6, 0.0, 0.8]], "<f4"), (36, 1))
        shaded.data[view["byteOffset"] : view["byteOffset"] + view["byteLength"]] = tilted.tobytes()
        _, after = light(shaded.glb(), tmp_path / "out.glb")
        primitive = glb_parts(after)[0]["meshes"][0]["primitives"][0]
        normals = glb_values(after, primitive["attributes"]["NORMAL"])
        # The box is wound inwards: where a normal agrees with that, it turns as the faces do.
        assert np.all(np.abs(normals) == tilted[0])

    def test_smooth_normals_point_out_of_the_corners(self, shaded: Gltf, tmp_path: Path) -> None:
        _, after = light(shaded.glb(), tmp_path / "out.glb", Options(normals="smooth", crease_angle=180.0))
        attributes = glb_parts(after)[0]["meshes"][0]["primitives"][0]["attributes"]
        points, normals = glb_values(after, attributes["POSITION"]), glb_values(after, attributes["NORMAL"])
        assert np.allclose(normals, (points - 1.0) / np.sqrt(3.0), atol=1e-6)

    @pytest.mark.parametrize("choice", ["flat", "none"])
    def test_none_are_written_where_none_are_wanted(self, shaded: Gltf, tmp_path: Path, choice: str) -> None:
        _, after = light(shaded.glb(), tmp_path / "out.glb", Options(normals=choice))
        assert set(glb_parts(after)[0]["meshes"][0]["primitives"][0]["attributes"]) == {"POSITION"}
