"""glTF documents that are damaged, or odd: a result, or one error that says what is wrong."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gltf_cases import CASES, simplify_glb, textured
from shapes import Gltf, box, split_glb

from bldsimp import InputError, Options, OutputError, Tolerance
from bldsimp.io import read
from bldsimp.io import write as write_scene
from bldsimp.io.gltf import patch as gltf_patch
from bldsimp.options import DELIMITS
from bldsimp.scene import simplify_scene


def spoil(change) -> bytes:
    document = Gltf()
    document.mesh(document.box())
    change(document)
    return document.glb()


WRONG_INDICES = "not a list of unsigned whole numbers"
WRONG_FORMAT = "does not follow the format"

BROKEN = {
    "an index out of range": (
        lambda d: d.json["accessors"][1].update(count=7),
        "mesh 0, primitive 0: .* name points that do not exist",
    ),
    "indices with a sign": (
        lambda d: d.json["accessors"][0].update(componentType=5122),
        WRONG_INDICES,
    ),
    "indices with a fraction": (
        lambda d: d.json["accessors"][0].update(componentType=5126, count=18),
        WRONG_INDICES,
    ),
    "indices in pairs": (
        lambda d: d.json["accessors"][0].update(type="VEC2", count=18),
        WRONG_INDICES,
    ),
    "a sparse place with a sign": (
        lambda d: d.json["accessors"][1].update(
            sparse={"count": 1, "indices": {"bufferView": 0, "componentType": 5120}, "values": {"bufferView": 1}}
        ),
        "sparse in a way that is not understood",
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
    "a number that is none": (lambda d: d.json["nodes"][0].update(scale=[np.nan, 1, 1]), "contains NaN"),
    "nodes that scale without end": (
        lambda d: d.json.update(nodes=[{"children": [i + 1], "scale": [1e10] * 3} for i in range(40)] + [{"mesh": 0}]),
        "beyond 1e100",
    ),
    "a buffer of a number": (lambda d: d.json.update(buffers=[{"uri": 7}]), "the URI of glTF buffer 0 is not text"),
    "an image of nothing": (lambda d: d.json.update(images=[{}]), "image 0 has neither"),
    "an image of a number": (lambda d: d.json.update(images=[{"uri": 7}]), "image 0 has neither"),
    "an image of no view": (lambda d: d.json.update(images=[{"bufferView": 9}]), "no entry 9"),
    "a color of words": (
        lambda d: (
            d.json["meshes"][0]["primitives"][0].update(material=0),
            d.json.update(materials=[{"pbrMetallicRoughness": {"baseColorFactor": ["red"] * 4}}]),
        ),
        WRONG_FORMAT,
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
        read(spoil(change), "glb")


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
        (
            lambda d: d.json["nodes"].append({"extensions": {"EXT_mesh_gpu_instancing": []}}),
            WRONG_FORMAT,
        ),
    ],
)
def test_what_no_mesh_uses_is_told_on_writing(change, told: str) -> None:
    scene = read(spoil(change).replace(b"Infinity", b"1e400   "), "glb")
    results, _ = simplify_scene(scene, Options())
    with pytest.raises(OutputError, match=told):
        write_scene(scene, results, io.BytesIO(), "glb", Options())


def test_a_bug_of_ours_is_not_told_as_damage(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object, **__: object) -> bytes:
        raise KeyError("ours")

    document = Gltf()
    document.mesh(document.box(fine=True))
    scene = read(document.glb(), "glb")
    results, _ = simplify_scene(scene, Options())
    monkeypatch.setattr(gltf_patch, "replace_accessors", broken)
    with pytest.raises(KeyError, match="ours"):
        write_scene(scene, results, io.BytesIO(), "glb", Options())


WRONG = (None, -1, 10**9, 1.5, True, "x", [], [{}], {}, {"x": []})


def list_places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Where the members of JSON are."""
    members = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, member in members:
        yield (*path, key)
        yield from list_places(member, (*path, key))


