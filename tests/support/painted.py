"""Make an over-sampled box that is textured, colored and labeled, as files; and check that a result still is.

Its six sides are islands in an atlas, so that each edge of the box is a seam. The two sides across x have an image of
their own. Colors change evenly over the box.
"""

from __future__ import annotations

import struct

import numpy as np
import trimesh
from PIL import Image
from shapes import fine_box

from bldsimp.model import Mesh

SIZE = 2.0
IMAGE = Image.new("RGB", (64, 32), (200, 90, 40))


def png(width: int, height: int) -> bytes:
    """Return the first bytes of an image, which state its size."""
    return b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + struct.pack(">II", width, height) + b"\x08\x02\0\0\0 pixels"


WALL, ROOF = png(512, 256), png(64, 64)


def side_of(corners: np.ndarray) -> np.ndarray:
    """Return the side of each face, 0 to 5, from its corners (m, 3, 3): twice the axis, plus 1 for the far one."""
    flat = [(np.all(corners[:, :, axis] == value, axis=1)) for axis in range(3) for value in (0.0, SIZE)]
    found = np.argmax(flat, axis=0)
    assert np.all(np.any(flat, axis=0))
    return found


def uv_of(corners: np.ndarray) -> np.ndarray:
    """Return the UV that corners of faces must have, (m, 3, 2), in numbers of single precision."""
    side = side_of(corners)
    axis = side // 2
    u = np.take_along_axis(corners, ((axis + 1) % 3)[:, None, None].repeat(3, axis=1), axis=2)[:, :, 0]
    v = np.take_along_axis(corners, ((axis + 2) % 3)[:, None, None].repeat(3, axis=1), axis=2)[:, :, 0]
    return np.stack([u / 16 + (side % 3)[:, None] / 4, v / 8 + (side // 3)[:, None] / 2], axis=2)


def color_of(points: np.ndarray) -> np.ndarray:
    """Return the colors that points must have: levels of 255 on every point of the fine box."""
    return np.rint(points / SIZE * 4) * 51 / 255


def material_of_side(side: np.ndarray) -> np.ndarray:
    """Return 1 for the sides across x, which have the other material, else 0."""
    return (side < 2).astype(int)


def obj(names: tuple[str, str] = ("wall", "roof"), library: str = "m.mtl", colors: bool = False) -> str:
    """Return the box as an OBJ file."""
    points, faces = fine_box()
    uv = uv_of(points[faces]).reshape(-1, 2)
    distinct, index = np.unique(uv, axis=0, return_inverse=True)
    index = index.reshape(-1, 3)
    lines = [f"mtllib {library}"]
    paint = color_of(points)
    lines += [
        "v " + " ".join(map(repr, [*p, *(c if colors else [])]))
        for p, c in zip(points.tolist(), paint.tolist(), strict=True)
    ]
    lines += [f"vt {u!r} {v!r}" for u, v in distinct.tolist()]
    of_material = material_of_side(side_of(points[faces]))
    for number, name in enumerate(names):
        lines.append(f"usemtl {name}")
        for face, own in zip(faces[of_material == number], index[of_material == number], strict=True):
            lines.append("f " + " ".join(f"{p + 1}/{t + 1}" for p, t in zip(face, own, strict=True)))
    return "\n".join(lines) + "\n"


def values(mesh: Mesh, name: str) -> np.ndarray:
    """Return the values of an attribute of a mesh."""
    return next(one.values for one in mesh.attributes if one.name == name)


def check_uv(mesh: Mesh) -> None:
    """Check that all corners of a mesh have the UV of their side and place, exactly."""
    corners = mesh.points[mesh.faces]
    assert np.array_equal(values(mesh, "TEXCOORD_0")[mesh.faces], uv_of(corners))


def side_areas(mesh: Mesh, chosen: np.ndarray) -> list[float]:
    """Return the area of some faces on each of the six sides."""
    corners = mesh.points[mesh.faces[chosen]]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    return np.bincount(side_of(corners), area, 6).tolist()


def textured() -> trimesh.Trimesh:
    """Return the painted box, its points repeated at seams."""
    points, faces = fine_box()
    corners = points[faces]
    rows = np.hstack([corners.reshape(-1, 3), uv_of(corners).reshape(-1, 2)])
    distinct, inverse = np.unique(rows, axis=0, return_inverse=True)
    material = trimesh.visual.material.SimpleMaterial(image=IMAGE, name="wall")
    visual = trimesh.visual.TextureVisuals(uv=distinct[:, 3:], material=material)
    return trimesh.Trimesh(distinct[:, :3], inverse.reshape(-1, 3), visual=visual, process=False)
