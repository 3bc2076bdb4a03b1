"""What glTF vertices carry: read as it is meant, and written as it was stored."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gltf_cases import add_picture, new_primitive, png, simplify_glb
from shapes import Gltf, fine_box, read_values, split_glb, write

from bldsimp import Options
from bldsimp.io import read
from bldsimp.io import write as write_scene
from bldsimp.model import Attribute, Mesh, SimplifiedMesh
from bldsimp.options import COLOR_LEVELS, CUSTOM_LEVELS, UNKNOWN_TEXELS
from bldsimp.scene import simplify_scene


def read_mesh(document: Gltf, *primitives: dict[str, Any], **more: Any) -> Mesh:
    document.mesh(*primitives, **more)
    return read(document.glb(), "glb").meshes[0]


def find_attribute(mesh: Mesh, name: str) -> Attribute:
    return next(one for one in mesh.attributes if one.name == name)


def add_typed(document: Gltf, numbers: int, kind: str) -> int:
    """An accessor of 98 elements, whatever an element is."""
    number = document.accessor(np.arange(numbers) / 100.0)
    document.json["accessors"][number].update(count=98, type=kind)
    return number


class TestRead:
    def test_kinds_widths_and_directions(self) -> None:
        document = Gltf()
        points = fine_box()[0]
        uv = document.accessor(points[:, :2])
        names = {"TEXCOORD_0": uv, "TEXCOORD_1": document.accessor(points[:, 1:])}
        names |= {"COLOR_0": document.accessor(np.full((98, 3), 128), "u1", normalized=True)}
        names |= {"COLOR_1": document.accessor(np.ones((98, 4)))}
        names |= {"_FEATURE_ID_0": document.accessor(np.full(98, 7.0)), "_BATCHID": document.accessor(np.full(98, 3.0))}
        names |= {"_HEAT": document.accessor(points[:, :1] * -5.0), "TANGENT": document.accessor(np.ones((98, 4)))}
        mesh = read_mesh(document, document.box(fine=True, **names))
        kinds = {one.name: (one.kind, one.values.shape[1]) for one in mesh.attributes}
        assert kinds == {
            "TEXCOORD_0": ("uv", 2), "TEXCOORD_1": ("uv", 2), "COLOR_0": ("color", 3), "COLOR_1": ("color", 4),
            "_FEATURE_ID_0": ("feature", 1), "_BATCHID": ("feature", 1), "_HEAT": ("color", 1),
            "TANGENT": ("tangent", 4),
        }  # fmt: skip
        upwards = np.stack([points[:, 0], 1.0 - points[:, 1]], axis=1)
        assert np.array_equal(find_attribute(mesh, "TEXCOORD_0").values, upwards)
        assert np.allclose(find_attribute(mesh, "COLOR_0").values, 128 / 255)
        assert find_attribute(mesh, "COLOR_0").steps.tolist() == [[COLOR_LEVELS] * 3]
        assert find_attribute(mesh, "_HEAT").steps.tolist() == [[CUSTOM_LEVELS / 10.0]]
        assert mesh.parts[0].attributes == tuple(names)
        assert not mesh.parts[0].fixed

    def test_rows_are_shared_only_by_primitives_that_are_the_same_in_everything(self) -> None:
        document = Gltf()
        base = document.box(fine=True)
        second = document.accessor(np.zeros((98, 2)))
        other = {**base, "attributes": {**base["attributes"], "TEXCOORD_1": second}}
        mesh = read_mesh(document, base, other, {**other})
        assert len(mesh.points) == 2 * 98
        values = find_attribute(mesh, "TEXCOORD_1").values
        assert np.isnan(values[:98]).all()
        assert not np.isnan(values[98:]).any()

    def test_whole_numbers_of_our_own_name_something_unless_they_change_over_a_face(self) -> None:
        for values, kind in ((np.full(98, 4), "feature"), (np.arange(98), "color")):
            document = Gltf()
            mesh = read_mesh(document, document.box(fine=True, _X=document.accessor(values, "u2")))
            assert find_attribute(mesh, "_X").kind == kind

    def test_numbers_of_our_own_are_told_apart_as_in_other_formats(self, tmp_path: Path) -> None:
        """An infinite one says nothing about how large the others are."""
        points, faces = fine_box()
        heat = points[:, 0] * 5.0
        heat[0] = np.inf
        document = Gltf()
        ours = read_mesh(document, document.box(fine=True, _heat=document.accessor(heat)))
        lines = [f"{x} {y} {z} {own}" for (x, y, z), own in zip(points.tolist(), heat.tolist(), strict=True)]
        lines += [f"3 {a} {b} {c}" for a, b, c in faces.tolist()]
        head = "ply\nformat ascii 1.0\nelement vertex 98\n"
        head += "".join(f"property float {name}\n" for name in ("x", "y", "z", "heat"))
        head += "element face 192\nproperty list uchar int vertex_indices\nend_header\n"
        theirs = read(write(tmp_path / "in.ply", head + "\n".join(lines) + "\n"), "ply").meshes[0]
        for mesh in (ours, theirs):
            one = find_attribute(mesh, "_heat")
            assert (one.kind, one.steps.tolist()) == ("color", [[CUSTOM_LEVELS / 10.0]])

    def test_quantized_and_sparse_texture_coordinates(self) -> None:
        document = Gltf()
        places, changes = document.accessor([3, 5], "u1"), document.accessor([[65535, 0], [0, 65535]], "u2")
        views = [document.json["accessors"][i]["bufferView"] for i in (places, changes)]
        document.json["accessors"].append({
            "componentType": 5123, "normalized": True, "count": 98, "type": "VEC2",
            "sparse": {"count": 2, "indices": {"bufferView": views[0], "componentType": 5121},
                       "values": {"bufferView": views[1]}},
        })  # fmt: skip
        document.json["extensionsUsed"] = ["KHR_mesh_quantization"]
        values = find_attribute(read_mesh(document, document.box(fine=True, TEXCOORD_0=2)), "TEXCOORD_0").values
        assert values[[0, 3, 5]].tolist() == [[0, 1], [1, 1], [0, 0]]

    @pytest.mark.parametrize(
        ("change", "told"),
        [
            (lambda p, d: p.update(targets=[{"POSITION": p["attributes"]["POSITION"]}]), "morph targets"),
            (lambda p, d: p["attributes"].update(JOINTS_0=d.accessor(np.zeros((98, 4)), "u1")), "skin"),
            (lambda p, d: d.json["nodes"][0].update(skin=0), "skin"),
            (lambda p, d: p.update(extensions={"ACME_lines": {"indices": 0}}), "ACME_lines"),
            (
                lambda p, d: p.update(extensions={"EXT_mesh_features": {"featureIds": [{"featureCount": 98}]}}),
                "implicit feature ids",
            ),
            (
                lambda p, d: p["attributes"].update(_X=d.accessor(np.zeros((97, 1)))),
                "_X of another length than its positions",
            ),
            (lambda p, d: p["attributes"].update(_X=add_typed(d, 98 * 4, "MAT2")), "_X of type MAT2"),
            (lambda p, d: p["attributes"].update(TEXCOORD_0=add_typed(d, 98, "SCALAR")), "TEXCOORD_0 of type SCALAR"),
            (lambda p, d: p["attributes"].update(TEXCOORD_0=add_typed(d, 98 * 3, "VEC3")), "TEXCOORD_0 of type VEC3"),
            (lambda p, d: p["attributes"].update(TEXCOORD_0=add_typed(d, 98 * 4, "VEC4")), "TEXCOORD_0 of type VEC4"),
            (
                lambda p, d: d.json.update(
                    animations=[{"samplers": [], "channels": [{"sampler": 0, "target": {"node": 0, "path": "scale"}}]}]
                ),
                "animated scale",
            ),
        ],
    )
    def test_what_cannot_follow_is_named_and_passed_on(self, change: Any, told: str) -> None:
        document = Gltf()
        primitive = document.box(fine=True)
        document.mesh(primitive, document.box(fine=True, shift=9.0))
        change(primitive, document)
        scene = read(document.glb(), "glb")
        assert scene.meshes[0].parts[0].fixed == (told,)
        assert all(one.values.shape[1] == one.steps.shape[1] for one in scene.meshes[0].attributes)
        _, report = simplify_scene(scene, Options())
        assert told in report.unchanged_parts[0].reason

    def test_faces_are_seen_from_one_side_unless_their_material_says_otherwise(self) -> None:
        document = Gltf()
        document.json["materials"] = [{}, {"doubleSided": True}]
        plain, one, two = (document.box(shift=shift) for shift in (0.0, 9.0, 18.0))
        one["material"], two["material"] = 0, 1
        assert [part.one_sided for part in read_mesh(document, plain, one, two).parts] == [True, True, False]


@pytest.mark.parametrize("fixed", [False, True])
def test_faces_without_area_are_no_obstacle(fixed: bool, tmp_path: Path) -> None:
    document = Gltf()
    names = {"TEXCOORD_0": document.accessor(np.zeros((8, 2))), "_FEATURE_ID_0": document.accessor(np.zeros(8))}
    flat = document.box(size=0.0, **names)
    if fixed:
        flat["extensions"] = {"ACME_lines": {}}
    document.mesh(document.box(fine=True), name="house")
    document.mesh(flat, name="nothing")
    _, after = simplify_glb(document.glb(), tmp_path / "out.glb")
    assert [mesh["name"] for mesh in split_glb(after)[0]["meshes"]] == ["house", "nothing"][: 1 + fixed]


class TestTexels:
    """How many texels a unit of a UV set is worth."""

    def steps(self, material: dict[str, Any], name: str = "TEXCOORD_0", **primitive: Any) -> list[float]:
        document = Gltf()
        small, large = add_picture(document, png(16, 8)), add_picture(document, png(64, 32))
        assert (small, large) == (0, 1)
        sets = {key: document.accessor(np.zeros((98, 2))) for key in ("TEXCOORD_0", "TEXCOORD_1")}
        document.json["materials"] = [material, {"normalTexture": {"index": 1}}]
        mesh = read_mesh(document, {**document.box(fine=True, **sets), "material": 0, **primitive})
        return find_attribute(mesh, name).steps[0].tolist()

    def test_the_largest_image_that_reads_a_set_counts(self) -> None:
        material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
        assert self.steps(material) == [16, 8]
        assert self.steps(material, "TEXCOORD_1") == [UNKNOWN_TEXELS] * 2
        assert self.steps({**material, "emissiveTexture": {"index": 1}}) == [64, 32]
        both = {**material, "occlusionTexture": {"index": 1, "texCoord": 1}}
        assert self.steps(both) == [16, 8]
        assert self.steps(both, "TEXCOORD_1") == [64, 32]

    def test_textures_of_extensions_count(self) -> None:
        coat = {"extensions": {"KHR_materials_clearcoat": {"clearcoatTexture": {"index": 0}}}}
        assert self.steps(coat) == [16, 8]

    def test_transforms_scale_turn_and_choose_the_set(self) -> None:
        def moved(**transform: Any) -> dict[str, Any]:
            info = {"index": 0, "texCoord": 1, "extensions": {"KHR_texture_transform": transform}}
            return {"pbrMetallicRoughness": {"baseColorTexture": info}}

        assert self.steps(moved(texCoord=0, scale=[10, -3])) == [160, 24]
        assert self.steps(moved(scale=[2, 2]), "TEXCOORD_1") == [32, 16]
        assert self.steps(moved(texCoord=0, rotation=np.pi / 2)) == pytest.approx([8, 16])

    def test_variants_count(self) -> None:
        variants = {"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [0]}]}}
        assert self.steps({}, extensions=variants) == [64, 32]

    def test_pictures_of_feature_ids_count(self) -> None:
        features = {"EXT_mesh_features": {"featureIds": [{"featureCount": 2, "texture": {"index": 1, "texCoord": 1}}]}}
        assert self.steps({}, "TEXCOORD_1", extensions=features) == [64, 32]

    def test_pictures_beside_the_document(self, tmp_path: Path) -> None:
        document = Gltf()
        document.json.update(
            images=[{"uri": "a%20b.png"}, {"uri": "gone.png"}], textures=[{"source": 0}, {"source": 1}],
            materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": number}}} for number in (0, 1)],
        )  # fmt: skip
        uv = document.accessor(np.zeros((98, 2)))
        boxes = [{**document.box(fine=True, TEXCOORD_0=uv), "material": number} for number in (0, 1)]
        document.mesh(*boxes)
        write(tmp_path / "a b.png", png(40, 20))
        scene = read(write(tmp_path / "a.gltf", document.gltf()), "gltf")
        assert find_attribute(scene.meshes[0], "TEXCOORD_0").steps.tolist() == [[40, 20], [UNKNOWN_TEXELS] * 2]
        assert scene.size == (tmp_path / "a.gltf").stat().st_size


class TestWrite:
    def test_all_attributes_stay_as_they_are_stored(self, tmp_path: Path) -> None:
        """Each kept vertex has the values that the input stores for it, in the same component type."""
        document = Gltf()
        points = fine_box()[0]
        document.json["extensionsUsed"] = ["KHR_mesh_quantization"]
        stored = {
            "TEXCOORD_0": (points[:, :2] * 30000, "u2", {"normalized": True}),
            "TEXCOORD_3": (points[:, 1:] * 0.3 - 7.0, "f4", {}),
            "COLOR_0": (np.full((98, 3), 128), "u1", {"normalized": True, "name": "paint", "extras": {"by": "us"}}),
            "_FEATURE_ID_0": (np.full(98, 9), "u1", {}),
            "_HEAT": (points[:, :1], "f4", {}),
        }
        numbers = {name: document.accessor(values, kind, **more) for name, (values, kind, more) in stored.items()}
        document.mesh(document.box(fine=True, **numbers))
        data = document.glb()
        _, after = simplify_glb(data, tmp_path / "out.glb")
        primitive = new_primitive(after)
        assert set(primitive["attributes"]) == {"POSITION", *stored}
        rows = {tuple(row): i for i, row in enumerate(points.tolist())}
        kept = [rows[tuple(row)] for row in read_values(after, primitive["attributes"]["POSITION"]).tolist()]
        assert len(kept) == 8
        for name, old in numbers.items():
            new = primitive["attributes"][name]
            before, now = split_glb(data)[0]["accessors"][old], split_glb(after)[0]["accessors"][new]
            for key in ("componentType", "normalized", "type", "name", "extras"):
                assert now.get(key) == before.get(key)
            assert np.array_equal(read_values(after, new), read_values(data, old)[kept])

    def test_tangents_keep_the_normals_that_they_need(self, tmp_path: Path) -> None:
        document = Gltf()
        square = np.array([[x, y, 0.0] for x in range(4) for y in range(4)])
        cells = [4 * x + y for x in range(3) for y in range(3)]
        faces = [face for a in cells for face in ((a, a + 4, a + 5), (a, a + 5, a + 1))]
        names = {"NORMAL": document.accessor(np.tile([0.0, 0, 1], (16, 1)))}
        names |= {"TANGENT": document.accessor(np.tile([1.0, 0, 0, 1], (16, 1)))}
        names |= {"TEXCOORD_0": document.accessor(square[:, :2])}
        document.mesh({"attributes": {"POSITION": document.accessor(square), **names},
                       "indices": document.accessor(np.ravel(faces), "u2")})  # fmt: skip
        _, after = simplify_glb(document.glb(), tmp_path / "out.glb")
        primitive = new_primitive(after)
        assert set(primitive["attributes"]) == {"POSITION", *names}
        assert read_values(after, primitive["attributes"]["NORMAL"]).tolist() == [[0, 0, 1]] * 4
        bare = simplify_glb(document.glb(), tmp_path / "flat.glb", Options(normals="flat"))[1]
        assert set(new_primitive(bare)["attributes"]) == {"POSITION", "TEXCOORD_0"}

    def test_changed_values_are_written_in_the_stored_type(self, tmp_path: Path) -> None:
        document = Gltf()
        uv = document.accessor(fine_box()[0][:, :2] * 30000, "u2", normalized=True)
        document.json["extensionsUsed"] = ["KHR_mesh_quantization"]
        document.mesh(document.box(fine=True, TEXCOORD_0=uv, COLOR_0=document.accessor(np.ones((98, 3)))))
        scene = read(document.glb(), "glb")
        lights, _ = simplify_scene(scene, Options())
        mesh, one = scene.meshes[0], lights[0]
        added = len(one.points)
        changed = find_attribute(mesh, "TEXCOORD_0").values[one.row]
        changed = np.vstack([changed, [[0.25, 0.75]]])
        changed[one.faces[0, 1]] = 2.0
        # A row that was told apart, and values that no such number can hold.
        faces = one.faces.copy()
        moved = faces[0, 0]
        faces[0, 0] = added
        points = np.vstack([one.points, one.points[moved] + 0.125])
        row = np.append(one.row, one.row[moved]).astype(np.int32)
        other = SimplifiedMesh(points, faces, one.part_of_face, row, one.face, {"TEXCOORD_0": changed})
        write_scene(scene, [other], tmp_path / "out.glb", "glb", Options())
        after = (tmp_path / "out.glb").read_bytes()
        primitive = new_primitive(after)
        index = read_values(after, primitive["indices"])[:2, 0]
        values = read_values(after, primitive["attributes"]["TEXCOORD_0"])[index]
        assert values.dtype == np.uint16
        assert values.tolist() == [[16384, 16384], [65535, 0]]
        position = read_values(after, primitive["attributes"]["POSITION"])[index[0]]
        assert position.tolist() == points[-1].tolist()
        assert read_values(after, primitive["attributes"]["COLOR_0"]).tolist() == [[1, 1, 1]] * 9

    def test_vertices_are_split_only_where_values_differ(self, tmp_path: Path) -> None:
        points, faces = fine_box()
        half = np.repeat(np.arange(6) < 3, 96)
        for color, vertices in ((np.ones((576, 3)), 8), (np.stack([half, half * 0, half * 0], axis=1), 16)):
            document = Gltf()
            names = {"POSITION": document.accessor(points[faces].reshape(-1, 3)), "COLOR_0": document.accessor(color)}
            document.mesh({"attributes": names})
            _, after = simplify_glb(document.glb(), tmp_path / "out.glb")
            assert len(read_values(after, new_primitive(after)["attributes"]["POSITION"])) == vertices

    def test_what_names_dropped_attributes_goes_with_them(self, tmp_path: Path) -> None:
        document = Gltf()
        ids = document.accessor(np.zeros(98))
        uv = document.accessor(np.zeros((98, 2)))
        add_picture(document, png(4, 4))
        features = {"featureIds": [{"featureCount": 1, "attribute": 0},
                                   {"featureCount": 1, "texture": {"index": 0, "texCoord": 0}}]}  # fmt: skip
        variants = {"mappings": [{"material": 0, "variants": [0]}]}
        primitive = {**document.box(fine=True, _FEATURE_ID_0=ids, TEXCOORD_0=uv)}
        primitive["extensions"] = {"EXT_mesh_features": features, "KHR_materials_variants": variants}
        document.json["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
        document.json["extensions"] = {"KHR_materials_variants": {"variants": [{"name": "other"}]}}
        document.json["extensionsUsed"] = ["EXT_mesh_features", "KHR_materials_variants"]
        document.mesh(primitive)
        data = document.glb()
        assert new_primitive(simplify_glb(data, tmp_path / "all.glb")[1])["extensions"] == primitive["extensions"]
        geometry = new_primitive(simplify_glb(data, tmp_path / "none.glb", Options(delimit=frozenset()))[1])
        assert set(geometry["attributes"]) == {"POSITION"}
        assert set(geometry["extensions"]) == {"KHR_materials_variants"}
        assert geometry["extensions"]["KHR_materials_variants"]["mappings"][0]["material"] == 1
        mapped = new_primitive(simplify_glb(data, tmp_path / "uv.glb", Options(delimit=frozenset({"uv"})))[1])
        assert mapped["extensions"]["EXT_mesh_features"]["featureIds"] == features["featureIds"][1:]
