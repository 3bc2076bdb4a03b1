"""Writing: stored numbers stay what they are, what is rounded is told, nothing is lost in silence."""

from __future__ import annotations

import io
import json
import os
from pathlib import Path

import numpy as np
import pytest
from batch_runs import leave_file
from shapes import (
    FAR,
    Gltf,
    box,
    box_quads,
    fine_box,
    obj_text,
    off_text,
    open_cone,
    ply_bytes,
    split_glb,
    write,
)

from bldsimp import Options, OutputError
from bldsimp.cli import main
from bldsimp.inspection import count_defects
from bldsimp.io import WRITABLE, Written, read
from bldsimp.io import write as write_scene
from bldsimp.io.atomic import ABANDONED_SECONDS, clear_leftovers, replace_files
from bldsimp.io.flat_mesh import FlatMesh, apply_uv_maps
from bldsimp.io.single_precision import choose_origin, measure_rounding
from bldsimp.material import Material, UvMap
from bldsimp.model import Attribute, Part, Scene
from bldsimp.scene import simplify_scene
from bldsimp.tolerance import transform_points


def convert(source: Path, target: Path, options: Options | None = None) -> Written:
    """Simplify a file into another."""
    scene = read(source, source.suffix[1:])
    results, _ = simplify_scene(scene, options or Options())
    return write_scene(scene, results, target, target.suffix[1:], options or Options())


def read_points(path: Path) -> np.ndarray:
    """Points that a face uses, in world space."""
    mesh = read(path, path.suffix[1:]).meshes[0]
    return transform_points(mesh.points[np.unique(mesh.faces)], mesh.transforms[0])


def make_set(points: np.ndarray) -> set[tuple[float, ...]]:
    return {tuple(row) for row in np.asarray(points, float).tolist()}


def rotate(points: np.ndarray) -> np.ndarray:
    """Points turned about a skew axis, so that no coordinate is a round number."""
    axis = np.array([0.2, 0.3, 1.0])
    axis /= np.linalg.norm(axis)
    k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return points @ (np.eye(3) + np.sin(0.4) * k + (1 - np.cos(0.4)) * k @ k).T


@pytest.mark.parametrize("shift", FAR)
@pytest.mark.parametrize("suffix", WRITABLE)
def test_map_coordinates_survive_in_every_format(tmp_path: Path, suffix: str, shift: float) -> None:
    points, faces = open_cone(7)
    points = rotate(points) + shift
    source = write(tmp_path / "in.obj", obj_text(points, faces))
    target = tmp_path / f"out.{suffix}"
    written = convert(source, target)
    after = np.unique(read_points(target), axis=0)
    distance = np.linalg.norm(points[:, None] - after[None], axis=2).min(axis=1)
    assert distance.max() <= written.rounding
    if suffix in ("obj", "off", "ply"):
        assert written.rounding == 0.0
        assert make_set(after) == make_set(points)
    elif suffix in ("glb", "gltf"):
        assert 0.0 < written.rounding < 2e-7  # single precision about an origin near the model
        assert len(after) == 8
    else:
        assert any("single precision" in text for text in written.warnings) == (shift > 0)


@pytest.mark.parametrize("shift", FAR)
@pytest.mark.parametrize("suffix", WRITABLE)
def test_same_format_gives_identical_numbers(tmp_path: Path, suffix: str, shift: float) -> None:
    points, faces = open_cone(7)
    start = write(tmp_path / "start.ply", ply_bytes(rotate(points) + shift, faces))
    first, second = tmp_path / f"first.{suffix}", tmp_path / f"second.{suffix}"
    convert(start, first)
    written = convert(first, second)
    assert written.rounding == 0.0
    assert make_set(read_points(second)) == make_set(read_points(first))


@pytest.mark.parametrize("suffix", WRITABLE)
def test_a_fine_box_comes_out_as_a_box(tmp_path: Path, suffix: str) -> None:
    source = write(tmp_path / "in.obj", obj_text(*fine_box()))
    convert(source, tmp_path / f"out.{suffix}")
    mesh = read(tmp_path / f"out.{suffix}", suffix).meshes[0]
    surface = count_defects(mesh.points, mesh.faces)
    assert (surface.points, surface.triangles, surface.watertight) == (8, 12, True)
    assert make_set(mesh.points) == make_set(box()[0])


