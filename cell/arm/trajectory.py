"""Timed joint trajectories: joint moves, straight lines, and standing still.

Every motion is a path and one jerk-limited parameter along it, from rest to rest, planned by ruckig. A joint move is
straight in joint space, so all joints start and stop together, as in a UR's moveJ; a line is straight for the flange,
as in a UR's moveL. The plan is stretched by less than one time step so that it ends on the grid: the last sample is the
goal, at rest. Stretching in time only lowers speed, acceleration and jerk.
"""

import math
from dataclasses import dataclass

import numpy as np
import ruckig
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from cell.arm.limits import SpeedPreset, check_positive
from cell.arm.ur10 import JOINT_LIMIT, SPEED_LIMITS, checked_joints, forward, inverse_path
from cell.errors import InvalidTrajectoryError
from maskval import Pose

Array = NDArray[np.float64]

# A line's start pose and start joints are two statements of one thing: metres, and entries of the rotation.
START_TOLERANCE = 1e-6
# Joints that agree to this are on the same solution; others are at least a turn or a flip away.
SAME_SOLUTION_RAD = 1e-3
# A way this short, in rad or metres, is none: ruckig's own numbers end near 1e-14.
NO_WAY = 1e-9
# Slower than the fastest joint demands, because the samples of a stretched line fall elsewhere on it.
SLOWDOWN_MARGIN = 1.01
MAX_SLOWDOWNS = 4


@dataclass(frozen=True, slots=True, eq=False)
class JointTrajectory:
    """Joint positions and velocities on an even time grid from t = 0; the arrays are read-only copies.

    Args:
        time_step_s: time between samples, s, > 0.
        positions: joint angles, shape (N, 6), N ≥ 1, rad.
        velocities: joint speeds, shape (N, 6), rad/s.

    Raises:
        InvalidTrajectoryError: wrong shapes, values that are not finite or a time step that is not above zero.
    """

    time_step_s: float
    positions: Array
    velocities: Array

    def __post_init__(self) -> None:
        check_positive("time_step_s", self.time_step_s)
        for name in ("positions", "velocities"):
            array = np.array(getattr(self, name), dtype=np.float64)
            if array.ndim != 2 or array.shape[1] != 6 or len(array) == 0:
                raise InvalidTrajectoryError(f"expected {name} of shape (N, 6) with N >= 1, got {array.shape}")
            if not np.isfinite(array).all():
                row, joint = (int(i) for i in np.argwhere(~np.isfinite(array))[0])
                raise InvalidTrajectoryError(f"expected finite {name}, got {array[row, joint]} at [{row}, {joint}]")
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        if self.positions.shape != self.velocities.shape:
            raise InvalidTrajectoryError(
                f"expected as many velocities as positions, got {len(self.velocities)} and {len(self.positions)}"
            )

    @property
    def duration_s(self) -> float:
        """Time from the first sample to the last, s, ≥ 0."""
        return (len(self.positions) - 1) * self.time_step_s

    @property
    def accelerations(self) -> Array:
        """Joint accelerations, (N, 6) rad/s²: differences of the velocities around each sample."""
        if len(self.velocities) == 1:
            return np.zeros((1, 6))
        accelerations: Array = np.gradient(self.velocities, self.time_step_s, axis=0)
        return accelerations


def joint_move(q_start: ArrayLike, q_goal: ArrayLike, preset: SpeedPreset, time_step_s: float) -> JointTrajectory:
    """Motion from rest to rest, straight in joint space, with all joints in step.

    Args:
        q_start: joint angles, shape (6,), rad, within ±2π; the first sample.
        q_goal: joint angles, likewise; the last sample.
        preset: its joint limits hold throughout.
        time_step_s: time between samples, s, > 0.

    Raises:
        KinematicsInputError: wrong shape or not finite.
        InvalidTrajectoryError: a joint beyond its limit or a time step that is not above zero.
    """
    check_positive("time_step_s", time_step_s)
    start, goal = _joints_in_range(q_start), _joints_in_range(q_goal)
    way = goal - start
    length = float(np.abs(way).max())
    if length < NO_WAY:
        return hold(goal, 0.0, time_step_s)
    share = np.abs(way) / length
    moving = share > 0.0
    limits = [
        float(np.min(np.array(of_joints)[moving] / share[moving]))
        for of_joints in (preset.joint_speed, preset.joint_acceleration, preset.joint_jerk)
    ]
    parameter, rate = _sampled(_planned(length, *limits), time_step_s)
    positions = start + parameter[:, np.newaxis] * way
    positions[-1] = goal
    return JointTrajectory(time_step_s, positions, rate[:, np.newaxis] * way)


