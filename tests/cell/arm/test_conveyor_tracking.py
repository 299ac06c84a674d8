import numpy as np
import pytest

from cell.arm.conveyor_tracking import (
    BELT_SD,
    POSE_SD,
    RAMP_TIME,
    BeltSpeed,
    at_speed,
    carried,
    joining,
    leaving,
    track,
)
from cell.arm.limits import PRESETS
from cell.arm.trajectory import line_poses
from cell.arm.ur10 import SPEED_LIMITS, forward, forward_batch, inverse_on_branch
from maskval import Pose
from tests.fakes import HOME

DT, V_B = 0.002, np.array([0.0, 0.1, 0.0])
DOWN = np.diag([1.0, -1.0, -1.0])
X_HIGH = Pose(DOWN, np.array([-0.68, 0.0, 0.30]))
X_LOW = Pose(DOWN, np.array([-0.68, 0.0, 0.18]))
Q_HIGH = inverse_on_branch(X_HIGH, HOME)


def test_a_line_on_the_belt_is_the_line_at_rest_carried_along() -> None:
    line = line_poses(X_HIGH, X_LOW, PRESETS["ur-default"], DT)
    trajectory = track(line, Q_HIGH, V_B, at_speed, DT)
    assert trajectory is not None
    time = DT * np.arange(1, len(line) + 1)
    reached = forward_batch(trajectory.positions)
    np.testing.assert_allclose(reached[:, :3, 3] - time[:, None] * V_B, line[:, :3, 3], atol=1e-9)
    np.testing.assert_allclose(reached[:, :3, :3], line[:, :3, :3], atol=1e-9)
    assert (np.abs(trajectory.velocities) <= SPEED_LIMITS).all()


def test_joining_and_leaving_cover_half_of_the_belts_way_without_a_jump_in_speed() -> None:
    time = np.linspace(0.0, 2 * RAMP_TIME, 2001)
    step = time[1]
    speed_joining, speed_leaving = (np.gradient(way(time), step) for way in (joining, leaving))
    assert joining(np.array([RAMP_TIME]))[0] == pytest.approx(RAMP_TIME / 2)
    assert leaving(np.array([RAMP_TIME, 5.0])) == pytest.approx([RAMP_TIME / 2] * 2)
    assert (speed_joining[0], speed_joining[-1]) == pytest.approx((0.0, 1.0), abs=1e-3)
    assert (speed_leaving[0], speed_leaving[-1]) == pytest.approx((1.0, 0.0), abs=1e-3)
    # The largest slope of 3 x² − 2 x³ is 1.5: 0.75 m/s² of the lines' 2.5 m/s² at the belt's 0.15 m/s.
    assert 0.15 * np.abs(np.gradient(speed_joining, step)).max() == pytest.approx(0.15 * 1.5 / RAMP_TIME, rel=1e-2)


def test_an_arm_that_stands_still_on_the_belt_leaves_it_where_that_carries_it() -> None:
    standing = np.repeat(X_HIGH.matrix[None], round(RAMP_TIME / DT), axis=0)
    trajectory = track(standing, Q_HIGH, V_B, leaving, DT)
    assert trajectory is not None
    moved = forward(trajectory.positions[-1]).translation - X_HIGH.translation
    assert moved == pytest.approx(V_B * RAMP_TIME / 2, abs=1e-6)
    assert np.abs(trajectory.velocities[-1]).max() < 1e-3


def test_a_ride_out_of_reach_is_none() -> None:
    standing = np.repeat(X_HIGH.matrix[None], 7500, axis=0)  # 15 s, 1.5 m
    assert track(standing, Q_HIGH, V_B, at_speed, DT) is None
    assert track(standing[:500], Q_HIGH, V_B, at_speed, DT) is not None


def test_what_is_carried_moves_with_the_belt_and_turns_not() -> None:
    there = carried(X_LOW, V_B, 2.0)
    assert there.translation - X_LOW.translation == pytest.approx([0.0, 0.2, 0.0])
    assert np.array_equal(there.rotation, X_LOW.rotation)
    assert carried(there, V_B, -2.0).translation == pytest.approx(X_LOW.translation)
    assert carried(X_LOW, np.zeros(3), 2.0) is X_LOW


ALONG = np.array([0.0, 0.6, 0.8])
ASIDE = np.array([1.0, 0.0, 0.0])


def test_one_pair_of_looks_corrects_the_speed_by_the_share_that_the_variances_say() -> None:
    belt = BeltSpeed(0.1)
    assert belt.learn(0.105 * 2.0 * ALONG, ALONG, 2.0)
    prior, measured = (BELT_SD * 0.1) ** 2, 2 * POSE_SD**2 / 2.0**2
    assert belt.speed == pytest.approx(0.1 + 0.005 * prior / (prior + measured))


def test_many_pairs_of_looks_tell_the_speed_whatever_was_believed() -> None:
    belt, rng = BeltSpeed(0.1), np.random.default_rng(0)
    for _ in range(400):
        belt.learn(0.11 * 1.5 * ALONG + rng.normal(0.0, np.sqrt(2) * POSE_SD, 3), ALONG, 1.5)
    # 4 standard deviations of the mean of 400, with the prior worth less than 2 of them.
    assert belt.speed == pytest.approx(0.11, abs=4 * np.sqrt(2) * POSE_SD / 1.5 / 20 + 0.01 * 2 / 400)


@pytest.mark.parametrize("wrong", [0.05 * ALONG, -0.05 * ALONG, 0.05 * ASIDE])
def test_looks_that_do_not_belong_together_teach_nothing(wrong: np.ndarray) -> None:
    belt = BeltSpeed(0.1)
    assert not belt.learn(0.1 * 1.5 * ALONG + wrong, ALONG, 1.5)
    assert belt.speed == 0.1
