"""The depth that a camera measures of a mesh under a pose."""

from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Protocol, cast

import numpy as np
from numpy.typing import NDArray

from maskval.camera import Camera
from maskval.geometry import Pose
from maskval.mesh import Mesh
from maskval.rendering.reference import homogeneous
from maskval.rendering.silhouettes import Implementation
from maskval.rendering.views import CLIPPED, UNSEEN, Views, views


@dataclass(frozen=True, slots=True, eq=False)
class DepthCrop:
    """The depth inside the box of a silhouette.

    Args:
        depth: z-depth, (h, w), metres, float32; 0 where the mesh is not.
        left: Column of the image that the first column is.
        top: Row of the image that the first row is.
    """

    depth: NDArray[np.float32]
    left: int
    top: int

    def __post_init__(self) -> None:
        self.depth.setflags(write=False)


def depth_image(
    mesh: Mesh,
    X_CO: Pose,
    camera: Camera,
    *,
    pixel_center: float = 0.0,
    implementation: Implementation = "numba",
) -> NDArray[np.float32]:
    """The z-depth of a mesh in the image, (H, W), metres, float32; 0 where the mesh is not.

    Args:
        mesh: The object.
        X_CO: Pose of the object in the camera frame; what is nearer than 1 mm to the camera's plane is cut off.
        camera: Intrinsics and image size.
        pixel_center: Where pixel i is sampled, u = i + pixel_center: 0 for OpenCV, 0.5 for OpenGL, MuJoCo and BOP.
        implementation: "numba", or the slower "numpy" of the same result, which compiles nothing.
    """
    crop = depth_crop(mesh, X_CO, camera, pixel_center=pixel_center, implementation=implementation)
    image = np.zeros((camera.height, camera.width), dtype=np.float32)
    height, width = crop.depth.shape
    image[crop.top : crop.top + height, crop.left : crop.left + width] = crop.depth
    return image


def depth_crop(
    mesh: Mesh,
    X_CO: Pose,
    camera: Camera,
    *,
    pixel_center: float = 0.0,
    implementation: Implementation = "numba",
) -> DepthCrop:
    """The z-depth of a mesh in the part of the image that holds it, which may be empty.

    Args:
        mesh: The object.
        X_CO: Pose of the object in the camera frame; what is nearer than 1 mm to the camera's plane is cut off.
        camera: Intrinsics and image size.
        pixel_center: Where pixel i is sampled, u = i + pixel_center: 0 for OpenCV, 0.5 for OpenGL, MuJoCo and BOP.
        implementation: "numba", or the slower "numpy" of the same result, which compiles nothing.
    """
    view = views(mesh.edges, (X_CO,), camera, pixel_center=pixel_center, canvas="3x3")
    points, triangles = _visible(mesh, view)
    if len(triangles) == 0:
        return DepthCrop(np.zeros((0, 0), dtype=np.float32), 0, 0)
    size = np.array((camera.width, camera.height))
    u, v = points[:, 0], points[:, 1]
    low = np.clip(np.ceil((u.min(), v.min())), 0, size).astype(np.int64)
    high = np.clip(np.ceil((u.max(), v.max())), low, size).astype(np.int64)
    depth = np.empty((high - low)[::-1], dtype=np.float32)
    _kernel(implementation).nearest(points, triangles, int(low[0]), int(low[1]), depth)
    return DepthCrop(depth, int(low[0]), int(low[1]))


def _visible(mesh: Mesh, view: Views) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
    """u, v and inverse depth of the corners, (V, 3), and the triangles that may be seen, (F, 3)."""
    edges = mesh.edges
    kind = view.kinds[0]
    corners = homogeneous(view.projections[0], edges.vertices_M)
    triangles = edges.faces
    if kind == UNSEEN:
        return corners, triangles[:0]
    if kind == CLIPPED:
        corners, triangles = _cut(corners, triangles, view.near)
    elif mesh.is_solid:
        # From outside, the faces of a solid that look away are hidden by those that look at the camera.
        nx, ny, nz, offset = edges.planes_M
        x, y, z = view.eyes_M[0]
        triangles = triangles.take(np.flatnonzero(nx * x + ny * y + nz * z + offset > 0), axis=0)
    points = np.empty_like(corners)
    np.divide(1.0, corners[:, 2], out=points[:, 2])
    for axis in range(2):  # a column at a time is ten times as fast as both
        np.multiply(corners[:, axis], points[:, 2], out=points[:, axis])
    return points, triangles


def _cut(
    corners: NDArray[np.float64], triangles: NDArray[np.uint32], near: float
) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
    """The triangles' parts before the near plane, with corners of their own."""
    soup = corners[triangles]
    before = soup[..., 2] >= near
    parts = [soup[before.all(axis=1)]]
    for triangle, inside in zip(soup, before, strict=True):
        if inside.all() or not inside.any():
            continue
        # Turn the triangle so that its first corner is alone on its side.
        lone = int(np.argmax(inside == (inside.sum() == 1)))
        a, b, c = np.roll(triangle, -lone, axis=0)
        ab, ac = (a + (other - a) * ((near - a[2]) / (other[2] - a[2])) for other in (b, c))
        ab[2] = ac[2] = near
        parts.append(np.array([[a, ab, ac]] if inside.sum() == 1 else [[ab, b, c], [ab, c, ac]]))
    kept = np.concatenate(parts)
    return kept.reshape(-1, 3), np.arange(3 * len(kept), dtype=np.uint32).reshape(-1, 3)


class _Kernel(Protocol):
    """What both implementations offer."""

    def nearest(
        self,
        points: NDArray[np.float64],
        triangles: NDArray[np.uint32],
        left: int,
        top: int,
        depth: NDArray[np.float32],
    ) -> None: ...


@cache
def _kernel(implementation: Implementation) -> _Kernel:
    modules = {"numba": "maskval.rendering.depth_kernels", "numpy": "maskval.rendering.depth_reference"}
    if implementation not in modules:
        raise ValueError(f"implementation must be one of {sorted(modules)}, but is {implementation!r}")
    return cast(_Kernel, import_module(modules[implementation]))
