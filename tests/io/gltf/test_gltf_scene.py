"""A glTF scene comes out as it went in, but for the accessors of what was simplified."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gltf_cases import CASES, bounded, everything_around, textured
from gltf_scene import Contents, read_gltf_scene
from khronos import assert_no_new_issues
from shapes import Gltf, box, write

from bldsimp import Options, Report, simplify
from bldsimp.io import read
from bldsimp.io import write as write_scene
from bldsimp.options import DEFAULTS
from bldsimp.scene import simplify_scene

MODELS = (
    "cesium_house-3-0.glb", "kaykit_building_H/building_H.gltf", "kenney_building-small-a.glb",
    "khronos_NegativeScaleTest.glb", "khronos_SimpleInstancing.glb", "trimesh_no_indices_3storybuilding.glb",
)  # fmt: skip


def simplify_to(source: Path, target: Path, options: Options = DEFAULTS) -> Report:
    """Simplify a file."""
    scene = read(source, source.suffix[1:])
    results, report = simplify_scene(scene, options)
    report.after.bytes = write_scene(scene, results, target, target.suffix[1:], options).bytes
    return report


def list_rows(primitive: dict[str, Any], names: list[str]) -> set[bytes]:
    """Corners of a primitive, each by the bytes of all its values."""
    columns = [np.ascontiguousarray(primitive["attributes"][name]) for name in names]
    return {b"".join(column[i].tobytes() for column in columns) for i in range(len(columns[0]))}


def assert_same_scene(before: dict[str, Any], after: dict[str, Any], fixed: bool = False) -> None:
    """All is equal but for primitives with fewer corners, each of which was there."""
    old = [one for mesh in before["meshes"] for one in mesh.pop("primitives")]
    new = [one for mesh in after["meshes"] for one in mesh.pop("primitives")]
    assert after == before
    for one, other in zip(old, new, strict=True):
        left = {key: value for key, value in other.items() if key not in ("attributes", "types", "mode")}
        assert left == {key: value for key, value in one.items() if key not in ("attributes", "types", "mode")}
        names = list(other["attributes"])
        # Normals that are those of the faces need not be stored.
        assert set(one["attributes"]) - set(names) <= {"NORMAL"}
        assert {name: one["types"][name] for name in names} == other["types"]
        assert len(other["attributes"]["POSITION"]) <= len(one["attributes"]["POSITION"])
        assert list_rows(other, names) <= list_rows(one, names)


@pytest.mark.parametrize("name", MODELS)
def test_models_come_out_as_they_went_in(name: str, models: Path, tmp_path: Path) -> None:
    source = models / "textured" / name
    target = tmp_path / source.name
    report = simplify_to(source, target)
    assert not report.unchanged_parts
    assert_same_scene(read_gltf_scene(source), read_gltf_scene(target))
    assert report.after.bytes <= report.before.bytes
    assert target.stat().st_size <= source.stat().st_size
    others = [tmp_path / f"other.{suffix}" for suffix in ("glb", "gltf")]
    for other in others:
        simplify_to(source, other)
    assert_no_new_issues(source, target, *others)


@pytest.mark.parametrize("name", CASES)
def test_every_feature_comes_out_as_it_went_in(name: str, tmp_path: Path) -> None:
    source, target = write(tmp_path / "in.glb", CASES[name]().glb()), tmp_path / "out.glb"
    report = simplify_to(source, target)
    before, after = read_gltf_scene(source), read_gltf_scene(target)
    sizes = [[len(p["attributes"]["POSITION"]) for m in s["meshes"] for p in m["primitives"]] for s in (before, after)]
    assert_same_scene(before, after)
    if name == "bent":
        assert [one.name.split(" / ")[0] for one in report.unchanged_parts] == ["flag", "door"]
        assert sizes[1] == [576, 576, 36]
    else:
        assert not report.unchanged_parts
        assert all(one <= 36 for one in sizes[1])
    assert target.stat().st_size < source.stat().st_size
    text = tmp_path / "out.gltf"
    simplify_to(source, text)
    wide = tmp_path / "wide.glb"
    simplify_to(source, wide, Options(delimit=frozenset({"material"})))
    assert_no_new_issues(source, target, text, wide)


@pytest.mark.parametrize("name", ["instances", "nodes"])
def test_a_window_used_five_hundred_times_is_simplified_once(name: str, tmp_path: Path) -> None:
    source, target = write(tmp_path / "in.glb", CASES[name]().glb()), tmp_path / "out.glb"
    report = simplify_to(source, target)
    assert (report.before.triangles, report.after.triangles) == (192, 12)
    scene = read(target, "glb")
    assert [len(mesh.transforms) for mesh in scene.meshes] == [500]
    assert np.array_equal(scene.meshes[0].transforms, read(source, "glb").meshes[0].transforms)


class TestNothingToGain:
    def test_what_loses_nothing_keeps_its_accessors(self, tmp_path: Path) -> None:
        document = Gltf()
        points, faces = simplify(box()).mesh
        names = {"POSITION": bounded(document, points), "COLOR_0": document.accessor(np.ones((8, 3)))}
        # Bytes serve for so few vertices, but are not what is written anew.
        document.mesh({"attributes": names, "indices": document.accessor(faces[::-1].reshape(-1), "u1")})
        document.mesh(textured(document, shift=5.0))
        source, target = write(tmp_path / "in.glb", document.glb()), tmp_path / "out.glb"
        simplify_to(source, target)
        before, after = Contents(source), Contents(target)
        primitives = [one.json["meshes"][0]["primitives"][0] for one in (before, after)]
        for number, other in zip(*(list_slots(one) for one in primitives), strict=True):
            assert {**before.json["accessors"][number], "bufferView": 0} == {
                **after.json["accessors"][other], "bufferView": 0
            }  # fmt: skip
            assert np.array_equal(before.values(number), after.values(other))
        assert len(after.values(after.json["meshes"][1]["primitives"][0]["indices"])) == 36

    def test_meshes_of_the_same_numbers_share_them(self, tmp_path: Path) -> None:
        document = Gltf()
        red, blue = textured(document), textured(document, name="blue")
        document.mesh(red)
        document.mesh({**red, "material": blue["material"]}, node={"translation": [9, 0, 0]})
        source, target = write(tmp_path / "in.glb", document.glb()), tmp_path / "out.glb"
        simplify_to(source, target)
        one, other = (mesh["primitives"][0] for mesh in Contents(target).json["meshes"])
        assert list_slots(one) == list_slots(other)
        assert_same_scene(read_gltf_scene(source), read_gltf_scene(target))


def list_slots(primitive: dict[str, Any]) -> list[int]:
    """Accessors of a primitive."""
    return [*primitive["attributes"].values(), primitive["indices"]]


class TestSeveralBuffers:
    """Files beside a document that lose nothing stay as they are."""

    def document(self, folder: Path) -> Path:
        """A document whose picture and animation stand in buffers of their own, and one picture in a file."""
        document = CASES["everything around"]()
        json_, data = json.loads(json.dumps(document.json)), bytes(document.data)
        json_["buffers"] = []
        picture = json_["images"][0]["bufferView"]
        moving = {json_["accessors"][n]["bufferView"] for n in json_["animations"][0]["samplers"][0].values()}
        groups = {"shape.bin": set(range(len(json_["bufferViews"]))) - moving - {picture}, "sub/move.bin": moving}
        groups["picture.bin"] = {picture}
        (folder / "sub").mkdir()
        for number, (name, views) in enumerate(groups.items()):
            body = b""
            for index in sorted(views):
                view = json_["bufferViews"][index]
                start = view["byteOffset"]
                view.update(buffer=number, byteOffset=len(body))
                body += data[start : start + view["byteLength"]] + bytes(-view["byteLength"] % 4)
            write(folder / name, body)
            json_["buffers"].append({"uri": name, "byteLength": len(body), "name": name})
        return write(folder / "in.gltf", json.dumps(json_))

    def test_only_what_changes_is_written_anew(self, tmp_path: Path) -> None:
        source = self.document(tmp_path)
        files = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
        before = read_gltf_scene(source)
        simplify_to(source, tmp_path / "out.gltf")
        assert {path: path.read_bytes() for path in files} == files
        json_ = json.loads((tmp_path / "out.gltf").read_text())
        assert [entry["uri"] for entry in json_["buffers"]] == ["out.bin", "sub/move.bin", "picture.bin"]
        assert [entry["name"] for entry in json_["buffers"]] == ["shape.bin", "sub/move.bin", "picture.bin"]
        assert_same_scene(before, read_gltf_scene(tmp_path / "out.gltf"))
        assert_no_new_issues(source, tmp_path / "out.gltf")

    def test_they_come_along_to_another_folder(self, tmp_path: Path) -> None:
        folder, target = tmp_path / "in", tmp_path / "out" / "picture.gltf"
        folder.mkdir()
        target.parent.mkdir()
        source = self.document(folder)
        simplify_to(source, target)
        # The new buffer must not take the name of one that stays.
        json_ = json.loads(target.read_text())
        assert [entry["uri"] for entry in json_["buffers"]] == ["light_picture.bin", "sub/move.bin", "picture.bin"]
        assert (target.parent / "picture.bin").read_bytes() == (folder / "picture.bin").read_bytes()
        assert_same_scene(read_gltf_scene(source), read_gltf_scene(target))

    def test_files_of_one_name_in_two_folders_stay_two(self, tmp_path: Path) -> None:
        names = ["a/color.png", "b%20b/color.png", "c\\color.png"]
        document = Gltf()
        document.json["images"] = [{"uri": name} for name in names]
        document.mesh(document.box(fine=True))
        source, target = tmp_path / "in" / "box.gltf", tmp_path / "out" / "box.gltf"
        target.parent.mkdir()
        for folder in ("a", "b b", "c"):
            (source.parent / folder).mkdir(parents=True)
            write(source.parent / folder / "color.png", f"picture of {folder}")
        write(source, document.gltf())
        simplify_to(source, target)
        assert [image["uri"] for image in json.loads(target.read_text())["images"]] == names
        for folder in ("a", "b b", "c"):
            assert (target.parent / folder / "color.png").read_text() == f"picture of {folder}"

    @pytest.mark.parametrize("piped", [False, True])
    def test_a_buffer_takes_no_name_of_an_image(self, piped: bool, tmp_path: Path) -> None:
        document = Gltf()
        document.json["images"] = [{"uri": "box.bin"}]
        document.mesh(document.box(fine=True))
        source, target = tmp_path / "box.glb", tmp_path / "box.gltf"
        write(source, document.glb())
        write(tmp_path / "box.bin", "picture")
        scene = read(source.read_bytes() if piped else source, "glb")
        write_scene(scene, simplify_scene(scene, Options())[0], target, "gltf", Options())
        assert (tmp_path / "box.bin").read_text() == "picture"
        assert [entry["uri"] for entry in json.loads(target.read_text())["buffers"]] == ["light_box.bin"]

    def test_over_itself_and_into_a_glb(self, tmp_path: Path) -> None:
        source = self.document(tmp_path)
        before = read_gltf_scene(source)
        simplify_to(source, tmp_path / "out.glb")
        assert_same_scene(read_gltf_scene(source), read_gltf_scene(tmp_path / "out.glb"))
        assert len(read_gltf_scene(tmp_path / "out.glb")["images"]) == 1
        large = (tmp_path / "shape.bin").stat().st_size
        simplify_to(source, source)
        assert next(entry["uri"] for entry in json.loads(source.read_text())["buffers"]) == "shape.bin"
        assert (tmp_path / "shape.bin").stat().st_size < large / 3
        assert_same_scene(before, read_gltf_scene(source))


@pytest.mark.parametrize("suffix", ["obj", "ply", "stl", "off", "gltf"])
def test_what_stands_around_the_surface_is_told_where_it_is_lost(suffix: str, tmp_path: Path) -> None:
    document = everything_around()
    document.json["meshes"][0]["primitives"].append({**document.box(), "mode": 1})
    scene = read(document.glb(), "glb")
    results, _ = simplify_scene(scene, Options())
    told = write_scene(scene, results, tmp_path / f"out.{suffix}", suffix, Options()).warnings
    assert [text for text in told if "glTF document" in text] == [
        f"{suffix.upper()} cannot store points and lines, cameras, lights, animations,"
        " wrap and filter of textures, tree of nodes, names of nodes, extras of the glTF document: lost"
    ] * (suffix != "gltf")


@pytest.mark.parametrize("suffix", ["gltf", "glb"])
def test_a_document_that_loses_nothing_is_written_byte_for_byte(suffix: str, tmp_path: Path) -> None:
    document = Gltf()
    points, faces = box()
    # The first two are cut along the other diagonal.
    faces = np.array([[0, 1, 2], [1, 3, 2], *faces[2:, ::-1].tolist()])
    position = document.accessor(points)
    document.mesh({"attributes": {"POSITION": position}, "indices": document.accessor(faces.reshape(-1), "u2")})
    source, target = tmp_path / f"in.{suffix}", tmp_path / f"out.{suffix}"
    # Spaces of its own, which no writer would make.
    write(source, document.glb() if suffix == "glb" else document.gltf().replace(b'"asset":', b'"asset"  :\n\n'))
    report = simplify_to(source, target)
    assert target.read_bytes() == source.read_bytes()
    assert report.after.bytes == report.before.bytes


@pytest.mark.parametrize("line", ["", "\n"])
def test_compact_text_stays_compact(line: str, tmp_path: Path) -> None:
    document = Gltf()
    document.mesh(document.box(fine=True), name="box")
    source = write(tmp_path / "in.gltf", document.gltf().replace(b", ", b"," + line.encode()))
    target = tmp_path / "out.gltf"
    report = simplify_to(source, target)
    assert (b"\n" in target.read_bytes()) == bool(line)
    assert report.after.triangles == 12
