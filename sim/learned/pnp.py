"""A pose from points of an object, where a network saw them, and what it says of the depth."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from maskval import Camera, Pose
from maskval.correspondences import Correspondences, jacobian

FEWEST = 6  # correspondences
_STEPS = 15
_GAIN = 1e-5  # of the cost: what a step must bring for another one
_OUTLIER = 3.0  # sigmas from which on an error counts less and less (Cauchy)
_NEAREST = 0.05  # m: no pose is nearer to the camera

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class DepthEstimate:
    """What a network says of the depth of a point of the object.

    Attributes:
        point_O: the point, (3,) m.
        log_depth: logarithm of its z-depth in metres.
        sigma: standard deviation of that logarithm.
    """

    point_O: Array
    log_depth: float
    sigma: float


def solve(found: Correspondences, camera: Camera, depth: DepthEstimate, weight: float) -> Pose | None:
    """X_CO that fits the correspondences and the depth best; None where nothing does.

    Minimises weight · Σ ρ(|e_i|² / σ_i²) + (log z − log z_est)² / σ², with ρ of Cauchy, by Levenberg and Marquardt,
    from SQPnP's pose of the surer half of the correspondences.

    Args:
        found: the correspondences.
        camera: that sees them.
        depth: what else is known.
        weight: of one correspondence: errors of neighbouring ones are alike, so each tells less than its sigma says.
    """
    start = _start(found, camera)
    return None if start is None else _refine(start, found, camera, depth, weight)


def _start(found: Correspondences, camera: Camera) -> Pose | None:
    if len(found) < FEWEST:
        return None
    sure = found.sigma_px <= np.median(found.sigma_px)
    sure = sure if np.count_nonzero(sure) >= FEWEST else np.ones(len(found), dtype=bool)
    try:
        solved, turn, shift = cv2.solvePnP(
            found.points_O[sure], found.pixels[sure], camera.K, None, flags=cv2.SOLVEPNP_SQPNP
        )
    except cv2.error:  # all points on a line, or in one place
        return None
    if not solved or not (np.isfinite(turn).all() and np.isfinite(shift).all()):
        return None
    start = Pose.from_rotvec(turn.ravel(), shift.ravel())
    # Of wild correspondences, the less sure ones may lie behind the camera.
    return start if start.apply(found.points_O)[:, 2].min() >= _NEAREST else None


def _refine(start: Pose, found: Correspondences, camera: Camera, depth: DepthEstimate, weight: float) -> Pose:
    X_CO, damping = start, 1e-3
    cost, H, g = _normal_equations(X_CO, found, camera, depth, weight)
    for _ in range(_STEPS):
        step = -np.asarray(np.linalg.solve(H + damping * np.diag(np.diag(H)), g), dtype=np.float64)
        moved = _moved(X_CO, depth.point_O, step)
        if moved.apply(found.points_O)[:, 2].min() < _NEAREST:
            damping *= 10.0
            continue
        better = _normal_equations(moved, found, camera, depth, weight)
        if better[0] >= cost:
            damping *= 10.0
            continue
        gained = cost - better[0]
        X_CO, (cost, H, g), damping = moved, better, damping / 3.0
        if gained < _GAIN * cost:
            break
    return X_CO


def _moved(X_CO: Pose, point_O: Array, step: Array) -> Pose:
    """The pose turned about a point of the object, then shifted: the depth of the point then depends on no turn."""
    R_CO = Pose.from_rotvec(step[:3]).rotation @ X_CO.rotation
    return Pose(R_CO, X_CO.apply(point_O) + step[3:] - R_CO @ point_O)


def _normal_equations(
    X_CO: Pose, found: Correspondences, camera: Camera, depth: DepthEstimate, weight: float
) -> tuple[float, Array, Array]:
    """Cost, approximate second derivatives and gradient of the cost by a step of `_moved`."""
    points_C, point_C = X_CO.apply(found.points_O), X_CO.apply(depth.point_O)
    errors = (camera.project(points_C) - found.pixels) / found.sigma_px[:, None]
    J = jacobian(points_C, point_C, camera) / found.sigma_px[:, None, None]
    squares = np.sum(errors**2, axis=1) / _OUTLIER**2
    w = weight / (1.0 + squares)
    H = np.einsum("i,ijk,ijl->kl", w, J, J, optimize=True)
    g = np.einsum("i,ijk,ij->k", w, J, errors, optimize=True)
    z = max(point_C[2], _NEAREST)
    error = (np.log(z) - depth.log_depth) / depth.sigma
    j = np.array((0.0, 0.0, 0.0, 0.0, 0.0, 1.0)) / (z * depth.sigma)
    cost = weight * _OUTLIER**2 * np.log1p(squares).sum() + error**2
    return float(cost), H + np.outer(j, j), g + j * error