def line_move(
    X_BF_start: Pose, X_BF_goal: Pose, q_start: ArrayLike, preset: SpeedPreset, time_step_s: float
) -> JointTrajectory | None:
    """Straight motion of the flange from rest to rest; None when the arm cannot follow all of it.

    The flange turns about one axis in step with its way (slerp). The preset's line limits hold; where a joint would
    exceed the arm's own `SPEED_LIMITS` the whole line is slowed down. Velocities are central differences of the
    positions. None when `inverse_path` is None, `q_start` is of another class of solutions, or the slowed line is still
    too fast.

    Args:
        X_BF_start: the flange's pose at `q_start`.
        X_BF_goal: the flange's pose at the end.
        q_start: joint angles, shape (6,), rad, within ±2π.
        preset: its line limits hold throughout.
        time_step_s: time between samples, s, > 0.

    Raises:
        KinematicsInputError: wrong shape or not finite.
        InvalidTrajectoryError: `q_start` does not put the flange at `X_BF_start`, a joint beyond its limit, or a time
            step that is not above zero.
    """
    check_positive("time_step_s", time_step_s)
    start = _joints_in_range(q_start)
    gap = float(np.abs(forward(start).matrix - X_BF_start.matrix).max())
    if gap > START_TOLERANCE:
        raise InvalidTrajectoryError(
            f"q_start and X_BF_start differ by {gap:.2e} (m or 1), expected < {START_TOLERANCE}"
        )
    slowdown = 1.0
    for _ in range(MAX_SLOWDOWNS):
        X_BF = line_poses(X_BF_start, X_BF_goal, preset, time_step_s, slowdown)
        if len(X_BF) == 1:
            return hold(start, 0.0, time_step_s)
        positions = inverse_path(X_BF, start)
        if positions is None or float(np.abs(positions[0] - start).max()) > SAME_SOLUTION_RAD:
            return None
        excess = float((np.abs(np.diff(positions, axis=0)) / time_step_s / SPEED_LIMITS).max())
        if excess <= 1.0:
            velocities = np.gradient(positions, time_step_s, axis=0)
            velocities[[0, -1]] = 0.0
            return JointTrajectory(time_step_s, positions, velocities)
        slowdown *= excess * SLOWDOWN_MARGIN
    return None


def line_poses(
    X_BF_start: Pose, X_BF_goal: Pose, preset: SpeedPreset, time_step_s: float, slowdown: float = 1.0
) -> Array:
    """Poses X_BF on a line from rest to rest, one per time step, shape (N, 4, 4); a single one for no way.

    Args:
        X_BF_start: the first pose.
        X_BF_goal: the last pose.
        preset: its line limits hold throughout.
        time_step_s: time between samples, s, > 0.
        slowdown: how much slower than the limits allow, ≥ 1.
    """
    way = X_BF_goal.translation - X_BF_start.translation
    rotvec_F = (X_BF_start.inverse() @ X_BF_goal).rotvec
    length = max(
        float(np.linalg.norm(way)),
        float(np.linalg.norm(rotvec_F)) * preset.line_speed / preset.line_rotation_speed,
    )
    if length < NO_WAY:
        return X_BF_start.matrix[np.newaxis]
    plan = _planned(length, preset.line_speed, preset.line_acceleration, preset.line_jerk)
    parameter, _ = _sampled(plan, time_step_s, slowdown)
    return _line_poses(X_BF_start, way, rotvec_F, parameter)


