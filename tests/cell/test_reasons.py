"""The constants of the cell, held by the reasons that stand beside them."""

from types import SimpleNamespace

import numpy as np
import pytest

from cell.arm.limits import PRESETS
from cell.grasping import (
    APPROACH_LENGTH,
    HALF_TURN,
    LIFT_HEIGHT,
    RELEASE_GAP,
    RELEASE_HEIGHT,
    look_at,
    plan_grasps,
)
from cell.layout import Layout
from cell.motion import LONGEST_WAIT, WAIT_STEP, Motion, Unreachable
from cell.part import MAX_TILT
from cell.viewpoints import REFINE_DISTANCE, SEARCH_DISTANCE, SEARCH_STEP, SecondLook
from maskval import Pose
from tests.fakes import FakeStation, brick, on_belt, small_layout, turned

LAYOUT = Layout()
TALLEST, LONGEST = 0.09, 0.21  # m: above the parts that come with the package, and their diameters


def test_a_search_view_shows_the_belts_whole_width_up_to_60_mm_over_it_and_hardly_more() -> None:
    camera, belt = LAYOUT.camera, LAYOUT.belt
    covered = camera.height / camera.fy
    assert (SEARCH_DISTANCE - 0.060) * covered >= belt.width
    assert (SEARCH_DISTANCE - 0.110) * covered < belt.width  # nearer than that, the picture would be wasted


def test_neighbouring_search_views_show_every_part_of_the_belt_at_least_twice() -> None:
    width = SEARCH_DISTANCE * LAYOUT.camera.width / LAYOUT.camera.fx
    assert 2 * SEARCH_STEP + LONGEST <= width < 4 * SEARCH_STEP


def test_a_second_look_is_as_near_as_leaves_room_around_the_longest_part() -> None:
    height = REFINE_DISTANCE * LAYOUT.camera.height / LAYOUT.camera.fy
    assert 1.3 * LONGEST <= height < 2 * LONGEST
    assert REFINE_DISTANCE < SEARCH_DISTANCE


def test_lifting_clears_the_walls_and_the_parts_with_the_jaws_and_with_a_part_in_them() -> None:
    container, gripper = LAYOUT.container, LAYOUT.gripper
    assert container.wall_height + gripper.tip_below_tcp < LIFT_HEIGHT  # the empty jaws on their way out
    assert container.wall_height + TALLEST < LIFT_HEIGHT + RELEASE_HEIGHT  # a part over one that lies in its slot
    assert LIFT_HEIGHT < 2 * TALLEST  # no higher than that
    assert TALLEST + gripper.tip_below_tcp < APPROACH_LENGTH < LIFT_HEIGHT


def test_a_part_is_let_go_above_what_a_pose_error_presses_into_the_floor() -> None:
    assert 0.015 < RELEASE_HEIGHT < LAYOUT.container.wall_height  # m: the pose error that a grasp may have
    assert 0.010 <= RELEASE_GAP < 0.015


def test_beyond_the_greatest_tilt_the_grippers_body_comes_down_to_the_belt() -> None:
    gripper = LAYOUT.gripper
    body_above_tcp = gripper.tcp_from_flange - 0.030 - gripper.body_height  # the adapter has 30 mm
    corner = body_above_tcp * np.cos(MAX_TILT) - gripper.body_length / 2 * np.sin(MAX_TILT)
    assert -0.010 < corner < 0.0  # m from the tool point, which is a little above the belt
    steeper = MAX_TILT + np.radians(15.0)
    assert body_above_tcp * np.cos(steeper) - gripper.body_length / 2 * np.sin(steeper) < -gripper.tip_below_tcp


def test_half_a_turn_is_about_the_approach() -> None:
    np.testing.assert_array_equal(HALF_TURN.rotation @ [0.0, 0.0, 1.0], [0.0, 0.0, 1.0])
    np.testing.assert_array_equal(HALF_TURN.rotation @ [0.0, 1.0, 0.0], [0.0, -1.0, 0.0])
    np.testing.assert_array_equal(HALF_TURN.translation, np.zeros(3))


def test_a_grasp_is_lifted_along_the_bases_z_axis_and_begins_along_its_approach() -> None:
    part = brick()
    for plan in plan_grasps(part, on_belt(part, small_layout(), turned())):
        lifted = plan.X_BT_lifted.translation - plan.X_BT_grip.translation
        np.testing.assert_allclose(lifted, [0.0, 0.0, LIFT_HEIGHT], atol=1e-12)
        before = plan.X_BT_grip.translation - plan.X_BT_before.translation
        np.testing.assert_allclose(before, APPROACH_LENGTH * plan.X_BT_grip.rotation[:, 2], atol=1e-12)


def test_on_a_belt_at_rest_a_second_look_asks_nothing_of_the_motion() -> None:
    motion = SimpleNamespace(belt_moves=False)  # neither the time nor what the arm reaches
    chosen = look_at((0.1, 0.2, 0.0), 0.3)
    seen = SimpleNamespace(
        decision=SimpleNamespace(X_BC=chosen), observation=SimpleNamespace(frame=SimpleNamespace(time=1.0))
    )
    second_look = SecondLook(motion, np.zeros(3), REFINE_DISTANCE, 0.05)
    assert second_look.view(seen) is chosen
    above = SimpleNamespace(
        decision=SimpleNamespace(X_BC=None),
        observation=seen.observation,
        X_BO_est=Pose.from_translation((0.3, 0.1, 0.0)),
    )
    np.testing.assert_allclose(second_look.view(above).translation, [0.3, 0.1, REFINE_DISTANCE], atol=1e-12)


def test_the_arm_meets_at_once_what_is_where_it_stands() -> None:
    layout = small_layout()
    motion = Motion(FakeStation(layout), layout, PRESETS["ur-default"])
    assert motion.meeting_time(lambda _: motion.station.q) == motion.station.time


@pytest.mark.parametrize("share", [0.5, 0.985])
def test_the_arm_waits_for_what_comes_within_its_patience(share: float) -> None:
    layout = small_layout()
    motion = Motion(FakeStation(layout), layout, PRESETS["ur-default"])
    due = motion.station.time + share * LONGEST_WAIT

    def q_at(time: float) -> np.ndarray:
        if time < due:
            raise Unreachable("not yet there")
        return motion.station.q

    meeting = motion.meeting_time(q_at)
    assert meeting is not None
    assert due <= meeting <= due + WAIT_STEP
    assert LONGEST_WAIT * 0.15 > 1.0  # what rides at the fastest belt's speed comes along a metre and more