def make_two_boxes(shift: float, gap: float = 0.1) -> tuple[np.ndarray, np.ndarray]:
    """Two closed boxes a gap apart: on the map, singles are half a unit apart."""
    points, faces = fine_box()
    both = np.vstack([points, points + np.array([2.0 + gap, 0.0, 0.0])])
    return both + shift, np.vstack([faces, faces + len(points)])


class TestCounts:
    """The report counts what is stored."""

    @pytest.mark.parametrize("suffix", WRITABLE)
    @pytest.mark.parametrize("shift", [0.0, 5_000_000.0])
    def test_what_is_reported_is_what_is_read_back(self, tmp_path: Path, suffix: str, shift: float) -> None:
        source = write(tmp_path / "in.obj", obj_text(*make_two_boxes(shift)))
        target = tmp_path / f"out.{suffix}"
        report_path = tmp_path / "report.json"
        assert main(["simplify", str(source), str(target), "--report", str(report_path), "-q"]) == 0
        after = json.loads(report_path.read_text())["after"]
        mesh = read(target, suffix).meshes[0]
        surface = count_defects(mesh.points, mesh.faces)
        for name in ("points", "triangles", "watertight", "open_edges", "nonmanifold_edges"):
            assert after[name] == getattr(surface, name)
        fallen = suffix == "stl" and shift > 0
        assert after["points"] == (12 if fallen else 16)
        assert after["watertight"] is not fallen

    def test_points_that_fall_together_are_told(self, tmp_path: Path) -> None:
        written = convert(write(tmp_path / "in.obj", obj_text(*make_two_boxes(5e6))), tmp_path / "out.stl")
        assert written.warnings[0] == (
            "the single precision of STL merged 4 points: 12 are left, with 0 open and 5 non-manifold edges"
        )

    def test_of_instances_the_worst_counts_once(self, tmp_path: Path) -> None:
        document = Gltf()
        points, faces = make_two_boxes(0.0)
        number = document.mesh(
            {"attributes": {"POSITION": document.accessor(points)},
             "indices": document.accessor(faces.reshape(-1), "u2")}
        )  # fmt: skip
        document.json["nodes"].append({"mesh": number, "translation": [5e6, 5e6, 5e6]})
        document.json["scenes"][0]["nodes"].append(1)
        written = convert(write(tmp_path / "in.glb", document.glb()), tmp_path / "out.stl")
        assert written.after is not None
        assert (written.after.points, written.after.watertight) == (12, False)


class TestText:
    def test_shortest_digits_that_read_back_exactly(self, tmp_path: Path) -> None:
        points, faces = open_cone(7)
        for suffix, text in (("obj", obj_text), ("off", off_text)):
            convert(write(tmp_path / f"in.{suffix}", text(rotate(points), faces)), tmp_path / f"out.{suffix}")
            words = (tmp_path / f"out.{suffix}").read_text().split()
            decimals = [word for word in words if "." in word]
            assert len(decimals) == 24
            assert all(repr(float(word)) == word for word in decimals)

    def test_obj_parts_keep_their_names_and_the_rest_of_their_state(self, tmp_path: Path) -> None:
        lines = obj_text(*fine_box()).splitlines()
        half = len(lines) - 192
        lines[half:half] = ["mtllib colors.mtl", "o house", "g south wall", "usemtl brick", "s 1"]
        lines[half + 101 : half + 101] = ["usemtl tiles", "s off"]
        source = write(tmp_path / "in.obj", "\n".join(lines))
        convert(source, tmp_path / "out.obj")
        said = [line for line in (tmp_path / "out.obj").read_text().splitlines() if line[0] not in "vf"]
        assert said == [
            "mtllib colors.mtl", "o house", "g south wall", "usemtl brick", "s 1", "usemtl tiles", "s off",
        ]  # fmt: skip
        assert [p.name for p in read(tmp_path / "out.obj", "obj").meshes[0].parts] == [
            p.name for p in read(source, "obj").meshes[0].parts
        ]

    def test_names_that_are_no_utf8_stay_as_they_are(self, tmp_path: Path) -> None:
        lines = obj_text(*fine_box()).encode().splitlines()
        lines[-192:-192] = [b"mtllib m.mtl", b"o caf\xe9", b"usemtl gr\xfcn"]
        write(tmp_path / "m.mtl", b"newmtl gr\xfcn\nKd 0 1 0\n")
        convert(write(tmp_path / "in.obj", b"\n".join(lines)), tmp_path / "out.obj")
        assert b"\no caf\xe9\nusemtl gr\xfcn\n" in (tmp_path / "out.obj").read_bytes()
        convert(tmp_path / "in.obj", tmp_path / "out.glb")
        material = split_glb((tmp_path / "out.glb").read_bytes())[0]["materials"][0]
        assert material["name"] == "gr\ufffdn"
        assert material["pbrMetallicRoughness"]["baseColorFactor"] == [0, 1, 0, 1]


