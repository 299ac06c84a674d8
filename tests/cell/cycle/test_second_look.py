"""Looking again: where the camera goes, and the fresh look before a grasp on a moving belt."""

import numpy as np
import pytest

from cell.cycle import CycleConfig
from cell.interfaces import Action, Decision, Observation, Outcome, Touch
from cell.records import State
from cell.viewpoints import REFINE_DISTANCE, refinement_view
from maskval import Pose
from policies import Always, ThresholdPolicy
from tests.cell.cycle.runs import entered
from tests.fakes import (
    ATTEMPT,
    LOOK_TIME,
    SETTLE_TIME,
    Experiment,
    Try,
    brick,
    on_belt,
    run_cycle,
    small_layout,
    turned,
)

SPEED = 0.1
PART, LAYOUT = brick(), small_layout(SPEED)
MIDDLE_O = PART.mesh.center
FIRST = on_belt(PART, LAYOUT, turned(), y_W=0.4)
THEN = on_belt(PART, LAYOUT, turned(yaw_deg=5.0), y_W=0.2)  # where the fresh look shows it
CAREFUL = ThresholdPolicy(u_grasp=0.2, u_refine=0.6)
LOOK, AGAIN = [State.SEARCH, State.LOOK, State.DECIDE], [State.REFINE, State.LOOK, State.DECIDE]


def config(**other: object) -> CycleConfig:
    return CycleConfig(parts=1, settle_time=SETTLE_TIME, **other)


def reasons(experiment: Experiment, state: State) -> list[str]:
    return [transition.reason for transition in experiment.transitions if transition.target is state]


# The fresh look


def test_on_a_moving_belt_a_grasp_is_decided_upon_anew_on_a_fresh_look_and_carried_out_from_there() -> None:
    experiment = run_cycle(Always(), belt_speed=SPEED, X_BO=[FIRST, THEN])
    assert entered(experiment) == [*LOOK, *AGAIN, State.DECIDE, *ATTEMPT, State.DONE]
    assert reasons(experiment, State.REFINE) == ["fresh look at detection 0"]
    assert "the belt runs at 0.1" in reasons(experiment, State.DECIDE)[-1]
    assert [seen.observation.refining for seen in experiment.seen] == [False, True]
    assert [seen.decision.action for seen in experiment.seen] == [Action.GRASP, Action.GRASP]
    (attempt,) = experiment.attempts
    assert (attempt.frame, attempt.decision_index, attempt.outcome) == (1, 1, Outcome.PLACED)
    np.testing.assert_allclose(attempt.X_BO_est.matrix, THEN.matrix, atol=1e-12)


@pytest.mark.parametrize(("speed", "fresh_look"), [(0.0, True), (SPEED, False)])
def test_on_a_belt_at_rest_or_where_it_is_not_wanted_there_is_no_fresh_look(speed: float, fresh_look: bool) -> None:
    experiment = run_cycle(Always(), belt_speed=speed, X_BO=[FIRST, THEN], config=config(fresh_look=fresh_look))
    assert entered(experiment) == [*LOOK, *ATTEMPT, State.DONE]
    (attempt,) = experiment.attempts
    np.testing.assert_allclose(attempt.X_BO_est.matrix, FIRST.matrix, atol=1e-12)


def test_a_second_look_that_the_policy_asked_for_is_fresh_enough() -> None:
    experiment = run_cycle(CAREFUL, belt_speed=SPEED, X_BO=[FIRST, THEN], u=[0.4, 0.1])
    assert entered(experiment) == [*LOOK, *AGAIN, State.DECIDE, *ATTEMPT, State.DONE]
    assert reasons(experiment, State.REFINE) == ["detection 0"]


def test_a_part_that_looks_uncertain_on_the_fresh_look_is_not_grasped() -> None:
    experiment = run_cycle(CAREFUL, belt_speed=SPEED, X_BO=[FIRST, THEN], u=[0.1, 0.3], config=config(slot_time=3.5))
    assert entered(experiment) == [*LOOK, *AGAIN, State.DONE]
    assert [seen.decision.action for seen in experiment.seen] == [Action.GRASP, Action.SEARCH]
    assert experiment.count.timeouts == 1


@pytest.mark.parametrize("u_first", [0.1, 0.5])
def test_after_a_second_look_in_vain_the_part_is_grasped_as_seen_from_the_search_view(u_first: float) -> None:
    tries = {"u": [u_first, 0.3, 0.1, 0.1, 0.1], "tries": [Try(Outcome.DROPPED), Try()]}
    parts = CycleConfig(parts=2, settle_time=SETTLE_TIME)
    experiment = run_cycle(CAREFUL, belt_speed=SPEED, X_BO=[FIRST, THEN], config=parts, **tries)
    assert [seen.observation.refining for seen in experiment.seen] == [False, True, False, False, True]
    assert [attempt.frame for attempt in experiment.attempts] == [2, 4]  # the next part is looked at afresh


