"""Grips, their filters, the choice among them and the slot, on shapes whose answers are known."""

import numpy as np
import pytest
import trimesh

from cell.layout import Gripper, Layout
from maskval import Mesh, Pose
from sim.part_making.fingers import LEAST_CLEARANCE, grip_at
from sim.part_making.grasp_search import BELT_ROOM, Candidate, Lying, find_candidates, is_free
from sim.part_making.pose_search import stable_poses
from sim.part_making.samples import sample_surface
from sim.part_making.selection import choose
from sim.part_making.slot import fit_slot

GRIPPER, LAYOUT = Gripper(), Layout()
BOX = trimesh.creation.box((0.09, 0.05, 0.03))
SURFACE = sample_surface(BOX)
DOWN = np.diag([1.0, -1.0, -1.0])  # R_OT of a tool that comes from O's z, its jaws along y


def tool(x: float = 0.0, y: float = 0.0, z: float = 0.0, R_OT: np.ndarray = DOWN) -> Pose:
    return Pose(R_OT, np.array([x, y, z]))


def test_a_box_is_gripped_across_its_width_and_the_tool_moves_to_its_middle() -> None:
    grip = grip_at(tool(y=0.006), SURFACE, np.zeros(3), GRIPPER)
    assert grip is not None
    assert grip.half_width == pytest.approx(0.025, abs=1e-6)
    assert grip.X_OT.translation == pytest.approx((0, 0, 0), abs=1e-6)
    assert grip.half_opening == pytest.approx(0.045)  # 20 mm beside the part
    assert grip.lever == pytest.approx(0.0)


def test_the_lever_is_the_way_of_the_centre_of_mass_from_the_closing_line() -> None:
    grip = grip_at(tool(x=0.02), SURFACE, np.zeros(3), GRIPPER)
    assert grip is not None
    assert grip.lever == pytest.approx(0.02)


@pytest.mark.parametrize(
    ("X_OT", "mesh"),
    [
        (tool(z=0.08), BOX),  # above the part: nothing between the pads
        (tool(), trimesh.creation.box((0.09, 0.2, 0.03))),  # wider than the jaws open
        (tool(), trimesh.creation.box((0.09, 0.11 - LEAST_CLEARANCE, 0.03))),  # no room beside it
        (tool(R_OT=DOWN @ trimesh.transformations.rotation_matrix(0.8, (0, 0, 1))[:3, :3]), BOX),  # askew
        (tool(), trimesh.creation.box((0.02, 0.05, 0.3))),  # the body meets its top
    ],
    ids=["nothing", "too wide", "no room", "askew", "too high"],
)
def test_what_the_jaws_cannot_hold_is_no_grip(X_OT: Pose, mesh: trimesh.Trimesh) -> None:
    assert grip_at(X_OT, sample_surface(mesh), np.zeros(3), GRIPPER) is None


def test_a_finger_needs_room_inside_of_a_part() -> None:
    for room, fits in ((0.06, True), (0.03, False)):
        wall, block = trimesh.creation.box((0.15, 0.01, 0.06)), trimesh.creation.box((0.15, 0.09, 0.06))
        both = trimesh.util.concatenate([wall, block.apply_translation((0, 0.05 + room, 0))])
        grip = grip_at(tool(z=0.02), sample_surface(both), np.zeros(3), GRIPPER)  # across the wall
        assert (grip is not None) is fits
        if grip is not None:
            assert grip.half_width == pytest.approx(0.005, abs=1e-6)


def test_fingers_stay_off_the_belt() -> None:
    flat = next(pose for pose in stable_poses(BOX) if pose.rotation[2, 2] > 0.9)
    lowest = GRIPPER.tip_below_tcp + BELT_ROOM - 0.015  # of the tool above the middle of a box that is 30 mm high
    for height, free in ((lowest + 0.001, True), (lowest - 0.001, False)):
        grip = grip_at(tool(z=height), SURFACE, np.zeros(3), GRIPPER)
        assert grip is not None
        assert is_free(grip, Lying.of(flat, SURFACE), GRIPPER) is free


@pytest.fixture(scope="module")
def candidates() -> list[Candidate]:
    return find_candidates(SURFACE, stable_poses(BOX), np.zeros(3), GRIPPER)


def test_every_candidate_may_be_used_in_its_poses_and_is_not_in_others(candidates: list[Candidate]) -> None:
    poses = stable_poses(BOX)
    lying = [Lying.of(pose, SURFACE) for pose in poses]
    assert len(candidates) > 20
    for one in candidates:
        tilts = [np.arccos(np.clip(-(pose.rotation @ one.grip.X_OT.rotation)[2, 2], -1, 1)) for pose in poses]
        within = {index for index, tilt in enumerate(tilts) if tilt <= one.max_tilt}
        assert within == set(one.usable)
        assert all(is_free(one.grip, lying[index], GRIPPER) for index in within)
        assert one.grip.half_opening <= GRIPPER.max_half_opening


def test_the_choice_covers_every_stable_pose_and_the_slot_takes_part_and_jaws(candidates: list[Candidate]) -> None:
    poses, mesh = stable_poses(BOX), Mesh(BOX.vertices, BOX.faces)
    chosen = choose(candidates, poses, mesh, LAYOUT)
    assert sorted(index for one in chosen for index in one.poses) == list(range(len(poses)))
    slot = fit_slot(chosen, poses, mesh, LAYOUT)
    assert slot.reached == 8
    assert slot.size[0] >= 0.09
    # Gripped across 50 mm: each jaw opens by 12 mm and is 21 mm thick.
    assert max(slot.size) >= min(0.05, 0.03) + 2 * (0.012 + 0.021)


def test_a_part_that_is_too_long_has_fewer_slots_or_none() -> None:
    bar = trimesh.creation.box((0.36, 0.03, 0.03))
    poses, mesh = stable_poses(bar), Mesh(bar.vertices, bar.faces)
    chosen = choose(find_candidates(sample_surface(bar), poses, np.zeros(3), GRIPPER), poses, mesh, LAYOUT)
    assert len(chosen) > 0
    assert fit_slot(chosen, poses, mesh, LAYOUT).reached == 0