def simplify_or_explain(data: bytes, options: Options) -> bytes | str:
    """A light GLB, or the one line that says why there is none."""
    target = io.BytesIO()
    try:
        scene = read(data, "glb")
        results, _ = simplify_scene(scene, options)
        write_scene(scene, results, target, "glb", options)
    except (InputError, OutputError) as error:
        return str(error)
    return target.getvalue()


@pytest.mark.filterwarnings("ignore:invalid value encountered in cast")
@pytest.mark.parametrize("case", ["everything around", "sparse", "variants", "features"])
@pytest.mark.parametrize("words", [DELIMITS, ("material",)])
def test_whatever_stands_in_the_json_ends_in_a_result_or_one_error(case: str, words: tuple[str, ...]) -> None:
    document, options = CASES[case](), Options(delimit=frozenset(words))
    text, random = json.dumps(document.json), np.random.default_rng(0)
    written = 0
    for path in list_places(json.loads(text)):
        document.json = json.loads(text)
        holder = document.json
        for key in path[:-1]:
            holder = holder[key]
        holder[path[-1]] = WRONG[random.integers(len(WRONG))]
        found = simplify_or_explain(document.glb(), options)
        if isinstance(found, str):
            assert "\n" not in found
        else:
            written += 1
            read(found, "glb")
    assert written > 0


@pytest.mark.parametrize("number", ["count", "byteOffset"])
def test_what_trims_a_view_takes_any_accessor(number: str, tmp_path: Path) -> None:
    """One of a component type that only an extension knows keeps its view whole, and a count may be written 98.0."""
    document = Gltf()
    document.mesh(document.box(fine=True))
    position = document.json["accessors"][1]
    position["count"] = 98.0
    document.json["accessors"].append({**position, "componentType": 5130, number: 1})
    document.json["animations"] = [{"channels": [], "samplers": [{"input": 2, "output": 2}]}]
    _, after = simplify_glb(document.glb(), tmp_path / "out.glb")
    json_, binary = split_glb(after)
    odd = json_["accessors"][json_["animations"][0]["samplers"][0]["input"]]
    view = json_["bufferViews"][odd["bufferView"]]
    before = document.json["bufferViews"][1]
    stored = document.data[before["byteOffset"] : before["byteOffset"] + before["byteLength"]]
    assert binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]] == stored


def test_json_may_be_nested_as_deep_as_it_can_be_read(tmp_path: Path) -> None:
    deep: dict = {}
    for _ in range(700):
        deep = {"a": deep}
    document = Gltf()
    document.mesh({**document.box(fine=True), "material": 0})
    document.json.update(materials=[{"extensions": {"ACME_deep": deep}}], extras=deep)
    for words in (DELIMITS, ()):
        _, after = simplify_glb(document.glb(), tmp_path / "out.glb", Options(delimit=frozenset(words)))
        assert split_glb(after)[0]["extras"] == deep


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
    document.mesh(primitive)
    with pytest.raises(InputError, match=r"not finite .*: 3:"):
        read(document.glb(), "glb")


@pytest.mark.parametrize(("uri", "told"), [("data:image/png,%89PNG%0D%0A", 0), ("data:image/png;base64,!", 1)])
@pytest.mark.parametrize("suffix", ["gltf", "glb", "obj"])
def test_no_data_uri_of_an_image_refuses_a_mesh(uri: str, told: int, suffix: str, tmp_path: Path) -> None:
    document = Gltf()
    document.mesh(textured(document))
    document.json["images"] = [{"uri": uri}]
    scene = read(document.gltf(), "gltf")
    assert [bool("image 0 cannot be decoded" in text) for text in scene.warnings] == [True] * told
    results, _ = simplify_scene(scene, Options())
    target = tmp_path / f"out.{suffix}"
    write_scene(scene, results, target, suffix, Options())
    if suffix == "gltf":
        assert json.loads(target.read_bytes())["images"] == [{"uri": uri}]


def test_a_buffer_of_no_base64_is_an_error() -> None:
    document = Gltf()
    document.mesh(document.box())
    with pytest.raises(InputError, match="data URI of glTF buffer 0 cannot be decoded"):
        read(document.gltf("data:application/octet-stream;base64,!"), "gltf")
