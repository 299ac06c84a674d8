import dataclasses

import pytest

from cell.interfaces import Action, Decision
from cell.layout import Layout
from cell.viewpoints import refinement_view, search_run
from policies.patient import LEAST_TIME, Patient
from tests.fakes import brick, observation, on_belt, policy_setup, turned

LAYOUT, PART = Layout(), brick()
X_BO = on_belt(PART, LAYOUT, turned())
VIEW = search_run(LAYOUT).views[2]


def seen(u, refining=False, time_left=15.0):
    return observation([u], X_BC=VIEW, X_BO=[X_BO], refining=refining, time_left=time_left)


@pytest.mark.parametrize(
    ("u", "action", "bound"),
    [(0.2, Action.GRASP, 0.2), (0.21, Action.REFINE, 0.6), (0.6, Action.REFINE, 0.6), (0.61, Action.SEARCH, 0.6)],
)
@pytest.mark.parametrize("refining", [False, True])
def test_patient_looks_again_between_the_bounds_in_every_look(u, action, bound, refining):
    decision = Patient(policy_setup()).decide(seen(u, refining))
    assert (decision.action, decision.detection, decision.threshold) == (action, 0, bound)


def test_patient_never_takes_the_same_view_twice_and_begins_from_above():
    patient = Patient(policy_setup())
    decisions = [patient.decide(seen(0.4, refining=look > 0)) for look in range(18)]
    assert [decision.action for decision in decisions] == 17 * [Action.REFINE] + [Action.SEARCH]
    assert decisions[-1] == Decision(Action.SEARCH, 0, 0.2)
    views = [tuple(decision.X_BC.translation.round(6)) for decision in decisions[:-1]]
    assert len(set(views)) == 17
    above = refinement_view(X_BO, PART.mesh.center)
    assert views[0] == tuple(above.translation.round(6))


def test_patient_takes_a_fresh_look_that_it_did_not_ask_for_as_the_one_from_above():
    patient, asking = Patient(policy_setup()), Patient(policy_setup())
    assert patient.decide(seen(0.1)).action is Action.GRASP  # on a moving belt a look from above comes first
    _, second = asking.decide(seen(0.4)), asking.decide(seen(0.4, refining=True))
    assert (patient.decide(seen(0.4, refining=True)).X_BC.matrix == second.X_BC.matrix).all()


def test_patient_begins_anew_with_the_next_view_of_the_search():
    patient = Patient(policy_setup())
    first, _, again = (patient.decide(seen(0.4, refining)) for refining in (False, True, False))
    assert (first.X_BC.matrix == again.X_BC.matrix).all()


def test_patient_searches_on_when_there_is_no_time_for_another_look():
    in_time, late = (Patient(policy_setup()).decide(seen(0.4, time_left=left)) for left in (LEAST_TIME, 2.4))
    assert (in_time.action, late) == (Action.REFINE, Decision(Action.SEARCH, 0, 0.2))


def test_patient_searches_when_nothing_is_seen_or_no_view_is_in_reach():
    far = on_belt(PART, LAYOUT, turned(), x_W=2.0)
    nothing = dataclasses.replace(seen(0.4), detections=(), uncertainties=observation([]).uncertainties)
    assert Patient(policy_setup()).decide(nothing) == Decision(Action.SEARCH)
    assert Patient(policy_setup()).decide(observation([0.4], X_BC=VIEW, X_BO=[far])).action is Action.SEARCH
