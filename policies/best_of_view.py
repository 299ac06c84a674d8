"""Grasp the least uncertain detection, however uncertain it is."""

from dataclasses import dataclass

from cell.interfaces import Action, Decision, Observation


@dataclass(frozen=True, slots=True)
class BestOfView:
    """Grasps the detection of the lowest u; searches on if there is none. A ranking without a threshold."""

    def decide(self, observation: Observation) -> Decision:
        """See `cell.interfaces.Policy`."""
        if not observation.detections:
            return Decision(Action.SEARCH)
        return Decision(Action.GRASP, int(observation.uncertainties.argmin()))
