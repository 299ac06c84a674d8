"""Points all over a surface, with the normals there."""

from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray

SPACING = 0.0012  # m between points, about
_FEWEST, _MOST = 8_000, 30_000


@dataclass(frozen=True, slots=True, eq=False)
class SurfacePoints:
    """Points (N, 3) m and outward normals (N, 3) of a surface, in O; the corners of the mesh come last.

    Attributes:
        points: m.
        normals: of the faces; at a corner the mean of those around it.
        flat: how many come before the corners.
    """

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    flat: int

    def __post_init__(self) -> None:
        for name in ("points", "normals"):
            held = np.array(getattr(self, name))
            held.flags.writeable = False
            object.__setattr__(self, name, held)


def sample_surface(mesh: trimesh.Trimesh, seed: int = 0) -> SurfacePoints:
    """Points spread over the mesh by area, every corner among them; the same for the same mesh.

    Args:
        mesh: a closed surface.
        seed: of the draws.
    """
    count = int(np.clip(mesh.area / SPACING**2, _FEWEST, _MOST))
    points, faces = trimesh.sample.sample_surface(mesh, count, seed=seed)
    corners = mesh.vertices if len(mesh.vertices) <= _FEWEST else mesh.vertices[:: len(mesh.vertices) // _FEWEST + 1]
    used = mesh.vertex_normals if len(corners) == len(mesh.vertices) else _normals_at(mesh, corners)
    return SurfacePoints(np.vstack([points, corners]), np.vstack([mesh.face_normals[faces], used]), len(points))


def _normals_at(mesh: trimesh.Trimesh, corners: NDArray[np.float64]) -> NDArray[np.float64]:
    normals: NDArray[np.float64] = mesh.vertex_normals[:: len(mesh.vertices) // _FEWEST + 1][: len(corners)]
    return normals
