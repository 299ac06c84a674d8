"""The state machine, as its table has it."""

from itertools import pairwise

import pytest

from cell.cycle import Cycle
from cell.records import TRANSITIONS, State
from policies import Always
from tests.fakes import run_cycle


def test_every_state_has_its_followers_and_is_reached_from_the_first_one() -> None:
    assert set(TRANSITIONS) == set(State)
    reached, new = {State.SEARCH}, {State.SEARCH}
    while new:
        new = set().union(*(TRANSITIONS[state] for state in new)) - reached
        reached |= new
    assert reached == set(State)
    assert [state for state in State if not TRANSITIONS[state]] == [State.DONE]


def test_the_changes_of_an_experiment_follow_one_another_and_the_table() -> None:
    changes = run_cycle(Always()).transitions
    assert len(changes) > 10
    assert all(change.target in TRANSITIONS[change.source] for change in changes)
    assert all(one.target is other.source for one, other in pairwise(changes))
    assert (changes[0].source, changes[-1].target) == (State.SEARCH, State.DONE)


def test_a_change_that_the_table_has_not_is_an_error() -> None:
    cycle = Cycle.__new__(Cycle)
    cycle._state = State.LOOK
    with pytest.raises(RuntimeError, match="expected one of decide after look, got lift"):
        cycle._enter(State.LIFT, "by mistake")
