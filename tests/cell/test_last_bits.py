"""What differs in the last bit only leads to the same choice: of two ways, grasps, detections, views."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cell.arm.limits import PRESETS
from cell.arm.ur10 import forward, inverse_on_branch
from cell.attempt import Attempt
from cell.grasping import plan_grasps
from cell.layout import Belt, Layout
from cell.motion import Motion
from cell.perception import Perception
from cell.viewpoints import SEARCH_DISTANCE, SEARCH_STEP, search_run
from maskval import Pose
from tests.fakes import (
    HOME,
    MOVE_TIME,
    FakeMasks,
    FakeMethod,
    FakePoses,
    FakeStation,
    brick,
    on_belt,
    small_layout,
    turned,
)

LAYOUT = small_layout()
LAST_BITS = [-1e-15, 0.0, 1e-15]
X_BO = on_belt(brick(), LAYOUT, turned(yaw_deg=20.0), y_W=0.2)


@pytest.mark.parametrize("joint", [0, 5])
def test_a_joint_half_a_turn_away_goes_the_same_way_whatever_the_last_bits(joint):
    q = HOME.copy()
    q[joint] = math.pi
    q_near = HOME.copy()
    q_near[joint] = 0.0
    found = []
    for bits in (-1e-12, 0.0, 1e-12):
        beside = q.copy()
        beside[joint] += bits
        near = inverse_on_branch(forward(beside), q_near)
        assert near is not None
        found.append(near[joint])
    assert found == pytest.approx([-math.pi] * 3, abs=1e-9)


@pytest.mark.parametrize("bits", [-3e-8, 0.0, 3e-8])  # what the arc cosine makes of 1's last bits
def test_of_grasps_that_are_equally_upright_the_first_of_the_file_comes_first(bits):
    part = brick()
    grasp = part.grasps[0]
    twins = replace(part, grasps=(replace(grasp, name="one"), replace(grasp, name="other")))
    lean = Pose.from_rotvec([bits, 0.0, 0.0])
    nearly = replace(twins.grasps[0], X_OT=lean @ grasp.X_OT)
    plans = plan_grasps(replace(twins, grasps=(nearly, twins.grasps[1])), on_belt(part, LAYOUT, turned(), y_W=0.2))
    assert [plan.grasp.name for plan in plans] == ["one", "one", "other", "other"]


@pytest.mark.parametrize("bits", LAST_BITS)
def test_of_ways_that_turn_the_joints_equally_the_first_is_taken(bits, monkeypatch):
    turns = iter([1.0, 1.0 + bits, 2.0, 2.0 + bits])
    monkeypatch.setattr(Attempt, "_turn", lambda *_: next(turns))
    station = FakeStation(LAYOUT, move_time=MOVE_TIME)
    motion = Motion(station, LAYOUT, PRESETS["ur-default"])
    Attempt(motion, brick(), lambda *_: None).run(X_BO, 0, 0.0)
    first = motion.layout.gripper.X_FT
    X_BT = forward(station.motions[0].q) @ first
    assert np.abs(X_BT.matrix - plan_grasps(brick(), X_BO)[0].X_BT_before.matrix).max() < 1e-8


@pytest.mark.parametrize("bits", LAST_BITS)
def test_detections_of_scores_that_differ_in_the_last_bit_stay_in_order(bits):
    station = FakeStation(LAYOUT)
    seeing = Perception(brick(), FakeMasks([[0.3, 0.5, 0.5 + bits]]), (FakePoses([X_BO]),), FakeMethod(), 0.5)
    seen = seeing.observe(seeing.take_frame(station), False, time_left=5.0)
    width = LAYOUT.camera.width
    assert [int(detection.mask.argmax()) // width for detection in seen.detections] == [1, 2, 0]


@pytest.mark.parametrize("bits", LAST_BITS)
def test_uncertainties_that_differ_in_the_last_bit_are_one_number(bits):
    station = FakeStation(LAYOUT)
    seeing = Perception(brick(), FakeMasks([[0.5]]), (FakePoses([X_BO]),), lambda _: np.array([0.5 + bits]), 0.5)
    assert seeing.observe(seeing.take_frame(station), False, time_left=5.0).uncertainties.tolist() == [0.5]


@pytest.mark.parametrize("bits", LAST_BITS)
def test_the_number_of_views_of_a_belt_of_whole_steps_does_not_hang_on_the_last_bit(bits):
    camera = Layout().camera
    half_view = SEARCH_DISTANCE * camera.width / (2 * camera.fx)
    belt = Belt(loading_length=2 * half_view + 3 * SEARCH_STEP + bits)
    assert len(search_run(Layout(belt=belt)).views) == 4
