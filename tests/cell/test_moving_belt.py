"""The controller on a moving belt: it meets parts where the belt has carried them."""

import numpy as np
import pytest

from cell.arm.conveyor_tracking import RAMP_TIME
from cell.arm.limits import PRESETS
from cell.attempt import Attempt, Reach
from cell.grasping import APPROACH_LENGTH, LIFT_HEIGHT
from cell.interfaces import Contact, Touch
from cell.motion import Motion
from cell.records import State
from cell.viewpoints import search_run
from tests.fakes import FakeStation, brick, on_belt, small_layout, turned

SPEED, SEEN_AT = 0.1, 2.0
PART, LAYOUT = brick(), small_layout(SPEED)


class ObservedStation(FakeStation):
    """Keeps when and where the tool was after every motion, by state."""

    def __init__(self, **options: object) -> None:
        super().__init__(LAYOUT, **options)
        self.time = SEEN_AT + 0.5  # what the estimate took
        self.after: list[tuple[State, float, np.ndarray]] = []

    def _pass(self, duration: float, watch: frozenset[Touch], touch: Touch | None) -> Contact | None:
        contact = super()._pass(duration, watch, touch)
        self.after.append((self.state, self.time, (LAYOUT.X_WB @ self.X_BT).translation))
        return contact

    def last(self, state: State) -> tuple[float, np.ndarray]:
        return next((time, p_WT) for was, time, p_WT in reversed(self.after) if was is state)


def attempted(y_W: float, **options: object) -> tuple[Reach, ObservedStation]:
    """An attempt on a brick that was seen at SEEN_AT at a place along the belt."""
    station = ObservedStation(**options)

    def enter(state: State, reason: str) -> None:
        station.state = state

    motion = Motion(station, LAYOUT, PRESETS["ur-default"])
    X_BO_est = on_belt(PART, LAYOUT, turned(yaw_deg=20.0), y_W=y_W)
    return Attempt(motion, PART, enter).run(X_BO_est, 0, SEEN_AT), station


def middle_of_brick(y_W: float, time: float) -> np.ndarray:
    """Where the grip is at a time, in W: the belt runs along −y."""
    return np.array([0.68, y_W - SPEED * (time - SEEN_AT), LAYOUT.belt.top_z + 0.020])


@pytest.mark.parametrize("y_W", [0.6, 0.2])
def test_the_tool_meets_the_part_and_moves_with_it(y_W: float) -> None:
    reach, station = attempted(y_W)
    assert reach == Reach("from above", State.RETREAT, None)
    heights = {State.APPROACH: APPROACH_LENGTH, State.DESCEND: 0.0, State.CLOSE: 0.0}
    for state, height in heights.items():
        time, p_WT = station.last(state)
        np.testing.assert_allclose(p_WT, middle_of_brick(y_W, time) + [0, 0, height], atol=5e-4)
    time, p_WT = station.last(State.LIFT)
    # It came to rest in the last RAMP_TIME and so lags half of that behind the belt.
    lag = np.array([0.0, SPEED * RAMP_TIME / 2, LIFT_HEIGHT])
    np.testing.assert_allclose(p_WT, middle_of_brick(y_W, time) + lag, atol=5e-4)


def test_a_part_that_is_still_out_of_reach_is_waited_for() -> None:
    reach, station = attempted(1.6)
    assert reach.grasp is not None
    times = [time for state, time, _ in station.after if state is State.APPROACH]
    assert times[1] - times[0] > 1.0  # the arm was there first
    assert station.last(State.CLOSE)[1][1] < LAYOUT.belt.loading_length / 2


def test_a_part_that_will_be_out_of_reach_is_left_alone() -> None:
    reach, station = attempted(-0.75)
    assert reach == Reach(None, State.APPROACH, None)
    assert station.after == []


def test_jaws_that_close_on_nothing_leave_the_belt_and_go_up() -> None:
    reach, station = attempted(0.4, part_half_width=0.0)
    assert (reach.last_state, reach.contact) == (State.CLOSE, None)
    closed_at, _ = station.last(State.CLOSE)
    _, p_WT = station.last(State.RETREAT)
    assert p_WT[2] == pytest.approx(LAYOUT.belt.top_z + 0.020 + APPROACH_LENGTH, abs=1e-6)
    assert p_WT[1] < middle_of_brick(0.4, closed_at)[1]


def test_parts_are_waited_for_at_the_upstream_view() -> None:
    run, still = search_run(LAYOUT), search_run(small_layout())
    assert len(run.views) == 1 < len(still.views)
    assert np.array_equal(run.views[0].matrix, still.views[0].matrix)
