"""glTF made of other formats: valid, and textured as they were."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT
from gltf_cases import png
from gltf_scene import Contents
from khronos import list_issues
from shapes import box, fine_box, off_text, stl_bytes, write

from bldsimp import Options
from bldsimp.io import read
from bldsimp.io import write as write_scene
from bldsimp.scene import simplify_scene

DATA = ROOT / "data"


def convert(source: Path, *targets: Path) -> list[Path]:
    """Simplify a file, and write it in other formats."""
    scene = read(source, source.suffix[1:])
    results, _ = simplify_scene(scene, Options())
    for target in targets:
        write_scene(scene, results, target, target.suffix[1:], Options())
    return list(targets)


def make_colored_ply() -> bytes:
    points, faces = fine_box()
    head = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n" + "".join(f"property float {n}\n" for n in "xyz")
    head += "".join(f"property uchar {n}\n" for n in ("red", "green", "blue"))
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    body = "".join(f"{x} {y} {z} 255 0 {int(60 * x)}\n" for x, y, z in points)
    return (head + body + "".join(f"3 {a} {b} {c}\n" for a, b, c in faces)).encode()


def write_textured_obj(folder: Path) -> Path:
    """Two boxes in two materials, one with a picture, one with normals that are no face's."""
    points, faces = box()
    brick = "newmtl brick\nKd 1 0.5 0\nmap_Kd -s 4 4 1 -o 0.5 0 0 -clamp on brick.png\nKe 2 1 0\nPr 0.5\n"
    write(folder / "a.mtl", brick + "newmtl plain\nKd 0 1 0\nd 0.5\n")
    write(folder / "brick.png", png(16, 16))
    lines = ["mtllib a.mtl", *(f"v {x} {y} {z}" for x, y, z in np.vstack([points, points + 9.0]))]
    lines += [f"vt {x / 2} {y / 2}" for x, y, _ in points]
    lines += [f"vn {x} {y} {z}" for x, y, z in (points - 1.0) / np.sqrt(3.0)]
    lines += ["usemtl brick", *(f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in faces + 1)]
    lines += ["usemtl plain", *("f " + " ".join(f"{i + 8}//{i}" for i in face) for face in (faces + 1).tolist())]
    return write(folder / "a.obj", "\n".join(lines) + "\n")


@pytest.mark.parametrize("name", ["building_a.obj", "house_textured.obj", "ply", "off", "stl", "obj"])
def test_what_is_made_has_no_error_and_no_warning(name: str, tmp_path: Path) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    made = {
        "ply": lambda: write(folder / "a.ply", make_colored_ply()),
        "off": lambda: write(folder / "a.off", off_text(*fine_box())),
        "stl": lambda: write(folder / "a.stl", stl_bytes(*fine_box())),
        "obj": lambda: write_textured_obj(folder),
    }
    source = made[name]() if name in made else DATA / name
    assert not any(list_issues(*convert(source, tmp_path / "out.glb", tmp_path / "out.gltf")))


