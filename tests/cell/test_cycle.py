import re
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cell.cycle import CycleConfig
from cell.errors import CellError, EstimatorError, LayoutError, PolicyError
from cell.interfaces import Action, Decision, Detection, Frame, Observation, Outcome, Touch
from cell.records import FailedFrame, State, TimeSlot
from cell.ur10 import forward
from cell.viewpoints import refinement_view, search_run
from maskval import Pose
from policies import Always, ThresholdPolicy
from tests.fakes import (
    ATTEMPT,
    CONTACT_FORCE,
    LOOK_TIME,
    MOVE_TIME,
    SETTLE_TIME,
    VOID,
    Experiment,
    FakeMasks,
    FakeStation,
    Try,
    brick,
    on_belt,
    run_cycle,
    scripted,
    small_layout,
    turned,
)

LAYOUT, PART = small_layout(), brick()
HERE = on_belt(PART, LAYOUT, turned())
ON_ITS_SIDE = on_belt(PART, LAYOUT, turned(roll_deg=90), y_W=-0.3)
FAR = on_belt(PART, LAYOUT, turned(), x_W=2.0)
LOOK = [State.LOOK, State.DECIDE]
CAREFUL = ThresholdPolicy(u_grasp=0.2, u_refine=0.6)


def config(parts: int = 1, slot_time: float = 20.0, **other: float) -> CycleConfig:
    return CycleConfig(parts=parts, slot_time=slot_time, settle_time=SETTLE_TIME, **other)


def views_of(experiment: Experiment) -> list[int | None]:
    """Which view of the search run each frame was taken from, None for none of them."""
    views = search_run(LAYOUT).views
    found = []
    for seen in experiment.seen:
        X_BC = seen.observation.frame.X_BC
        near = [index for index, view in enumerate(views) if np.abs(view.matrix - X_BC.matrix).max() < 1e-6]
        found.append(near[0] if near else None)
    return found


def entered(experiment: Experiment) -> list[State]:
    return [transition.target for transition in experiment.transitions]


# The way of a success


def test_a_part_that_can_be_placed_is_placed_through_the_states_in_order():
    experiment = run_cycle(Always())
    assert entered(experiment) == [State.SEARCH, *LOOK, *ATTEMPT, State.DONE]
    count = experiment.count
    assert (count.tp, count.fp, count.fn, count.void, count.unreachable, count.timeouts) == (1, 0, 0, 0, 0, 0)
    assert experiment.slots == [TimeSlot(0, 0.0, count.duration, Outcome.PLACED)]
    assert count.duration == experiment.station.time


def test_every_transition_leaves_the_state_that_the_one_before_entered():
    tries = [Try(Outcome.DROPPED), VOID, Try(touches=(State.TRANSFER, Touch.ROBOT)), Try()]
    transitions = run_cycle(CAREFUL, config=config(parts=3), tries=tries, u=[0.9, 0.5, 0.1]).transitions
    assert len(transitions) > 30
    assert transitions[0].source is State.SEARCH
    assert all(before.target is after.source for before, after in pairwise(transitions))
    assert all(before.time <= after.time for before, after in pairwise(transitions))
    assert transitions[-1].target is State.DONE


def test_parts_go_into_the_next_slot_of_the_container_once_something_was_put_into_one():
    tries = [
        Try(),  # into 0
        Try(touches=(State.DESCEND, Touch.BELT)),  # nothing into 1
        Try(touches=(State.TRANSFER, Touch.CONTAINER)),  # nothing into 1
        Try(touches=(State.INSERT, Touch.PRESSED)),  # let go in 1
        Try(Outcome.MISPLACED),  # let go in 2
        Try(),  # into 3
    ]
    experiment = run_cycle(Always(), config=config(parts=6), tries=tries)
    assert experiment.referee.container_slots == [0, 1, 1, 1, 2, 3]
    assert [attempt.container_slot for attempt in experiment.attempts] == [0, 1, 1, 1, 2, 3]


# Slots of time


def test_a_slot_in_which_nothing_is_seen_is_a_timeout_after_20_s():
    experiment = run_cycle(Always(), config=config(parts=2), masks=[[]])
    assert LOOK_TIME == 2.0
    assert len(experiment.seen) == 2 * 20 / 2
    assert experiment.slots == [TimeSlot(0, 0.0, 20.0, None), TimeSlot(1, 20.0, 40.0, None)]
    assert (experiment.count.timeouts, experiment.count.duration) == (2, 40.0)
    assert experiment.attempts == []


