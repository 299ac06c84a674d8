"""What a policy is shown and made with."""

from collections.abc import Sequence

import numpy as np

from cell.interfaces import Detection, Frame, Observation
from cell.layout import Layout
from cell.setup import PolicySetup
from maskval import Pose
from tests.fakes.scene import brick
from tests.fakes.script import MASK_TIME


def observation(
    u: Sequence[float],
    scores: Sequence[float] | None = None,
    *,
    X_BC: Pose | None = None,
    X_BO: Sequence[Pose] | None = None,
    refining: bool = False,
    time_left: float = 10.0,
) -> Observation:
    """What a policy is shown: detections of these uncertainties, seen from a camera pose, of parts at these poses."""
    frame = Frame(0, 0.0, Layout().camera, X_BC or Pose.identity())
    detections = tuple(Detection(np.zeros((480, 640), dtype=bool), score) for score in scores or [0.9] * len(u))
    X_CB = frame.X_BC.inverse()
    poses = tuple(X_CB @ X_BO_each for X_BO_each in X_BO or [Pose.identity()] * len(u))
    return Observation(frame, detections, (poses,), np.array(u, dtype=np.float64), refining, time_left, MASK_TIME)


def policy_setup(u_grasp: float = 0.2, u_refine: float = 0.6) -> PolicySetup:
    """What a policy is made with: the brick in the whole cell."""
    return PolicySetup(brick(), Layout(), u_grasp, u_refine)
