"""How uncertain a pose is, judged by the correspondences that it was computed from."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from maskval.camera import Camera
from maskval.correspondences import Correspondences, jacobian
from maskval.errors import InvalidEstimatesError
from maskval.estimates import Estimates, Needs
from maskval.geometry import Pose
from maskval.inputs.arrays import check_number

WITHIN_PX = 2.0
ERROR_M = 0.015  # at which u of a covariance is 1/2: the paper's error threshold
_FEWEST = 4  # correspondences that tell a pose
_LEAST_Z_M = 1e-3
_NEEDS = Needs(correspondences=True)

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class InlierShare:
    """How many correspondences disagree with the pose: u = 1 - share of those whose reprojection error is small.

    The usual confidence of pose estimators with RANSAC (Fischler & Bolles 1981). Without correspondences, u = 1.

    Args:
        within_px: The greatest reprojection error of an inlier, pixels, > 0.
    """

    within_px: float = WITHIN_PX
    needs: ClassVar[Needs] = _NEEDS

    def __post_init__(self) -> None:
        check_number("within_px", self.within_px, InvalidEstimatesError, least=0.0, most=np.inf, ends="()")

    def __call__(self, estimates: Estimates) -> Array:
        """The share of outliers of each pose, (N,), in [0, 1].

        Raises:
            InvalidEstimatesError: If there are no correspondences.
        """
        u = np.ones(len(estimates))
        for i, (X_CO, points) in enumerate(zip(estimates.poses[0], _points(estimates, "inliers"), strict=True)):
            if len(points):
                errors_px = np.linalg.norm(points.errors_px(X_CO, estimates.camera), axis=1)
                u[i] = np.mean(errors_px > self.within_px)
        return u


@dataclass(frozen=True, slots=True)
class PnpCovariance:
    """How far the object's points may be off, by the covariance of the pose that its correspondences give.

    Σ = (Σ_i J_iᵀ J_i / σ_i²)⁻¹ with J_i the derivative of a correspondence's reprojection by the pose (the first
    order of Gauss and Newton); d = the greatest standard deviation of a vertex, √ trace(J_v Σ J_vᵀ); u = d / (d + e).
    Errors are taken for independent, which those of neighbouring pixels are not: d ranks poses, it is no length.

    Args:
        error_m: The e at which u = 1/2, metres, > 0.
    """

    error_m: float = ERROR_M
    needs: ClassVar[Needs] = _NEEDS

    def __post_init__(self) -> None:
        check_number("error_m", self.error_m, InvalidEstimatesError, least=0.0, most=np.inf, ends="()")

    def __call__(self, estimates: Estimates) -> Array:
        """A rising function of the expected error of each pose, (N,), in [0, 1].

        Raises:
            InvalidEstimatesError: If there are no correspondences.
        """
        vertices_O, camera = estimates.mesh.vertices, estimates.camera
        found = zip(estimates.poses[0], _points(estimates, "pnp-covariance"), strict=True)
        spread_m = np.array([greatest_deviation(X_CO, points, vertices_O, camera) for X_CO, points in found])
        u = np.ones(len(estimates))
        known = np.isfinite(spread_m)
        u[known] = spread_m[known] / (spread_m[known] + self.error_m)
        return u


def greatest_deviation(X_CO: Pose, points: Correspondences, vertices_O: Array, camera: Camera) -> float:
    """The greatest standard deviation of a vertex, metres; infinite where the correspondences tell no pose.

    Args:
        X_CO: Pose of the object.
        points: What it was computed from.
        vertices_O: The object's vertices, (V, 3), metres.
        camera: Intrinsics.
    """
    points_C = X_CO.apply(points.points_O)
    before = points_C[:, 2] > _LEAST_Z_M
    if np.count_nonzero(before) < _FEWEST:
        return np.inf
    J = jacobian(points_C[before], X_CO.translation, camera) / points.sigma_px[before, None, None]
    information = np.einsum("ijk,ijl->kl", J, J)
    scale = np.sqrt(np.diag(information))  # of turns and shifts, whose units differ
    if not (scale > 0).all():
        return np.inf
    values, axes = np.linalg.eigh(information / np.outer(scale, scale))
    if values[0] <= 1e-9 * values[-1]:
        return np.inf
    covariance = (axes / values) @ axes.T / np.outer(scale, scale)
    arms = X_CO.apply(vertices_O) - X_CO.translation
    x, y, z = arms.T
    zero = np.zeros_like(x)
    # dp = ω × arm + shift
    turns = np.stack((np.stack((zero, z, -y), 1), np.stack((-z, zero, x), 1), np.stack((y, -x, zero), 1)), axis=1)
    J_v = np.concatenate((turns, np.broadcast_to(np.eye(3), turns.shape)), axis=2)
    return float(np.sqrt(np.einsum("vij,jk,vik->v", J_v, covariance, J_v, optimize=True).max()))


def _points(estimates: Estimates, name: str) -> tuple[Correspondences, ...]:
    if estimates.correspondences is None:
        raise InvalidEstimatesError(f"{name} needs the correspondences of the poses, but the estimates hold none")
    return estimates.correspondences
