"""What Python users may pass, and the one clear error that they get for anything else."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import trimesh
from shapes import fine_box

import bldsimp
from bldsimp import BldsimpError, InputError, Options, Tolerance, UsageError, simplify

POINTS = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
FACES = [[0, 1, 2], [0, 2, 3]]


@pytest.mark.parametrize(
    ("given", "length"),
    [
        (0.25, 0.25),
        (1, 1.0),
        (np.float32(0.25), 0.25),
        (np.int8(1), 1.0),
        ("0.25", 0.25),
        ("50%", np.sqrt(12.0) / 2),
        (Tolerance(50, "percent"), np.sqrt(12.0) / 2),
        (1e308, 1e308),
    ],
)
def test_a_tolerance_is_a_number_or_what_the_command_line_takes(given: Any, length: float) -> None:
    light = simplify(fine_box(), given)
    assert light.report.tolerance == pytest.approx(length)
    assert light.report.after.points <= 8


def test_auto_is_what_is_left_out() -> None:
    tolerances = {simplify(fine_box(), given).report.tolerance for given in (None, "auto", " AUTO ", Tolerance())}
    assert len(tolerances) == 1


@pytest.mark.parametrize(
    "given", [True, False, -1, -0.1, np.nan, np.inf, 1j, [1], (), b"1", 10**400, "much", "", "-1", "1%%", object()]
)
def test_what_is_no_tolerance_is_refused(given: Any) -> None:
    with pytest.raises(UsageError, match=r"^(tolerance )?['\"].*give a number that is finite and not negative"):
        simplify((POINTS, FACES), given)


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: Options(weld=-1.0), "weld '-1.0'"),
        (lambda: Options(weld=True), "weld 'True'"),
        (lambda: Options(tolerance=0.1), "give a Tolerance"),  # type: ignore[arg-type]
        (lambda: Options(normals="pretty"), "normals 'pretty': choose one of auto, flat"),
        (lambda: Tolerance(1.0, "inch"), "unit 'inch': choose one of auto, length, percent"),
        (lambda: Tolerance(np.nan, "length"), "tolerance 'nan'"),
    ],
)
def test_options_are_checked_where_they_are_made(make: Any, told: str) -> None:
    with pytest.raises(UsageError, match=told):
        make()


@pytest.mark.parametrize(
    "mesh",
    [None, 3, "house.obj", "ab", (), (POINTS,), (POINTS, FACES, FACES), {"points": 1, "faces": 2}, trimesh.Scene()],
    ids=lambda mesh: str(mesh)[:20],
)
def test_what_is_no_mesh_is_refused(mesh: Any) -> None:
    with pytest.raises(InputError, match=r"the mesh is of type \w+: give a trimesh.Trimesh or \(points, faces\)"):
        simplify(mesh)


@pytest.mark.parametrize(
    ("points", "told"),
    [
        (np.array(POINTS) * 1j, r"points have shape \(4, 3\) and type complex128"),
        ([[0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "points are no array"),
        ([["a", "b", "c"]] * 4, "points have .* type <U1"),
        ([[None] * 3] * 4, "points have .* type object"),
        (np.zeros((4, 2)), r"points have shape \(4, 2\)"),
        (np.zeros(12), r"points have shape \(12,\)"),
        (np.zeros((4, 3, 1)), r"points have shape \(4, 3, 1\)"),
        (np.ones((4, 3), bool), "type bool"),
        (5, r"points have shape \(\)"),
        ([[np.nan, 0, 0], *POINTS[1:]], "not finite .* 0: 0:"),
        (np.array(POINTS) * 1e150, "beyond 1e100"),
    ],
)
def test_points_that_are_none_are_refused(points: Any, told: str, recwarn: pytest.WarningsRecorder) -> None:
    with pytest.raises(InputError, match=told):
        simplify((points, FACES))
    assert not recwarn.list


@pytest.mark.parametrize(
    ("faces", "told"),
    [
        (None, r"faces have shape \(\) and type object: give \(m, 3\) integers"),
        (np.array(FACES, float), "type float64"),
        (np.array(FACES, bool), "type bool"),
        ([[0, 1, 2, 3]], r"faces have shape \(1, 4\)"),
        ([[0, 1, 2], [0, 1, 2, 3]], "faces are no array"),
        ([[0, 1, -1]], r"faces \[0\] use points that are not there: there are 4"),
        ([[0, 1, 2], [0, 1, 4]], r"faces \[1\] use"),
        (np.array([[0, 1, 2**63]], np.uint64), r"faces \[0\] use"),
    ],
)
def test_faces_that_are_none_are_refused(faces: Any, told: str) -> None:
    with pytest.raises(InputError, match=told):
        simplify((POINTS, faces))


@pytest.mark.parametrize(
    "mesh",
    [
        ([], []),
        (np.zeros((0, 3)), np.zeros((0, 3), int)),
        (np.zeros((0, 3)), np.zeros((0, 3))),
        (POINTS, []),
        (POINTS, [[0, 0, 0]]),
        trimesh.Trimesh(),
    ],
    ids=lambda mesh: str(mesh)[:20],
)
def test_without_faces_the_result_is_empty(mesh: Any) -> None:
    light = simplify(mesh)
    points, faces = light.mesh if isinstance(light.mesh, tuple) else (light.mesh.vertices, light.mesh.faces)
    assert (points.shape, faces.shape) == ((0, 3), (0, 3))
    assert light.facets == []
    assert light.report.after.watertight is False


def test_a_primitive_becomes_a_mesh() -> None:
    light = simplify(trimesh.primitives.Box())
    assert type(light.mesh) is trimesh.Trimesh
    assert (len(light.mesh.vertices), len(light.mesh.faces)) == (8, 12)


def test_every_public_name_is_there_and_no_other() -> None:
    for name in bldsimp.__all__:
        assert getattr(bldsimp, name).__name__ == name
        assert name in dir(bldsimp)
    assert issubclass(UsageError, BldsimpError)
    with pytest.raises(AttributeError, match="no attribute 'simplfy'"):
        _ = bldsimp.simplfy  # type: ignore[attr-defined]
