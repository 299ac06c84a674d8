"""What the arm reaches: grasps on the loaded belt, slots of the container."""

from itertools import product

import numpy as np

from cell.arm.ur10 import inverse_on_branch
from cell.grasping import HALF_TURN, GraspPlan, plan_grasps, plan_places
from cell.layout import Layout
from cell.part import Grasp, Part
from maskval import Pose
from sim.parts.stable_poses import RestingPose

_NEAR = np.radians([0.0, -100.0, 100.0, -90.0, -90.0, 0.0])
_YAWS = 8
_ACROSS, _ALONG = (-0.1, 0.0, 0.1), (-0.6, -0.2, 0.2, 0.6)  # m from the belt's middle
ENOUGH = 0.98  # share of places and turns on the belt that a grasp should reach


def lying_at(pose: RestingPose, yaw: float, x: float, y: float, layout: Layout) -> Pose:
    """X_WO of a part that lies so, turned by `yaw` (rad), x and y (m) from the belt's middle."""
    c, s = np.cos(yaw), np.sin(yaw)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    place = [layout.belt.center_x + x, y, layout.belt.top_z + pose.height]
    return Pose(turn @ pose.rotation, np.array(place))


def belt_share(part: Part, pose: RestingPose, layout: Layout) -> float:
    """Share of places and turns on the belt in which the arm reaches one of the part's grasps."""
    reached = []
    for index, (x, y) in enumerate(product(_ACROSS, _ALONG)):
        for turn in range(_YAWS):
            yaw = 2 * np.pi * (turn + 0.37 * index) / _YAWS
            X_BO = layout.X_WB.inverse() @ lying_at(pose, yaw, x, y, layout)
            reached.append(any(_reaches_all(plan, layout) for plan in plan_grasps(part, X_BO)))
    return float(np.mean(reached))


def reached_slots(part: Part, grasp: Grasp, pose: RestingPose, half_opening: float, layout: Layout) -> list[bool]:
    """For each slot of the container, whether the arm can lay the part into it that it holds so.

    Args:
        part: with its slot's size.
        grasp: how it is held.
        pose: how it lay on the belt.
        half_opening: of the jaws when they let go, m.
        layout: the cell.
    """
    X_BO = layout.X_WB.inverse() @ lying_at(pose, 0.0, 0.0, 0.0, layout)
    found = []
    for slot in range(layout.container.rows * layout.container.columns):
        places = []
        for flip in (Pose.identity(), HALF_TURN):
            X_BT = X_BO @ grasp.X_OT @ flip
            plan = GraspPlan(grasp, X_BO, X_BT, X_BT, X_BT)
            places.append(plan_places(part, layout, plan, slot, half_opening))
        ways = [
            all(_reaches(X_BT, layout) for X_BT in (one.X_BT_above, one.X_BT_release)) for row in places for one in row
        ]
        found.append(all(any(ways[2 * flip : 2 * flip + 2]) for flip in (0, 1)))
    return found


def _reaches_all(plan: GraspPlan, layout: Layout) -> bool:
    return all(_reaches(X_BT, layout) for X_BT in (plan.X_BT_grip, plan.X_BT_before, plan.X_BT_lifted))


def _reaches(X_BT: Pose, layout: Layout) -> bool:
    return inverse_on_branch(X_BT @ layout.gripper.X_FT.inverse(), _NEAR) is not None