class TestPly:
    def test_single_stays_single_and_double_double(self, tmp_path: Path) -> None:
        points, faces = open_cone(7)
        for kind in ("float", "double"):
            source = write(tmp_path / "in.ply", ply_bytes(rotate(points), faces, kind=kind))
            convert(source, tmp_path / "out.ply")
            assert f"property {kind} x".encode() in (tmp_path / "out.ply").read_bytes()

    def test_doubles_of_another_format_become_single_where_that_moves_nothing(self, tmp_path: Path) -> None:
        for scale, kind in ((1.0, b"float"), (1 / 3, b"double")):
            points, faces = box()
            convert(write(tmp_path / "in.obj", obj_text(points * scale, faces)), tmp_path / "out.ply")
            assert b"property " + kind + b" x" in (tmp_path / "out.ply").read_bytes()

    def test_text_stays_text_with_all_its_digits(self, tmp_path: Path) -> None:
        points, faces = open_cone(7)
        points = rotate(points) + 500_000.0
        source = write(tmp_path / "in.ply", ply_bytes(points, faces, encoding="ascii"))
        convert(source, tmp_path / "out.ply")
        assert b"format ascii" in (tmp_path / "out.ply").read_bytes()
        assert make_set(read_points(tmp_path / "out.ply")) == make_set(points)


class TestOrigin:
    def test_no_origin_where_nothing_is_gained(self) -> None:
        points, _ = open_cone(7)
        assert not choose_origin(rotate(points)).any()
        assert not choose_origin(box(shift=5_000_000.0)[0]).any()

    def test_the_origin_is_single_and_moving_is_exact(self) -> None:
        points = rotate(open_cone(7)[0]) + np.array([678_100.25, 5_403_790.5, 310.0])
        origin = choose_origin(points)
        assert np.array_equal(origin.astype(np.float32).astype(float), origin)
        assert np.array_equal((points - origin) + origin, points)
        assert measure_rounding(points, origin) < 2e-7
        assert measure_rounding(points) > 0.1

    def test_rounding_is_never_below_the_truth(self) -> None:
        from fractions import Fraction

        points = rotate(open_cone(7)[0]) + 5_000_000.0
        origin = np.array([0.1, 4_999_999.7, 0.0])
        kept = (points - origin).astype(np.float32)
        told = Fraction(measure_rounding(points, origin))
        for point, short in zip(points, kept, strict=True):
            gaps = [
                Fraction(float(p)) - Fraction(float(o)) - Fraction(float(s))
                for p, o, s in zip(point, origin, short, strict=True)
            ]
            assert sum(gap * gap for gap in gaps) <= told * told

    def test_instances_of_a_glb_go_out_in_world_space(self, tmp_path: Path) -> None:
        document = Gltf()
        number = document.mesh(document.box(fine=True), node={"translation": [10, 0, 0], "scale": [-1, 1, 1]})
        document.json["nodes"].append({"mesh": number})
        document.json["scenes"][0]["nodes"].append(1)
        source = write(tmp_path / "in.glb", document.glb())
        written = convert(source, tmp_path / "out.obj")
        mesh = read(tmp_path / "out.obj", "obj").meshes[0]
        assert make_set(mesh.points) == make_set(np.vstack([box()[0], box()[0] * [-1, 1, 1] + [10, 0, 0]]))
        a, b, c = (mesh.points[mesh.faces[:, i]] for i in range(3))
        volume = float((a * np.cross(b, c)).sum() / 6)
        assert volume == pytest.approx(16.0)  # the mirrored one is turned, so that both face outwards
        assert written.warnings == ["OBJ cannot store instances: each was written out"]


