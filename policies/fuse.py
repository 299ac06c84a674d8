"""The paper's rule on the average of several views of the same part."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cell.interfaces import Action, Decision, Observation
from cell.setup import PolicySetup
from maskval import Pose, mdd
from policies.threshold import ThresholdPolicy

AGREEMENT = 0.015  # m: largest distance of a point of the part between two poses of one and the same part
BASELINE = 0.10  # m between the cameras of two views; a nearer one repeats the error of the first


@dataclass(frozen=True, slots=True, eq=False)
class _View:
    """A part in one frame."""

    X_BC: Pose
    X_BO_est: Pose
    u: float


class Fuse:
    """Like `ThresholdPolicy`, but on averages: of each detection with all earlier views that agree with it.

    Views agree if their cameras stood apart (`BASELINE`) and their poses are close (`AGREEMENT`), each with each. The
    rule decides on the mean u, and the robot grasps the mean pose. On a moving belt a part is elsewhere in the next
    view: none agree (except below a few mm/s), and the rule is `ThresholdPolicy`'s.
    """

    def __init__(self, setup: PolicySetup) -> None:
        self._mesh = setup.part.mesh
        self._center_O = setup.part.mesh.center
        self._rule = ThresholdPolicy(setup.u_grasp, setup.u_refine)
        self._seen: list[_View] = []

    def decide(self, observation: Observation) -> Decision:
        """See `cell.interfaces.Policy`."""
        newest = [
            _View(observation.frame.X_BC, observation.X_BO_est(index), float(u))
            for index, u in enumerate(observation.uncertainties)
        ]
        groups = [self._agreeing(view) for view in newest]
        self._seen += newest
        u = np.array([np.mean([view.u for view in group]) for group in groups])
        decision = self._rule.decide(replace(observation, uncertainties=u))
        chosen = decision.detection
        if chosen is None:
            return decision
        poses = [view.X_BO_est for view in groups[chosen]]
        X_BO_est = mean_pose(poses, self._center_O) if decision.action is Action.GRASP else None
        return replace(decision, u=float(u[chosen]), X_BO_est=X_BO_est)

    def _agreeing(self, newest: _View) -> list[_View]:
        """The view and those before it, the latest first, that agree with it and with one another."""
        group = [newest]
        for view in reversed(self._seen):
            if all(self._agree(view, other) for other in group):
                group.append(view)
        return group

    def _agree(self, a: _View, b: _View) -> bool:
        # The part's middle moves by no more than its farthest point, and is faster to compare.
        between = np.linalg.norm(a.X_BO_est.apply(self._center_O) - b.X_BO_est.apply(self._center_O))
        return bool(
            between <= AGREEMENT
            and np.linalg.norm(a.X_BC.translation - b.X_BC.translation) >= BASELINE
            and mdd(a.X_BO_est, b.X_BO_est, self._mesh.vertices) <= AGREEMENT
        )


def mean_pose(poses: Sequence[Pose], center_O: NDArray[np.float64]) -> Pose:
    """The mean of several poses that are close: the mean position of a point, and the mean rotation.

    Args:
        poses: X_AO, at least one.
        center_O: the point, (3,) m in O.
    """
    if len(poses) == 1:
        return poses[0]
    rotation = Rotation.from_matrix([pose.rotation for pose in poses]).mean().as_matrix()
    center_A = np.mean([pose.apply(center_O) for pose in poses], axis=0)
    return Pose(rotation, center_A - rotation @ center_O)
