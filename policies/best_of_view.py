"""Grasp the least uncertain of what is seen, however uncertain it is."""

from dataclasses import dataclass

from cell.interfaces import Action, Decision, Observation


@dataclass(frozen=True, slots=True)
class BestOfView:
    """Grasps the detection of the lowest u; searches on when there is none. A ranking, without any threshold."""

    def decide(self, observation: Observation) -> Decision:
        """See `cell.interfaces.Policy`."""
        if not observation.detections:
            return Decision(Action.SEARCH)
        return Decision(Action.GRASP, int(observation.uncertainties.argmin()))
