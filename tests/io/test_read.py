"""Reading: every format gives the same mesh; what is damaged is refused in one clear line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import painted
import pytest
from shapes import (
    FAR,
    Gltf,
    box,
    box_quads,
    collect_triangles,
    concave_polygon_obj,
    fine_box,
    obj_text,
    off_text,
    open_cone,
    ply_bytes,
    stl_bytes,
    stl_text,
    write,
)  # fmt: skip

from bldsimp import InputError
from bldsimp.inspection import count_defects
from bldsimp.io import read
from bldsimp.model import Mesh, Scene
from bldsimp.tolerance import measure_spacing


def read_mesh(content: str | bytes, format_: str) -> Mesh:
    scene = read_scene(content, format_)
    assert len(scene.meshes) == 1
    return scene.meshes[0]


def read_scene(content: str | bytes, format_: str) -> Scene:
    return read(content.encode() if isinstance(content, str) else content, format_)


def find_values(mesh: Mesh, name: str) -> np.ndarray:
    return next(one.values for one in mesh.attributes if one.name == name)


def measure_area(mesh: Mesh) -> float:
    a, b, c = (mesh.points[mesh.faces[:, i]] for i in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


@pytest.mark.parametrize("shift", FAR)
@pytest.mark.parametrize("format_", ["obj", "off", "ascii", "little", "big", "double", "stl"])
def test_the_same_box_from_every_format(format_: str, shift: float) -> None:
    points, faces = box(shift=shift)
    files = {
        "obj": ("obj", obj_text(points, faces)),
        "off": ("off", off_text(points, faces)),
        "ascii": ("ply", ply_bytes(points, faces, encoding="ascii")),
        "little": ("ply", ply_bytes(points, faces)),
        "big": ("ply", ply_bytes(points, faces, encoding="binary_big_endian")),
        "double": ("ply", ply_bytes(points, faces, kind="double")),
        "stl": ("stl", stl_text(points, faces)),
    }
    suffix, content = files[format_]
    mesh = read_mesh(content, suffix)
    assert collect_triangles(mesh.points, mesh.faces) == collect_triangles(points, faces)
    assert count_defects(mesh.points, mesh.faces).watertight
    assert mesh.single  # all coordinates are whole numbers below 2**24


@pytest.mark.parametrize("write_as", [obj_text, off_text, ply_bytes])
def test_polygons_keep_their_area_and_winding(write_as) -> None:
    points, quads = box_quads()
    mesh = read_mesh(write_as(points, quads), {obj_text: "obj", off_text: "off", ply_bytes: "ply"}[write_as])
    assert len(mesh.faces) == 12
    assert measure_area(mesh) == pytest.approx(24.0)
    assert count_defects(mesh.points, mesh.faces).watertight


def test_a_concave_polygon_is_not_cut_as_a_fan() -> None:
    mesh = read_mesh(concave_polygon_obj(), "obj")
    assert measure_area(mesh) == pytest.approx(3.0)  # the fan from its first corner has more
    assert len(mesh.faces) == 2


def test_ply_with_triangles_and_quads_mixed() -> None:
    points, quads = box_quads()
    polygons = [quads[0][:3], (quads[0][0], *quads[0][2:]), *quads[1:]]
    for encoding in ("ascii", "binary_little_endian", "binary_big_endian"):
        mesh = read_mesh(ply_bytes(points, polygons, encoding=encoding), "ply")
        assert measure_area(mesh) == pytest.approx(24.0)
        assert len(mesh.faces) == 12


class TestObj:
    def test_objects_groups_and_materials_are_parts_of_one_mesh(self) -> None:
        points, faces = box()
        lines = obj_text(points, faces).splitlines()
        lines[8:8] = ["o house", "g walls front", "usemtl brick"]
        lines[15:15] = ["g roof"]
        lines[18:18] = ["usemtl tiles"]
        lines[20:20] = ["g walls front", "usemtl brick"]
        mesh = read_mesh("\n".join(lines), "obj")
        assert [part.name for part in mesh.parts] == [
            "house / walls front / brick", "house / roof / brick", "house / roof / tiles",
        ]  # fmt: skip
        assert np.bincount(mesh.part_of_face).tolist() == [9, 2, 1]
        assert len(mesh.points) == 8

    def test_negative_indices_count_back_from_the_face(self) -> None:
        text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 1\nf -4 -1 -2\n"
        mesh = read_mesh(text, "obj")
        assert collect_triangles(mesh.points, mesh.faces) == {
            ((0, 0, 0), (1, 0, 0), (0, 1, 0)), ((0, 0, 0), (0, 0, 1), (0, 1, 0)),
        }  # fmt: skip

    def test_lines_go_on_after_a_backslash(self) -> None:
        points, faces = box()
        text = obj_text(points, faces)
        assert collect_triangles(*read_arrays(text.replace(" ", " \\\n ", 40))) == collect_triangles(points, faces)

    def test_windows_line_ends_tabs_and_comments(self) -> None:
        points, faces = box()
        text = obj_text(points, faces).replace("\n", "\r\n").replace("v ", "v\t") + "# done\r\n"
        assert collect_triangles(*read_arrays(text)) == collect_triangles(points, faces)

    def test_a_byte_order_mark_and_bare_carriage_returns(self) -> None:
        points, faces = box()
        mesh = read_mesh(b"\xef\xbb\xbf" + obj_text(points, faces).replace("\n", "\r").encode(), "obj")
        assert collect_triangles(mesh.points, mesh.faces) == collect_triangles(points, faces)

    def test_faces_of_two_corners_are_left_out_and_told(self) -> None:
        scene = read_scene("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1// 2//\nf 1// 2// 3//\nf 1 1 2\n", "obj")
        assert len(scene.meshes[0].faces) == 1
        assert scene.warnings == ["removed 2 faces with fewer than three distinct corners"]

    def test_corner_forms_may_differ_within_a_file(self) -> None:
        text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvn 0 0 1\nf 1 2 3\nf 1//1 2//1 3//1\nf 1/1 3/1/1 4\n"
        mesh = read_mesh(text, "obj")
        assert len(mesh.faces) == 3
        assert mesh.parts[0].attributes == ("TEXCOORD_0",)
        assert mesh.normals is not None
        assert not mesh.normals[mesh.faces[0]].any()
        assert mesh.normals[mesh.faces[1]].tolist() == [[0, 0, 1]] * 3

    def test_colors_that_are_no_numbers_are_left_out_and_told(self) -> None:
        points, faces = box()
        text = "".join(
            line + (" 0.5 nan 1" if line.startswith("v ") else "") + "\n"
            for line in obj_text(points, faces).splitlines()
        )
        scene = read_scene(text, "obj")
        mesh = scene.meshes[0]
        assert mesh.parts[0].attributes == ()
        assert scene.warnings == ["ignored the colors of 8 OBJ points, which are no numbers"]
        assert collect_triangles(mesh.points, mesh.faces) == collect_triangles(points, faces)

    def test_short_normals_and_texture_coordinates_are_filled_up(self) -> None:
        mesh = read_mesh("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5\nvn 0 1\nf 1/1/1 2/1/1 3/1/1\n", "obj")
        assert mesh.normals is not None
        assert mesh.normals.tolist() == [[0, 1, 0]] * 3
        assert find_values(mesh, "TEXCOORD_0").tolist() == [[0.5, 0]] * 3

    def test_lines_and_curves_are_told(self) -> None:
        scene = read_scene("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\nl 2 3\n", "obj")
        assert scene.warnings == ["ignored 2 OBJ lines that start with 'l'"]

    def test_what_it_names_is_told_and_no_image_is_read_twice(self, tmp_path: Path, monkeypatch) -> None:
        folder = tmp_path / "materials"
        folder.mkdir()
        write(tmp_path / "box.obj", painted.obj(library="materials/m.mtl"))
        write(folder / "m.mtl", "newmtl wall\nmap_Kd wall.png\nmap_d gone.png\nnewmtl roof\nbump roof.png\n")
        for name in ("wall.png", "roof.png"):
            write(folder / name, painted.WALL)
        opened, read_bytes = [], Path.read_bytes

        def counted(path: Path) -> bytes:
            opened.append(path.name)
            return read_bytes(path)

        monkeypatch.setattr(Path, "read_bytes", counted)
        scene = read(tmp_path / "box.obj", "obj")
        assert sorted(scene.beside) == ["materials/m.mtl", "materials/roof.png", "materials/wall.png"]
        assert sorted(opened) == sorted({*opened})


def read_arrays(text: str) -> tuple[np.ndarray, np.ndarray]:
    mesh = read_mesh(text, "obj")
    return mesh.points, mesh.faces


class TestAttributes:
    def test_ply_colors_and_normals(self) -> None:
        points, faces = box()
        head = "ply\nformat ascii 1.0\nelement vertex 8\n"
        head += "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
        head += "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
        head += "element face 12\nproperty list uchar int vertex_indices\nend_header\n"
        body = "".join(f"{x} {y} {z} 0 0 1 255 0 {i}\n" for i, (x, y, z) in enumerate(points))
        body += "".join(f"3 {a} {b} {c}\n" for a, b, c in faces)
        mesh = read_mesh(head + body, "ply")
        assert mesh.parts[0].attributes == ("COLOR_0",)
        assert mesh.normals is not None
        assert mesh.normals.tolist() == [[0, 0, 1]] * 8
        assert find_values(mesh, "COLOR_0")[3].tolist() == [1.0, 0.0, 3 / 255]

    def test_off_with_normals_and_with_colors(self) -> None:
        text = "NOFF # a comment\n\n3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n"
        mesh = read_mesh(text, "off")
        assert mesh.normals is not None
        assert mesh.parts[0].attributes == ()
        colored = read_mesh("COFF\n3 1 0\n0 0 0 9 9 9 255\n1 0 0 9 9 9 255\n0 1 0 9 9 9 255\n3 0 1 2\n", "off")
        assert colored.parts[0].attributes == ("COLOR_0",)
        faced = read_mesh("OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 255 0 0\n", "off")
        assert faced.parts[0].attributes == ("FACE_COLOR_0",)

    def test_stl_solids_are_parts_of_one_mesh(self) -> None:
        points, faces = box()
        mesh = read_mesh(stl_text(points, faces[:6], "left") + stl_text(points, faces[6:], "right"), "stl")
        assert [part.name for part in mesh.parts] == ["left", "right"]
        assert np.bincount(mesh.part_of_face).tolist() == [6, 6]
        assert count_defects(mesh.points, mesh.faces).watertight


class TestNumberFormat:
    def test_six_written_decimals_are_rounding(self) -> None:
        points, faces = open_cone()
        rounded = np.round(points + 3.0, 6)
        mesh = read_mesh(obj_text(rounded, faces), "obj")
        assert (mesh.single, mesh.rounding) == (False, 5e-7)
        assert measure_spacing(mesh) == 1e-6

    def test_few_digits_are_exact(self) -> None:
        points, faces = box(size=0.3)
        mesh = read_mesh(obj_text(points, faces), "obj")
        assert (mesh.single, mesh.rounding) == (False, 0.0)
        assert measure_spacing(mesh) == np.spacing(0.3)

    def test_trailing_zeros_are_no_digits(self) -> None:
        mesh = read_mesh("v 0.300000 0 0\nv 1.100000 0 0\nv 0 1.700000 0\nf 1 2 3\n", "obj")
        assert mesh.rounding == 0.0

    def test_binary_single(self) -> None:
        points, faces = open_cone()
        mesh = read_mesh(ply_bytes(points + 500_000.0, faces), "ply")
        assert mesh.single
        assert measure_spacing(mesh) == 2.0**-5

    def test_unused_points_do_not_count(self) -> None:
        points, faces = box()
        mesh = read_mesh(obj_text(np.vstack([points, [[1e30, 0.1, np.nan]]]), faces), "obj")
        assert mesh.single
        assert measure_spacing(mesh) == 2.0**-22


BROKEN = {
    "an empty file": ("obj", "", "empty"),
    "points without faces": ("obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no faces"),
    "an OBJ index that is too large": ("obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "line 4"),
    "an OBJ index 0": ("obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", "line 4"),
    "an OBJ index that counts back too far": ("obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 1 2\n", "line 4"),
    "an OBJ texture index that is too large": ("obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/1 3/1\n", "'vt'"),
    "an OBJ point cut short": ("obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nv 1 2", "vertex 4"),
    "an OBJ face without a corner": ("obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf\n", "no faces"),
    "an OBJ index that is a sign alone": ("obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 - 2 3\n", "without a vertex number"),
    "an OBJ coordinate that is a sign alone": ("obj", "v 0 0 0\nv 1 - 0 0\nv 0 1 0\nf 1 2 3\n", "'-' is not a number"),
    "an OBJ of words": ("obj", "v zero 0 0\nf 1 1 1\n", "'zero' is not a number"),
    "a PLY without header": ("ply", "plywood", "no PLY header"),
    "a PLY of a kind unknown": ("ply", "ply\nformat morse 1.0\nend_header\n", "'morse'"),
    "a PLY without values": ("ply", "ply\nformat ascii 1.0\nelement v 1\nproperty int x\nend_header\n\n", "ends early"),
    "a PLY of odd types": ("ply", "ply\nformat ascii 1.0\nelement v 1\nproperty quad x\nend_header\n", "x"),
    "an OFF without header": ("off", "3 1 0\n", "no OFF header"),
    "an OFF cut short": ("off", off_text(*box())[:-20], "ends early"),
    "an OFF in binary": ("off", "OFF BINARY\n", "binary OFF"),
    "an OFF index that is too large": ("off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "do not exist"),
    "an OFF face of too few corners": ("off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4 0 1 2\n", "fewer corners"),
    "an STL text of no face": ("stl", "solid a\nendsolid a\n", "no faces"),
    "an STL text cut in its first face": ("stl", "solid a\nfacet\n", "after 0 whole ones"),
    "an STL text cut in a word": ("stl", stl_text(*box())[:-30], "after 11 whole ones: it is truncated"),
    "an STL cut in its header": ("stl", stl_bytes(*box())[:60], "within its header"),
    "an STL cut in a face": ("stl", stl_bytes(*box())[:-30], "promises 12 faces, and 11 fit in its 654 bytes"),
    "an STL cut that begins like text": (
        "stl", stl_bytes(*box(), head=b"solid box")[:-60], "promises 12 faces, and 10 fit"
    ),
    "an STL that promises too much": (
        "stl", stl_bytes(*box(), count=4_000_000_000), "promises 4,000,000,000 faces, and 12 fit"
    ),
    "an STL that promises nothing": ("stl", stl_bytes(*box(), count=0), "no face, though 12 would fit"),
}  # fmt: skip


@pytest.mark.parametrize("case", BROKEN)
def test_broken_files_are_refused_in_one_line(case: str) -> None:
    format_, content, told = BROKEN[case]
    with pytest.raises(InputError, match=told) as caught:
        read_scene(content, format_)
    assert str(caught.value).startswith("standard input: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("data", [stl_bytes(*box()), stl_text(*box()).encode()], ids=["binary", "text"])
def test_every_truncation_of_an_stl_is_refused(data: bytes) -> None:
    for length in range(0, data.rfind(b"endfacet") if data[:5] == b"solid" else len(data), 7):
        with pytest.raises(InputError, match=r"truncated|empty|whole"):
            read(data[:length], "stl")


def test_bytes_after_the_faces_of_an_stl_are_left_out_and_told() -> None:
    scene = read(stl_bytes(*box()) + b"made by hand", "stl")
    assert len(scene.meshes[0].faces) == 12
    assert scene.warnings == ["ignored 12 bytes after the 12 faces of the STL file"]


@pytest.mark.parametrize("kind", ["ascii", "little", "big", "mixed"])
def test_every_truncation_of_a_ply_is_refused(kind: str) -> None:
    points, faces = box()
    polygons = [tuple(face) for face in faces] + ([(0, 1, 3, 2)] if kind == "mixed" else [])
    encoding = {"ascii": "ascii", "big": "binary_big_endian"}.get(kind, "binary_little_endian")
    data = ply_bytes(points, polygons, encoding=encoding)
    read(data, "ply")
    for length in range(0, len(data) - 2, 7):
        with pytest.raises(InputError):
            read(data[:length], "ply")


def test_points_that_are_not_finite_are_named_up_to_ten() -> None:
    points, faces = fine_box()
    points[:12, 1] = np.inf
    with pytest.raises(InputError, match=r"12 points .* 0, 1, 2, 3, 4, 5, 6, 7, 8, 9 \.\.\."):
        read_scene(obj_text(points, faces), "obj")


def test_missing_file_and_directory(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read(tmp_path / "none.obj", "obj")
    with pytest.raises(InputError, match="cannot be read"):
        read(tmp_path, "obj")


def test_size_counts_the_buffers_beside(tmp_path: Path) -> None:
    document = Gltf()
    document.mesh(document.box())
    write(tmp_path / "box.bin", bytes(document.data))
    path = write(tmp_path / "box.gltf", document.gltf("box.bin"))
    assert read(path, "gltf").size == path.stat().st_size + len(document.data)


def test_every_model_is_read_or_refused_for_a_reason(models: Path) -> None:
    refused = {}
    for path in sorted(models.rglob("*")):
        suffix = path.suffix.lower()[1:]
        if suffix not in ("obj", "ply", "off", "stl", "glb", "gltf"):
            continue
        try:
            scene = read(path, suffix)
        except InputError as error:
            refused[path.name] = str(error)
            continue
        for mesh in scene.meshes:
            assert len(mesh.faces) == len(mesh.part_of_face) > 0
            assert mesh.faces.max() < len(mesh.points)
            assert mesh.faces.dtype == np.int32
    assert set(refused) == {"trimesh_empty.ply", "trimesh_points_emptyface.ply"}


def test_the_wall_with_a_window_has_the_area_of_its_outlines(models: Path) -> None:
    # Its two large faces are rings with a slit to the window: a fan covers the window and more.
    mesh = read(models / "broken" / "trimesh_wallhole.obj", "obj").meshes[0]
    plain = count_defects(mesh.points, mesh.faces)
    assert plain.open_edges == plain.nonmanifold_edges == 0
