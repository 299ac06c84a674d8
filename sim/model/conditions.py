"""What disturbs an experiment: named knobs, none of them set by default. No engine is needed to set them."""

import math
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from cell.layout import Belt
from maskval import Camera, Pose
from maskval.inputs.spelling import is_finite, shown
from sim.errors import ConditionsError

Clutter = Literal["none", "close", "touching", "distractors"]
CLUTTERS = get_args(Clutter)
Three = tuple[float, float, float]

_NONE = (0.0, 0.0, 0.0)
# Least and most of every knob. They are wide: what lies beyond is a slip of the keyboard, or breaks the contact model.
RANGES = {
    "light": (0.0, 4.0),
    "reflections": (0.0, 1.0),
    "hand_eye_error_mm": (-100.0, 100.0),
    "hand_eye_error_deg": (-20.0, 20.0),
    "focal_error_percent": (-20.0, 20.0),
    "principal_point_error_px": (-100.0, 100.0),
    "friction": (0.05, 3.0),
    "mass": (0.1, 10.0),
    "latency_s": (0.0, 10.0),
    "belt_speed": (0.0, 0.15),
    "belt_speed_error_percent": (-20.0, 20.0),
    "takt_s": (5.0, 60.0),
}


@dataclass(frozen=True)
class Conditions:
    """How the true cell differs from the one that the controller believes in.

    Raises:
        ConditionsError: a value out of its range; the message names the option as the command line spells it.
    """

    light: float = 1.0
    """Scale of all lights, 0 to 4. Changes pictures only: the simulated networks read none."""
    reflections: float = 0.0
    """How much the belt mirrors and the parts glare, 0 to 1. Changes pictures only."""
    hand_eye_error_mm: Three = _NONE
    """Shift of the true camera from where the robot believes it, along the camera's x, y and z."""
    hand_eye_error_deg: Three = _NONE
    """Turn of the true camera from how the robot believes it: rotation vector in the camera's x, y and z."""
    focal_error_percent: float = 0.0
    """By how much the true focal length exceeds the one that controller and networks believe in."""
    principal_point_error_px: tuple[float, float] = (0.0, 0.0)
    """Shift of the true principal point from the believed one, in pixels along u and v."""
    friction: float = 1.0
    """Scale of the friction of everything, 0.05 to 3."""
    mass: float = 1.0
    """Scale of the parts' masses, 0.1 to 10."""
    latency_s: float = 0.0
    """Seconds more between a picture and what is known of it, 0 to 10."""
    belt_speed: float = 0.0
    """Speed of the belt in m/s, 0 to 0.15; where it moves, the parts come along it one after the other."""
    belt_speed_error_percent: float = 0.0
    """By how much the true belt's speed exceeds the one that the controller believes in, -20 to 20."""
    takt_s: float = 15.0
    """Mean time between parts that come along a moving belt, s, 5 to 60."""

    clutter: Clutter = "none"
    """none: 55 mm around every part; close: 15 mm; touching: parts lean on one another; distractors: other things."""

    def __post_init__(self) -> None:
        for name in RANGES:
            _check_numbers(name, getattr(self, name), getattr(Conditions, name))
        if self.clutter not in CLUTTERS:
            raise ConditionsError(f"unknown clutter {shown(self.clutter)}: expected one of {', '.join(CLUTTERS)}")
        if self.belt_speed > 0.0 and self.clutter != "none":
            raise ConditionsError(f"expected --clutter none on a moving belt, got {self.clutter}")
        for name, (least, most) in RANGES.items():
            value = getattr(self, name)
            if not all(least <= number <= most for number in np.atleast_1d(value)):
                raise ConditionsError(
                    f"expected --{name.replace('_', '-')} within {least:g} and {most:g}, got {_shown(value)}"
                )

    def X_FC_true(self, X_FC: Pose) -> Pose:
        """Where the camera really is, given where the controller believes it."""
        turn = tuple(map(math.radians, self.hand_eye_error_deg))
        return X_FC @ Pose.from_rotvec(turn, np.array(self.hand_eye_error_mm) / 1000.0)

    def camera_true(self, camera: Camera) -> Camera:
        """The camera that takes the pictures, given the one that the controller believes in."""
        scale, (du, dv) = 1.0 + self.focal_error_percent / 100.0, self.principal_point_error_px
        return replace(camera, fx=camera.fx * scale, fy=camera.fy * scale, cx=camera.cx + du, cy=camera.cy + dv)

    def belt_true(self, belt: Belt) -> Belt:
        """The belt as it runs, given the one that the controller believes in."""
        return replace(belt, speed=belt.speed * (1.0 + self.belt_speed_error_percent / 100.0))


def _check_numbers(name: str, value: object, default: float | tuple[float, ...]) -> None:
    """Raises ConditionsError unless the value is a number, or as many of them as the default has."""
    numbers = value if isinstance(default, tuple) and isinstance(value, tuple) else (value,)
    wanted = len(default) if isinstance(default, tuple) else 1
    if len(numbers) != wanted or not all(isinstance(x, float) or is_finite(x) for x in numbers):
        what = "a number" if wanted == 1 else f"{wanted} numbers"
        raise ConditionsError(f"expected --{name.replace('_', '-')} to be {what}, got {shown(value)}")


UNDISTURBED = Conditions()


def _shown(value: float | tuple[float, ...]) -> str:
    return " ".join(f"{number:g}" for number in np.atleast_1d(value))
