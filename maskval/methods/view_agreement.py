"""How uncertain a pose is, judged by what other views of the same scene made of it."""

from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from maskval.errors import InvalidEstimatesError
from maskval.estimates import Estimates, Needs
from maskval.geometry import Pose
from maskval.mesh import Mesh

# The upper end of the paper's disagreement of two estimators, taken for that of two views.
MAXIMUM_M = 0.05
# Nearer views have nearly the same errors: they would agree on a wrong pose. At the paper's 0.6 m this is 9 degrees.
BASELINE_M = 0.1


class _View(NamedTuple):
    """An earlier call: where the camera was, and the poses in the fixed frame."""

    p_BC: NDArray[np.float64]
    poses: tuple[Pose, ...]


class TemporalConsistency:
    """Whether a view from elsewhere saw the object in the same pose.

    u = min(1, d / maximum): d is the maximum distance error (MDD) between this pose and the nearest one that any
    earlier call with a camera at least the baseline away has seen, in the fixed frame. Without such a call, u = 1:
    nothing speaks for the pose yet. It remembers every call: take a new object for a new scene.

    Args:
        maximum_m: Distance of u = 1, metres, > 0.
        baseline_m: Least distance between the camera's places, metres, >= 0.

    Attributes:
        u_grasp: The paper's 15 mm on this scale; what to grasp at unless a threshold is given.
    """

    needs: ClassVar[Needs] = Needs(X_BC=True)
    u_grasp: ClassVar[float] = 0.015 / MAXIMUM_M

    def __init__(self, maximum_m: float = MAXIMUM_M, baseline_m: float = BASELINE_M) -> None:
        if not (0 < maximum_m < np.inf and 0 <= baseline_m < np.inf):
            raise InvalidEstimatesError(
                f"maximum_m must be > 0 and baseline_m >= 0, but are {maximum_m} and {baseline_m}"
            )
        self._maximum_m, self._baseline_m = maximum_m, baseline_m
        self._views: list[_View] = []

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        """The distance of each pose from what was seen before, (N,), in [0, 1].

        Raises:
            InvalidEstimatesError: If the camera's pose is unknown.
        """
        X_BC = estimates.X_BC
        if X_BC is None:
            raise InvalidEstimatesError(
                "temporal consistency needs the camera's pose X_BC, but the estimates hold none"
            )
        poses = tuple(X_BC @ X_CO for X_CO in estimates.poses[0])
        others = [
            X_BO
            for view in self._views
            if np.linalg.norm(view.p_BC - X_BC.translation) >= self._baseline_m
            for X_BO in view.poses
        ]
        self._views.append(_View(X_BC.translation, poses))
        apart = (_nearest(X_BO, others, estimates.mesh, self._maximum_m) for X_BO in poses)
        return np.array([min(1.0, distance / self._maximum_m) for distance in apart])


def _nearest(X_BO: Pose, others: list[Pose], mesh: Mesh, maximum_m: float) -> float:
    """The least maximum distance error between a pose and others, metres; infinite where it is above the maximum."""
    middle_O = mesh.center
    middle_B, points_B = X_BO.apply(middle_O), X_BO.apply(mesh.vertices)
    # No point inside the vertices' hull, such as the middle, moves farther than the vertex that moves farthest.
    near = (other for other in others if np.linalg.norm(other.apply(middle_O) - middle_B) <= maximum_m)
    apart = (np.linalg.norm(points_B - other.apply(mesh.vertices), axis=1).max() for other in near)
    return float(min(apart, default=np.inf))