class TestConversion:
    def test_obj_parts_become_primitives_with_names_and_colors(self, tmp_path: Path) -> None:
        lines = obj_text(*fine_box()).splitlines()
        lines[-192:-192] = ["mtllib m.mtl", "usemtl brick"]
        lines[-96:-96] = ["usemtl tiles"]
        write(tmp_path / "m.mtl", "newmtl brick\nKd 0.5 0.25 0\nnewmtl tiles\nKd 1 0 0\nd 0.5\n")
        convert(write(tmp_path / "in.obj", "\n".join(lines)), tmp_path / "out.glb")
        json_ = split_glb((tmp_path / "out.glb").read_bytes())[0]
        primitives = json_["meshes"][0]["primitives"]
        assert [p["extras"]["name"] for p in primitives] == ["brick", "tiles"]
        colors = [json_["materials"][p["material"]]["pbrMetallicRoughness"]["baseColorFactor"] for p in primitives]
        assert colors == [[0.5, 0.25, 0.0, 1.0], [1.0, 0.0, 0.0, 0.5]]
        assert primitives[0]["attributes"] == primitives[1]["attributes"]

    @pytest.mark.parametrize("suffix", ["off", "stl"])
    def test_what_a_format_cannot_hold_is_named(self, tmp_path: Path, suffix: str) -> None:
        text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nvt 0 0\nusemtl photo\nf 1/1 2/1 3/1\n"
        written = convert(write(tmp_path / "in.obj", text), tmp_path / f"out.{suffix}")
        assert any("texture coordinates: lost" in warning for warning in written.warnings)


