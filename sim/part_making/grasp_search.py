"""Grasps of a part that lies: antipodal pairs of its surface, gripped from above, without meeting belt or rails."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from cell.layout import Gripper
from cell.part import MAX_TILT
from maskval import Pose
from sim.part_making.fingers import LEAST_CLEARANCE, Grip, grip_at
from sim.part_making.samples import SurfacePoints
from sim.parts.stable_poses import RestingPose

BELT_ROOM = 0.0025  # m between finger tips and belt; the tool stays within 0.5 mm of its way
RAIL_REACH = 0.050  # m beyond the part's outline that belong to it: 55 mm are free around it
RAIL_TOP = 0.012  # m above the belt
PREFERRED_TILT = float(np.radians(40.0))
PAIRS = 130  # per stable pose
DEPTHS = (-0.008, 0.0, 0.010)  # m of the tool above the pair's middle
_LEVEL = np.sin(np.radians(20.0))  # a closing direction so near to the horizontal is made horizontal
_TUBE, _OPPOSITE = 0.0015, -0.9  # m around a pair's line, and the cosine of its normals
_SEEDS = 900

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Lying:
    """A stable pose with the half planes, (E, 3), that bound the part's outline seen from above."""

    pose: RestingPose
    outline: Array

    @classmethod
    def of(cls, pose: RestingPose, surface: SurfacePoints) -> "Lying":
        """The surface in a stable pose."""
        points = surface.points @ pose.rotation.T
        return cls(pose, scipy.spatial.ConvexHull(points[:, :2]).equations)

    def __post_init__(self) -> None:
        held = np.array(self.outline)
        held.flags.writeable = False
        object.__setattr__(self, "outline", held)


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """A grip and in which of the stable poses it may be used.

    Attributes:
        grip: the grip.
        usable: numbers of the stable poses, the most upright first.
        max_tilt: rad; beyond it stands the first stable pose in which the gripper would meet something.
        score: larger is better.
    """

    grip: Grip
    usable: tuple[int, ...]
    max_tilt: float
    score: float


def find_candidates(
    surface: SurfacePoints, poses: Sequence[RestingPose], center_of_mass: Array, gripper: Gripper, seed: int = 0
) -> list[Candidate]:
    """All grips found for the stable poses, the best first."""
    rng = np.random.default_rng(np.random.SeedSequence(seed))
    middles, axes = antipodal_pairs(surface, rng, 2 * (gripper.max_half_opening - LEAST_CLEARANCE))
    lying = [Lying.of(pose, surface) for pose in poses]
    found = []
    for pose in poses:
        up_O = pose.rotation[2]
        tilted = np.abs(axes @ up_O)
        order = np.flatnonzero(tilted <= np.sin(PREFERRED_TILT))
        for pair in rng.permutation(order)[:PAIRS]:
            for X_OT in _tools(middles[pair], axes[pair], pose, gripper):
                grip = grip_at(X_OT, surface, center_of_mass, gripper)
                if grip is not None and (candidate := _judged(grip, lying, gripper)) is not None:
                    found.append(candidate)
    return sorted(found, key=lambda one: (-round(one.score, 6), *one.grip.X_OT.translation.round(6)))


def antipodal_pairs(surface: SurfacePoints, rng: np.random.Generator, widest: float) -> tuple[Array, Array]:
    """Middles (N, 3) m and directions (N, 3) of lines that meet the surface straight on both sides.

    Args:
        surface: the part's.
        rng: chooses where lines begin.
        widest: longest line, m.
    """
    points, normals = surface.points, surface.normals
    middles, axes = [], []
    for index in rng.permutation(len(points))[:_SEEDS]:
        away = points[index] - points
        along = away @ normals[index]
        across = np.linalg.norm(away - along[:, None] * normals[index], axis=1)
        facing = (across < _TUBE) & (along > 1e-4) & (along < widest) & (normals @ normals[index] < _OPPOSITE)
        lengths = along[facing]
        for length in {round(float(lengths.min()), 4), round(float(lengths.max()), 4)} if len(lengths) else ():
            middles.append(points[index] - length / 2 * normals[index])
            axes.append(normals[index])
    return np.array(middles).reshape(-1, 3), np.array(axes).reshape(-1, 3)


def _tools(middle: Array, axis: Array, pose: RestingPose, gripper: Gripper) -> list[Pose]:
    """Tool poses that close along the axis, as upright as it lets them be, at several heights."""
    up_O = pose.rotation[2]
    if abs(axis @ up_O) < _LEVEL:
        axis = axis - (axis @ up_O) * up_O
    closing = axis / np.linalg.norm(axis)
    approach = -(up_O - (up_O @ closing) * closing)
    approach /= np.linalg.norm(approach)
    R_OT = np.column_stack([np.cross(closing, approach), closing, approach])
    height = float(middle @ up_O) + pose.height
    lowest = gripper.tip_below_tcp + BELT_ROOM + 0.0005
    heights = sorted({round(max(lowest, height + depth), 4) for depth in DEPTHS})
    steep = float(-approach @ up_O)
    return [Pose(R_OT, middle - (h - height) / steep * approach) for h in heights]


def _judged(grip: Grip, lying: Sequence[Lying], gripper: Gripper) -> Candidate | None:
    ups = [one.pose.rotation[2] for one in lying]
    tilts = [float(np.arccos(np.clip(-up @ grip.X_OT.rotation[:, 2], -1, 1))) for up in ups]
    usable: list[int] = []
    limit = MAX_TILT
    for index in sorted(range(len(lying)), key=lambda one: (round(tilts[one], 6), one)):
        if tilts[index] > MAX_TILT - np.radians(2.0):
            break
        if not is_free(grip, lying[index], gripper):
            last = tilts[usable[-1]] if usable else 0.0
            limit = min(MAX_TILT, (last + tilts[index]) / 2)
            break
        usable.append(index)
    if not usable or limit - tilts[usable[0]] < np.radians(3.0):
        return None
    return Candidate(grip, tuple(usable), limit, _score(grip, tilts[usable[0]]))


def _score(grip: Grip, tilt: float) -> float:
    """Large pads' contact, room beside the part, the centre of mass near, upright: each about 1 where it is good."""
    return float(
        min(grip.patch / 40.0, 1.0)
        + 0.7 * min(grip.clearance / 0.015, 1.0)
        - 1.0 * grip.lever / 0.03
        - 0.7 * tilt / PREFERRED_TILT
    )


def is_free(grip: Grip, lying: Lying, gripper: Gripper) -> bool:
    """Whether fingers and body stay off the belt, and so near to the part that rails and other parts stay clear."""
    pose = lying.pose
    R_WT = pose.rotation @ grip.X_OT.rotation
    p_WT = pose.rotation @ grip.X_OT.translation + [0.0, 0.0, pose.height]
    fingers = _corners(gripper.finger_width / 2, grip.half_opening + gripper.finger_thickness, gripper.tip_below_tcp)
    root = gripper.tcp_from_flange - 0.030 - gripper.body_height
    body = _corners(gripper.body_width / 2, gripper.body_length / 2, -root)
    tips, base = fingers @ R_WT.T + p_WT, body @ R_WT.T + p_WT
    if tips[:, 2].min() < BELT_ROOM or base[:, 2].min() < RAIL_TOP + BELT_ROOM:
        return False
    outside = lying.outline[:, :2] @ tips[:, :2].T + lying.outline[:, 2:]
    return bool(outside.max() <= RAIL_REACH)


def _corners(half_x: float, half_y: float, z: float) -> Array:
    return np.array([(sx * half_x, sy * half_y, z) for sx in (-1, 1) for sy in (-1, 1)])
