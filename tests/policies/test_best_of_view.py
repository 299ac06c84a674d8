from cell.interfaces import Action, Decision
from policies import BestOfView
from tests.fakes import observation


def test_best_of_view_grasps_the_least_uncertain_however_uncertain_it_is():
    assert BestOfView().decide(observation([1.0, 0.8, 0.9])) == Decision(Action.GRASP, 1)


def test_best_of_view_takes_the_better_score_of_two_that_are_equally_uncertain():
    assert BestOfView().decide(observation([0.9, 0.4, 0.4])) == Decision(Action.GRASP, 1)


def test_best_of_view_searches_when_nothing_is_seen():
    assert BestOfView().decide(observation([])) == Decision(Action.SEARCH)