def test_a_fresh_look_that_is_out_of_reach_is_left_out_and_the_grasp_goes_ahead_as_seen_first() -> None:
    too_high = config(refine_distance=1.5)  # the arm is 1.3 m long
    experiment = run_cycle(Always(), belt_speed=SPEED, X_BO=[FIRST, THEN], config=too_high)
    assert entered(experiment) == [*LOOK, State.REFINE, State.DECIDE, *ATTEMPT, State.DONE]
    assert reasons(experiment, State.DECIDE)[1:] == ["no fresh look: the part will be out of the camera's reach"]
    (attempt,) = experiment.attempts
    assert (attempt.frame, attempt.outcome) == (0, Outcome.PLACED)
    np.testing.assert_allclose(attempt.X_BO_est.matrix, FIRST.matrix, atol=1e-12)


def test_a_grasp_whose_fresh_look_ends_too_late_is_not_tried() -> None:
    slot_time = 1.5 * LOOK_TIME
    experiment = run_cycle(Always(), belt_speed=SPEED, X_BO=[FIRST, THEN], config=config(slot_time=slot_time))
    assert [seen.decision.action for seen in experiment.seen] == [Action.GRASP, Action.GRASP]
    assert (experiment.attempts, experiment.count.timeouts) == ([], 1)


def test_a_contact_on_the_way_to_the_fresh_look_is_a_false_positive() -> None:
    experiment = run_cycle(Always(), belt_speed=SPEED, X_BO=[FIRST], touches={State.REFINE: Touch.CONTAINER})
    assert [slot.outcome for slot in experiment.slots] == [Outcome.COLLISION_CONTAINER]
    assert experiment.attempts == []


def test_a_fresh_look_goes_for_every_part() -> None:
    experiment = run_cycle(
        Always(),
        belt_speed=SPEED,
        X_BO=[FIRST, THEN, FIRST, THEN],
        tries=[Try(Outcome.DROPPED), Try()],
        config=CycleConfig(parts=2, settle_time=SETTLE_TIME),
    )
    assert [seen.observation.refining for seen in experiment.seen] == [False, True, False, True]
    assert [attempt.frame for attempt in experiment.attempts] == [1, 3]


# Where the camera meets the part


class RefineOnce:
    def __init__(self, X_BC: Pose | None = None) -> None:
        self._X_BC = X_BC

    def decide(self, observation: Observation) -> Decision:
        refine = Decision(Action.REFINE, 0, X_BC=self._X_BC)
        return Decision(Action.SEARCH) if observation.refining else refine


def second_view(policy: Always | RefineOnce) -> tuple[float, Pose]:
    """How long after the first frame the second one was taken, s, and from where, X_BC."""
    experiment = run_cycle(policy, belt_speed=SPEED, X_BO=[FIRST], config=config(slot_time=4.0))
    first, second = (seen.observation.frame for seen in experiment.seen[:2])
    return second.time - first.time, second.X_BC


@pytest.mark.parametrize("policy", [RefineOnce(), Always()])
def test_the_second_look_is_where_the_belt_has_carried_the_part(policy: Always | RefineOnce) -> None:
    later, X_BC = second_view(policy)
    p_WC = LAYOUT.X_WB.apply(X_BC.translation)
    # The fake arm takes 1 s for any way, the real one what it plans with: the part is met at the planned time.
    assert p_WC[:2] == pytest.approx([0.68, 0.4 - SPEED * later], abs=0.06)
    assert p_WC[2] == pytest.approx(LAYOUT.belt.top_z + 0.020 + REFINE_DISTANCE)


def test_a_view_that_the_policy_chooses_is_carried_along_with_the_part() -> None:
    aside = refinement_view(FIRST, MIDDLE_O) @ Pose.from_translation(np.array([0.05, 0.0, 0.0]))
    (later, X_BC), (_, above) = second_view(RefineOnce(aside)), second_view(RefineOnce())
    went_W = LAYOUT.X_WB.rotation @ (X_BC.translation - aside.translation)
    assert went_W[1] == pytest.approx(-SPEED * later, abs=0.06)
    assert went_W[[0, 2]] == pytest.approx([0.0, 0.0], abs=1e-6)
    assert np.linalg.norm(X_BC.translation - above.translation) == pytest.approx(0.05, abs=0.02)
    np.testing.assert_allclose(X_BC.rotation, aside.rotation, atol=1e-6)
