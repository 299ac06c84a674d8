import dataclasses
import math

import pytest

from cell.arm.limits import PRESETS
from cell.arm.ur10 import SPEED_LIMITS
from cell.errors import CellError, InvalidTrajectoryError

UR_DEFAULT = PRESETS["ur-default"]


def test_presets_rise_in_speed_and_stay_below_the_arms_own() -> None:
    assert list(PRESETS) == ["ur-default", "moderate", "fast"]
    assert UR_DEFAULT.joint_speed == pytest.approx([math.radians(60.0)] * 6)
    assert UR_DEFAULT.joint_acceleration == pytest.approx([math.radians(80.0)] * 6)
    assert UR_DEFAULT.joint_jerk == pytest.approx([math.radians(800.0)] * 6)
    assert PRESETS["moderate"].joint_speed == pytest.approx([0.8 * limit for limit in SPEED_LIMITS])
    assert PRESETS["fast"].joint_speed == pytest.approx([0.95 * limit for limit in SPEED_LIMITS])


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: dataclasses.replace(UR_DEFAULT, line_speed=0.0), InvalidTrajectoryError, "line_speed above zero"),
        (lambda: dataclasses.replace(UR_DEFAULT, line_jerk=math.inf), InvalidTrajectoryError, "line_jerk .* got inf"),
        (
            lambda: dataclasses.replace(UR_DEFAULT, joint_jerk=(1.0,) * 5),
            InvalidTrajectoryError,
            "six values of joint_j",
        ),
        (
            lambda: dataclasses.replace(UR_DEFAULT, joint_acceleration=(1.0, 1.0, -1.0, 1.0, 1.0, 1.0)),
            InvalidTrajectoryError,
            r"joint_acceleration\[2\] above zero and finite, got -1.0",
        ),
        (
            lambda: dataclasses.replace(UR_DEFAULT, joint_speed=(1.0, 2.2, 1.0, 1.0, 1.0, 1.0)),
            InvalidTrajectoryError,
            r"joint_speed\[1\] of at most 2.094 rad/s, the UR10's, got 2.200",
        ),
    ],
)
def test_bad_input_is_named(call, error, words) -> None:
    with pytest.raises(error, match=words) as caught:
        call()
    assert isinstance(caught.value, CellError)
    assert isinstance(caught.value, ValueError)
