from dataclasses import dataclass, replace

import numpy as np
import pytest

from cell.arm.limits import PRESETS
from cell.arm.ur10 import forward, inverse_on_branch
from cell.attempt import CLOSING_TIME, RELEASE_TIME, Attempt, Reach
from cell.grasping import APPROACH_LENGTH, HALF_TURN, LIFT_HEIGHT, RELEASE_GAP, RELEASE_HEIGHT, plan_grasps
from cell.interfaces import Contact, Touch
from cell.layout import Container, Layout
from cell.motion import Motion, Unreachable
from cell.records import State
from maskval import Pose
from tests.fakes import (
    ATTEMPT,
    CONTACT_FORCE,
    HALF_WIDTH,
    HOME,
    MOVE_TIME,
    FakeStation,
    brick,
    on_belt,
    small_layout,
    turned,
)

PART, LAYOUT = brick(), small_layout()
X_BO = on_belt(PART, LAYOUT, turned(yaw_deg=20.0), y_W=0.2)
OPEN = LAYOUT.gripper.max_half_opening


@dataclass
class Tried:
    """An attempt that is over."""

    reach: Reach
    states: list[State]
    station: FakeStation

    @property
    def p_WT(self) -> np.ndarray:
        return tool_point(self.station.q)


def tool_point(q: np.ndarray) -> np.ndarray:
    """p_WT of an arm with these joints."""
    return (LAYOUT.X_WB @ forward(q) @ LAYOUT.gripper.X_FT).translation


def up(height: float) -> np.ndarray:
    return np.array([0.0, 0.0, height])


def attempt(
    station: FakeStation | None = None, X_BO_est: Pose = X_BO, layout: Layout = LAYOUT, motion: Motion | None = None
) -> Tried:
    station = station or FakeStation(layout, move_time=MOVE_TIME)
    states = []

    def enter(state: State, reason: str) -> None:
        assert reason
        station.state = state
        states.append(state)

    motion = motion or Motion(station, layout, PRESETS["ur-default"])
    return Tried(Attempt(motion, PART, enter).run(X_BO_est, container_slot=2, seen_at=0.0), states, station)


# Where the tool stands after an attempt on X_BO, in W. The brick is gripped at its middle, 20 mm above its lower side,
# so it hangs in the middle of its slot.
GRIP = LAYOUT.X_WB.apply(X_BO.apply(PART.mesh.center))
BEFORE = GRIP + up(APPROACH_LENGTH)
LIFTED = GRIP + up(LIFT_HEIGHT)
RELEASED = LAYOUT.container.slot_center(2, PART.slot_size) + up(0.020 + RELEASE_HEIGHT)
ABOVE = RELEASED + up(LIFT_HEIGHT)
START = tool_point(HOME)


def test_a_success_goes_through_the_states_in_order_and_ends_above_the_slot():
    tried = attempt()
    assert tried.states == [*ATTEMPT]
    assert tried.reach == Reach("from above", State.RETREAT, None)
    np.testing.assert_allclose(tried.p_WT, ABOVE, atol=1e-9)
    # Six motions, and the two times that the jaws take.
    assert tried.station.time == pytest.approx(6 * MOVE_TIME + CLOSING_TIME + RELEASE_TIME)


def test_the_tool_stops_at_the_grip_above_the_belt_and_in_the_slot():
    places = [(motion.state, tool_point(motion.q)) for motion in attempt().station.motions]
    expected = {
        State.APPROACH: BEFORE,
        State.DESCEND: GRIP,
        State.CLOSE: GRIP,
        State.LIFT: LIFTED,
        State.TRANSFER: ABOVE,
        State.INSERT: RELEASED,
        State.RELEASE: RELEASED,
        State.RETREAT: ABOVE,
    }
    assert [state for state, _ in places] == list(expected)
    for state, p_WT in places:
        np.testing.assert_allclose(p_WT, expected[state], atol=1e-9, err_msg=state)


def test_the_jaws_open_for_the_grasp_press_at_the_part_and_let_go_a_little_wider_than_it():
    (_, opened), (_, gripped), (_, released) = attempt().station.jaw_commands
    assert opened == PART.grasps[0].half_opening
    assert gripped < 0
    assert released == HALF_WIDTH + RELEASE_GAP


