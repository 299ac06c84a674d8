"""The cycle driven from outside, decision by decision."""

import re

import pytest

from cell.cycle import Cycle, CycleConfig, Deciding
from cell.errors import PolicyError
from cell.interfaces import Action, Decision, Outcome
from cell.perception import Perception
from cell.records import Tally, TimeSlot
from policies import ThresholdPolicy
from tests.fakes import (
    SETTLE_TIME,
    VOID,
    FakeMasks,
    FakeMethod,
    FakePoses,
    FakeReferee,
    FakeStation,
    Records,
    Try,
    brick,
    on_belt,
    run_cycle,
    small_layout,
    turned,
)

CONFIG = CycleConfig(parts=2, settle_time=SETTLE_TIME)
U = [0.4, 0.1, 0.9, 0.5, 0.05]
TRIES = [VOID, Try(Outcome.DROPPED), Try()]


def undecided() -> tuple[Cycle, Records]:
    layout, part = small_layout(), brick()
    station = FakeStation(layout, move_time=1.0)
    records = Records(station)
    poses = FakePoses([on_belt(part, layout, turned())])
    cycle = Cycle(
        station=station,
        referee=FakeReferee(station, TRIES),
        perception=Perception(part, FakeMasks(), (poses,), FakeMethod(U), pixel_center=0.5),
        layout=layout,
        config=CONFIG,
        listener=records,
    )
    return cycle, records


def driven(decisions: Deciding[Tally], policy: ThresholdPolicy) -> Tally:
    try:
        observation = next(decisions)
        while True:
            observation = decisions.send(policy.decide(observation))
    except StopIteration as end:
        count: Tally = end.value
        return count


def test_whoever_decides_like_the_policy_gets_what_the_policy_gets():
    policy = ThresholdPolicy(u_grasp=0.2, u_refine=0.6)
    expected = run_cycle(policy, config=CONFIG, u=U, tries=TRIES)
    cycle, records = undecided()
    assert driven(cycle.decisions(), policy) == expected.count
    assert records.of(TimeSlot) == expected.slots
    assert [seen.decision for seen in records.of(type(expected.seen[0]))] == [seen.decision for seen in expected.seen]
    assert len(expected.seen) > 4


def test_nothing_happens_before_the_first_observation_is_asked_for():
    cycle, records = undecided()
    decisions = cycle.decisions()
    assert records.all == []
    assert next(decisions).frame.index == 0


@pytest.mark.parametrize(
    ("decision", "words"),
    [
        ("grasp", "the decision on frame 0: expected a cell.interfaces.Decision, got str"),
        (Decision(Action.GRASP, 1), "the decision on frame 0: expected a detection in 0..0 to grasp, got 1"),
        (Decision(Action.REFINE), "the decision on frame 0: expected a detection in 0..0 to refine, got None"),
    ],
)
def test_a_decision_about_nothing_is_refused(decision, words):
    decisions = undecided()[0].decisions()
    next(decisions)
    with pytest.raises(PolicyError, match=f"^{re.escape(words)}$"):
        decisions.send(decision)


def test_a_cycle_without_a_policy_does_not_run_by_itself():
    with pytest.raises(ValueError, match="expected a cycle with a policy to run"):
        undecided()[0].run()
