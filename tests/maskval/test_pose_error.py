import math

import numpy as np
import pytest

from maskval import InvalidPoseError, Pose, add, mdd

POINTS = np.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.3, 0]])


def test_a_shift_moves_every_point_by_its_length() -> None:
    X_CO_true = Pose.from_rotvec((0.3, -0.2, 0.9), (0.1, 0.2, 0.7))
    X_CO_est = Pose.from_translation((0.003, 0, 0.004)) @ X_CO_true
    assert mdd(X_CO_est, X_CO_true, POINTS) == pytest.approx(0.005, abs=1e-15)
    assert add(X_CO_est, X_CO_true, POINTS) == pytest.approx(0.005, abs=1e-15)


def test_a_turn_moves_a_point_by_its_chord() -> None:
    # About z by θ, a point at distance r moves by 2 r sin(θ / 2).
    chord = 2 * math.sin(0.2 / 2)
    X_CO_est = Pose.from_rotvec((0, 0, 0.2))
    assert mdd(X_CO_est, Pose.identity(), POINTS) == pytest.approx(0.3 * chord, abs=1e-15)
    assert add(X_CO_est, Pose.identity(), POINTS) == pytest.approx((0 + 0.1 + 0.3) / 3 * chord, abs=1e-15)


@pytest.mark.parametrize("error", [mdd, add])
def test_errors_do_not_depend_on_the_frame_and_have_no_direction(error) -> None:
    X_CO_est = Pose.from_rotvec((0.5, 0.1, 0), (0, 0, 0.5))
    X_CO_true = Pose.from_rotvec((0.4, 0.2, 0), (0, 0.01, 0.5))
    X_WC = Pose.from_rotvec((1, 2, 0.5), (3, 2, 1))
    value = error(X_CO_est, X_CO_true, POINTS)
    assert value > 0.01
    assert error(X_WC @ X_CO_est, X_WC @ X_CO_true, POINTS) == pytest.approx(value, rel=1e-12)
    assert error(X_CO_true, X_CO_est, POINTS) == value
    assert error(X_CO_est, X_CO_est, POINTS) == 0


@pytest.mark.parametrize("error", [mdd, add])
@pytest.mark.parametrize("points_O", [np.empty((0, 3)), np.zeros(3), np.zeros((4, 2))])
def test_a_model_without_points_is_refused(error, points_O) -> None:
    with pytest.raises(InvalidPoseError, match=r"points_O must have shape \(P, 3\) with P >= 1, but has"):
        error(Pose.identity(), Pose.identity(), points_O)