def test_a_look_that_began_in_time_is_finished_before_the_timeout():
    slots = run_cycle(Always(), config=config(slot_time=9.0), masks=[[]]).slots
    assert slots == [TimeSlot(0, 0.0, 5 * LOOK_TIME, None)]  # the fifth look begins at 8 s


def test_an_attempt_that_began_in_time_is_finished_and_counts():
    experiment = run_cycle(Always(), config=config(slot_time=2.5))
    assert experiment.attempts[0].start == LOOK_TIME < 2.5
    assert experiment.attempts[0].end > 2.5
    assert experiment.slots == [TimeSlot(0, 0.0, experiment.attempts[0].end, Outcome.PLACED)]
    assert (experiment.count.tp, experiment.count.timeouts) == (1, 0)


@pytest.mark.parametrize("slot_time", [1.0, 2.0])
def test_a_grasp_that_is_decided_upon_too_late_is_not_tried(slot_time):
    experiment = run_cycle(Always(), config=config(slot_time=slot_time))
    assert [seen.decision.action for seen in experiment.seen] == [Action.GRASP]
    assert experiment.attempts == []
    assert (experiment.count.tp, experiment.count.timeouts) == (0, 1)


def test_a_grasp_that_comes_too_late_lets_the_next_part_begin_with_its_view():
    experiment = run_cycle(Always(), config=config(parts=2, slot_time=2 * LOOK_TIME), masks=[[], [0.9]])
    assert views_of(experiment)[:3] == [0, 1, 1]
    assert [slot.outcome for slot in experiment.slots] == [None, Outcome.PLACED]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"parts": 0}, "parts of at least 1, got 0"),
        ({"time_limit": 0.0}, "time_limit above 0 s, got 0.0"),
        ({"slot_time": 0.0}, "slot_time above 0 s, got 0.0"),
        ({"settle_time": float("nan")}, "settle_time of at least 0.0, got nan"),
    ],
)
def test_a_config_that_cannot_be_is_refused(change: dict[str, Any], words: str):
    with pytest.raises(ValueError, match=re.escape(words)):
        CycleConfig(**change)


def test_more_parts_than_slots_of_the_container_are_refused():
    with pytest.raises(LayoutError, match="at most 8 parts, one per slot of the container, got 9"):
        run_cycle(Always(), config=config(parts=9))


def test_a_refinement_that_is_decided_upon_too_late_is_not_begun():
    experiment = run_cycle(CAREFUL, config=config(slot_time=2.0), u=[0.5])
    assert [seen.decision.action for seen in experiment.seen] == [Action.REFINE]
    assert State.REFINE not in entered(experiment)
    assert experiment.count.timeouts == 1


def test_a_reach_into_the_void_costs_time_but_ends_no_slot():
    experiment = run_cycle(Always(), tries=[VOID, VOID, Try()])
    count = experiment.count
    assert (count.tp, count.fp, count.void, count.timeouts) == (1, 0, 2, 0)
    assert [attempt.outcome for attempt in experiment.attempts] == [Outcome.VOID, Outcome.VOID, Outcome.PLACED]
    assert [attempt.last_state for attempt in experiment.attempts] == [State.CLOSE, State.CLOSE, State.RETREAT]
    assert [slot.outcome for slot in experiment.slots] == [Outcome.PLACED]
    assert all(attempt.end - attempt.start > 2 * MOVE_TIME for attempt in experiment.attempts)
    assert count.ap == 1.0


def test_a_slot_of_voids_only_is_a_timeout():
    experiment = run_cycle(Always(), tries=[VOID])
    count = experiment.count
    assert (count.tp, count.fp, count.timeouts) == (0, 0, 1)
    assert count.void == len(experiment.attempts) >= 2
    assert count.ap is None
    assert experiment.slots[0].end >= 20.0


def test_an_unreachable_pose_costs_the_look_moves_nothing_and_ends_no_slot():
    experiment = run_cycle(Always(), X_BO=[FAR, FAR, HERE])
    count = experiment.count
    assert (count.tp, count.fp, count.unreachable, count.timeouts) == (1, 0, 2, 0)
    for attempt in experiment.attempts[:2]:
        assert (attempt.outcome, attempt.grasp, attempt.contact) == (Outcome.UNREACHABLE, None, None)
        assert attempt.start == attempt.end
    assert experiment.attempts[2].start == 3 * LOOK_TIME
    assert len(experiment.referee.verdicts) == 1, "nobody needs to judge what did not happen"


