"""Poses and a camera laid out for the kernels."""

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from maskval.camera import Camera
from maskval.contour import ContourEdges
from maskval.geometry import Pose

Canvas = Literal["full", "3x3"]

# What is nearer to the camera's plane is cut off, as every renderer does; no lens is in focus there.
NEAR_M = 1e-3
# The full projection of what touches the near plane is all but unbounded: it ends this far beyond the image.
FULL_MARGIN_PX = 16_384

REGULAR, CLIPPED, UNSEEN = 0, 1, 2


class Views(NamedTuple):
    """N views of one mesh.

    Args:
        projections: From the mesh's frame M to homogeneous pixels with centres at whole numbers, (N, 3, 4).
        eyes_M: The camera's centre, (N, 3), metres, float32 like the planes that it is compared with.
        kinds: Whether the mesh lies before the near plane, may touch it, or lies behind it, (N,).
        near: Least depth of what is seen, metres.
        canvas: Left, top, right and bottom of the pixels over which the whole silhouette is counted, (4,).
        width: Image width, pixels.
        height: Image height, pixels.
    """

    projections: NDArray[np.float64]
    eyes_M: NDArray[np.float32]
    kinds: NDArray[np.int8]
    near: float
    canvas: NDArray[np.int64]
    width: int
    height: int


def views(edges: ContourEdges, poses: Sequence[Pose], camera: Camera, *, pixel_center: float, canvas: Canvas) -> Views:
    """The views of a mesh from a camera.

    Args:
        edges: The mesh.
        poses: X_CO of each view.
        camera: Intrinsics and image size.
        pixel_center: Where pixel i is sampled, u = i + pixel_center.
        canvas: "full" or "3x3", the pixels of the whole silhouette.

    Raises:
        ValueError: If the canvas is another, or the pixel centre is not in [0, 1).
    """
    if canvas not in ("full", "3x3"):
        raise ValueError(f"canvas must be 'full' or '3x3', but is {canvas!r}")
    if not 0 <= pixel_center < 1:
        raise ValueError(f"pixel_center must be in [0, 1), 0 for OpenCV and 0.5 for OpenGL, but is {pixel_center}")
    R_CM = np.array([pose.rotation for pose in poses]).reshape(-1, 3, 3)
    p_CO = np.array([pose.translation for pose in poses]).reshape(-1, 3)
    K = camera.K
    K[:2, 2] -= pixel_center
    p_CM = p_CO + R_CM @ edges.centre_O
    projections = K @ np.concatenate((R_CM, p_CM[:, :, None]), axis=2)
    eyes_M = -np.einsum("nij,ni->nj", R_CM, p_CM)

    depths, reach = p_CM[:, 2], edges.radius * (1 + 1e-9)
    kinds = np.where(depths - reach > NEAR_M, REGULAR, np.where(depths + reach < NEAR_M, UNSEEN, CLIPPED))
    return Views(
        projections,
        eyes_M.astype(np.float32),
        kinds.astype(np.int8),
        NEAR_M,
        _canvas(canvas, camera.width, camera.height),
        camera.width,
        camera.height,
    )


def _canvas(canvas: Canvas, width: int, height: int) -> NDArray[np.int64]:
    across, down = (FULL_MARGIN_PX, FULL_MARGIN_PX) if canvas == "full" else (width, height)
    return np.array((-across, -down, width + across, height + down))
