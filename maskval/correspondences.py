"""Points of an object and where they were seen in an image: what a pose can be computed from and judged by."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from maskval.camera import Camera
from maskval.errors import InvalidEstimatesError
from maskval.geometry import Pose
from maskval.inputs.arrays import floats

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Correspondences:
    """M points of an object and where an estimator saw them.

    Args:
        points_O: The points, (M, 3), metres.
        pixels: Where they were seen, u and v, (M, 2), pixels.
        sigma_px: How sure the estimator was, (M,), pixels, > 0: the scale of the error that it expects.

    Raises:
        InvalidEstimatesError: If a shape is wrong, a number is not finite, or a sigma is not positive.
    """

    points_O: Array
    pixels: Array
    sigma_px: Array

    def __post_init__(self) -> None:
        count = floats("sigma_px", self.sigma_px, InvalidEstimatesError).size
        for name, shape in (("points_O", (count, 3)), ("pixels", (count, 2)), ("sigma_px", (count,))):
            array = floats(name, getattr(self, name), InvalidEstimatesError)
            if array.shape != shape or not np.isfinite(array).all():
                raise InvalidEstimatesError(f"{name} must be finite and of shape {shape}, but has {array.shape}")
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        if not (self.sigma_px > 0).all():
            raise InvalidEstimatesError(f"sigma_px must be > 0, but the least is {self.sigma_px.min():g}")

    def __len__(self) -> int:
        return len(self.sigma_px)

    def errors_px(self, X_CO: Pose, camera: Camera) -> Array:
        """How far each point would lie from where it was seen, u and v, (M, 2), pixels; infinite behind the camera.

        Args:
            X_CO: Pose of the object.
            camera: Intrinsics.
        """
        return reprojection(self.points_O, self.pixels, X_CO, camera)


def reprojection(points_O: Array, pixels: Array, X_CO: Pose, camera: Camera) -> Array:
    """Projected less seen coordinates, (M, 2), pixels; infinite for points that are not before the camera."""
    points_C = X_CO.apply(points_O)
    errors = np.full((len(points_C), 2), np.inf)
    before = points_C[:, 2] > 0
    errors[before] = camera.project(points_C[before]) - pixels[before]
    return errors


def jacobian(points_C: Array, origin_C: Array, camera: Camera) -> Array:
    """How a small turn of an object about its origin, then a shift, move its points in the image, (M, 2, 6).

    Args:
        points_C: The points, (M, 3), metres, z > 0.
        origin_C: The object's origin, (3,), metres.
        camera: Intrinsics.

    Returns:
        Pixels per radian about C's x, y and z, and per metre along them.
    """
    x, y, z = points_C.T
    zero = np.zeros_like(z)
    u = np.stack((camera.fx / z, camera.skew / z, -(camera.fx * x + camera.skew * y) / z**2), axis=1)
    v = np.stack((zero, camera.fy / z, -camera.fy * y / z**2), axis=1)
    per_shift = np.stack((u, v), axis=1)
    arms = points_C - origin_C
    # d(ω × arm)/dω applied from the left: row · (ω × arm) = ω · (arm × row).
    per_turn = np.cross(arms[:, None, :], per_shift)
    return np.concatenate((per_turn, per_shift), axis=2)
