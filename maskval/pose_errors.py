"""How far an estimated pose is from the true one, by BOP's definitions (VSD: `maskval.evaluation.visible_surface`).

X_AO is the pose of the object in any frame A, X_CO that in the camera's. Matrices (4, 4) will do for poses. All points
are the model's.
"""

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from maskval.camera import Camera
from maskval.errors import InvalidPoseError
from maskval.geometry import Pose, PoseLike, PosesLike, angle_between, as_pose, as_poses
from maskval.inputs.arrays import floats


def mdd(X_AO_est: PoseLike, X_AO_true: PoseLike, points_O: ArrayLike) -> float:
    """The maximum distance error, metres: max over x in M of ‖p̂ x − p̄ x‖.

    Args:
        X_AO_est: Estimated pose of the object.
        X_AO_true: True pose of the object in the same frame.
        points_O: The model's points M, (P, 3), metres, P >= 1.
    """
    return float(_displacements(X_AO_est, X_AO_true, _points(points_O)).max())


def add(X_AO_est: PoseLike, X_AO_true: PoseLike, points_O: ArrayLike) -> float:
    """The average distance (ADD), metres: mean over x in M of ‖p̂ x − p̄ x‖.

    Args:
        X_AO_est: Estimated pose of the object.
        X_AO_true: True pose of the object in the same frame.
        points_O: The model's points M, (P, 3), metres, P >= 1.
    """
    return float(_displacements(X_AO_est, X_AO_true, _points(points_O)).mean())


def add_s(X_AO_est: PoseLike, X_AO_true: PoseLike, points_O: ArrayLike) -> float:
    """The average distance of indistinguishable views (ADD-S, BOP's ADI), metres: mean of min over y of ‖p̂ y − p̄ x‖.

    Args:
        X_AO_est: Estimated pose of the object.
        X_AO_true: True pose of the object in the same frame.
        points_O: The model's points M, (P, 3), metres, P >= 1.
    """
    points = _points(points_O)
    # Distances do not depend on the frame: compare the points, moved by the error, with where they were.
    moved = (as_pose(X_AO_est).inverse() @ as_pose(X_AO_true)).apply(points)
    distances, _ = scipy.spatial.cKDTree(points).query(moved)
    return float(distances.mean())


def mssd(X_AO_est: PoseLike, X_AO_true: PoseLike, points_O: ArrayLike, symmetries: PosesLike) -> float:
    """The maximum symmetry-aware surface distance, metres: min over S of max over x of ‖p̂ x − p̄ S x‖.

    Args:
        X_AO_est: Estimated pose of the object.
        X_AO_true: True pose of the object in the same frame.
        points_O: The model's points, (P, 3), metres, P >= 1.
        symmetries: Poses that the object looks alike in, the identity among them (see `symmetry_poses`).
    """
    points, X_AO_true = _points(points_O), as_pose(X_AO_true)
    return min(float(_displacements(X_AO_est, X_AO_true @ S, points).max()) for S in _symmetries(symmetries))


def mspd(X_CO_est: PoseLike, X_CO_true: PoseLike, points_O: ArrayLike, symmetries: PosesLike, camera: Camera) -> float:
    """The maximum symmetry-aware projection distance, pixels: min over S of max over x of ‖π(p̂ x) − π(p̄ S x)‖.

    Args:
        X_CO_est: Estimated pose of the object.
        X_CO_true: True pose of the object.
        points_O: The model's points, (P, 3), metres, P >= 1, all in front of the camera.
        symmetries: Poses that the object looks alike in, the identity among them (see `symmetry_poses`).
        camera: Intrinsics π.
    """
    points, X_CO_true = _points(points_O), as_pose(X_CO_true)
    estimated = camera.project(as_pose(X_CO_est).apply(points))
    return min(
        float(np.linalg.norm(estimated - camera.project((X_CO_true @ S).apply(points)), axis=1).max())
        for S in _symmetries(symmetries)
    )


def rotation_error(X_AO_est: PoseLike, X_AO_true: PoseLike) -> float:
    """The angle between the rotations, radians, in [0, π].

    Args:
        X_AO_est: Estimated pose of the object.
        X_AO_true: True pose of the object in the same frame.
    """
    return angle_between(as_pose(X_AO_true).rotation, as_pose(X_AO_est).rotation)


def translation_error(X_AO_est: PoseLike, X_AO_true: PoseLike) -> float:
    """The distance between the translations, metres.

    Args:
        X_AO_est: Estimated pose of the object.
        X_AO_true: True pose of the object in the same frame.
    """
    return float(np.linalg.norm(as_pose(X_AO_est).translation - as_pose(X_AO_true).translation))


def _points(points_O: ArrayLike) -> NDArray[np.float64]:
    points = floats("points_O", points_O, InvalidPoseError)
    if points.ndim != 2 or points.shape[1] != 3 or len(points) == 0:
        raise InvalidPoseError(f"points_O must have shape (P, 3) with P >= 1, but has {points.shape}")
    return points


def _symmetries(symmetries: PosesLike) -> tuple[Pose, ...]:
    if len(symmetries) == 0:
        raise InvalidPoseError("symmetries must hold at least the identity, but are empty")
    return as_poses(symmetries)


def _displacements(X_AO_est: PoseLike, X_AO_true: PoseLike, points_O: NDArray[np.float64]) -> NDArray[np.float64]:
    est, true = as_pose(X_AO_est), as_pose(X_AO_true)
    shift = points_O @ (est.rotation - true.rotation).T + (est.translation - true.translation)
    distances: NDArray[np.float64] = np.sqrt(np.einsum("ij,ij->i", shift, shift))
    return distances
