"""From an estimated part pose to the poses of the tool: where to grip, where to let go. Geometry only."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from cell.layout import Gripper, Layout
from cell.part import Grasp, Part
from maskval import Pose

TILT_DIGITS = 6  # decimals of rad; of grasps that are as upright as one another, the first of the part's file
APPROACH_LENGTH = 0.12  # m, straight line to the part
LIFT_HEIGHT = 0.16  # m, straight up: part and jaws clear the container's walls and the other parts
RELEASE_HEIGHT = 0.020  # m between part and slot floor; less, and a pose error presses the part into the floor
RELEASE_GAP = 0.012  # m that each jaw opens beyond the width at which it holds the part
HALF_TURN = Pose(np.diag([-1.0, -1.0, 1.0]), np.zeros(3))  # about the approach: the same grip with jaws swapped


@dataclass(frozen=True, slots=True, eq=False)
class GraspPlan:
    """Tool poses X_BT for one grasp of a part that is estimated at X_BO_est."""

    grasp: Grasp
    X_BO_est: Pose
    X_BT_before: Pose
    X_BT_grip: Pose
    X_BT_lifted: Pose


@dataclass(frozen=True, slots=True, eq=False)
class PlacePlan:
    """Tool poses X_BT that put the held part into its slot."""

    X_BT_above: Pose
    X_BT_release: Pose


def plan_grasps(part: Part, X_BO_est: Pose) -> list[GraspPlan]:
    """Every way to grip the part from above, the most upright first; both ways round for each.

    Empty when the estimate shows the part in a pose that no grasp of its file reaches from above.
    """
    plans = []
    for grasp in part.grasps:
        for flip in (Pose.identity(), HALF_TURN):
            X_BT = X_BO_est @ grasp.X_OT @ flip
            approach_B = X_BT.rotation[:, 2]
            tilt = np.arccos(np.clip(-approach_B[2], -1.0, 1.0))
            if tilt > grasp.max_tilt:
                continue
            before = _shifted(X_BT, -APPROACH_LENGTH * approach_B)
            lifted = _shifted(X_BT, np.array([0.0, 0.0, LIFT_HEIGHT]))
            plans.append((float(tilt), GraspPlan(grasp, X_BO_est, before, X_BT, lifted)))
    # Stable: the two ways round keep their order. The arc cosine has half of the digits near 0.
    plans.sort(key=lambda entry: round(entry[0], TILT_DIGITS))
    return [plan for _, plan in plans]


def why_unreachable(part: Part, X_BO_est: Pose) -> str:
    """Why no grasp can be carried out, of a part whose grasps the arm does not reach."""
    from_above = len(dict.fromkeys(plan.grasp.name for plan in plan_grasps(part, X_BO_est)))
    if from_above:
        x, y, z = X_BO_est.translation.round(3).tolist()
        return f"out of reach: no joint angles for {from_above} grasps from above at ({x}, {y}, {z}) m in the base"
    uprights = [-(X_BO_est @ grasp.X_OT).rotation[2, 2] for grasp in part.grasps]
    tilt = float(np.degrees(np.arccos(np.clip(max(uprights), -1.0, 1.0))))
    return f"no grasp from above: the most upright of {len(part.grasps)} is tilted by {tilt:.0f}°"


def plan_places(
    part: Part, layout: Layout, plan: GraspPlan, container_slot: int, release_half_opening: float
) -> list[PlacePlan]:
    """Both ways to lay the part into its slot as it lay on the belt, its x axis along the slot, by the estimated pose.

    Part and jaws, opened to `release_half_opening` (m), together stand in the middle of the slot, the part's lowest
    point `RELEASE_HEIGHT` above the floor.
    """
    X_WB = layout.X_WB
    X_WO = X_WB @ plan.X_BO_est
    heading = heading_of(X_WO.rotation)
    X_OT = X_WO.inverse() @ X_WB @ plan.X_BT_grip
    p_WK = layout.container.slot_center(container_slot, part.slot_size)
    places = []
    for facing in (0.0, np.pi):
        turn = _about_z(facing - heading)
        R_WO = turn @ X_WO.rotation
        held = Pose(R_WO, np.zeros(3))
        occupied = np.vstack(
            [part.mesh.vertices @ R_WO.T, jaw_corners(layout.gripper, release_half_opening, held @ X_OT)]
        )
        middle = (occupied.min(axis=0) + occupied.max(axis=0)) / 2
        lowest = float((part.mesh.vertices @ R_WO.T)[:, 2].min())
        offset = np.array([-middle[0], -middle[1], RELEASE_HEIGHT - lowest])
        X_BT = X_WB.inverse() @ Pose(R_WO, p_WK + offset) @ X_OT
        above = _shifted(X_BT, np.array([0.0, 0.0, LIFT_HEIGHT]))
        places.append(PlacePlan(above, X_BT))
    return places


def jaw_corners(gripper: Gripper, half_opening: float, X_AT: Pose) -> NDArray[np.float64]:
    """The corners of the box that the finger tips fill when open, (8, 3) in A, m."""
    half_x = gripper.finger_width / 2
    half_y = half_opening + gripper.finger_thickness
    corners = product((-half_x, half_x), (-half_y, half_y), (-0.03, gripper.tip_below_tcp))
    return X_AT.apply(np.array(list(corners)))


def look_at(point_B: Sequence[float] | NDArray[np.float64], distance: float) -> Pose:
    """X_BC of a camera that looks straight down on a point from a distance (m), its image's width along the belt."""
    x_C, y_C = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])
    rotation = np.column_stack([x_C, y_C, np.cross(x_C, y_C)])
    return Pose(rotation, np.asarray(point_B) + np.array([0.0, 0.0, distance]))


def _shifted(X_AB: Pose, by_A: NDArray[np.float64]) -> Pose:
    return Pose(X_AB.rotation, X_AB.translation + by_A)


def heading_of(R_WO: NDArray[np.float64]) -> float:
    """Angle of the part's x axis seen from above, rad; of its y axis where it stands on the x axis."""
    axis = 0 if np.linalg.norm(R_WO[:2, 0]) > np.sqrt(0.5) else 1
    return float(np.arctan2(R_WO[1, axis], R_WO[0, axis]))


def _about_z(angle: float) -> NDArray[np.float64]:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
