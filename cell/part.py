"""A part as the controller knows it: its shape, where to grip it and the slot that it goes into."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray

from maskval import Mesh, Pose, mdd

MAX_TILT_DEG = 50.0  # of the approach from the vertical; beyond it the gripper's body meets the belt
MAX_TILT = np.radians(MAX_TILT_DEG)
_FEW = 32  # corners that tell most symmetries to be worse than another one


@dataclass(frozen=True, slots=True, eq=False)
class Grasp:
    """One way to grip a part.

    Attributes:
        name: as the part's file calls it.
        X_OT: the tool centre point in the part's frame; z is the approach, y the closing direction.
        half_opening: distance of each jaw from the middle before closing, m.
        max_tilt: of the approach from the vertical, rad; the grasp is not used where it would be more.
    """

    name: str
    X_OT: Pose
    half_opening: float
    max_tilt: float = MAX_TILT


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """One kind of part.

    Attributes:
        name: the kind's name, such as "antenna".
        mesh: its surface in frame O, metres.
        grasps: at least one for every pose in which it can lie.
        slot_size: inner size of its container slot along W's x and y, m.
        symmetries: poses in O in which it looks the same, the identity among them; none where none are known.
    """

    name: str
    mesh: Mesh
    grasps: tuple[Grasp, ...]
    slot_size: tuple[float, float]
    symmetries: tuple[Pose, ...] = ()


def pose_error(X_AO_est: Pose, X_AO_true: Pose, mesh: Mesh, symmetries: tuple[Pose, ...] = ()) -> float:
    """The maximum distance error, m; of a symmetric part the least over the poses that look the same.

    Args:
        X_AO_est: estimated pose of the part.
        X_AO_true: its true pose in the same frame.
        mesh: its surface.
        symmetries: see `Part`.
    """
    if not symmetries:
        return mdd(X_AO_est, X_AO_true, mesh.vertices)
    corners, error = _corners(mesh), X_AO_true.inverse() @ X_AO_est
    rotations, translations = _stacked(symmetries)
    turned, moved = error.rotation - rotations, error.translation - translations
    few = corners[:: -(-len(corners) // _FEW)]
    at_least = np.linalg.norm(few @ turned.transpose(0, 2, 1) + moved[:, None], axis=2).max(axis=1)
    best = np.inf
    for index in np.argsort(at_least):  # the few corners leave out most symmetries, without a change of the result
        if at_least[index] >= best:
            break
        best = min(best, float(np.linalg.norm(corners @ turned[index].T + moved[index], axis=1).max()))
    return best


@lru_cache(maxsize=16)
def _stacked(symmetries: tuple[Pose, ...]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Rotations (S, 3, 3) and translations (S, 3) m."""
    return np.array([pose.rotation for pose in symmetries]), np.array([pose.translation for pose in symmetries])


@lru_cache(maxsize=16)  # by identity: a mesh does not change
def _corners(mesh: Mesh) -> NDArray[np.float64]:
    """The corners of the convex hull, one of which is the point that is farthest off, (P, 3) m."""
    corners: NDArray[np.float64] = mesh.vertices[scipy.spatial.ConvexHull(mesh.vertices).vertices]
    return corners
