"""How a camera projects a mesh: arithmetic that NumPy and Numba do alike, written once, as plain sums and products."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from maskval.camera import Camera
from maskval.inputs.arrays import check_number

Floats = NDArray[np.float64]
Lens = tuple[float, float, float, float, float]  # fx, skew, cx, fy, cy, pixels; centres of pixels at whole numbers
Row = tuple[float, float, float, float]
Rows = tuple[Row, Row, Row]
Point = tuple[float, float, float]
Box = tuple[int, int, int, int]  # left, top, right and bottom of pixels


class View(NamedTuple):
    """How a mesh is seen.

    Args:
        rotation: R_CO, (3, 3).
        translation: p_CO, (3,), metres.
        lens: Intrinsics.
        near: Least depth of what is seen, metres.
        is_solid: Whether the mesh bounds a volume, so that its faces are seen from outside only.
    """

    rotation: Floats
    translation: Floats
    lens: Lens
    near: float
    is_solid: bool


class Layers(NamedTuple):
    """What is nearest at the pixels of an image, or of a box in it.

    Args:
        inverse: Inverse depth, (h, w), 1/m; 0 where nothing is.
        numbers: Number of the body, (h, w), or (0, 0) where none is asked for.
        left: Column of the image that the first column is.
        top: Row of the image that the first row is.
    """

    inverse: Floats
    numbers: NDArray[np.int8]
    left: int
    top: int


def lens(camera: Camera, pixel_center: float) -> Lens:
    """The intrinsics of a camera whose pixel i is sampled at u = i.

    Args:
        camera: Intrinsics and image size.
        pixel_center: Where pixel i is sampled, u = i + pixel_center.

    Raises:
        InvalidArgumentError: If the pixel centre is not in [0, 1).
    """
    check_number("pixel_center", pixel_center, least=0, most=1, ends="[)")  # 0: OpenCV, 0.5: OpenGL
    cx, cy = camera.cx - pixel_center, camera.cy - pixel_center
    # Floats of Python: Numba would compile anew for whole numbers.
    return float(camera.fx), float(camera.skew), float(cx), float(camera.fy), float(cy)


def centred(rotation: Floats, translation: Floats, centre_O: Floats) -> Rows:
    """X_CM, from the mesh's frame M to the camera's, as three rows; M is O shifted to the mesh's middle."""
    rows = [
        (
            rotation[i, 0],
            rotation[i, 1],
            rotation[i, 2],
            translation[i]
            + (rotation[i, 0] * centre_O[0] + rotation[i, 1] * centre_O[1] + rotation[i, 2] * centre_O[2]),
        )
        for i in range(3)
    ]
    return rows[0], rows[1], rows[2]


def projection(lens: Lens, X_CM: Rows) -> Rows:
    """From the mesh's frame M to homogeneous pixels, three rows."""
    fx, skew, cx, fy, cy = lens
    (a, b, c, d), (e, f, g, h), (i, j, k, m) = X_CM
    return (
        (
            fx * a + skew * e + cx * i,
            fx * b + skew * f + cx * j,
            fx * c + skew * g + cx * k,
            fx * d + skew * h + cx * m,
        ),
        (fy * e + cy * i, fy * f + cy * j, fy * g + cy * k, fy * h + cy * m),
        (i, j, k, m),
    )


def eye(X_CM: Rows) -> Point:
    """The camera's centre in M, metres."""
    (a, b, c, d), (e, f, g, h), (i, j, k, m) = X_CM
    return -(a * d + e * h + i * m), -(b * d + f * h + j * m), -(c * d + g * h + k * m)
