"""glTF: read by its own rules."""

from __future__ import annotations

import io
import os
import sys
from pathlib import Path

import numpy as np
import pytest
from gltf_cases import simplify_glb
from shapes import Gltf, box, collect_triangles, read_values, split_glb, write

from bldsimp import InputError, Options, Tolerance
from bldsimp.compare.placement import place_scene
from bldsimp.io import read
from bldsimp.io import write as write_scene
from bldsimp.job import simplify_file
from bldsimp.scene import simplify_scene
from bldsimp.tolerance import measure_diagonal, measure_spacing, resolve_tolerance


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
            assert collect_triangles(mesh.points, mesh.faces) == expected

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
        assert collect_triangles(mesh.points, mesh.faces) == collect_triangles(points, faces)

    def test_quantized_positions_have_the_spacing_of_their_integers(self) -> None:
        document = Gltf()
        points, faces = box(1000)
        document.json["extensionsUsed"] = ["KHR_mesh_quantization"]
        position = document.accessor(points, "u2")
        document.mesh({"attributes": {"POSITION": position}, "indices": document.accessor(faces.reshape(-1), "u2")})
        mesh = read(document.glb(), "glb").meshes[0]
        assert mesh.points.max() == 1000.0
        assert measure_spacing(mesh) == 1.0
        document.json["accessors"][position]["normalized"] = True
        mesh = read(document.glb(), "glb").meshes[0]
        assert mesh.points.max() == 1000.0 / 65535.0
        assert measure_spacing(mesh) == 1.0 / 65535.0

    def test_interleaved_attributes(self) -> None:
        document = Gltf()
        points, faces = box()
        both = document.accessor(np.hstack([points, np.tile([0.0], (8, 1))]))  # four floats a row
        view = document.json["accessors"][both]["bufferView"]
        document.json["bufferViews"][view]["byteStride"] = 16
        document.json["accessors"][both]["type"] = "VEC3"
        document.mesh({"attributes": {"POSITION": both}, "indices": document.accessor(faces.reshape(-1), "u4")})
        mesh = read(document.glb(), "glb").meshes[0]
        assert collect_triangles(mesh.points, mesh.faces) == collect_triangles(points, faces)

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
        document.json["nodes"].append({"children": [1], "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1]})
        document.json["scenes"][0]["nodes"].append(2)
        scene = read(document.glb(), "glb")
        assert np.allclose(scene.meshes[0].transforms[0], [[3, 0, 0, 10], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
        assert np.allclose(scene.meshes[0].transforms[1], [[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 5], [0, 0, 0, 1]])
        assert measure_diagonal(scene) == pytest.approx(np.sqrt(18**2 + 2**2 + 7**2))
        assert resolve_tolerance(scene, Tolerance(1.0, "percent")) == pytest.approx(measure_diagonal(scene) / 100)

    def test_a_mesh_that_no_node_shows_counts_only_where_no_other_is_shown(self) -> None:
        document = Gltf()
        document.mesh(document.box(size=2.0))
        document.mesh(document.box(size=200.0))
        del document.json["nodes"][1], document.json["scenes"][0]["nodes"][1]
        scene = read(document.glb(), "glb")
        assert [len(mesh.transforms) for mesh in scene.meshes] == [1, 0]
        assert measure_diagonal(scene) == pytest.approx(np.sqrt(12))
        assert len(place_scene(scene).points) == 8
        # The one that is shown stays, however small.
        (shown, _), _ = simplify_scene(scene, Options(min_component=1000.0))
        assert len(shown.faces) == 12
        document.json.update(nodes=[], scenes=[{}])
        scene = read(document.glb(), "glb")
        assert [mesh.transforms.tolist() for mesh in scene.meshes] == [[np.eye(4).tolist()]] * 2

    def test_gpu_instances(self, models: Path) -> None:
        scene = read(models / "textured" / "khronos_SimpleInstancing.glb", "glb")
        assert len(scene.meshes[0].transforms) == 125

    @pytest.mark.parametrize("name", ["TEXCOORD_0", "COLOR_0", "_FEATURE_ID_0", "TANGENT"])
    def test_attributes_are_named(self, name: str) -> None:
        document = Gltf()
        extra = document.accessor(np.zeros((8, 2 if name == "TEXCOORD_0" else 4)))
        document.mesh(document.box(**{name: extra}))
        scene = read(document.glb(), "glb")
        assert scene.meshes[0].parts[0].attributes == (name,)


@pytest.mark.parametrize("suffix", ["glb", "gltf", "obj", "ply"])
def test_half_a_letter_in_a_name_can_be_written(tmp_path: Path, suffix: str) -> None:
    document = Gltf()
    document.mesh({**document.box(), "material": 0}, name="\ud800")
    document.json["materials"] = [{"name": "\udc00"}]
    scene = read(document.glb(), "glb")
    results, _ = simplify_scene(scene, Options())
    target = tmp_path / f"out.{suffix}"
    write_scene(scene, results, target, suffix, Options())
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
        with pytest.raises(InputError, match="is not a file beneath the input's folder: put it there"):
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
        results, _ = simplify_scene(scene, Options())
        for suffix in ("glb", "obj"):
            written = write_scene(scene, results, folder / f"out.{suffix}", suffix, Options())
            assert any("'../secret.png' is not a file beneath" in text for text in written.warnings)
        assert not any(b"PNG secret" in path.read_bytes() for path in folder.iterdir())


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
            results, _ = simplify_scene(scene, Options())
            write_scene(scene, results, io.BytesIO(), "glb", Options())
        finally:
            sys.setprofile(None)
        return told

    assert calls(120) < 2.5 * calls(60)


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
        _, after = simplify_glb(shaded.glb(), tmp_path / "out.glb")
        primitive = split_glb(after)[0]["meshes"][0]["primitives"][0]
        assert set(primitive["attributes"]) == {"POSITION"}
        assert len(read_values(after, primitive["attributes"]["POSITION"])) == 8

    def test_other_normals_are_kept_as_stored(self, shaded: Gltf, tmp_path: Path) -> None:
        view = shaded.json["bufferViews"][1]
        tilted = np.tile(np.array([[0.6, 0.0, 0.8]], "<f4"), (36, 1))
        shaded.data[view["byteOffset"] : view["byteOffset"] + view["byteLength"]] = tilted.tobytes()
        _, after = simplify_glb(shaded.glb(), tmp_path / "out.glb")
        primitive = split_glb(after)[0]["meshes"][0]["primitives"][0]
        normals = read_values(after, primitive["attributes"]["NORMAL"])
        # The box is wound inwards: where a normal agrees with that, it turns as the faces do.
        assert np.all(np.abs(normals) == tilted[0])

    def test_smooth_normals_point_out_of_the_corners(self, shaded: Gltf, tmp_path: Path) -> None:
        _, after = simplify_glb(shaded.glb(), tmp_path / "out.glb", Options(normals="smooth", crease_angle=180.0))
        attributes = split_glb(after)[0]["meshes"][0]["primitives"][0]["attributes"]
        points, normals = read_values(after, attributes["POSITION"]), read_values(after, attributes["NORMAL"])
        assert np.allclose(normals, (points - 1.0) / np.sqrt(3.0), atol=1e-6)

    @pytest.mark.parametrize("choice", ["flat", "none"])
    def test_none_are_written_where_none_are_wanted(self, shaded: Gltf, tmp_path: Path, choice: str) -> None:
        _, after = simplify_glb(shaded.glb(), tmp_path / "out.glb", Options(normals=choice))
        assert set(split_glb(after)[0]["meshes"][0]["primitives"][0]["attributes"]) == {"POSITION"}


@pytest.mark.parametrize("suffix", ["obj", "ply", "stl", "off", "glb", "gltf"])
def test_a_mesh_that_no_node_shows_stays_where_there_are_nodes_alone(suffix: str, tmp_path: Path) -> None:
    document = Gltf()
    document.mesh(document.box(size=2.0, fine=True))
    document.mesh(document.box(size=200.0, fine=True))
    del document.json["nodes"][0]
    document.json["nodes"][0]["translation"] = [1.0, 0.0, 0.0]
    document.json["scenes"][0]["nodes"] = [0]
    target = tmp_path / f"out.{suffix}"
    report = simplify_file(document.glb(), "glb", target, suffix, Options()).report
    meshes = read(target, suffix).meshes
    if suffix in ("glb", "gltf"):
        assert [len(mesh.faces) for mesh in meshes] == [12, 12]
        assert report.after.triangles == 24
    else:
        assert [mesh.box.tolist() for mesh in meshes] == [[[1.0, 0.0, 0.0], [201.0, 200.0, 200.0]]]
        assert report.after.triangles == 12
    assert any("no node shows are left out: 1" in text for text in report.warnings) == (suffix not in ("glb", "gltf"))