class TestTarget:
    def test_nothing_is_left_over_and_the_old_file_stays_where_writing_fails(self, tmp_path: Path, monkeypatch) -> None:
        old = write(tmp_path / "out.bin", b"old")

        def full(*_: object) -> None:
            raise OSError(28, "No space left on device")

        monkeypatch.setattr("os.replace", full)
        with pytest.raises(OutputError, match="No space left"):
            replace_files({tmp_path / "other.bin": b"new", old: b"new"})
        assert old.read_bytes() == b"old"
        assert [path.name for path in tmp_path.iterdir()] == ["out.bin"]

    def test_an_interruption_leaves_nothing_over(self, tmp_path: Path, monkeypatch) -> None:
        def interrupted(*_: object) -> None:
            raise KeyboardInterrupt

        monkeypatch.setattr("os.replace", interrupted)
        with pytest.raises(KeyboardInterrupt):
            replace_files({tmp_path / "out.bin": b"new"})
        assert list(tmp_path.iterdir()) == []

    def test_clearing_up_leaves_alone_what_is_being_written(self, tmp_path: Path, monkeypatch) -> None:
        replace = os.replace

        def cleared_meanwhile(one: Path, other: Path) -> None:
            clear_leftovers(tmp_path)
            replace(one, other)

        monkeypatch.setattr("os.replace", cleared_meanwhile)
        replace_files({tmp_path / "one.bin": b"one", tmp_path / "other.bin": b"other"})
        assert (tmp_path / "other.bin").read_bytes() == b"other"

    def test_clearing_up_removes_what_a_killed_process_left(self, tmp_path: Path) -> None:
        mine = write(tmp_path / ".bldsimp-mine.tmp", b"")
        leave_file(tmp_path)
        clear_leftovers(tmp_path)
        assert list(tmp_path.iterdir()) == [mine]

    def test_what_another_machine_writes_is_left_until_it_is_old(self, tmp_path: Path) -> None:
        left = leave_file(tmp_path)
        _, _, process, end = left.name.split("-")
        there = left.rename(left.with_name(f".bldsimp-00000000-{process}-{end}"))
        clear_leftovers(tmp_path)
        assert there.exists()
        long_ago = there.stat().st_mtime - ABANDONED_SECONDS - 60
        os.utime(there, (long_ago, long_ago))
        clear_leftovers(tmp_path)
        assert not there.exists()

    def test_permissions_and_links_stay(self, tmp_path: Path) -> None:
        real = write(tmp_path / "real.bin", b"old")
        real.chmod(0o640)
        (tmp_path / "link.bin").symlink_to(real)
        replace_files({tmp_path / "link.bin": b"new"})
        assert real.read_bytes() == b"new"
        assert real.stat().st_mode & 0o777 == 0o640
        assert (tmp_path / "link.bin").is_symlink()

    def test_a_pipe_gets_the_same_bytes_as_a_file(self, tmp_path: Path) -> None:
        scene: Scene = read(obj_text(*fine_box()).encode(), "obj")
        results, _ = simplify_scene(scene, Options())
        for suffix in WRITABLE:
            stream = io.BytesIO()
            write_scene(scene, results, stream, suffix, Options())
            write_scene(scene, results, tmp_path / f"out.{suffix}", suffix, Options())
            if suffix != "gltf":  # whose buffer goes inside on a pipe
                assert stream.getvalue() == (tmp_path / f"out.{suffix}").read_bytes()

    def test_files_beside_the_target_are_not_replaced_unasked(self, tmp_path: Path) -> None:
        scene = read(obj_text(*fine_box()).encode(), "obj")
        results, _ = simplify_scene(scene, Options())
        write(tmp_path / "out.bin", b"something else")
        with pytest.raises(OutputError, match="overwrite"):
            write_scene(scene, results, tmp_path / "out.gltf", "gltf", Options(), overwrite=False)
        assert (tmp_path / "out.bin").read_bytes() == b"something else"
        assert not (tmp_path / "out.gltf").exists()


def test_mapped_texture_coordinates_are_summed_in_one_order() -> None:
    """Whatever library multiplies matrices, and however many there are, the written numbers are the same."""
    count = 999
    uv = np.random.default_rng(0).random((count, 2))
    matrix = tuple(np.random.default_rng(1).random(6).tolist())
    flat = FlatMesh(
        name="wall",
        points=np.zeros((count, 3)),
        normals=None,
        attributes=[Attribute("TEXCOORD_0", "uv", uv, np.ones((1, 2)))],
        faces=np.arange(count, dtype=np.int32).reshape(-1, 3),
        part=np.zeros(count // 3, np.int32),
        parts=[Part("wall", material=Material("brick", (1.0, 1.0, 1.0, 1.0), uv_map=UvMap(0, matrix)))],
    )
    a, b, c, d, e, f = matrix
    expected = [[a * u + b * v + c, d * u + e * v + f] for u, v in uv.tolist()]
    assert apply_uv_maps(flat).attributes[0].values.tolist() == expected


def test_an_obj_file_that_becomes_no_lighter_is_written_as_it_is(tmp_path: Path) -> None:
    points, quads = box_quads()
    quads = [square[::-1] for square in quads]
    source = write(tmp_path / "in.obj", "# ours\n" + obj_text(points, quads))
    written = convert(source, tmp_path / "out.obj")
    assert (tmp_path / "out.obj").read_bytes() == source.read_bytes()
    assert written.bytes == source.stat().st_size
    assert convert(source, tmp_path / "smooth.obj", Options(normals="smooth")).bytes > written.bytes
    write(source, obj_text(points * 1e90, quads))
    convert(source, tmp_path / "far.obj")
    assert (tmp_path / "far.obj").read_bytes() == source.read_bytes()
    # One face looks inwards: it is turned.
    write(source, obj_text(points, [quads[0][::-1], *quads[1:]]))
    convert(source, tmp_path / "out.obj")
    assert (tmp_path / "out.obj").read_bytes() != source.read_bytes()