@pytest.mark.parametrize("outcome", [outcome for outcome in Outcome if outcome.is_false_positive])
def test_a_failed_attempt_ends_its_slot_as_a_false_positive(outcome):
    experiment = run_cycle(Always(), config=config(parts=2), tries=[Try(outcome), Try()])
    assert [slot.outcome for slot in experiment.slots] == [outcome, Outcome.PLACED]
    assert (experiment.count.tp, experiment.count.fp) == (1, 1)


def test_false_negatives_are_the_parts_that_the_referee_still_sees_on_the_belt():
    count = run_cycle(Always(), config=config(parts=2), tries=[Try(), Try(Outcome.DROPPED)], left_on_belt=3).count
    assert (count.fn, count.ap, count.ar) == (3, 1 / (1 + 1), 1 / (1 + 3))


# Where the camera looks


def test_the_search_goes_on_where_it_was_when_a_slot_of_time_ends():
    experiment = run_cycle(Always(), config=config(parts=2, slot_time=3.0), masks=[[]])
    assert [slot.end for slot in experiment.slots] == [2 * LOOK_TIME, 4 * LOOK_TIME]
    assert views_of(experiment) == [0, 1, 2, 3]


def test_a_view_that_gave_a_part_is_looked_at_again_and_after_a_failure_the_next_one():
    far_then_here = [HERE, HERE, HERE, HERE, FAR, HERE]
    tries = [Try(), Try(Outcome.DROPPED), Try(), VOID, Try(), Try()]
    experiment = run_cycle(Always(), config=config(parts=4), tries=tries, X_BO=far_then_here)
    assert [attempt.outcome for attempt in experiment.attempts] == [
        Outcome.PLACED,
        Outcome.DROPPED,
        Outcome.PLACED,
        Outcome.VOID,
        Outcome.UNREACHABLE,
        Outcome.PLACED,
    ]
    assert views_of(experiment) == [0, 0, 1, 1, 2, 3]


def test_u_between_the_thresholds_leads_to_one_second_look_that_centres_the_part():
    experiment = run_cycle(CAREFUL, u=[0.4, 0.1])
    assert entered(experiment) == [State.SEARCH, *LOOK, State.REFINE, *LOOK, *ATTEMPT, State.DONE]
    first, second = experiment.seen
    assert (first.observation.refining, second.observation.refining) == (False, True)
    assert first.decision == Decision(Action.REFINE, 0, 0.6)
    assert second.decision == Decision(Action.GRASP, 0, 0.2)
    middle_O = PART.mesh.center
    middle_C = second.observation.poses[0][0].apply(middle_O)
    np.testing.assert_allclose(LAYOUT.camera.project(middle_C), [32 / 2, 24 / 2], atol=1e-6)
    assert experiment.attempts[0].frame == second.observation.frame.index == 1
    assert experiment.attempts[0].u == 0.1


def test_a_part_that_stays_uncertain_is_looked_at_once_more_then_the_search_goes_on():
    experiment = run_cycle(CAREFUL, config=config(slot_time=100.0), u=[0.4])
    assert [seen.observation.refining for seen in experiment.seen][:6] == [False, True] * 3
    assert views_of(experiment)[:6:2] == [0, 1, 2]
    assert experiment.attempts == []
    assert experiment.count.timeouts == 1


def test_a_policy_may_look_again_until_the_time_is_up_and_knows_what_is_left():
    always_again = Deciding(lambda: Decision(Action.REFINE, 0), first=0)
    experiment = run_cycle(always_again, config=config(slot_time=7.0))
    # A look takes 2 s, 1 s when the arm is there already; what is left is counted when the networks have answered.
    assert [seen.observation.time_left for seen in experiment.seen] == [5.0, 3.0, 2.0, 1.0, 0.0]
    assert [seen.observation.refining for seen in experiment.seen] == [False, True, True, True, True]
    assert experiment.count.timeouts == 1


def test_a_policy_chooses_the_view_of_the_next_look():
    X_BC = refinement_view(HERE, np.zeros(3))
    experiment = run_cycle(Deciding(lambda: Decision(Action.REFINE, 0, X_BC=X_BC), first=0), config=config(slot_time=3))
    _, second = experiment.seen
    np.testing.assert_allclose(second.observation.frame.X_BC.matrix, X_BC.matrix, atol=1e-9)


