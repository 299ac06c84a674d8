"""The domain gap: how much worse the networks are on real images than on the rendered ones that they were measured on.

Two numbers: `core_scale` multiplies the pose networks' small errors (shifts and rotations, of S1 and S2),
`outlier_odds` the odds of an outlier. The paper's dataset tables cannot hold them; its robot without uncertainty
quantification does, for S1. That S2 feels all of the gap and the detector none is an assumption: see `Reach`.
"""

import math
from dataclasses import asdict, dataclass

from sim.networks.noise_model import PartNoise


@dataclass(frozen=True, slots=True)
class Reach:
    """How much of the gap the networks beside S1 feel, as an exponent of both its numbers: 0 none of it, 1 all.

    Attributes:
        second: S2's share.
        detector: the detector's; `core_scale` multiplies its outline's displacement, `outlier_odds` the odds of a
            dropped piece and of a miss.
    """

    second: float = 1.0
    detector: float = 0.0

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            if not 0.0 <= value <= 1.0:
                raise ValueError(f"expected {name} in [0, 1], got {value}")


BASE_REACH = Reach()  # of the gap's fit and of every prediction but the variants that name another


@dataclass(frozen=True, slots=True)
class Gap:
    """A domain gap; 1 and 1 is none.

    Attributes:
        core_scale: of real images' small errors, in units of the rendered ones', above 0.
        outlier_odds: the same of the odds of an outlier.
    """

    core_scale: float = 1.0
    outlier_odds: float = 1.0

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            if not (math.isfinite(value) and value > 0.0):
                raise ValueError(f"expected {name} above 0, got {value}")

    def noise(self, rendered: PartNoise, reach: Reach = BASE_REACH) -> dict[str, float]:
        """The parameters of the error model that it changes, with their values on real images.

        Args:
            rendered: The error model on rendered images.
            reach: How much of the gap S2 and the detector feel.
        """
        pose = rendered.pose
        values = {
            "pose.lateral_mm": self.core_scale * pose.lateral_mm,  # the depth error is a multiple of it
            "pose.rotation_deg": self.core_scale * pose.rotation_deg,
            "pose.outlier_probability": _with_odds(pose.outlier_probability, self.outlier_odds),
        }
        if reach.second != 1.0:  # S2's numbers are in units of S1's, which have the whole gap
            spared = reach.second - 1.0
            values["pose.second_scale"] = self.core_scale**spared * pose.second_scale
            values["pose.second_outlier_odds_ratio"] = self.outlier_odds**spared * pose.second_outlier_odds_ratio
        if reach.detector != 0.0:
            odds, mask = self.outlier_odds**reach.detector, rendered.mask
            values["mask.field_cells"] = self.core_scale**reach.detector * mask.field_cells
            values["mask.drop_probability"] = _with_odds(mask.drop_probability, odds)
            values["mask.miss_probability"] = _with_odds(mask.miss_probability, odds)
        return values


def _with_odds(p: float, factor: float) -> float:
    """The probability whose odds are `factor` times those of p."""
    if p == 1.0:
        return 1.0
    odds = factor * p / (1.0 - p)
    return odds / (1.0 + odds)
