"""The visible surface discrepancy (VSD), BOP's pose error for what a depth camera can see."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from maskval.camera import Camera
from maskval.errors import InvalidPoseError
from maskval.geometry import PoseLike
from maskval.inputs.arrays import check_number, floats
from maskval.mesh import Mesh
from maskval.rendering.depth import depth_image

# BOP's tolerance for what is hidden behind what the camera measured.
DELTA_M = 0.015


def vsd(
    mesh: Mesh,
    X_CO_est: PoseLike,
    X_CO_true: PoseLike,
    measured_depth: ArrayLike,
    camera: Camera,
    *,
    taus_m: ArrayLike,
    delta_m: float = DELTA_M,
    pixel_center: float = 0.0,
) -> NDArray[np.float64]:
    """The share of the visible pixels of either pose at which the surfaces do not match, in [0, 1], for each tau.

    A pixel of a pose is visible where its distance from the camera is at most delta beyond the measured one, or where
    nothing was measured; and a pixel of the estimate also where the true pose is visible. Pixels match that are
    visible in both, at distances less than tau apart. Where no pixel is visible, the error is 1.

    Args:
        mesh: The object.
        X_CO_est: Estimated pose.
        X_CO_true: True pose.
        measured_depth: z-depth of the scene, (H, W), metres; 0 where nothing was measured.
        camera: Intrinsics and image size.
        taus_m: Tolerances of the surfaces' distance, (T,), metres; BOP's are 5 % to 50 % of the diameter.
        delta_m: Tolerance of the visibility, metres.
        pixel_center: Where pixel i is sampled, u = i + pixel_center: 0 for OpenCV, 0.5 for OpenGL and MuJoCo.

    Raises:
        InvalidPoseError: If the depth image has another size or a value that is no depth, or a tolerance is not > 0.
    """
    depth = floats("measured_depth", measured_depth, InvalidPoseError)
    if depth.shape != (camera.height, camera.width):
        raise InvalidPoseError(f"depth must have shape {(camera.height, camera.width)} (H, W), but has {depth.shape}")
    if not (np.isfinite(depth) & (depth >= 0)).all():
        raise InvalidPoseError("depth must be finite and >= 0 m")
    taus = floats("taus_m", taus_m, InvalidPoseError)
    check_number("delta_m", delta_m, InvalidPoseError, least=0.0)
    if taus.ndim != 1 or not (taus > 0).all():
        raise InvalidPoseError(f"taus_m must be > 0 m and of shape (T,), but are {taus}")

    per_depth = _distance_per_depth(camera, pixel_center)
    measured = depth * per_depth
    true, estimated = (
        depth_image(mesh, X_CO, camera, pixel_center=pixel_center) * per_depth for X_CO in (X_CO_true, X_CO_est)
    )
    seen_true = (true > 0) & ((true - measured <= delta_m) | (measured == 0))
    seen_estimated = (estimated > 0) & ((estimated - measured <= delta_m) | (measured == 0) | seen_true)
    either = np.count_nonzero(seen_true | seen_estimated)
    if either == 0:
        return np.ones(len(taus))
    both = seen_true & seen_estimated
    apart = np.abs(true[both] - estimated[both])
    matching = np.count_nonzero(apart[None] < taus[:, None], axis=1)
    errors: NDArray[np.float64] = 1.0 - matching / either
    return errors


def _distance_per_depth(camera: Camera, pixel_center: float) -> NDArray[np.float64]:
    """The distance from the camera's centre of a point of depth 1 at each pixel, (H, W)."""
    v, u = np.indices((camera.height, camera.width)) + pixel_center
    y = (v - camera.cy) / camera.fy
    x = (u - camera.cx - camera.skew * y) / camera.fx
    distance: NDArray[np.float64] = np.sqrt(x * x + y * y + 1.0)
    return distance
