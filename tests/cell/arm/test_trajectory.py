import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from cell.arm.limits import PRESETS, SpeedPreset
from cell.arm.trajectory import JointTrajectory, hold, joint_move, line_move
from cell.arm.ur10 import JOINT_LIMIT, SPEED_LIMITS, forward, forward_batch, inverse, inverse_on_branch
from cell.errors import CellError, InvalidTrajectoryError, KinematicsInputError
from maskval import Pose

Array = NDArray[np.float64]

DT = 0.002
UR_DEFAULT = PRESETS["ur-default"]
HOME = np.radians([0.0, -90.0, 90.0, -90.0, -90.0, 0.0])
TOOL_DOWN = np.diag([1.0, -1.0, -1.0])
X_HIGH = Pose(TOOL_DOWN, np.array([-0.75, -0.2, 0.4]))
X_LOW = Pose(TOOL_DOWN, np.array([-0.75, -0.2, 0.1]))


def joints_at(X_BF: Pose) -> Array:
    q = inverse_on_branch(X_BF, HOME)
    assert q is not None
    return q


def line(X_BF_start: Pose, X_BF_goal: Pose, preset: SpeedPreset = UR_DEFAULT) -> JointTrajectory:
    trajectory = line_move(X_BF_start, X_BF_goal, joints_at(X_BF_start), preset, DT)
    assert trajectory is not None
    return trajectory


def rest_to_rest_s(way: float, speed: float, acceleration: float, jerk: float) -> float:
    """Duration of a motion that reaches full speed and full acceleration."""
    return way / speed + speed / acceleration + acceleration / jerk


def assert_derivatives_within(values: Array, limits: list[Array], roundoff: float) -> None:
    """Difference quotients are means of the derivative, so they obey its limit too."""
    for order, limit in enumerate(limits, start=1):
        quotients = np.diff(values, n=order, axis=0) / DT**order
        assert len(quotients) > 0
        assert (np.abs(quotients).max(axis=0) <= limit * (1 + 1e-6) + roundoff / DT**order).all()


@pytest.mark.parametrize("preset", PRESETS.values(), ids=PRESETS.keys())
def test_joint_moves_obey_speed_acceleration_and_jerk_of_the_preset(preset: SpeedPreset) -> None:
    rng = np.random.default_rng(1)
    for _ in range(30):
        q_start, q_goal = rng.uniform(-3.0, 3.0, (2, 6))
        move = joint_move(q_start, q_goal, preset, DT)
        limits = [np.array(of) for of in (preset.joint_speed, preset.joint_acceleration, preset.joint_jerk)]
        assert (np.abs(move.velocities).max(axis=0) <= limits[0] * (1 + 1e-9)).all()
        assert_derivatives_within(move.positions, limits, roundoff=1e-14)
        assert_derivatives_within(move.velocities, limits[1:], roundoff=1e-14)


def test_joint_move_starts_and_ends_exactly_and_at_rest() -> None:
    rng = np.random.default_rng(2)
    for q_start, q_goal in rng.uniform(-3.0, 3.0, (30, 2, 6)):
        move = joint_move(q_start, q_goal, UR_DEFAULT, DT)
        np.testing.assert_array_equal(move.positions[0], q_start)
        np.testing.assert_array_equal(move.positions[-1], q_goal)
        np.testing.assert_array_equal(move.velocities[[0, -1]], np.zeros((2, 6)))


def test_joint_move_goes_straight_through_joint_space_without_turning_back() -> None:
    q_start, q_goal = np.random.default_rng(3).uniform(-3.0, 3.0, (2, 6))
    move = joint_move(q_start, q_goal, PRESETS["fast"], DT)
    share = (move.positions - q_start) / (q_goal - q_start)
    np.testing.assert_allclose(share, np.repeat(share[:, :1], 6, axis=1), atol=1e-12)
    assert (np.diff(share[:, 0]) > 0.0).all()


def test_joint_velocities_are_the_rate_of_the_positions() -> None:
    q_start, q_goal = np.random.default_rng(4).uniform(-3.0, 3.0, (2, 6))
    move = joint_move(q_start, q_goal, UR_DEFAULT, DT)
    # A central difference is off by at most jerk dt² / 6.
    off = math.radians(800.0) * DT**2 / 6
    np.testing.assert_allclose(np.gradient(move.positions, DT, axis=0)[1:-1], move.velocities[1:-1], atol=1.01 * off)


