"""Where the camera looks, and what it touches on its way there."""

import numpy as np
import pytest

from cell.arm.ur10 import forward
from cell.interfaces import Action, Decision, Outcome, Touch
from cell.records import State
from cell.viewpoints import refinement_view
from policies import Always
from tests.cell.cycle.runs import CAREFUL, FAR, HERE, LAYOUT, LOOK, PART, Deciding, config, entered, views_of
from tests.fakes import ATTEMPT, CONTACT_FORCE, LOOK_TIME, VOID, FakeStation, Try, on_belt, run_cycle, turned


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
