"""The depth that a camera measures of a mesh under a pose."""

from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Protocol, cast

import numpy as np
from numpy.typing import NDArray

from maskval.camera import Camera
from maskval.contour import ContourEdges
from maskval.errors import InvalidArgumentError
from maskval.geometry import PoseLike, as_pose
from maskval.masks import Implementation
from maskval.mesh import Mesh
from maskval.rendering.lens import Box, Floats, Layers, View, lens
from maskval.rendering.views import NEAR_M


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
    X_CO: PoseLike,
    camera: Camera,
    *,
    pixel_center: float = 0.0,
    implementation: Implementation = "numba",
) -> NDArray[np.float32]:
    """The z-depth of a mesh in the image, (H, W), metres, float32; 0 where the mesh is not.

    Args:
        mesh: The object.
        X_CO: Pose of the object in the camera frame, or its matrix, (4, 4). What is nearer than 1 mm to the camera's
            plane is cut off.
        camera: Intrinsics and image size.
        pixel_center: Where pixel i is sampled, u = i + pixel_center: 0 for OpenCV, 0.5 for OpenGL, MuJoCo and BOP.
        implementation: "numba", or the slower "numpy" of the same result, which compiles nothing.
    """
    image, _, _ = _depth(mesh, X_CO, camera, pixel_center=pixel_center, implementation=implementation, whole=True)
    return image


def depth_crop(
    mesh: Mesh,
    X_CO: PoseLike,
    camera: Camera,
    *,
    pixel_center: float = 0.0,
    implementation: Implementation = "numba",
) -> DepthCrop:
    """The z-depth of a mesh in the part of the image that holds it, which may be empty.

    Args:
        mesh: The object.
        X_CO: Pose of the object in the camera frame, or its matrix, (4, 4). What is nearer than 1 mm to the camera's
            plane is cut off.
        camera: Intrinsics and image size.
        pixel_center: Where pixel i is sampled, u = i + pixel_center: 0 for OpenCV, 0.5 for OpenGL, MuJoCo and BOP.
        implementation: "numba", or the slower "numpy" of the same result, which compiles nothing.
    """
    crop = _depth(mesh, X_CO, camera, pixel_center=pixel_center, implementation=implementation, whole=False)
    return DepthCrop(*crop)


def _depth(
    mesh: Mesh, X_CO: PoseLike, camera: Camera, *, pixel_center: float, implementation: Implementation, whole: bool
) -> tuple[NDArray[np.float32], int, int]:
    """The depth in the whole image or in the box around the mesh, and the first column and row of that."""
    X_CO = as_pose(X_CO)
    view = View(X_CO.rotation, X_CO.translation, lens(camera, pixel_center), NEAR_M, mesh.is_solid)
    return depth_kernel(implementation).depth(mesh.edges, view, (camera.width, camera.height), whole)


class _Kernel(Protocol):
    """What both implementations offer."""

    def draw(self, edges: ContourEdges, view: View, number: int, box: Box, layers: Layers) -> Box: ...

    def depth(
        self, edges: ContourEdges, view: View, size: tuple[int, int], whole: bool
    ) -> tuple[NDArray[np.float32], int, int]: ...

    def invert(self, inverse: Floats) -> NDArray[np.float32]: ...


@cache
def depth_kernel(implementation: Implementation) -> _Kernel:
    """The kernel's module, imported at its first use: Numba takes a second."""
    modules = {"numba": "maskval.rendering.depth_kernels", "numpy": "maskval.rendering.depth_reference"}
    if implementation not in modules:
        raise InvalidArgumentError(f"implementation must be one of {sorted(modules)}, but is {implementation!r}")
    return cast(_Kernel, import_module(modules[implementation]))