def test_joint_accelerations_are_the_rate_of_the_velocities() -> None:
    t = DT * np.arange(50)[:, np.newaxis]
    speeds = np.sin(t) * np.arange(1.0, 7.0)
    move = JointTrajectory(DT, np.zeros((50, 6)), speeds)
    # A central difference is off by at most DT² / 6 of the third derivative, one at an end by DT / 2 of the second.
    expected = np.cos(t) * np.arange(1.0, 7.0)
    np.testing.assert_allclose(move.accelerations[1:-1], expected[1:-1], atol=1.01 * 6 * DT**2 / 6)
    np.testing.assert_allclose(move.accelerations, expected, atol=1.01 * 6 * DT / 2)


def test_a_single_sample_has_no_acceleration() -> None:
    assert not hold(HOME, 0.0, DT).accelerations.any()


def test_ur_default_turns_a_quarter_in_the_time_that_its_limits_give() -> None:
    move = joint_move(HOME, HOME + np.radians([90.0, 0, 0, 0, 0, 30.0]), UR_DEFAULT, DT)
    # 1.5 s + 0.75 s + 0.1 s
    assert move.duration_s == pytest.approx(rest_to_rest_s(90.0, 60.0, 80.0, 800.0), abs=1e-12)
    assert np.abs(move.velocities).max(axis=0)[[0, 5]] == pytest.approx([math.radians(60), math.radians(20)])


def test_joint_move_is_led_by_the_joint_that_takes_longest() -> None:
    preset = dataclasses.replace(UR_DEFAULT, joint_speed=(1.0, 1.0, 1.0, 1.0, 1.0, 0.25))
    move = joint_move(np.zeros(6), np.array([2.0, 0, 0, 0, 0, -1.0]), preset, DT)
    # Wrist 3 at 0.25 rad/s lets the base have 0.5 rad/s.
    assert np.abs(move.velocities).max(axis=0) == pytest.approx([0.5, 0, 0, 0, 0, 0.25], rel=1e-2)
    assert move.duration_s >= 1.0 / 0.25


@pytest.mark.parametrize("time_step_s", [0.001, 0.002, 0.008, 0.1])
def test_joint_move_lasts_less_than_one_step_longer_than_planned(time_step_s: float) -> None:
    way_deg = 77.7
    move = joint_move(HOME, HOME + math.radians(way_deg), UR_DEFAULT, time_step_s)
    planned_s = rest_to_rest_s(way_deg, 60.0, 80.0, 800.0)
    assert planned_s - 1e-9 <= move.duration_s < planned_s + time_step_s


@given(exponent=st.floats(-16.0, 0.0), sign=st.sampled_from([-1.0, 1.0]))
def test_joint_moves_of_any_size_end_exactly(exponent: float, sign: float) -> None:
    q_goal = HOME + sign * np.array([1.0, 0.3, 0.0, -1e-9, 1e-3, -1.0]) * 10.0**exponent
    move = joint_move(HOME, q_goal, UR_DEFAULT, DT)
    np.testing.assert_array_equal(move.positions[-1], q_goal)
    np.testing.assert_array_equal(move.velocities[-1], np.zeros(6))
    assert np.abs(np.diff(move.positions, axis=0)).max(initial=0.0) <= math.radians(60.0) * DT


def test_move_to_where_the_arm_is_has_one_sample_and_no_duration() -> None:
    for still in (joint_move(HOME, HOME, UR_DEFAULT, DT), line(X_HIGH, X_HIGH)):
        assert still.positions.shape == (1, 6)
        assert still.duration_s == 0.0
        np.testing.assert_array_equal(still.velocities, np.zeros((1, 6)))


def test_line_is_straight_and_ends_at_its_goal() -> None:
    X_goal = Pose(TOOL_DOWN, np.array([-0.6, 0.3, 0.15]))
    trajectory = line(X_HIGH, X_goal)
    p_BF = forward_batch(trajectory.positions)[:, :3, 3]
    way = X_goal.translation - X_HIGH.translation
    along = (p_BF - X_HIGH.translation) @ way / (way @ way)
    np.testing.assert_allclose(p_BF, X_HIGH.translation + along[:, None] * way, atol=1e-6, rtol=0)
    assert (np.diff(along) > 0.0).all()
    np.testing.assert_allclose(forward(trajectory.positions[0]).matrix, X_HIGH.matrix, atol=1e-9)
    np.testing.assert_allclose(forward(trajectory.positions[-1]).matrix, X_goal.matrix, atol=1e-9)
    np.testing.assert_array_equal(trajectory.velocities[[0, -1]], np.zeros((2, 6)))


