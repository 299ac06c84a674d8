"""A container slot that takes the part however it is laid, and how many of them the arm reaches."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cell.grasping import RELEASE_GAP, jaw_corners
from cell.layout import Layout
from cell.part import Part
from maskval import Mesh
from sim.part_making.reach import reached_slots
from sim.part_making.selection import Chosen
from sim.parts.part_checks import laid_extents
from sim.parts.stable_poses import RestingPose

MARGINS = (0.020, 0.014, 0.008)  # m beside part and open jaws, the roomiest first
STEP = 0.005  # m; sizes are multiples of it
LONGEST_X = 0.37  # m; beyond it the container meets the belt
LONGEST_Y = 0.25  # m; and beyond this the robot


@dataclass(frozen=True, slots=True)
class Slot:
    """A slot's inner size along W's x and y, m, and how many slots the arm reaches, from the first on."""

    size: tuple[float, float]
    reached: int


def fit_slot(chosen: Sequence[Chosen], poses: Sequence[RestingPose], mesh: Mesh, layout: Layout) -> Slot:
    """The roomiest slot of which the arm reaches all; else that of which it reaches most."""
    needed = np.zeros(2)
    for one in chosen:
        for index in one.poses:
            needed = np.maximum(needed, _occupied(one, poses[index], mesh, layout))
    for pose in poses:  # those without a grasp are still the part's, and files are checked for them
        needed = np.maximum(needed, laid_extents(pose.rotation, mesh.vertices)[:2])
    found = []
    for margin in MARGINS:
        x, y = (float(size) for size in np.ceil((needed + 2 * margin) / STEP - 1e-6) * STEP)
        slot = Slot((round(x, 4), round(y, 4)), 0)
        if x <= LONGEST_X and y <= LONGEST_Y:
            slot = Slot(slot.size, _reached(chosen, poses, Part("part", mesh, (), slot.size), layout))
        found.append(slot)
        if slot.reached == layout.container.rows * layout.container.columns:
            break
    return max(found, key=lambda slot: slot.reached)


def release_opening(chosen: Chosen, layout: Layout) -> float:
    """Half opening of the jaws when they let go, m."""
    return min(chosen.candidate.grip.half_width + RELEASE_GAP, layout.gripper.max_half_opening)


def _occupied(chosen: Chosen, pose: RestingPose, mesh: Mesh, layout: Layout) -> np.ndarray:
    jaws = jaw_corners(layout.gripper, release_opening(chosen, layout), chosen.grasp.X_OT)
    return laid_extents(pose.rotation, np.vstack([mesh.vertices, jaws]))[:2]


def _reached(chosen: Sequence[Chosen], poses: Sequence[RestingPose], part: Part, layout: Layout) -> int:
    ways = [
        reached_slots(part, one.grasp, poses[index], release_opening(one, layout), layout)
        for one in chosen
        for index in one.poses
    ]
    everywhere = [all(column) for column in zip(*ways, strict=True)]
    return next((slot for slot, reached in enumerate(everywhere) if not reached), len(everywhere))
