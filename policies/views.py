"""Views of a part that the arm can take."""

from itertools import product

import numpy as np

from cell.arm.ur10 import inverse_on_branch
from cell.grasping import look_at
from cell.interfaces import Observation
from cell.setup import PolicySetup
from cell.viewpoints import REFINE_DISTANCE
from maskval import Pose

TILTS_DEG = (
    20.0,
    35.0,
)  # from the vertical; errors of pose networks hardly correlate beyond 30°, see sim.networks.view_noise
SIDES = 8  # directions of tilting, evenly around the part


def views_around(observation: Observation, detection: int, setup: PolicySetup) -> list[Pose]:
    """X_BC of views that centre a detection's part from 0.40 m and are in reach: from above, then from its sides.

    Smaller tilts come first; within one tilt, opposite sides follow one another.
    """
    center_B = observation.X_BO_est(detection).apply(setup.part.mesh.center)
    above = look_at(center_B, REFINE_DISTANCE)
    turns = np.arange(SIDES).reshape(2, -1).T.ravel()  # 0, 4, 1, 5, …
    tilts = [
        Pose.from_rotvec(np.radians(tilt) * np.array([np.cos(angle), np.sin(angle), 0.0]))
        for tilt, angle in product(TILTS_DEG, 2 * np.pi / SIDES * turns)
    ]
    around = [_turned_about(center_B, tilt) @ above for tilt in tilts]
    X_CF = setup.layout.X_FC.inverse()
    here = inverse_on_branch(observation.frame.X_BC @ X_CF, np.zeros(6))
    q_near = np.zeros(6) if here is None else here
    return [X_BC for X_BC in (above, *around) if inverse_on_branch(X_BC @ X_CF, q_near) is not None]


def _turned_about(point_B: np.ndarray, turn: Pose) -> Pose:
    return Pose.from_translation(point_B) @ turn @ Pose.from_translation(-point_B)