def hold(q: ArrayLike, duration_s: float, time_step_s: float) -> JointTrajectory:
    """Standing still for at least `duration_s`, rounded up to whole time steps; one sample for no time.

    Args:
        q: joint angles, shape (6,), rad, within ±2π.
        duration_s: s, ≥ 0.
        time_step_s: time between samples, s, > 0.

    Raises:
        KinematicsInputError: wrong shape or not finite.
        InvalidTrajectoryError: a joint beyond its limit, a negative duration or a time step that is not above zero.
    """
    check_positive("time_step_s", time_step_s)
    if not (math.isfinite(duration_s) and duration_s >= 0.0):
        raise InvalidTrajectoryError(f"expected a duration of 0 s or more, got {duration_s} s")
    positions = np.tile(_joints_in_range(q), (_steps(duration_s, time_step_s) + 1, 1))
    return JointTrajectory(time_step_s, positions, np.zeros_like(positions))


def _steps(duration_s: float, time_step_s: float) -> int:
    # The margin keeps (0.1 + 0.2) s / 0.1 s = 3.0000000000000004 at three steps.
    return math.ceil(duration_s / time_step_s - 1e-9)


def _planned(length: float, speed: float, acceleration: float, jerk: float) -> ruckig.Trajectory:
    """Fastest jerk-limited motion of one coordinate from rest at 0 to rest at `length`."""
    request = ruckig.InputParameter(1)
    request.current_position, request.target_position = [0.0], [length]
    request.max_velocity, request.max_acceleration, request.max_jerk = [speed], [acceleration], [jerk]
    plan = ruckig.Trajectory(1)
    result = ruckig.Ruckig(1).calculate(request, plan)
    if result != ruckig.Result.Working:
        raise InvalidTrajectoryError(f"no plan for {length} at speed {speed}, acceleration {acceleration}, jerk {jerk}")
    return plan


def _sampled(plan: ruckig.Trajectory, time_step_s: float, slowdown: float = 1.0) -> tuple[Array, Array]:
    """Path parameter from 0 to 1 and its rate, 1/s, on the grid; the plan's time runs slower by at least `slowdown`.

    Reads the plan's seven phases of constant jerk at once: ruckig's own `at_time` costs 2 us a sample.
    """
    profile = plan.profiles[0][0]
    steps = max(_steps(plan.duration * slowdown, time_step_s), 1)
    stretch = steps * time_step_s / plan.duration
    time = np.linspace(0.0, plan.duration, steps + 1)
    begins = np.concatenate([[0.0], np.cumsum(profile.t)])[:7]
    phase = np.searchsorted(begins, time, side="right") - 1
    t = time - begins[phase]
    j, a, v, p = (np.array(values)[phase] for values in (profile.j, profile.a, profile.v, profile.p))
    parameter = (p + t * (v + t * (a / 2 + t * j / 6))) / profile.pf
    rate = (v + t * (a + t * j / 2)) / profile.pf / stretch
    parameter[0], parameter[-1], rate[0], rate[-1] = 0.0, 1.0, 0.0, 0.0
    return parameter, rate


def _line_poses(X_BF_start: Pose, way: Array, rotvec_F: Array, parameter: Array) -> Array:
    """Poses X_BF on the line for path parameters from 0 to 1, shape (N, 4, 4)."""
    X = np.zeros((len(parameter), 4, 4))
    X[:, :3, :3] = X_BF_start.rotation @ Rotation.from_rotvec(parameter[:, np.newaxis] * rotvec_F).as_matrix()
    X[:, :3, 3] = X_BF_start.translation + parameter[:, np.newaxis] * way
    X[:, 3, 3] = 1.0
    return X


def _joints_in_range(q: ArrayLike) -> Array:
    joints = checked_joints(q)
    beyond = np.flatnonzero(np.abs(joints) > JOINT_LIMIT)
    if len(beyond):
        joint = int(beyond[0])
        raise InvalidTrajectoryError(f"expected joint {joint} within ±{JOINT_LIMIT:.3f} rad, got {joints[joint]:.3f}")
    return joints
