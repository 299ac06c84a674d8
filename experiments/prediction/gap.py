"""The domain gap: how much worse the networks are on real images than on the rendered ones that they were measured on.

Two numbers: `core_scale` multiplies the pose networks' small errors (shifts and rotations, of S1 and S2),
`outlier_odds` the odds of an outlier. The paper's dataset tables cannot hold them; its robot without uncertainty
quantification does.
"""

import json
import math
from dataclasses import asdict, dataclass
from importlib.resources import files
from pathlib import Path

from experiments.errors import UsageError
from sim.networks.noise_model import PartNoise

_PRESETS = files("experiments") / "presets" / "gaps"


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

    def noise(self, rendered: PartNoise) -> dict[str, float]:
        """The parameters of the error model that it changes, with their values on real images."""
        p = rendered.pose.outlier_probability
        odds = self.outlier_odds * p / (1.0 - p)
        return {
            "pose.lateral_mm": self.core_scale * rendered.pose.lateral_mm,  # the depth error is a multiple of it
            "pose.rotation_deg": self.core_scale * rendered.pose.rotation_deg,
            "pose.outlier_probability": odds / (1.0 + odds),
        }


def load_gaps(part: str, source: str) -> list[Gap]:
    """Draws of a part's gap.

    Args:
        part: The part's name.
        source: "none", "fitted" for those that come with the package, or a gap.json of `graspcell gap`.

    Raises:
        UsageError: there are none for this part, or the file is malformed.
    """
    if source == "none":
        return [Gap()]
    path = _PRESETS / f"{part}.json" if source == "fitted" else Path(source)
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        if found["object"] != part:
            raise UsageError(f"the gap {source} is of {found['object']}, but the part is {part}")
        gaps = [Gap(**row) for row in found["draws"]]
    except OSError as error:
        raise UsageError(
            f"no gap for {part} in {source}: expected none, fitted, or a gap.json of `graspcell gap --part {part}`"
        ) from error
    except (ValueError, KeyError, TypeError) as error:
        raise UsageError(f"the gap {source} is malformed: {type(error).__name__}: {error}") from error
    if not gaps:
        raise UsageError(f"the gap {source} holds no draws")
    return gaps
