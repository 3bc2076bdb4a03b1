"""Other tools, where they are installed: each takes a target and gives a mesh, as a decimator does."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..model import Faces, Points
from .decimate import Arrays, Refused

FINEST = 10**9
"""A tool that takes a length instead of a number of triangles gets the diagonal by the target, up to this."""


@dataclass(frozen=True)
class Peer:
    """A tool that is installed.

    Attributes
    ----------
    name : str
        Of its module, and in the table.
    run : callable
        Takes the module, points, faces, and the target.
    most : int or None
        Its greatest target; None where that is the number of faces.
    """

    name: str
    run: Callable[[Any, Points, Faces, int], Arrays]
    most: int | None = None

    def decimate(self, points: Points, faces: Faces, target: int) -> Arrays:
        """Points and faces that are left.

        Raises
        ------
        Refused
            With what the tool says.
        """
        try:
            return self.run(importlib.import_module(self.name), points, faces, target)
        except ImportError as error:
            raise Refused(f"it cannot be loaded: {error}") from error
        except (RuntimeError, ValueError) as error:
            raise Refused(str(error)) from error


def installed_peers() -> list[Peer]:
    """The tools that are there, in the order of the table; none is loaded yet."""
    return [peer for peer in PEERS if importlib.util.find_spec(peer.name) is not None]


def _manifold3d(module: Any, points: Points, faces: Faces, target: int) -> Arrays:
    """Manifold's own simplification, within a length."""
    solid = module.Manifold(module.Mesh64(points, faces.astype(np.uint64)))
    if solid.status() != module.Error.NoError:
        raise Refused(f"{solid.status().name}: it wants a closed manifold")
    length = float(np.linalg.norm(np.ptp(points, axis=0))) / target
    mesh = solid.simplify(length).to_mesh64()
    return np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts)


def _meshoptimizer(module: Any, points: Points, faces: Faces, target: int) -> Arrays:
    """Quadric edge collapse onto points that are there, within a length; it works in single precision."""
    corners = np.ascontiguousarray(faces.reshape(-1), np.uint32)
    stored = np.ascontiguousarray(points, np.float32)
    left = np.zeros_like(corners)
    length = float(np.linalg.norm(np.ptp(points, axis=0))) / target
    count = module.simplify(
        left, corners, stored, target_index_count=0, target_error=length, options=module.SIMPLIFY_ERROR_ABSOLUTE
    )
    return points, left[:count].reshape(-1, 3)


def _open3d(module: Any, points: Points, faces: Faces, target: int) -> Arrays:
    """Quadric decimation."""
    mesh = module.geometry.TriangleMesh(module.utility.Vector3dVector(points), module.utility.Vector3iVector(faces))
    left = mesh.simplify_quadric_decimation(target)
    return np.asarray(left.vertices), np.asarray(left.triangles)


def _pymeshlab(module: Any, points: Points, faces: Faces, target: int) -> Arrays:
    """Quadric edge collapse that knows of flat places."""
    meshes = module.MeshSet(verbose=False)
    meshes.add_mesh(module.Mesh(points, faces))
    meshes.apply_filter("meshing_decimation_quadric_edge_collapse", targetfacenum=target, planarquadric=True)
    left = meshes.current_mesh()
    return left.vertex_matrix(), left.face_matrix()


def _pyfqmr(module: Any, points: Points, faces: Faces, target: int) -> Arrays:
    """Fast quadric mesh reduction."""
    tool = module.Simplify()
    tool.setMesh(points, faces)
    tool.simplify_mesh(target_count=target, verbose=False)
    left, cells, _ = tool.getMesh()
    return left, cells


PEERS = (
    Peer("manifold3d", _manifold3d, FINEST),
    Peer("meshoptimizer", _meshoptimizer, FINEST),
    Peer("open3d", _open3d),
    Peer("pymeshlab", _pymeshlab),
    Peer("pyfqmr", _pyfqmr),
)
