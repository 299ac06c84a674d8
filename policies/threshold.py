"""The paper's rule with two thresholds."""

from dataclasses import dataclass

from cell.interfaces import Action, Decision, Observation


@dataclass(frozen=True, slots=True)
class ThresholdPolicy:
    """Acts on the least uncertain detection: u ≤ u_grasp grasps, else u ≤ u_refine looks again, once, else searches on.

    Attributes:
        u_grasp: the paper's u_t,g, in [0, 1].
        u_refine: the paper's u_t,r, in [0, 1].
    """

    u_grasp: float
    u_refine: float

    def __post_init__(self) -> None:
        for name in ("u_grasp", "u_refine"):
            value = getattr(self, name)
            if not 0.0 <= value <= 1.0:
                raise ValueError(f"expected {name} in [0, 1], got {value}")

    def decide(self, observation: Observation) -> Decision:
        """See `cell.interfaces.Policy`."""
        if not observation.detections:
            return Decision(Action.SEARCH)
        best = int(observation.uncertainties.argmin())  # of equals the first, which has the better score
        u = observation.uncertainties[best]
        if u <= self.u_grasp:
            return Decision(Action.GRASP, best, self.u_grasp)
        if observation.refining:
            return Decision(Action.SEARCH, best, self.u_grasp)
        return Decision(Action.REFINE if u <= self.u_refine else Action.SEARCH, best, self.u_refine)