# What stops the attempt in each state, where the arm ends after it, and how far open the jaws are then.
STOPS = [
    (State.APPROACH, Touch.BELT, START, OPEN),
    (State.APPROACH, Touch.PART, START, OPEN),
    (State.DESCEND, Touch.PART, BEFORE, PART.grasps[0].half_opening),
    (State.DESCEND, Touch.BELT, BEFORE, PART.grasps[0].half_opening),
    (State.CLOSE, Touch.BELT, BEFORE, OPEN),
    (State.LIFT, Touch.ROBOT, BEFORE, OPEN),
    (State.TRANSFER, Touch.CONTAINER, LIFTED, OPEN),
    (State.INSERT, Touch.PRESSED, ABOVE, OPEN),
    (State.INSERT, Touch.CONTAINER, ABOVE, OPEN),
    (State.RELEASE, Touch.CONTAINER, ABOVE, OPEN),
    (State.RETREAT, Touch.CONTAINER, ABOVE, OPEN),
]


@pytest.mark.parametrize(("state", "touch", "p_WT", "half_opening"), STOPS)
def test_a_contact_stops_the_motion_retreats_and_ends_the_attempt(state, touch, p_WT, half_opening):
    tried = attempt(FakeStation(LAYOUT, move_time=MOVE_TIME, touches={state: touch}))
    stopped = [index for index, motion in enumerate(tried.station.motions) if motion.contact]
    assert len(stopped) == 1
    contact = tried.station.motions[stopped[0]].contact
    assert contact == Contact(touch, CONTACT_FORCE, contact.time)
    assert tried.reach == Reach("from above", state, contact)

    way_there, way_back = tried.states[: ATTEMPT.index(state) + 1], tried.states[ATTEMPT.index(state) + 1 :]
    assert tuple(way_there) == ATTEMPT[: ATTEMPT.index(state) + 1]
    assert set(way_back) == {State.RETREAT}
    after = tried.station.motions[stopped[0] + 1 :]
    assert len(after) >= 1
    assert all(motion.watch == frozenset() for motion in after), "the way out is watched"

    np.testing.assert_allclose(tried.p_WT, p_WT, atol=1e-9)
    assert tried.station.jaw_half_opening == half_opening


@pytest.mark.parametrize("state", [State.LIFT, State.CLOSE])
def test_the_jaws_open_before_the_arm_goes_back_from_the_part(state):
    tried = attempt(FakeStation(LAYOUT, move_time=MOVE_TIME, touches={state: Touch.BELT}))
    opening, back = tried.station.motions[-2:]
    assert tried.station.jaw_commands[-1] == (State.RETREAT, OPEN)
    stopped_at = next(motion.q for motion in tried.station.motions if motion.contact)
    np.testing.assert_array_equal(opening.q, stopped_at)
    assert not np.allclose(back.q, stopped_at)


@pytest.mark.parametrize("state", ATTEMPT)
def test_the_part_may_touch_the_hand_that_holds_it(state):
    station = FakeStation(LAYOUT, move_time=MOVE_TIME, touches={state: Touch.PART})
    stopped = attempt(station).reach.contact is not None
    assert stopped is (state in (State.APPROACH, State.DESCEND))


@pytest.mark.parametrize("state", ATTEMPT)
def test_the_held_part_may_press_on_the_container_except_on_the_way_into_it(state):
    station = FakeStation(LAYOUT, move_time=MOVE_TIME, touches={state: Touch.PRESSED})
    stopped = attempt(station).reach.contact is not None
    assert stopped is (state is State.INSERT)


def test_jaws_that_close_on_nothing_go_back_up_and_transfer_nothing():
    tried = attempt(FakeStation(LAYOUT, move_time=MOVE_TIME, part_half_width=0.0))
    assert tried.states == [State.APPROACH, State.DESCEND, State.CLOSE, State.RETREAT]
    assert tried.reach == Reach("from above", State.CLOSE, None)
    np.testing.assert_allclose(tried.p_WT, BEFORE, atol=1e-9)
    assert tried.station.jaw_half_opening == OPEN


@pytest.mark.parametrize(("state", "p_WT"), [(State.LIFT, LIFTED), (State.TRANSFER, ABOVE)])
def test_a_part_that_slips_out_on_the_way_ends_the_attempt_there(state, p_WT):
    tried = attempt(FakeStation(LAYOUT, move_time=MOVE_TIME, loses_part_in=state))
    assert tried.states == [*ATTEMPT[: ATTEMPT.index(state) + 1], State.RETREAT]
    assert tried.reach == Reach("from above", state, None)
    np.testing.assert_allclose(tried.p_WT, p_WT, atol=1e-9)