def test_a_policy_chooses_the_pose_that_is_grasped():
    elsewhere = on_belt(PART, LAYOUT, turned(yaw_deg=30), y_W=0.1)
    experiment = run_cycle(Deciding(lambda: Decision(Action.GRASP, 0, X_BO_est=elsewhere), first=0))
    assert experiment.attempts[0].X_BO_est is elsewhere
    (grasp,) = (grasp for grasp in PART.grasps if grasp.name == experiment.attempts[0].grasp)
    descended = [motion.q for motion in experiment.station.motions if motion.state is State.DESCEND][-1]
    X_BT = forward(descended) @ LAYOUT.gripper.X_FT
    np.testing.assert_allclose(X_BT.translation, (elsewhere @ grasp.X_OT).translation, atol=1e-6)


def test_u_above_both_thresholds_is_searched_past():
    experiment = run_cycle(CAREFUL, u=[0.7, 0.7, 0.1])
    assert [seen.observation.refining for seen in experiment.seen] == [False] * 3
    assert views_of(experiment) == [0, 1, 2]


def test_a_second_look_from_out_of_reach_is_left_out():
    experiment = run_cycle(CAREFUL, X_BO=[FAR, HERE], u=[0.4, 0.1])
    assert entered(experiment)[:6] == [State.SEARCH, *LOOK, State.REFINE, State.SEARCH, State.SEARCH]
    assert [seen.observation.refining for seen in experiment.seen] == [False, False]
    assert experiment.count.tp == 1


# Contacts while the camera moves


@pytest.mark.parametrize(("state", "looks_before"), [(State.SEARCH, 0), (State.REFINE, 1)])
def test_a_contact_on_the_way_to_a_view_is_a_false_positive_with_a_slot_but_no_attempt(state, looks_before):
    experiment = run_cycle(
        CAREFUL, config=config(parts=2), u=[0.4] * looks_before + [0.1], touches={state: Touch.CONTAINER}
    )
    assert [slot.outcome for slot in experiment.slots] == [Outcome.COLLISION_CONTAINER, Outcome.PLACED]
    assert (experiment.count.fp, experiment.count.tp, experiment.count.timeouts) == (1, 1, 0)
    contact, placed = experiment.referee.verdicts
    assert (contact.touch, contact.force, placed) == (Touch.CONTAINER, CONTACT_FORCE, None)
    assert [attempt.slot for attempt in experiment.attempts] == [1]


def test_after_a_contact_on_the_way_to_a_view_the_arm_goes_back_unwatched_and_says_why():
    experiment = run_cycle(Always(), touches={State.SEARCH: Touch.BELT})
    start = FakeStation(LAYOUT).q
    stopped, back = experiment.station.motions[:2]
    assert stopped.contact is not None
    assert not np.allclose(stopped.q, start)
    assert back.watch == frozenset()
    np.testing.assert_allclose(back.q, start)
    retreat = experiment.transitions[1]
    assert (retreat.source, retreat.target, retreat.reason) == (State.SEARCH, State.RETREAT, "45 N against belt")


# Records


def test_every_attempt_can_be_traced_to_the_frame_detection_u_and_threshold_that_caused_it():
    experiment = run_cycle(
        CAREFUL,
        config=config(parts=4),
        masks=[[0.9, 0.8, 0.7], [0.9, 0.8], []],
        X_BO=[[FAR, FAR, HERE], [FAR, ON_ITS_SIDE], []],
        X_BO_second=[FAR],
        u=[[0.3, 0.9, 0.1], [0.7, 0.15], []],
        tries=[Try(Outcome.DROPPED), Try()],
    )
    seen_by_index = {seen.decision_index: seen for seen in experiment.seen}
    assert list(seen_by_index) == list(range(len(experiment.seen)))
    assert [(attempt.detection, attempt.u, attempt.slot) for attempt in experiment.attempts] == [
        (2, 0.1, 0),
        (1, 0.15, 1),
    ]
    for attempt, X_BO in zip(experiment.attempts, (HERE, ON_ITS_SIDE), strict=True):
        seen = seen_by_index[attempt.decision_index]
        observation = seen.observation
        assert seen.decision == Decision(Action.GRASP, attempt.detection, attempt.threshold)
        assert attempt.threshold == 0.2
        assert attempt.frame == observation.frame.index
        assert attempt.u == observation.uncertainties[attempt.detection]
        assert attempt.slot == seen.slot
        assert attempt.start >= observation.frame.time
        # The first estimator's, of this detection.
        np.testing.assert_allclose(attempt.X_BO_est.matrix, X_BO.matrix, atol=1e-12)


