"""The textured house as GLB, with all that a scene may hold, and as OBJ with its materials and pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from buildings import painted
from buildings.glb import INDICES, VERTICES, Z_UP, Glb
from buildings.tessellate import Faces, Points, tessellate
from buildings.textured_house import (
    LookSurface,
    build_body,
    build_sign,
    build_surfaces,
    build_terrace,
    build_wing,
    color_terrace,
)

NAME = "house_textured"
EDGE = {"glb": 0.32, "obj": 0.5}
"""Length above which edges are cut; meters."""

DECIMALS = 6
WING_AT = ((12.0, 2.0, 0.0), (0.0, 2.0, 0.0))
"""Where the wing stands, and where its mirror image does."""

IMAGES = {
    "facade": painted.paint_facade,
    "bricks": painted.paint_bricks,
    "tiles": painted.paint_tiles,
    "sign": painted.paint_sign,
    "light": painted.paint_light,
}
TIMBER = (0.36, 0.23, 0.15)
CLAMPED = 33071


def round_points(points: Points) -> Points:
    """Round coordinates as they are written."""
    return np.round(points, DECIMALS) + 0.0


def build_all_surfaces(edge: float) -> tuple[dict[str, LookSurface], dict[str, LookSurface], LookSurface]:
    """Build body and wing by the name of their looks, and the sign."""
    solid = build_body()
    return build_surfaces(solid, edge), build_surfaces(build_wing(len(solid.model.facets)), edge), build_sign(edge)


def write_textured_glb(path: Path) -> None:
    """Write binary glTF: several primitives, two maps, a mirrored node, vertex colors, a camera, a light, extras."""
    glb = Glb()
    images = [
        {"name": name, "mimeType": "image/png", "bufferView": glb.add_view(make())} for name, make in IMAGES.items()
    ]
    whole, side, board = build_all_surfaces(EDGE["glb"])
    names = [*list(IMAGES)[:4], "timber", "terrace"]
    meshes = [
        {"name": "body", "primitives": [add_primitive(glb, whole[name], names.index(name)) for name in sorted(whole)]},
        {"name": "wing", "primitives": [add_primitive(glb, side[name], names.index(name)) for name in sorted(side)]},
        {"name": "sign", "primitives": [add_primitive(glb, board, names.index("sign"), lit=False)]},
        {"name": "terrace", "primitives": [add_terrace(glb, names.index("terrace"))]},
    ]
    east, west = (list(at) for at in WING_AT)
    glb.write(
        path,
        extensionsUsed=["KHR_lights_punctual"],
        extensions={"KHR_lights_punctual": {"lights": [{"name": "sun", "type": "directional", "intensity": 3.0}]}},
        scene=0,
        scenes=[{"name": "street", "nodes": [0, 6, 7], "extras": {"number": 12}}],
        nodes=[
            {"name": "house", "rotation": Z_UP, "children": [1, 2, 3, 4, 5], "extras": {"storeys": 1}},
            {"name": "body", "mesh": 0},
            {"name": "wing_east", "mesh": 1, "translation": east},
            {"name": "wing_west", "mesh": 1, "translation": west, "scale": [-1, 1, 1]},
            {"name": "sign", "mesh": 2, "extras": {"text": "BRICKS"}},
            {"name": "terrace", "mesh": 3},
            {"name": "eye", "camera": 0, "translation": [6, 3, 24]},
            {"name": "sun", "extensions": {"KHR_lights_punctual": {"light": 0}}},
        ],
        cameras=[{"name": "street", "type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.1}}],
        meshes=meshes,
        materials=[build_material(name) for name in names],
        textures=[{"sampler": 1 if name in ("facade", "light") else 0, "source": k} for k, name in enumerate(IMAGES)],
        samplers=[{"magFilter": 9729, "minFilter": 9987}, {"wrapS": CLAMPED, "wrapT": CLAMPED}],
        images=images,
    )


def build_material(name: str) -> dict[str, Any]:
    """Describe a material of the document; pictures and textures have the order of `IMAGES`."""
    surface: dict[str, Any] = {"metallicFactor": 0.0, "roughnessFactor": 0.9}
    made: dict[str, Any] = {"name": name, "pbrMetallicRoughness": surface}
    if name in IMAGES:
        surface["baseColorTexture"] = {"index": list(IMAGES).index(name)}
    if name == "timber":
        surface["baseColorFactor"] = [*TIMBER, 1.0]
    if name == "sign":
        made |= {"alphaMode": "MASK", "alphaCutoff": 0.5, "doubleSided": True, "extras": {"note": "hangs"}}
    elif name != "terrace":
        made["occlusionTexture"] = {"index": list(IMAGES).index("light"), "texCoord": 1}
    return made


def add_primitive(glb: Glb, surface: LookSurface, material: int, *, lit: bool = True) -> dict[str, Any]:
    """Add a primitive with one map, or two where it is `lit` by a picture."""
    attributes = {
        "POSITION": glb.add_accessor(round_points(surface.join_rows("points")).astype("<f4"), VERTICES, bounded=True),
        "NORMAL": glb.add_accessor(surface.join_rows("normals").astype("<f4"), VERTICES),
        "TEXCOORD_0": glb.add_accessor(surface.join_rows("uv").astype("<f4"), VERTICES),
    }
    if lit:
        attributes["TEXCOORD_1"] = glb.add_accessor(surface.join_rows("light").astype("<f4"), VERTICES)
    indices = glb.add_accessor(surface.join_rows("faces").astype("<u2").ravel(), INDICES)
    return {"attributes": attributes, "indices": indices, "material": material}


def add_terrace(glb: Glb, material: int) -> dict[str, Any]:
    """Add the terrace, with colors at its points and no normals."""
    points, faces = tessellate(build_terrace(), EDGE["glb"])
    attributes = {
        "POSITION": glb.add_accessor(round_points(points).astype("<f4"), VERTICES, bounded=True),
        "COLOR_0": glb.add_accessor(color_terrace(points).astype("<f4"), VERTICES),
    }
    return {
        "attributes": attributes,
        "indices": glb.add_accessor(faces.astype("<u2").ravel(), INDICES),
        "material": material,
    }


def write_textured_obj(folder: Path) -> None:
    """Wavefront OBJ, z upwards, its materials, and their pictures beside it; without the terrace."""
    whole, side, board = build_all_surfaces(EDGE["obj"])
    lines = [f"mtllib {NAME}.mtl"]
    book: dict[str, dict[tuple[float, ...], int]] = {"v": {}, "vt": {}}
    east, west = (np.array(at) for at in WING_AT)
    mirror = np.array([-1.0, 1.0, 1.0])
    for name, group in (("body", whole), ("wing_east", side), ("wing_west", side), ("sign", {"sign": board})):
        lines.append(f"o {name}")
        for look in sorted(group):
            surface = group[look]
            points, faces = surface.join_rows("points"), surface.join_rows("faces")
            if name == "wing_east":
                points = points + east
            elif name == "wing_west":
                points, faces = points * mirror + west, faces[:, ::-1]
            uv = surface.join_rows("uv") * (1, -1) + (0, 1)
            lines += format_group(look, (points, uv), faces, book)
    (folder / f"{NAME}.obj").write_text("\n".join(lines) + "\n", encoding="ascii", newline="\n")
    looks = sorted({*whole, *side, "sign"})
    text = "\n\n".join(format_material(look) for look in looks) + "\n"
    (folder / f"{NAME}.mtl").write_text(text, encoding="ascii", newline="\n")
    for look in looks:
        if look in IMAGES:
            (folder / f"house_{look}.png").write_bytes(IMAGES[look]())


def format_group(
    look: str, rows: tuple[Points, Points], faces: Faces, book: dict[str, dict[tuple[float, ...], int]]
) -> list[str]:
    """Write the lines of one material; `book` maps numbers that are written already to their places."""
    lines: list[str] = []
    numbers: list[NDArray[np.int64]] = []
    for word, values in zip(("v", "vt"), rows, strict=True):
        known, found = book[word], []
        for row in round_points(values).tolist():
            if tuple(row) not in known:
                known[tuple(row)] = len(known) + 1
                lines.append(f"{word} " + " ".join(f"{value:.{DECIMALS}f}" for value in row))
            found.append(known[tuple(row)])
        numbers.append(np.array(found))
    corners = np.stack([number[faces] for number in numbers], axis=2).tolist()
    lines.append(f"usemtl {look}")
    lines += ["f " + " ".join(f"{point}/{uv}" for point, uv in face) for face in corners]
    return lines


def format_material(look: str) -> str:
    """Write a material of the library."""
    color = " ".join(map(str, TIMBER if look == "timber" else (1.0, 1.0, 1.0)))
    picture = f"\nmap_Kd house_{look}.png" if look in IMAGES else ""
    return f"newmtl {look}\nKd {color}\nd 1.0\nillum 1{picture}"