def test_line_turns_about_one_axis_in_step_with_its_way() -> None:
    rotvec_F = np.array([0.2, -0.3, 0.9])
    X_goal = Pose(X_HIGH.rotation @ Pose.from_rotvec(rotvec_F, np.zeros(3)).rotation, X_LOW.translation)
    X = forward_batch(line(X_HIGH, X_goal).positions)
    share = (X_HIGH.translation[2] - X[:, 2, 3]) / (X_HIGH.translation[2] - X_LOW.translation[2])
    turned = np.stack([(X_HIGH.inverse() @ Pose.from_matrix(pose)).rotvec for pose in X])
    np.testing.assert_allclose(turned, share[:, None] * rotvec_F, atol=1e-8)


def test_line_obeys_speed_acceleration_and_jerk_of_the_preset() -> None:
    p_BF = forward_batch(line(X_HIGH, X_LOW).positions)[:, :3, 3]
    assert_derivatives_within(p_BF[:, 2:], [np.array([limit]) for limit in (0.5, 2.5, 20.0)], roundoff=1e-13)


def test_line_lasts_as_long_as_its_limits_give() -> None:
    # 0.3 m at 0.5 m/s, 2.5 m/s², 20 m/s³: 0.6 s + 0.2 s + 0.125 s = 0.925 s, and 0.926 s on the grid.
    assert rest_to_rest_s(0.3, 0.5, 2.5, 20.0) == pytest.approx(0.925)
    assert line(X_HIGH, X_LOW).duration_s == pytest.approx(0.926, abs=1e-12)


def test_line_that_only_turns_obeys_the_rotation_speed() -> None:
    angle = math.radians(150.0)
    X_goal = X_HIGH @ Pose.from_rotvec([0.0, 0.0, angle], np.zeros(3))
    trajectory = line(X_HIGH, X_goal)
    # At 90°/s, with the time profile of a line of 0.5 m per 90°.
    expected_s = rest_to_rest_s(0.5 * 150.0 / 90.0, 0.5, 2.5, 20.0)
    assert expected_s <= trajectory.duration_s < expected_s + DT
    assert np.abs(trajectory.velocities[:, 5]).max() == pytest.approx(math.radians(90.0), rel=1e-3)


def test_line_velocities_are_the_rate_of_the_positions() -> None:
    trajectory = line(X_HIGH, Pose(TOOL_DOWN, np.array([-0.7, 0.3, 0.15])))
    # Trapezoids over 2 ms are off by the change of acceleration times dt² / 12.
    travelled = np.cumsum((trajectory.velocities[1:] + trajectory.velocities[:-1]) / 2 * DT, axis=0)
    np.testing.assert_allclose(trajectory.positions[0] + travelled, trajectory.positions[1:], atol=1e-5)


def test_line_is_slowed_down_until_no_joint_exceeds_the_arms_speed() -> None:
    preset = dataclasses.replace(PRESETS["fast"], line_speed=3.0, line_acceleration=30.0, line_jerk=600.0)
    trajectory = line(Pose(TOOL_DOWN, np.array([-0.6, -0.5, 0.3])), Pose(TOOL_DOWN, np.array([-0.6, 0.5, 0.3])), preset)
    used = np.abs(np.diff(trajectory.positions, axis=0)).max(axis=0) / DT / SPEED_LIMITS
    assert 0.97 < used.max() <= 1.0
    assert (np.abs(trajectory.velocities) <= SPEED_LIMITS).all()
    assert trajectory.duration_s > 1.2 * rest_to_rest_s(1.0, 3.0, 30.0, 600.0)


def test_lines_over_the_belt_keep_the_joints_within_the_arms_speed_and_never_jump() -> None:
    rng = np.random.default_rng(5)
    made = 0
    for _ in range(60):
        places = rng.uniform([-0.95, -0.8, -0.1], [-0.55, 0.8, 0.6], (2, 3))
        start, goal = (Pose(TOOL_DOWN, place) for place in places)
        q_start = inverse_on_branch(start, HOME)
        trajectory = None if q_start is None else line_move(start, goal, q_start, PRESETS["fast"], DT)
        if trajectory is None:
            continue
        made += 1
        assert (np.abs(np.diff(trajectory.positions, axis=0)) <= np.array(SPEED_LIMITS) * DT * (1 + 1e-9)).all()
    assert made >= 58


def test_line_is_none_where_it_leaves_the_reach() -> None:
    X_far = Pose(TOOL_DOWN, np.array([-1.6, -0.2, 0.4]))
    assert line_move(X_HIGH, X_far, joints_at(X_HIGH), UR_DEFAULT, DT) is None