def test_an_attempt_tells_the_u_of_its_own_detection_and_no_threshold_where_there_was_none():
    (attempt,) = run_cycle(Always(), masks=[[0.9, 0.8]], u=[[0.3, 0.1]]).attempts
    assert (attempt.detection, attempt.u, attempt.threshold) == (0, 0.3, None)


def test_an_attempt_tells_what_stopped_it_and_how_far_it_came():
    experiment = run_cycle(Always(), tries=[Try(touches=(State.INSERT, Touch.PRESSED))])
    (attempt,) = experiment.attempts
    assert attempt.last_state is State.INSERT
    assert attempt.contact is not None
    assert (attempt.contact.touch, attempt.contact.force) == (Touch.PRESSED, CONTACT_FORCE)
    assert attempt.outcome is Outcome.COLLISION_CONTAINER
    assert attempt.start < attempt.contact.time < attempt.end == experiment.count.duration
    assert attempt.grasp == "from above"


# Policies and estimators that fail


@dataclass
class Deciding:
    """A policy that decides whatever it is told to, from a certain frame on; before, it searches."""

    answer: Callable[[], Any]
    first: int = 1

    def decide(self, observation: Observation) -> Any:
        return Decision(Action.SEARCH) if observation.frame.index < self.first else self.answer()


def raising() -> Any:
    raise LookupError("no such table")


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (raising, "raised LookupError: no such table"),
        (lambda: None, "expected a cell.interfaces.Decision, got NoneType"),
        (lambda: "grasp", "expected a cell.interfaces.Decision, got str"),
        (lambda: Decision(Action.GRASP, 2), "expected a detection in 0..1 to grasp, got 2"),
        (lambda: Decision(Action.GRASP, -1), "expected a detection in 0..1 to grasp, got -1"),
        (lambda: Decision(Action.REFINE, 2), "expected a detection in 0..1 to refine, got 2"),
        (lambda: Decision(Action.GRASP), "expected a detection in 0..1 to grasp, got None"),
        (lambda: Decision(Action.GRASP, 1.0), "expected a detection in 0..1 to grasp, got 1.0"),
        (lambda: Decision(Action.SEARCH, 2), "expected a detection in 0..1 to search, got 2"),
        (lambda: Decision("grasp", 0), "expected a cell.interfaces.Action, got 'grasp'"),
        (lambda: Decision(Action.GRASP, 0, "low"), "expected threshold to be a finite number or None, got 'low'"),
        (lambda: Decision(Action.GRASP, 0, float("nan")), "expected threshold to be a finite number or None, got nan"),
        (
            lambda: Decision(Action.GRASP, 0, None, np.eye(4)),
            "expected X_BO_est to be a maskval.Pose or None, got ndarray",
        ),
        (lambda: Decision(Action.REFINE, 0, X_BC="up"), "expected X_BC to be a maskval.Pose or None, got str"),
        (lambda: sys.exit("bye"), "raised SystemExit: bye"),
    ],
)
def test_a_policy_that_raises_or_names_what_is_not_there_is_refused_by_name_and_frame(answer, message):
    place = r"( \(test_cycle\.py:\d+\))?"
    with pytest.raises(PolicyError, match=f"^{re.escape(f'Deciding on frame 1: {message}')}{place}$"):
        run_cycle(Deciding(answer), masks=[[0.9, 0.8]])


def test_rubbish_from_a_network_ends_the_experiment_and_not_only_the_slot():
    with pytest.raises(EstimatorError, match=r"FakeMasks on frame 2: expected score 0 in \[0, 1\], got 7.0"):
        run_cycle(Always(), config=config(parts=2), masks=[[], [], [7.0]])


@pytest.mark.parametrize("case", ["detector", "policy"])
def test_the_frame_on_which_something_failed_is_told_of(case):
    told: list[object] = []
    fails = Deciding(raising, first=2) if case == "policy" else Always()
    masks = [[]] * 2 + [[0.9]] if case == "policy" else [[], [], [7.0]]
    with pytest.raises(CellError) as error:
        run_cycle(fails, masks=masks, listener=told.append)
    (failed,) = (record for record in told if isinstance(record, FailedFrame))
    assert (failed.frame.index, failed.refining, failed.reason) == (2, False, str(error.value))
    assert (failed.observation is None) == (case == "detector")
    assert told[-1] is failed


