"""Call other tools where they are installed: each takes a target and returns a mesh, as a decimator does."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..model import Faces, Points
from .decimate import Arrays, RefusalError

FINEST = 10**9
"""A tool that takes a length, not a number of triangles, gets the diagonal divided by the target, up to this."""


@dataclass(frozen=True)
class Peer:
    """A tool that may be installed.

    Attributes
    ----------
    name : str
        Of its module, also in the table.
    run : callable
        Takes the module, points, faces, and the target.
    most : int or None
        Its greatest target; None where that is the number of faces.
    """

    name: str
    run: Callable[[Any, Points, Faces, int], Arrays]
    most: int | None = None

    def decimate(self, points: Points, faces: Faces, target: int) -> Arrays:
        """Return the remaining points and faces.

        Raises
        ------
        RefusalError
            With the message of the tool.
        """
        try:
            return self.run(importlib.import_module(self.name), points, faces, target)
        except ImportError as error:
            raise RefusalError(f"it cannot be loaded: {error}") from error
        except (RuntimeError, ValueError) as error:
            raise RefusalError(str(error)) from error


def find_peers() -> list[Peer]:
    """Find the tools that are installed, in the order of the table, without loading any."""
    return [peer for peer in PEERS if importlib.util.find_spec(peer.name) is not None]


def _run_manifold3d(module: Any, points: Points, faces: Faces, target: int) -> Arrays:
    """Simplify within a length."""
    solid = module.Manifold(module.Mesh64(points, faces.astype(np.uint64)))
    if solid.status() != module.Error.NoError:
        raise RefusalError(f"{solid.status().name}: it needs a closed manifold")
    length = float(np.linalg.norm(np.ptp(points, axis=0))) / target
    mesh = solid.simplify(length).to_mesh64()
    return np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts)


def _run_meshoptimizer(module: Any, points: Points, faces: Faces, target: int) -> Arrays:
    """Collapse edges by quadrics onto existing points, within a length, in single precision."""
    corners = np.ascontiguousarray(faces.reshape(-1), np.uint32)
    stored = np.ascontiguousarray(points, np.float32)
    kept = np.zeros_like(corners)
    length = float(np.linalg.norm(np.ptp(points, axis=0))) / target
    count = module.simplify(
        kept, corners, stored, target_index_count=0, target_error=length, options=module.SIMPLIFY_ERROR_ABSOLUTE
    )
    return points, kept[:count].reshape(-1, 3)


def _run_open3d(module: Any, points: Points, faces: Faces, target: int) -> Arrays:
    """Decimate by quadrics."""
    mesh = module.geometry.TriangleMesh(module.utility.Vector3dVector(points), module.utility.Vector3iVector(faces))
    made = mesh.simplify_quadric_decimation(target)
    return np.asarray(made.vertices), np.asarray(made.triangles)


def _run_pymeshlab(module: Any, points: Points, faces: Faces, target: int) -> Arrays:
    """Collapse edges by quadrics, with its option for planar places."""
    meshes = module.MeshSet(verbose=False)
    meshes.add_mesh(module.Mesh(points, faces))
    meshes.apply_filter("meshing_decimation_quadric_edge_collapse", targetfacenum=target, planarquadric=True)
    made = meshes.current_mesh()
    return made.vertex_matrix(), made.face_matrix()


def _run_pyfqmr(module: Any, points: Points, faces: Faces, target: int) -> Arrays:
    """Reduce by fast quadrics."""
    tool = module.Simplify()
    tool.setMesh(points, faces)
    tool.simplify_mesh(target_count=target, verbose=False)
    made, cells, _ = tool.getMesh()
    return made, cells


PEERS = (
    Peer("manifold3d", _run_manifold3d, FINEST),
    Peer("meshoptimizer", _run_meshoptimizer, FINEST),
    Peer("open3d", _run_open3d),
    Peer("pymeshlab", _run_pymeshlab),
    Peer("pyfqmr", _run_pyfqmr),
)
