"""How far an estimated pose is from the true one."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from maskval.errors import InvalidPoseError
from maskval.geometry import Pose


def mdd(X_AO_est: Pose, X_AO_true: Pose, points_O: ArrayLike) -> float:
    """The maximum distance error, metres: max over x in M of ‖p̂ x − p̄ x‖.

    Args:
        X_AO_est: Estimated pose of the object, in any frame A.
        X_AO_true: True pose of the object in the same frame.
        points_O: The model's points M, (P, 3), metres, P >= 1.
    """
    return float(_displacements(X_AO_est, X_AO_true, points_O).max())


def add(X_AO_est: Pose, X_AO_true: Pose, points_O: ArrayLike) -> float:
    """The average distance (ADD), metres: mean over x in M of ‖p̂ x − p̄ x‖.

    Args:
        X_AO_est: Estimated pose of the object, in any frame A.
        X_AO_true: True pose of the object in the same frame.
        points_O: The model's points M, (P, 3), metres, P >= 1.
    """
    return float(_displacements(X_AO_est, X_AO_true, points_O).mean())


def _displacements(X_AO_est: Pose, X_AO_true: Pose, points_O: ArrayLike) -> NDArray[np.float64]:
    points = np.asarray(points_O, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or len(points) == 0:
        raise InvalidPoseError(f"points_O must have shape (P, 3) with P >= 1, but has {points.shape}")
    rotation = X_AO_est.rotation - X_AO_true.rotation
    shift = points @ rotation.T + (X_AO_est.translation - X_AO_true.translation)
    distances: NDArray[np.float64] = np.sqrt(np.einsum("ij,ij->i", shift, shift))
    return distances