def test_a_policy_that_hangs_is_ended_by_name_and_frame():
    with pytest.raises(PolicyError, match=r"^Deciding on frame 1: took longer than 0\.25 s$"):
        run_cycle(Deciding(lambda: time.sleep(30)), config=config(time_limit=0.25))


# Whatever happens


@dataclass(frozen=True)
class Happening:
    """What one look meets: whether a part is seen, how uncertain it is, where it is, and a contact thereafter."""

    seen: bool
    u: float
    X_BO: Pose
    touch_on_the_way: bool


class EventfulMasks(FakeMasks):
    """Sees what happens, and puts things in the way of the camera's next move."""

    def __init__(self, station: FakeStation, happenings: Sequence[Happening]) -> None:
        super().__init__([[0.9] if happening.seen else [] for happening in happenings])
        self._station, self._happenings, self._looks = station, happenings, 0

    def detect(self, frame: Frame) -> Sequence[Detection]:
        if scripted(self._happenings, self._looks).touch_on_the_way:
            self._station.touches |= {State.SEARCH: Touch.ROBOT, State.REFINE: Touch.ROBOT}
        self._looks += 1
        return super().detect(frame)


HAPPENINGS = st.builds(
    Happening,
    seen=st.booleans(),
    u=st.sampled_from([0.0, 0.2, 0.4, 0.6, 0.9]),
    X_BO=st.sampled_from([HERE, ON_ITS_SIDE, FAR]),
    touch_on_the_way=st.booleans(),
)
FINISHED = st.sampled_from([Outcome.PLACED, Outcome.PLACED, Outcome.DROPPED, Outcome.MISPLACED]).map(Try)
STOPPED = st.sampled_from([*ATTEMPT]).map(lambda state: Try(touches=(state, Touch.CONTAINER)))


@given(
    happenings=st.lists(HAPPENINGS, min_size=1, max_size=12),
    tries=st.lists(st.one_of(FINISHED, STOPPED, st.just(VOID)), min_size=1, max_size=6),
    config=st.builds(config, st.integers(1, 4), st.sampled_from([1.0, 6.0, 12.0])),
    left_on_belt=st.integers(0, 4),
)
@settings(max_examples=200, deadline=None)
def test_whatever_happens_every_part_has_one_slot_and_every_slot_is_a_tp_an_fp_or_a_timeout(
    happenings, tries, config, left_on_belt
):
    experiment = run_cycle(
        CAREFUL,
        config=config,
        masks=lambda station: EventfulMasks(station, happenings),
        X_BO=[happening.X_BO for happening in happenings],
        u=[happening.u for happening in happenings],
        tries=tries,
        left_on_belt=left_on_belt,
    )
    count, slots = experiment.count, experiment.slots
    assert count.tp + count.fp + count.timeouts == config.parts
    assert count.fn == left_on_belt

    assert [slot.index for slot in slots] == list(range(config.parts))
    assert slots[0].start == 0.0
    assert all(before.end == after.start for before, after in pairwise(slots))
    assert slots[-1].end == count.duration == experiment.station.time
    outcomes = [slot.outcome for slot in slots]
    assert outcomes.count(Outcome.PLACED) == count.tp
    assert outcomes.count(None) == count.timeouts
    assert all(slot.end >= slot.start + config.slot_time for slot in slots if slot.outcome is None)

    attempted = [attempt.outcome for attempt in experiment.attempts]
    assert attempted.count(Outcome.PLACED) == count.tp
    assert attempted.count(Outcome.VOID) == count.void
    assert attempted.count(Outcome.UNREACHABLE) == count.unreachable
    camera_contacts = sum(
        motion.contact is not None and motion.state in (State.SEARCH, State.REFINE)
        for motion in experiment.station.motions
    )
    assert sum(outcome.is_false_positive for outcome in attempted) + camera_contacts == count.fp
    assert all(attempt.start < slots[attempt.slot].start + config.slot_time for attempt in experiment.attempts)
    assert all(attempt.u <= 0.2 for attempt in experiment.attempts)

    transitions = experiment.transitions
    assert all(before.target is after.source for before, after in pairwise(transitions))
    assert (transitions[0].source, transitions[-1].target) == (State.SEARCH, State.DONE)
