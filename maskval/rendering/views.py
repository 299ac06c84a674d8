"""Poses and a camera laid out for the kernels."""

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from maskval.camera import Camera
from maskval.errors import InvalidArgumentError
from maskval.geometry import PosesLike, as_poses
from maskval.rendering.lens import Box, Floats, Lens, Point, Rows, lens

Canvas = Literal["full", "3x3"]

# What is nearer to the camera's plane is cut off, as every renderer does; no lens is in focus there.
NEAR_M = 1e-3
# The full projection of what touches the near plane is all but unbounded: it ends this far beyond the image.
FULL_MARGIN_PX = 16_384

REGULAR, CLIPPED, UNSEEN = 0, 1, 2


class Frame(NamedTuple):
    """What all views from one camera share.

    Args:
        lens: Intrinsics.
        near: Least depth of what is seen, metres.
        canvas: The pixels over which the whole silhouette is counted.
        width: Image width, pixels.
        height: Image height, pixels.
    """

    lens: Lens
    near: float
    canvas: Box
    width: int
    height: int


class View(NamedTuple):
    """A mesh under a pose.

    Args:
        projection: From the mesh's frame M to homogeneous pixels with centres at whole numbers.
        eye_M: The camera's centre, metres.
        kind: Whether the mesh lies before the near plane, may touch it, or lies behind it.
    """

    projection: Rows
    eye_M: Point
    kind: int


def frame(camera: Camera, *, pixel_center: float, canvas: Canvas) -> Frame:
    """What all views from a camera share.

    Args:
        camera: Intrinsics and image size.
        pixel_center: Where pixel i is sampled, u = i + pixel_center.
        canvas: "full" or "3x3", the pixels of the whole silhouette.

    Raises:
        InvalidArgumentError: If the canvas is another, or the pixel centre is not in [0, 1).
    """
    if canvas not in ("full", "3x3"):
        raise InvalidArgumentError(f"canvas must be 'full' or '3x3', but is {canvas!r}")
    width, height = camera.width, camera.height
    across, down = (FULL_MARGIN_PX, FULL_MARGIN_PX) if canvas == "full" else (width, height)
    return Frame(lens(camera, pixel_center), NEAR_M, (-across, -down, width + across, height + down), width, height)


def stacked(poses: PosesLike) -> tuple[Floats, Floats]:
    """Rotations, (N, 3, 3), and translations, (N, 3), in arrays of their own."""
    made = as_poses(poses)
    if not made:
        return np.empty((0, 3, 3)), np.empty((0, 3))
    rotations: NDArray[np.float64] = np.concatenate([pose.rotation for pose in made])
    translations: NDArray[np.float64] = np.concatenate([pose.translation for pose in made])
    return rotations.reshape(-1, 3, 3), translations.reshape(-1, 3)


def kind(depth: float, radius: float, near: float) -> int:
    """Where a sphere around the mesh, with its centre at a depth, lies to the near plane."""
    reach = radius * (1 + 1e-9)
    if depth - reach > near:
        return 0
    return 2 if depth + reach < near else 1
