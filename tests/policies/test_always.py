from cell.interfaces import Action, Decision
from policies import Always
from tests.fakes import observation


def test_always_grasps_the_detection_of_the_best_score_however_uncertain():
    assert Always().decide(observation(u=[1.0, 0.0])) == Decision(Action.GRASP, detection=0, threshold=None)


def test_always_searches_when_nothing_is_seen():
    assert Always().decide(observation(u=[])) == Decision(Action.SEARCH)
