"""The branch of solutions that the arm stays on, pose by pose and along paths."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cell.arm.ur10 import (
    BRANCH,
    BRANCHES,
    JOINT_LIMIT,
    MIN_SIN_ELBOW,
    forward,
    forward_batch,
    inverse,
    inverse_on_branch,
    inverse_path,
)
from maskval import Pose

Array = NDArray[np.float64]

# base_link L of the ROS description has B's origin and half a turn about z.
R_LB = np.diag([-1.0, -1.0, 1.0])
TOOL_DOWN = np.diag([1.0, -1.0, -1.0])
HOME = np.radians([0.0, -90.0, 90.0, -90.0, -90.0, 0.0])
# Where flanges go above the belt, in base_link.
BELT_LOW, BELT_HIGH = (0.55, -0.8, -0.1), (0.95, 0.8, 0.6)


def flange_over_belt(p_LF: Array, yaw: float = 0.0, tilt: float = 0.0, tilt_direction: float = 0.0) -> Pose:
    """X_BF of a flange that points down at a place in base_link, turned about z and then tilted."""
    R_tilt = Rotation.from_rotvec(
        tilt * np.array([math.cos(tilt_direction), math.sin(tilt_direction), 0.0])
    ).as_matrix()
    R_yaw = Rotation.from_rotvec([0.0, 0.0, yaw]).as_matrix()
    return Pose(R_LB @ R_tilt @ R_yaw @ TOOL_DOWN, R_LB @ np.asarray(p_LF))


def random_flanges(rng: np.random.Generator, count: int, tilt: float) -> list[Pose]:
    turns = rng.uniform(-math.pi, math.pi, (count, 2))
    places = rng.uniform(BELT_LOW, BELT_HIGH, (count, 3))
    return [flange_over_belt(p, yaw, tilt, direction) for p, (yaw, direction) in zip(places, turns, strict=True)]


def line_poses(X_BF_start: Pose, X_BF_goal: Pose, count: int) -> Array:
    X_FG = X_BF_start.inverse() @ X_BF_goal
    return np.stack(
        [
            Pose(
                X_BF_start.rotation @ Rotation.from_rotvec(share * X_FG.rotvec).as_matrix(),
                X_BF_start.translation + share * (X_BF_goal.translation - X_BF_start.translation),
            ).matrix
            for share in np.linspace(0.0, 1.0, count)
        ]
    )


def test_branch_solution_faces_the_target_with_the_elbow_up_and_wrist_2_negative() -> None:
    rng = np.random.default_rng(6)
    checked = 0
    for X_BF in random_flanges(rng, 300, math.radians(20.0)):
        q = inverse_on_branch(X_BF, HOME)
        if q is None:
            continue
        checked += 1
        p_LF = R_LB @ X_BF.translation
        assert math.cos(q[0]) * p_LF[0] + math.sin(q[0]) * p_LF[1] > 0.0
        # Shoulder at 0.1273 m; the elbow is a2 from it, wrist 1 a3 further, both in the arm's plane.
        elbow = 0.612 * np.array([math.cos(q[1]), -math.sin(q[1])])
        wrist = elbow + 0.5723 * np.array([math.cos(q[1] + q[2]), -math.sin(q[1] + q[2])])
        assert elbow[1] > 0.0
        assert elbow[1] > wrist[1] * elbow[0] / wrist[0]
        assert math.sin(q[4]) < 0.0
        np.testing.assert_allclose(forward(q).matrix, X_BF.matrix, atol=1e-9, rtol=0)
    assert checked > 290


def test_branch_solution_is_one_of_all_solutions() -> None:
    X_BF = flange_over_belt(np.array([0.75, 0.2, 0.3]), yaw=0.4, tilt=0.3)
    q = inverse_on_branch(X_BF, HOME)
    assert q is not None
    solutions, valid = inverse(X_BF.matrix[np.newaxis])
    row = int(np.flatnonzero((BRANCHES == BRANCH).all(axis=1))[0])
    assert valid[0, row]
    np.testing.assert_allclose(np.exp(1j * q), np.exp(1j * solutions[0, row]), atol=1e-12)


@pytest.mark.parametrize(("tilt_deg", "least_share"), [(0.0, 0.995), (20.0, 0.99), (40.0, 0.985)])
def test_branch_reaches_the_flange_poses_over_the_belt(tilt_deg: float, least_share: float) -> None:
    # Measured on 20,000 poses: 0.9988, 0.9971, 0.9932; the rest lies in the far corners, beyond the arm's length.
    poses = random_flanges(np.random.default_rng(7), 2000, math.radians(tilt_deg))
    found = np.array([inverse_on_branch(X_BF, HOME) is not None for X_BF in poses])
    assert found.mean() >= least_share
    if not found.all():
        assert min(np.linalg.norm(poses[i].translation) for i in np.flatnonzero(~found)) > 1.15


def test_branch_reaches_over_the_container_beside_the_robot() -> None:
    places = [(x, y, z) for x in (-0.15, 0.05, 0.25) for y in (-0.55, -1.05) for z in (0.1, 0.4)]
    assert all(inverse_on_branch(flange_over_belt(np.array(place)), HOME) is not None for place in places)


@pytest.mark.parametrize(
    "X_BF",
    [
        flange_over_belt(np.array([1.5, 0.0, 0.2])),
        flange_over_belt(np.array([0.05, 0.0, 0.5])),
        flange_over_belt(np.array([0.164, 0.0, 0.5])),
        forward(np.array([0.0, -0.5, 0.9 * MIN_SIN_ELBOW, -1.2, -1.5, 0.0])),
        forward(np.array([0.0, -1.5, 1.5, -1.5, -0.05, 0.0])),
        forward(np.array([0.0, 0.2, 0.5, -1.5, -1.5, 0.0])),
    ],
    ids=[
        "too far",
        "in the base",
        "over the base axis",
        "elbow straight",
        "wrist aligned",
        "upper arm below horizontal",
    ],
)
def test_branch_has_no_solution_where_the_pose_is_out_of_bounds(X_BF: Pose) -> None:
    assert inverse_on_branch(X_BF, HOME) is None


@pytest.mark.parametrize("joint", [0, 5])
@pytest.mark.parametrize("turns", [-1, 0, 1])
def test_branch_solution_takes_the_turn_nearest_to_where_the_arm_is(joint: int, turns: int) -> None:
    q = HOME.copy()
    q[0], q[5] = 0.2, -0.3
    q_near = q.copy()
    q_near[joint] += turns * 2 * math.pi
    within_limits = abs(q_near[joint]) <= JOINT_LIMIT
    found = inverse_on_branch(forward(q), q_near)
    assert found is not None
    np.testing.assert_allclose(found, q_near if within_limits else q, atol=1e-9)


def test_paths_over_the_belt_are_continuous_and_follow_the_poses() -> None:
    rng = np.random.default_rng(8)
    followed = 0
    for _ in range(60):
        start, goal = (random_flanges(rng, 1, math.radians(rng.uniform(0.0, 40.0)))[0] for _ in range(2))
        X = line_poses(start, goal, 400)
        path = inverse_path(X, HOME)
        if path is None:
            continue
        followed += 1
        np.testing.assert_allclose(forward_batch(path), X, atol=1e-9, rtol=0)
        # At most 1.75 m and half a turn in 399 steps: 4.4 mm and 7.9 mrad a step, amplified by the arm's leverage.
        assert np.abs(np.diff(path, axis=0)).max() < 0.15
        assert np.abs(path).max() <= JOINT_LIMIT
    assert followed >= 55


def test_path_starts_at_the_joints_it_is_given() -> None:
    start = flange_over_belt(np.array([0.7, 0.1, 0.3]))
    q_start = inverse_on_branch(start, HOME)
    assert q_start is not None
    q_start[5] += 2 * math.pi if q_start[5] < 0 else -2 * math.pi
    path = inverse_path(line_poses(start, flange_over_belt(np.array([0.7, 0.1, 0.1])), 100), q_start)
    assert path is not None
    np.testing.assert_allclose(path[0], q_start, atol=1e-9)


def test_path_keeps_turning_wrist_3_past_half_a_turn_and_ends_at_its_limit() -> None:
    place = np.array([0.7, 0.1, 0.3])
    yaws = np.linspace(0.0, 4 * math.pi, 400)
    X = np.stack([flange_over_belt(place, yaw).matrix for yaw in yaws])
    q_start = inverse_on_branch(flange_over_belt(place), [0.0, 0.0, 0.0, 0.0, 0.0, math.pi])
    assert q_start is not None
    one_turn = inverse_path(X[:200], q_start)
    # From above the flange turns left, along its own z right: wrist 3 goes down by as much as it has turned.
    assert one_turn is not None
    np.testing.assert_allclose(one_turn[:, 5], q_start[5] - yaws[:200], atol=1e-9)
    assert inverse_path(X, q_start) is None


@pytest.mark.parametrize(
    ("places", "count"),
    [([(0.8, 0.0, 0.3), (1.6, 0.0, 0.3)], 200), ([(0.7, -0.3, 0.3), (0.7, 0.7, 0.3)], 2)],
    ids=["leaves the reach", "steps too far between neighbours"],
)
def test_path_is_none_where_it_cannot_be_followed(places: list[tuple[float, ...]], count: int) -> None:
    start, goal = (flange_over_belt(np.array(place)) for place in places)
    assert inverse_path(line_poses(start, goal, count), HOME) is None
