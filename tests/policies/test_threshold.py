import dataclasses
import math

import pytest

from cell.interfaces import Action, Decision
from policies import ThresholdPolicy
from tests.fakes import observation

POLICY = ThresholdPolicy(u_grasp=0.2, u_refine=0.6)


@pytest.mark.parametrize(
    ("u", "decision"),
    [
        (0.0, Decision(Action.GRASP, 0, 0.2)),
        (0.2, Decision(Action.GRASP, 0, 0.2)),
        (math.nextafter(0.2, 1.0), Decision(Action.REFINE, 0, 0.6)),
        (0.6, Decision(Action.REFINE, 0, 0.6)),
        (math.nextafter(0.6, 1.0), Decision(Action.SEARCH, 0, 0.6)),
        (1.0, Decision(Action.SEARCH, 0, 0.6)),
    ],
)
def test_threshold_grasps_refines_or_searches_with_both_bounds_included(u, decision):
    assert POLICY.decide(observation([u])) == decision


def test_threshold_grasps_the_least_uncertain_and_not_the_best_score():
    assert POLICY.decide(observation([0.19, 0.9, 0.05, 0.1])) == Decision(Action.GRASP, 2, 0.2)


def test_threshold_refines_the_least_uncertain():
    assert POLICY.decide(observation([0.9, 0.5, 0.4])) == Decision(Action.REFINE, 2, 0.6)


def test_threshold_takes_the_better_score_of_two_that_are_equally_uncertain():
    assert POLICY.decide(observation([0.9, 0.1, 0.1])) == Decision(Action.GRASP, 1, 0.2)


@pytest.mark.parametrize(("u", "action"), [(0.2, Action.GRASP), (0.5, Action.SEARCH), (0.9, Action.SEARCH)])
def test_threshold_looks_again_only_once_and_then_the_bound_to_grasp_is_the_one_missed(u, action):
    second_look = dataclasses.replace(observation([u]), refining=True)
    assert POLICY.decide(second_look) == Decision(action, 0, 0.2)


def test_threshold_searches_when_nothing_is_seen():
    assert POLICY.decide(observation([])) == Decision(Action.SEARCH)


def test_threshold_never_refines_when_grasping_allows_more_than_refining():
    actions = [ThresholdPolicy(0.7, 0.6).decide(observation([u])).action for u in (0.0, 0.65, 0.7, 0.75, 1.0)]
    assert actions == [Action.GRASP] * 3 + [Action.SEARCH] * 2


@pytest.mark.parametrize("name", ["u_grasp", "u_refine"])
@pytest.mark.parametrize("value", [-0.1, 1.1, math.nan, math.inf])
def test_threshold_refuses_bounds_outside_0_to_1_by_name(name, value):
    with pytest.raises(ValueError, match=rf"{name} in \[0, 1\], got {value}"):
        dataclasses.replace(POLICY, **{name: value})
