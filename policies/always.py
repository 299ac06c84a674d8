"""Grasp whatever is detected: the paper's "w/o UQ"."""

from dataclasses import dataclass

from cell.interfaces import Action, Decision, Observation


@dataclass(frozen=True, slots=True)
class Always:
    """Grasps the detection of the best score; searches on if there is none."""

    def decide(self, observation: Observation) -> Decision:
        """See `cell.interfaces.Policy`."""
        if not observation.detections:
            return Decision(Action.SEARCH)
        return Decision(Action.GRASP, detection=0)
