"""The paper's rule with as many second looks as time allows, each from another side."""

from dataclasses import replace

from cell.interfaces import Action, Decision, Observation
from cell.setup import PolicySetup
from policies.threshold import ThresholdPolicy
from policies.views import views_around

LEAST_TIME = 2.5  # s: a move and a look take 2 s at the UR's default speed, and an attempt must begin in time


class Patient:
    """Like `ThresholdPolicy`, but looks again while u_grasp < u ≤ u_refine: from above, then from the part's sides.

    It searches on after every view that the arm reaches, or when there is no time for another one.
    """

    def __init__(self, setup: PolicySetup) -> None:
        self._setup = setup
        self._rule = ThresholdPolicy(setup.u_grasp, setup.u_refine)
        self._looks = 0  # second looks since the last view of the search

    def decide(self, observation: Observation) -> Decision:
        """See `cell.interfaces.Policy`."""
        # A second look that was not asked for, a fresh one before a grasp, was the one from above.
        self._looks = max(self._looks, 1) if observation.refining else 0
        decision = self._rule.decide(replace(observation, refining=False))
        if decision.action is not Action.REFINE or decision.detection is None:
            return decision
        views = views_around(observation, decision.detection, self._setup)
        if self._looks >= len(views) or observation.time_left < LEAST_TIME:
            return Decision(Action.SEARCH, decision.detection, self._rule.u_grasp)
        X_BC = views[self._looks]
        self._looks += 1
        return replace(decision, X_BC=X_BC)
