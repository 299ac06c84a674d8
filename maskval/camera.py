"""The pinhole camera, in OpenCV's frame: x right, y down, z forward."""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from maskval.errors import InvalidCameraError, InvalidPoseError
from maskval.inputs.arrays import check_number, floats


@dataclass(frozen=True, slots=True)
class Camera:
    """A pinhole camera without distortion: `u = (fx x + skew y) / z + cx`, `v = fy y / z + cy`.

    Where in a pixel the image is sampled is not the camera's: see `pixel_center` of `silhouette`.

    Args:
        fx: Focal length along u, pixels, > 0.
        fy: Focal length along v, pixels, > 0.
        cx: Principal point, u, pixels.
        cy: Principal point, v, pixels.
        width: Image width, pixels, >= 1.
        height: Image height, pixels, >= 1.
        skew: Skew of the pixel axes, pixels.

    Raises:
        InvalidCameraError: If a number is not finite, a focal length is not positive, or the image has no pixels.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    width: int
    height: int
    skew: float = 0.0

    def __post_init__(self) -> None:
        for name in ("fx", "fy", "cx", "cy", "skew"):
            check_number(name, getattr(self, name), InvalidCameraError)
            if not math.isfinite(getattr(self, name)):
                raise InvalidCameraError(f"{name} must be finite, but is {getattr(self, name)}")
        for name in ("fx", "fy"):
            if getattr(self, name) <= 0:
                raise InvalidCameraError(f"{name} must be > 0 px, but is {getattr(self, name):g}")
        for name in ("width", "height"):
            size = getattr(self, name)
            check_number(name, size, InvalidCameraError)
            if not math.isfinite(size) or size != int(size) or size < 1:
                raise InvalidCameraError(f"{name} must be a whole number of pixels >= 1, but is {size}")
            object.__setattr__(self, name, int(size))

    @classmethod
    def from_K(cls, K: ArrayLike, width: int, height: int) -> Self:
        """The camera of a matrix of intrinsics.

        Args:
            K: (3, 3), upper triangular with last row 0 0 1, pixels.
            width: Image width, pixels.
            height: Image height, pixels.
        """
        matrix = floats("K", K, InvalidCameraError)
        if matrix.shape != (3, 3):
            raise InvalidCameraError(f"K must have shape (3, 3), but has {matrix.shape}")
        if not np.isfinite(matrix).all():
            raise InvalidCameraError(f"K must be finite, but is {matrix.tolist()}")
        if matrix[1, 0] != 0 or matrix[2].tolist() != [0, 0, 1]:
            raise InvalidCameraError(f"K must be upper triangular with last row 0 0 1, but is {matrix.tolist()}")
        fx, skew, cx, fy, cy = (float(matrix[index]) for index in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2)))
        return cls(fx, fy, cx, cy, width, height, skew)

    @property
    def K(self) -> NDArray[np.float64]:
        """The matrix of intrinsics, (3, 3), pixels."""
        return np.array(((self.fx, self.skew, self.cx), (0.0, self.fy, self.cy), (0.0, 0.0, 1.0)))

    def project(self, points_C: ArrayLike) -> NDArray[np.float64]:
        """The image coordinates u, v of points, (..., 2), pixels; they may lie outside the image.

        Args:
            points_C: Points in the camera frame, (..., 3), metres, z > 0.

        Raises:
            InvalidPoseError: If a point is not in front of the camera, or the shape is wrong.
        """
        points = floats("points_C", points_C, InvalidPoseError)
        if points.shape[-1:] != (3,):
            raise InvalidPoseError(f"points_C must have shape (..., 3), but has {points.shape}")
        x, y, z = np.moveaxis(points, -1, 0)
        if not np.all(z > 0):
            raise InvalidPoseError(f"points_C must lie in front of the camera, but the least z is {np.min(z):g} m")
        return np.stack(((self.fx * x + self.skew * y) / z + self.cx, self.fy * y / z + self.cy), axis=-1)