UNREACHABLE = {
    "beyond the arm": on_belt(PART, LAYOUT, turned(), x_W=2.0),
    "no grasp from above": on_belt(PART, LAYOUT, turned(pitch_deg=90)),
}


@pytest.mark.parametrize("X_BO_est", UNREACHABLE.values(), ids=UNREACHABLE)
def test_nothing_moves_for_a_pose_that_no_grasp_reaches(X_BO_est):
    tried = attempt(X_BO_est=X_BO_est)
    assert tried.reach == Reach(None, State.APPROACH, None)
    assert (tried.states, tried.station.motions, tried.station.jaw_commands) == ([], [], [])
    assert tried.station.time == 0.0


def test_a_slot_out_of_reach_ends_the_attempt_with_the_part_let_go_where_it_was_lifted():
    far = replace(LAYOUT, container=Container(center_y=-3.0))
    tried = attempt(FakeStation(far, move_time=MOVE_TIME), layout=far)
    assert tried.reach == Reach("from above", State.LIFT, None)
    assert tried.states == [State.APPROACH, State.DESCEND, State.CLOSE, State.LIFT, State.RETREAT]
    np.testing.assert_allclose(tried.p_WT, LIFTED, atol=1e-9)
    assert tried.station.jaw_half_opening == OPEN


@dataclass(frozen=True, slots=True, eq=False)
class NoLine(Motion):
    """An arm that can follow no straight line in one state, as if it led past a singular pose."""

    state: State = State.LIFT

    def line_to(self, X_BT: Pose, *args: object, **kwargs: object) -> Contact | None:
        if self.station.state is self.state:
            raise Unreachable("no straight line")
        return Motion.line_to(self, X_BT, *args, **kwargs)


@pytest.mark.parametrize(
    ("state", "p_WT"), [(State.DESCEND, BEFORE), (State.LIFT, BEFORE), (State.INSERT, ABOVE), (State.RETREAT, ABOVE)]
)
def test_a_line_that_the_arm_cannot_follow_ends_the_attempt_with_the_arm_out_of_the_way(state, p_WT):
    station = FakeStation(LAYOUT, move_time=MOVE_TIME)
    tried = attempt(station, motion=NoLine(station, LAYOUT, PRESETS["ur-default"], state=state))
    assert tried.reach == Reach("from above", state, None)
    np.testing.assert_allclose(tried.p_WT, p_WT, atol=1e-9)


@pytest.mark.parametrize("yaw_deg", [0.0, 60.0, 120.0, 180.0, 240.0, 300.0])
def test_of_the_two_ways_round_the_arm_takes_the_one_that_turns_its_joints_less(yaw_deg):
    X_BO_est = on_belt(PART, LAYOUT, turned(yaw_deg=yaw_deg))
    fresh = Motion(FakeStation(LAYOUT), LAYOUT, PRESETS["ur-default"])
    turns = [np.abs(fresh.joints_for(plan.X_BT_before) - HOME).max() for plan in plan_grasps(PART, X_BO_est)]
    assert len(turns) == 2
    taken = np.abs(attempt(X_BO_est=X_BO_est).station.motions[0].q - HOME).max()
    assert taken == pytest.approx(min(turns))


@pytest.mark.parametrize("yaw_deg", [0.0, 60.0, 120.0, 180.0, 240.0, 300.0])
def test_of_the_two_ways_to_lay_a_part_down_the_arm_takes_the_one_that_turns_its_joints_less(yaw_deg):
    X_BO_est = on_belt(PART, LAYOUT, turned(yaw_deg=yaw_deg))
    motions = attempt(X_BO_est=X_BO_est).station.motions
    q = {motion.state: motion.q for motion in motions}
    taken = np.abs(q[State.TRANSFER] - q[State.LIFT])
    # The other way is the same tool point with the last joint half a turn further, one way or back.
    X_BT = forward(q[State.TRANSFER]) @ LAYOUT.gripper.X_FT
    other = inverse_on_branch(X_BT @ HALF_TURN @ LAYOUT.gripper.X_FT.inverse(), q[State.LIFT])
    assert other is not None
    assert taken.max() <= np.abs(other - q[State.LIFT]).max()
