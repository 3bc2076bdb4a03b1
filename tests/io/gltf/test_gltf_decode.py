"""Compressed glTF: read through the packages that decode it, written without compression."""

from __future__ import annotations

import json
import struct
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gltf_cases import fine, import_decoder, new_primitive, simplify_glb
from khronos import assert_no_new_issues
from shapes import Gltf, box, collect_triangles, fine_box, read_values, split_glb, write

from bldsimp import InputError
from bldsimp.io import read

MESHOPT, DRACO = "EXT_meshopt_compression", "KHR_draco_mesh_compression"


def pack(json_: dict[str, Any], data: bytes) -> bytes:
    text = json.dumps(json_).encode()
    text, data = text + b" " * (-len(text) % 4), data + b"\0" * (-len(data) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


def pack_meshopt(document: Gltf, views: dict[int, tuple[str, str]]) -> bytes:
    """A document with some of its views compressed, each by a mode and after a filter."""
    meshoptimizer = import_decoder("meshoptimizer")
    json_, data = json.loads(json.dumps(document.json)), bytearray(document.data)
    for number, (mode, filter_) in views.items():
        view = json_["bufferViews"][number]
        start = view["byteOffset"]
        raw = bytes(document.data[start : start + view["byteLength"]])
        accessor = next(one for one in json_["accessors"] if one["bufferView"] == number)
        stride = view.get("byteStride") or view["byteLength"] // accessor["count"]
        if mode == "ATTRIBUTES":
            rows = np.frombuffer(raw, np.uint8).reshape(-1, stride)
            packed = meshoptimizer.encode_vertex_buffer(rows, len(rows), stride)
        else:
            encode = {"TRIANGLES": meshoptimizer.encode_index_buffer, "INDICES": meshoptimizer.encode_index_sequence}
            corners = np.frombuffer(raw, f"<u{stride}").astype(np.uint32)
            packed = encode[mode](corners, len(corners), int(corners.max()) + 1)
        place = {"buffer": 0, "byteOffset": len(data), "byteLength": len(packed)}
        extension = {**place, "byteStride": stride, "count": accessor["count"], "mode": mode, "filter": filter_}
        view.update(buffer=1, extensions={MESHOPT: extension})
        data += bytes(packed) + bytes(-len(packed) % 4)
    fallback = {"byteLength": len(document.data), "extensions": {MESHOPT: {"fallback": True}}}
    json_["buffers"] = [{"byteLength": len(data)}, fallback]
    json_["extensionsUsed"] = json_["extensionsRequired"] = ["KHR_mesh_quantization", MESHOPT]
    return pack(json_, bytes(data))


def pack_draco(document: Gltf, **kinds: Any) -> bytes:
    """A document whose first primitive is compressed, its attributes by their type or as generic ones."""
    draco = import_decoder("DracoPy")
    json_ = json.loads(json.dumps(document.json))
    primitive, whole = json_["meshes"][0]["primitives"][0], document.glb()
    values = {name: read_values(whole, number) for name, number in primitive["attributes"].items()}
    faces = read_values(whole, primitive["indices"]).reshape(-1, 3).astype(np.uint32)
    packed = draco.encode(
        values["POSITION"], faces, preserve_order=True,
        # Steps of a power of two, so that positions are exact.
        quantization_bits=16, quantization_range=65535 / 16384, quantization_origin=[0.0, 0.0, 0.0],
        **{key: values[name].astype(float) if key != "colors" else values[name] for key, name in kinds.items()},
        generic_attributes={7: values["_FEATURE_ID_0"].astype(np.uint16)},
    )  # fmt: skip
    named = {one["attribute_type"]: one["unique_id"] for one in draco.decode(packed).attributes}
    types = {"POSITION": 0, **{name: {"normals": 1, "colors": 2, "tex_coord": 3}[key] for key, name in kinds.items()}}
    attributes = {"_FEATURE_ID_0": 7, **{name: int(named[type_]) for name, type_ in types.items()}}
    for number in (*primitive["attributes"].values(), primitive["indices"]):
        json_["accessors"][number].pop("bufferView")
    data = bytes(document.data) + b"\0" * (-len(document.data) % 4)
    json_["bufferViews"] = [{"buffer": 0, "byteOffset": len(data), "byteLength": len(packed)}]
    primitive["extensions"] = {DRACO: {"bufferView": 0, "attributes": attributes}}
    json_["buffers"] = [{"byteLength": len(data) + len(packed)}]
    json_["extensionsUsed"] = json_["extensionsRequired"] = [DRACO]
    return pack(json_, data + packed)


def make_textured() -> Gltf:
    """A fine box with texture coordinates, colors and a feature id."""
    document, points = Gltf(), fine_box()[0]
    names = {"TEXCOORD_0": document.accessor(points[:, :2] / 2.0)}
    names |= {"COLOR_0": document.accessor(np.full((98, 4), 51), "u1", normalized=True)}
    names |= {"_FEATURE_ID_0": document.accessor(np.full(98, 5), "u2")}
    document.mesh(fine(document, **names), extras={"stays": True})
    return document


def assert_same(data: bytes, plain: bytes) -> None:
    """What is read from two files is the same."""
    one, other = read(data, "glb").meshes[0], read(plain, "glb").meshes[0]
    assert collect_triangles(one.points, one.faces) == collect_triangles(other.points, other.faces)
    assert [(a.name, a.kind) for a in one.attributes] == [(a.name, a.kind) for a in other.attributes]
    for a, b in zip(one.attributes, other.attributes, strict=True):
        assert np.allclose(a.values[one.faces], b.values[other.faces], atol=1e-4)


class TestMeshopt:
    @pytest.mark.parametrize("mode", ["TRIANGLES", "INDICES"])
    def test_vertices_and_indices_are_what_was_packed(self, mode: str, tmp_path: Path) -> None:
        document = make_textured()
        accessors, primitive = document.json["accessors"], document.json["meshes"][0]["primitives"][0]
        views = {accessors[n]["bufferView"]: ("ATTRIBUTES", "NONE") for n in primitive["attributes"].values()}
        # A stride of two bytes is not a multiple of four.
        del views[accessors[primitive["attributes"]["_FEATURE_ID_0"]]["bufferView"]]
        views[accessors[primitive["indices"]]["bufferView"]] = (mode, "NONE")
        data = pack_meshopt(document, views)
        assert_same(data, document.glb())
        scene, after = simplify_glb(data, tmp_path / "out.glb")
        assert any(MESHOPT in text for text in scene.warnings)
        json_ = split_glb(after)[0]
        assert (json_["extensionsUsed"], json_["extensionsRequired"]) == (["KHR_mesh_quantization"],) * 2
        assert len(json_["buffers"]) == 1
        assert MESHOPT not in json.dumps(json_)
        assert len(read_values(after, new_primitive(after)["attributes"]["POSITION"])) == 8
        assert json_["meshes"][0]["extras"] == {"stays": True}

    def test_filters_are_undone(self) -> None:
        document = Gltf()
        points, faces = fine_box()
        whole = document.box(fine=True)
        powers = (np.int64(0xFF) << 24) | (np.rint(points * 2).astype(np.int64) & 0xFFFFFF)
        position = document.accessor(powers, "u4")
        document.json["accessors"][position]["componentType"] = 5126
        normal = document.accessor(np.tile([0, 0, 127, 0], (98, 1)), "i1", normalized=True)
        document.json["accessors"][normal]["type"] = "VEC3"
        turn = document.accessor([[0, 0, 0, 32767]], "i2", normalized=True)
        instances = {"extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"ROTATION": turn}}}}
        names = {"POSITION": position, "NORMAL": normal}
        document.mesh({"attributes": names, "indices": whole["indices"]}, node=instances)
        filters = {position: "EXPONENTIAL", normal: "OCTAHEDRAL", turn: "QUATERNION"}
        views = {document.json["accessors"][n]["bufferView"]: ("ATTRIBUTES", f) for n, f in filters.items()}
        mesh = read(pack_meshopt(document, views), "glb").meshes[0]
        assert collect_triangles(mesh.points, mesh.faces) == collect_triangles(points, faces)
        assert np.allclose(mesh.normals, [0, 0, 1])
        assert np.allclose(mesh.transforms, np.eye(4))

    def test_a_fallback_is_read_without_the_package(self, monkeypatch: pytest.MonkeyPatch) -> None:
        document = Gltf()
        document.mesh(document.box())
        view = document.json["bufferViews"][0]
        packed = {"buffer": 0, "byteLength": 1, "byteStride": 2, "count": 36, "mode": "TRIANGLES"}
        view["extensions"] = {MESHOPT: packed}
        monkeypatch.setitem(sys.modules, "meshoptimizer", None)
        assert len(read(document.glb(), "glb").meshes[0].faces) == 12

    @pytest.mark.parametrize(
        "change", [{"byteLength": 30}, {"mode": "LINES"}, {"filter": "SOFT"}, {"count": 10**9}, {"byteStride": 6}]
    )
    def test_damaged_data_is_refused(self, change: dict[str, Any]) -> None:
        document = Gltf()
        document.mesh(document.box(fine=True))
        number = document.json["accessors"][1]["bufferView"]
        data = pack_meshopt(document, {number: ("ATTRIBUTES", "NONE")})
        json_, binary = split_glb(data)
        json_["bufferViews"][number]["extensions"][MESHOPT].update(change)
        with pytest.raises(InputError, match=r"cannot be decoded .*: the file is damaged"):
            read(pack(json_, binary), "glb")


class TestDraco:
    def test_all_attributes_are_what_was_packed(self, tmp_path: Path) -> None:
        document = make_textured()
        data = pack_draco(document, tex_coord="TEXCOORD_0", colors="COLOR_0")
        assert_same(data, document.glb())
        scene, after = simplify_glb(data, tmp_path / "out.glb")
        assert any(DRACO in text for text in scene.warnings)
        json_ = split_glb(after)[0]
        assert not {"extensionsUsed", "extensionsRequired"} & set(json_)
        assert "extensions" not in new_primitive(after)
        assert json_["meshes"][0]["extras"] == {"stays": True}
        assert_same(after, simplify_glb(document.glb(), tmp_path / "plain.glb")[1])

    def test_what_is_passed_on_is_valid_and_equal_data_is_there_once(self, tmp_path: Path) -> None:
        document = make_textured()
        json_, binary = split_glb(pack_draco(document, tex_coord="TEXCOORD_0", colors="COLOR_0"))
        json_["extensionsUsed"] = [*json_["extensionsUsed"], "EXT_mesh_features"]
        implicit = {"featureIds": [{"featureCount": 98}]}
        json_["meshes"][0]["primitives"][0]["extensions"]["EXT_mesh_features"] = implicit
        twin = json.loads(json.dumps(json_["meshes"][0]["primitives"][0]))
        count = len(json_["accessors"])
        json_["accessors"] += [dict(one) for one in json_["accessors"]]
        twin["attributes"] = {name: number + count for name, number in twin["attributes"].items()}
        json_["meshes"][0]["primitives"].append({**twin, "indices": twin["indices"] + count})
        _, after = simplify_glb(pack(json_, binary), tmp_path / "out.glb")
        write(tmp_path / "plain.glb", document.glb())
        assert_no_new_issues(tmp_path / "plain.glb", tmp_path / "out.glb")
        assert len(split_glb(after)[0]["bufferViews"]) == count

    def test_damaged_data_is_refused(self) -> None:
        json_, binary = split_glb(pack_draco(make_textured(), tex_coord="TEXCOORD_0", colors="COLOR_0"))
        start = json_["bufferViews"][0]["byteOffset"]
        with pytest.raises(InputError, match="Draco data of the glTF file cannot be decoded"):
            read(pack(json_, binary[:start] + bytes(len(binary) - start)), "glb")
        json_["meshes"][0]["primitives"][0]["extensions"][DRACO]["attributes"]["POSITION"] = 99
        with pytest.raises(InputError, match="no attribute 99, POSITION"):
            read(pack(json_, binary), "glb")


@pytest.mark.parametrize(("package", "extension"), [("meshoptimizer", MESHOPT), ("DracoPy", DRACO)])
def test_without_the_package_one_line_names_it(package: str, extension: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if extension == DRACO:
        data = pack_draco(make_textured(), tex_coord="TEXCOORD_0", colors="COLOR_0")
    else:
        document = Gltf()
        document.mesh(document.box())
        data = pack_meshopt(document, {1: ("ATTRIBUTES", "NONE")})
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(InputError, match=f"compressed .*{extension}.*: install .* 'pip install {package}'"):
        read(data, "glb")


def test_an_extension_that_nothing_uses_is_no_obstacle() -> None:
    document = Gltf()
    document.json["extensionsUsed"] = [DRACO]
    document.mesh(document.box())
    mesh = read(document.glb(), "glb").meshes[0]
    assert collect_triangles(mesh.points, mesh.faces) == collect_triangles(*box())
