"""How fast the arm may move: limits of joint moves and lines, and the named presets of them."""

import math
from dataclasses import dataclass

from cell.arm.ur10 import SPEED_LIMITS
from cell.errors import InvalidTrajectoryError


def check_positive(name: str, value: float) -> None:
    """Raises InvalidTrajectoryError unless the value is finite and above zero."""
    if not (math.isfinite(value) and value > 0.0):
        raise InvalidTrajectoryError(f"expected {name} above zero and finite, got {value}")


@dataclass(frozen=True, slots=True)
class SpeedPreset:
    """How fast the arm moves: limits of joint moves and of lines, all above zero.

    Args:
        joint_speed: per joint, rad/s, at most the arm's own `SPEED_LIMITS`.
        joint_acceleration: per joint, rad/s².
        joint_jerk: per joint, rad/s³.
        line_speed: of the flange along a line, m/s.
        line_acceleration: m/s².
        line_jerk: m/s³.
        line_rotation_speed: of the flange about its axis of rotation, rad/s. A line that turns a lot takes the time
            profile of one as long as line_speed / line_rotation_speed times its angle.

    Raises:
        InvalidTrajectoryError: a limit that is not finite and above zero, not six of them per joint quantity, or a
            joint speed above the arm's.
    """

    joint_speed: tuple[float, ...]
    joint_acceleration: tuple[float, ...]
    joint_jerk: tuple[float, ...]
    line_speed: float
    line_acceleration: float
    line_jerk: float
    line_rotation_speed: float

    def __post_init__(self) -> None:
        for name in ("joint_speed", "joint_acceleration", "joint_jerk"):
            limits = getattr(self, name)
            if len(limits) != 6:
                raise InvalidTrajectoryError(f"expected six values of {name}, got {len(limits)}")
            for joint, limit in enumerate(limits):
                check_positive(f"{name}[{joint}]", limit)
        for name in ("line_speed", "line_acceleration", "line_jerk", "line_rotation_speed"):
            check_positive(name, getattr(self, name))
        for joint, (speed, most) in enumerate(zip(self.joint_speed, SPEED_LIMITS, strict=True)):
            if speed > most:
                raise InvalidTrajectoryError(
                    f"expected joint_speed[{joint}] of at most {most:.3f} rad/s, the UR10's, got {speed:.3f}"
                )


def _preset(speed: tuple[float, ...], acceleration: tuple[float, ...]) -> SpeedPreset:
    # Full acceleration after 0.1 s: a UR's jerk is not published; this is 800°/s³ at its default acceleration.
    jerk = tuple(10.0 * limit for limit in acceleration)
    # Lines: UR's default moveL is 0.25 m/s, 1.2 m/s²; these are what a trial of the cell ran with.
    return SpeedPreset(speed, acceleration, jerk, 0.5, 2.5, 20.0, math.radians(90.0))


def _share_of_speed_limits(share: float) -> tuple[float, ...]:
    return tuple(share * limit for limit in SPEED_LIMITS)


PRESETS = {
    # PolyScope's moveJ default: 60°/s and 80°/s² on the leading joint.
    "ur-default": _preset((math.radians(60.0),) * 6, (math.radians(80.0),) * 6),
    # The accelerations are ours: the big joints carry the arm, the wrists only the gripper.
    "moderate": _preset(_share_of_speed_limits(0.8), (3.0, 3.0, 4.0, 6.0, 6.0, 6.0)),
    "fast": _preset(_share_of_speed_limits(0.95), (6.0, 6.0, 8.0, 12.0, 12.0, 12.0)),
}