def test_line_is_none_from_joints_of_another_class_of_solutions() -> None:
    solutions, valid = inverse(X_HIGH.matrix[np.newaxis])
    own = joints_at(X_HIGH)
    others = [q for q in solutions[valid] if np.abs(np.exp(1j * q) - np.exp(1j * own)).max() > 0.1]
    assert len(others) >= 3
    assert all(line_move(X_HIGH, X_LOW, q, UR_DEFAULT, DT) is None for q in others)


def test_line_refuses_a_start_pose_that_the_start_joints_do_not_have() -> None:
    with pytest.raises(InvalidTrajectoryError, match=r"q_start and X_BF_start differ by 3\.00e-01"):
        line_move(X_LOW, X_HIGH, joints_at(X_HIGH), UR_DEFAULT, DT)


@pytest.mark.parametrize(
    ("duration_s", "time_step_s", "samples"), [(0.0, DT, 1), (0.4, DT, 201), (0.1 + 0.2, 0.1, 4), (0.0031, DT, 3)]
)
def test_hold_stands_still_for_the_time_rounded_up_to_steps(
    duration_s: float, time_step_s: float, samples: int
) -> None:
    still = hold(HOME, duration_s, time_step_s)
    np.testing.assert_array_equal(still.positions, np.tile(HOME, (samples, 1)))
    np.testing.assert_array_equal(still.velocities, np.zeros((samples, 6)))
    assert still.duration_s == (samples - 1) * time_step_s


def test_trajectory_copies_its_arrays_and_lets_nobody_write_to_them() -> None:
    positions = np.zeros((3, 6))
    trajectory = JointTrajectory(DT, positions, np.zeros((3, 6)))
    positions[0, 0] = 1.0
    assert trajectory.positions[0, 0] == 0.0
    for array in (trajectory.positions, trajectory.velocities):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        trajectory.positions = positions  # type: ignore[misc]


BEYOND = HOME + np.array([JOINT_LIMIT + 0.1, 0, 0, 0, 0, 0])


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: JointTrajectory(0.0, np.zeros((1, 6)), np.zeros((1, 6))), InvalidTrajectoryError, "time_step_s above"),
        (lambda: JointTrajectory(math.nan, np.zeros((1, 6)), np.zeros((1, 6))), InvalidTrajectoryError, "got nan"),
        (lambda: JointTrajectory(DT, np.zeros((0, 6)), np.zeros((0, 6))), InvalidTrajectoryError, r"got \(0, 6\)"),
        (lambda: JointTrajectory(DT, np.zeros(6), np.zeros(6)), InvalidTrajectoryError, r"positions .* got \(6,\)"),
        (
            lambda: JointTrajectory(DT, np.zeros((2, 6)), np.zeros((2, 5))),
            InvalidTrajectoryError,
            "velocities of shape",
        ),
        (lambda: JointTrajectory(DT, np.zeros((2, 6)), np.zeros((3, 6))), InvalidTrajectoryError, "got 3 and 2"),
        (lambda: JointTrajectory(DT, np.full((1, 6), math.nan), np.zeros((1, 6))), InvalidTrajectoryError, r"\[0, 0\]"),
        (
            lambda: joint_move(HOME, BEYOND, UR_DEFAULT, DT),
            InvalidTrajectoryError,
            "joint 0 within .6.283 rad, got 6.383",
        ),
        (lambda: joint_move(BEYOND, HOME, UR_DEFAULT, DT), InvalidTrajectoryError, "joint 0 within"),
        (lambda: joint_move(HOME, HOME, UR_DEFAULT, -DT), InvalidTrajectoryError, "time_step_s above zero"),
        (lambda: joint_move(HOME[:5], HOME, UR_DEFAULT, DT), KinematicsInputError, r"shape \(6,\), got \(5,\)"),
        (lambda: joint_move(HOME, HOME * math.nan, UR_DEFAULT, DT), KinematicsInputError, "finite joint angles"),
        (lambda: line_move(X_HIGH, X_LOW, BEYOND, UR_DEFAULT, DT), InvalidTrajectoryError, "joint 0 within"),
        (lambda: line_move(X_HIGH, X_LOW, HOME, UR_DEFAULT, 0.0), InvalidTrajectoryError, "time_step_s above zero"),
        (lambda: hold(HOME, -0.1, DT), InvalidTrajectoryError, "duration of 0 s or more, got -0.1 s"),
        (lambda: hold(HOME, math.inf, DT), InvalidTrajectoryError, "got inf s"),
        (lambda: hold(BEYOND, 1.0, DT), InvalidTrajectoryError, "joint 0 within"),
    ],
)
def test_bad_input_is_named(call, error, words) -> None:
    with pytest.raises(error, match=words) as caught:
        call()
    assert isinstance(caught.value, CellError)
    assert isinstance(caught.value, ValueError)
