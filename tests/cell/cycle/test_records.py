"""What attempts tell of what led to them."""

import numpy as np

from cell.interfaces import Action, Decision, Outcome, Touch
from cell.records import State
from policies import Always
from tests.cell.cycle.runs import CAREFUL, FAR, HERE, ON_ITS_SIDE, config
from tests.fakes import CONTACT_FORCE, Try, run_cycle


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
