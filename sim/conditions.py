"""What disturbs an experiment: named knobs, none of them set by default. No engine needed to set them."""

import math
from dataclasses import dataclass

from sim.errors import ConditionsError


@dataclass(frozen=True)
class Conditions:
    """How the true cell differs from the one that the controller believes in.

    Raises:
        ConditionsError: a value out of its range; the message names the option as the command line spells it.
    """

    hand_eye_error_mm: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Shift of the true camera from where the robot believes it, along the camera's x, y and z."""

    def __post_init__(self) -> None:
        _finite("hand_eye_error_mm", self.hand_eye_error_mm)


def _finite(name: str, values: tuple[float, ...]) -> None:
    if not all(map(math.isfinite, values)):
        raise ConditionsError(f"expected --{name.replace('_', '-')} of finite numbers, got {values}")