def test_pictures_and_coordinates_come_along(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    [target] = convert(write_textured_obj(tmp_path / "in"), tmp_path / "out.glb")
    found = Contents(target)
    brick, plain = found.json["meshes"][0]["primitives"]
    assert set(brick["attributes"]) == {"POSITION", "TEXCOORD_0"}
    assert set(plain["attributes"]) == {"POSITION", "NORMAL"}
    picture = found.json["images"][0]
    assert found.view(picture["bufferView"]) == (tmp_path / "in" / "brick.png").read_bytes()
    points, uv = (found.values(brick["attributes"][key]) for key in ("POSITION", "TEXCOORD_0"))
    assert np.allclose(uv, np.stack([points[:, 0] / 2, 1.0 - points[:, 1] / 2], axis=1))


def test_what_lets_light_through_is_blended(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    [target] = convert(write_textured_obj(tmp_path / "in"), tmp_path / "out.glb")
    brick, plain = Contents(target).json["materials"]
    assert "alphaMode" not in brick
    assert plain["alphaMode"] == "BLEND"
    assert plain["pbrMetallicRoughness"]["baseColorFactor"] == [0.0, 1.0, 0.0, 0.5]


@pytest.mark.parametrize("alpha", [255, 100])
def test_colors_of_alpha_are_blended(alpha: int, tmp_path: Path) -> None:
    prop = "".join(f"property uchar {n}\n" for n in ("red", "green", "blue", "alpha"))
    source = write(tmp_path / "in.ply", make_ply(prop, f"255 0 0 {alpha}", f"255 0 0 {alpha}"))
    [target] = convert(source, tmp_path / "out.glb")
    json_ = Contents(target).json
    primitive = json_["meshes"][0]["primitives"][0]
    modes = [json_["materials"][primitive["material"]]["alphaMode"]] if "material" in primitive else []
    assert modes == (["BLEND"] if alpha < 255 else [])
    assert not any(list_issues(target))


def test_an_alpha_of_a_material_fades_colors_of_points(tmp_path: Path) -> None:
    points, faces = box()
    write(tmp_path / "a.mtl", "newmtl glass\nKd 0 1 0\nd 0.5\n")
    lines = ["mtllib a.mtl", *(f"v {x} {y} {z} 1 0 0" for x, y, z in points), "usemtl glass"]
    lines += [f"f {a} {b} {c}" for a, b, c in faces + 1]
    [target] = convert(write(tmp_path / "in.obj", "\n".join(lines) + "\n"), tmp_path / "out.glb")
    [glass] = Contents(target).json["materials"]
    assert glass["alphaMode"] == "BLEND"
    assert glass["pbrMetallicRoughness"]["baseColorFactor"] == [1.0, 1.0, 1.0, 0.5]


def make_ply(prop: str, of_points: str, of_faces: str) -> bytes:
    """A box whose points and faces have the same properties."""
    points, faces = fine_box()
    head = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n" + "".join(f"property float {n}\n" for n in "xyz")
    head += f"{prop}element face {len(faces)}\nproperty list uchar int vertex_indices\n{prop}end_header\n"
    rows = [f"{x} {y} {z} {of_points}\n" for x, y, z in points] + [f"3 {a} {b} {c} {of_faces}\n" for a, b, c in faces]
    return (head + "".join(rows)).encode()


SAME = {
    "COLOR_0": ("".join(f"property uchar {n}\n" for n in ("red", "green", "blue")), "255 0 0", "0 255 0", (0, 1, 0)),
    "_label": ("property int label\n", "1", "2", (2,)),
}


@pytest.mark.parametrize("suffix", ["glb", "obj"])
@pytest.mark.parametrize("name", SAME)
def test_what_faces_carry_wins_over_the_same_of_points(name: str, suffix: str, tmp_path: Path) -> None:
    prop, of_points, of_faces, wanted = SAME[name]
    scene = read(write(tmp_path / "in.ply", make_ply(prop, of_points, of_faces)), "ply")
    results, _ = simplify_scene(scene, Options())
    target = tmp_path / f"out.{suffix}"
    written = write_scene(scene, results, target, suffix, Options())
    word = {"COLOR_0": "colors", "_label": "'label'"}[name]
    held = suffix == "glb" or name == "COLOR_0"
    assert any(f"cannot store {word} of both" in told for told in written.warnings) == held
    assert any(f"cannot store {word}" in told for told in written.warnings)
    (mesh,) = read(target, suffix).meshes
    found = {own.name: own.values for own in mesh.attributes}
    assert set(found) == ({name} if held else set())
    assert all(np.allclose(values, wanted) for values in found.values())


def test_faces_without_texture_coordinates_show_no_texture(tmp_path: Path) -> None:
    points, faces = box()
    write(tmp_path / "brick.png", png(16, 16))
    write(tmp_path / "a.mtl", "newmtl brick\nKd 0 1 0\nmap_Kd brick.png\n")
    lines = ["mtllib a.mtl", *(f"v {x} {y} {z}" for x, y, z in points), *(f"vt {x} {y}" for x, y, _ in points)]
    textured, bare = faces[:4] + 1, faces[4:] + 1
    lines += ["usemtl brick", *(f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in textured)]
    lines += [f"f {a} {b} {c}" for a, b, c in bare]
    [target] = convert(write(tmp_path / "in.obj", "\n".join(lines) + "\n"), tmp_path / "out.glb")
    found = Contents(target)
    seen = {}
    for primitive in found.json["meshes"][0]["primitives"]:
        metallic = found.json["materials"][primitive["material"]]["pbrMetallicRoughness"]
        assert metallic["baseColorFactor"] == [0.0, 1.0, 0.0, 1.0]
        assert ("baseColorTexture" in metallic) == ("TEXCOORD_0" in primitive["attributes"])
        seen["baseColorTexture" in metallic] = len(found.values(primitive["indices"]).reshape(-1)) // 3
    assert seen == {True: len(textured), False: len(bare)}
    assert not any(list_issues(target))


MODELS = ("cesium_house-3-0.glb", "kaykit_building_H/building_H.gltf", "kenney_building-small-a.glb")


@pytest.mark.parametrize("name", MODELS)
def test_by_way_of_obj_and_back(name: str, models: Path, tmp_path: Path) -> None:
    [between] = convert(models / "textured" / name, tmp_path / "between.obj")
    assert not any(list_issues(*convert(between, tmp_path / "out.glb")))
