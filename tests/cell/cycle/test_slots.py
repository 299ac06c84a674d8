"""Attempts, slots of time and of the container, and what counts as what."""

import re
from itertools import pairwise
from typing import Any

import pytest

from cell.cycle import CycleConfig
from cell.errors import LayoutError
from cell.interfaces import Action, Outcome, Touch
from cell.records import State, TimeSlot
from policies import Always
from tests.cell.cycle.runs import CAREFUL, FAR, HERE, LOOK, config, entered, views_of
from tests.fakes import ATTEMPT, LOOK_TIME, MOVE_TIME, VOID, Try, run_cycle

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
    told = [change.reason for change in experiment.transitions if change.reason.startswith("unreachable")]
    assert len(told) == 2
    assert "out of reach: no joint angles for" in told[0]
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
