"""Closed solids of manifold3d, which the extra `parts` brings: simplified, joined, measured."""

# ruff: noqa: PLC0415  # an extra

from collections.abc import Sequence
from typing import Any

import numpy as np
import trimesh

from sim.errors import PartExtraError


def extra(name: str) -> Any:
    """A module of the extra `parts`.

    Raises:
        PartExtraError: it is not installed.
    """
    import importlib

    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise PartExtraError(f"{name} is not installed; type: pip install 'graspcell[parts]'") from error


def solid_of(mesh: trimesh.Trimesh) -> Any | None:
    """The solid that a closed mesh bounds; None where the mesh bounds none."""
    manifold3d = extra("manifold3d")
    data = manifold3d.Mesh64(np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.uint64))
    solid = manifold3d.Manifold(data)
    return solid if solid.status() == manifold3d.Error.NoError and not solid.is_empty() else None


def mesh_of(solid: Any) -> trimesh.Trimesh:
    """The surface of a solid."""
    data = solid.to_mesh64()
    return trimesh.Trimesh(np.asarray(data.vert_properties)[:, :3], np.asarray(data.tri_verts), process=True)


def joined(solids: Sequence[Any]) -> Any:
    """All of the space that the solids fill."""
    manifold3d = extra("manifold3d")
    return manifold3d.Manifold.batch_boolean(list(solids), manifold3d.OpType.Add)


def simplified(mesh: trimesh.Trimesh, faces: int, tolerances: Sequence[float]) -> tuple[trimesh.Trimesh, float]:
    """A mesh of at most so many faces, and by how much its surface may have moved, m.

    Args:
        mesh: a closed mesh.
        faces: how many are enough.
        tolerances: m, increasing; the first that is enough is taken, else the last.
    """
    solid = solid_of(mesh)
    if solid is None or len(mesh.faces) <= faces:
        return mesh, 0.0
    for tolerance in tolerances:
        made = mesh_of(solid.simplify(tolerance))
        if len(made.faces) <= faces:
            break
    return (made, tolerance) if made.is_watertight and made.volume > 0 else (mesh, 0.0)
