"""What the gripper meets on its way to a grasp: the part between the pads, and the part where nothing may be."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cell.grasping import RELEASE_GAP
from cell.layout import Gripper
from maskval import Pose
from sim.part_making.samples import SurfacePoints

PAD_LENGTH = 0.040  # m along the approach, of the pads that sim.model.robot builds
PAD_STANDS_OUT = 0.005  # m by which the pads stand out of the fingers
ROOM = 0.0015  # m between finger and part that is as good as a touch
EASY_CLEARANCE = 0.020  # m that a jaw opens beyond the part where there is room: a pose may be wrong by as much
LEAST_CLEARANCE = 0.007  # m beside the part that a jaw needs
_PATCH = 0.0007  # m below the outermost point within which the surface lies against a pad
_FACING = 0.3  # of a normal to the closing direction: faces beside the touched one are not against the pad
_STRAIGHT = np.cos(np.radians(30.0))  # of the mean normal there to the closing direction
_COUPLE = 0.006  # m between the middles of both patches, across the closing direction: more turns the part

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Grip:
    """How the jaws hold the part.

    Attributes:
        X_OT: the tool, its y axis through the middle of the part between the pads.
        half_width: of the part between the pads, m.
        half_opening: of the jaws before they close, m.
        clearance: free way of each jaw beside the part, m.
        patch: points of the surface that lie against the pad that has fewer.
        lever: distance of the centre of mass from the closing line along the approach's plane, m.
    """

    X_OT: Pose
    half_width: float
    half_opening: float
    clearance: float
    patch: int
    lever: float


def grip_at(X_OT: Pose, surface: SurfacePoints, center_of_mass: Array, gripper: Gripper) -> Grip | None:
    """The grip of jaws that close there, moved along their closing direction to the part's middle; None if it is none.

    It is none if there is nothing between the pads or more than they open to, if fingers or body meet the part on the
    straight way there or while the jaws open and close, or if the part would turn between the pads.

    Args:
        X_OT: a tool pose.
        surface: the part's.
        center_of_mass: of the part, (3,) m in O.
        gripper: the jaws.
    """
    R_OT = X_OT.rotation
    points = (surface.points - X_OT.translation) @ R_OT
    between = _between(points, gripper)
    if not between.any():
        return None
    low, high = points[between, 1].min(), points[between, 1].max()
    middle, half_width = (low + high) / 2, (high - low) / 2
    points[:, 1] -= middle
    clearance = _clearance(points, half_width, gripper)
    if clearance < LEAST_CLEARANCE or _body_meets(points, gripper):
        return None
    between[surface.flat :] = False  # a corner's normal says nothing of the faces beside it
    patches = _patches(points, surface.normals @ R_OT, between, half_width)
    if patches is None:
        return None
    p_OT = X_OT.translation + middle * R_OT[:, 1]
    offset = (center_of_mass - p_OT) @ R_OT
    half_opening = min(half_width + min(clearance, EASY_CLEARANCE), gripper.max_half_opening)
    return Grip(Pose(R_OT, p_OT), half_width, half_opening, clearance, patches, float(abs(offset[0])))


def _between(points: Array, gripper: Gripper) -> NDArray[np.bool_]:
    """The points that the pads close on: of those within the pads' width and length, what lies around the middle."""
    x, y, z = points.T
    tip = gripper.tip_below_tcp
    window = (np.abs(x) <= gripper.finger_width / 2) & (z <= tip) & (z >= tip - PAD_LENGTH)
    inside: NDArray[np.bool_] = window & (np.abs(y) <= gripper.max_half_opening)
    if not inside.any():
        return inside
    # A jaw may stand inside of the part: what is beyond a gap as wide as a jaw is not between them.
    order = np.sort(y[inside])
    gaps = np.flatnonzero(np.diff(order) > gripper.finger_thickness + 2 * LEAST_CLEARANCE)
    starts, ends = np.append(0, gaps + 1), np.append(gaps, len(order) - 1)
    near = int(np.argmin([max(order[a], -order[b], 0.0) for a, b in zip(starts, ends, strict=True)]))
    inside &= (y >= order[starts[near]]) & (y <= order[ends[near]])
    return inside


def _clearance(points: Array, half_width: float, gripper: Gripper) -> float:
    """How far a jaw can be open beside the part, on its way down and before it closes, m."""
    x, y, z = np.abs(points[:, 0]), np.abs(points[:, 1]), points[:, 2]
    tip = gripper.tip_below_tcp
    way = (x <= gripper.finger_width / 2 + ROOM) & (z <= tip + ROOM)
    beside = way & (y > half_width + ROOM) & (z >= tip - PAD_LENGTH)
    above = way & (y > half_width + PAD_STANDS_OUT - ROOM) & (z < tip - PAD_LENGTH)
    meets = y[beside | above]
    nearest = float(meets.min()) if len(meets) else np.inf
    free = nearest - half_width - gripper.finger_thickness - ROOM
    if free < min(RELEASE_GAP, gripper.max_half_opening - half_width):
        return -1.0  # what lets go opens so far
    return float(min(free, gripper.max_half_opening - half_width))


def _body_meets(points: Array, gripper: Gripper) -> bool:
    fingers = gripper.tcp_from_flange - 0.030 - gripper.body_height  # from the TCP up to the body
    x, y, z = np.abs(points[:, 0]), np.abs(points[:, 1]), points[:, 2]
    inside = (x <= gripper.body_width / 2 + ROOM) & (y <= gripper.body_length / 2 + ROOM)
    return bool((inside & (z <= -fingers + 2 * ROOM)).any())


def _patches(points: Array, normals: Array, between: NDArray[np.bool_], half_width: float) -> int | None:
    """Points against the pad that has fewer; None where the surface stands askew or the sides are not opposite."""
    middles, counts = [], []
    for side in (1.0, -1.0):
        touching = between & (side * points[:, 1] >= half_width - _PATCH) & (side * normals[:, 1] > _FACING)
        if not touching.any() or (side * normals[touching, 1]).mean() < _STRAIGHT:
            return None
        middles.append(points[touching][:, [0, 2]].mean(axis=0))
        counts.append(int(touching.sum()))
    return min(counts) if np.linalg.norm(middles[0] - middles[1]) <= _COUPLE else None
