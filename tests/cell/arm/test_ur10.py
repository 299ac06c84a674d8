import math

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from cell.arm.ur10 import (
    BRANCH,
    BRANCHES,
    JOINT_LIMIT,
    forward,
    forward_batch,
    inverse,
    inverse_on_branch,
    inverse_path,
)
from cell.errors import CellError, KinematicsInputError
from maskval import Pose

Array = NDArray[np.float64]

# base_link L of the ROS description has B's origin and half a turn about z.
R_LB = np.diag([-1.0, -1.0, 1.0])
TOOL_DOWN = np.diag([1.0, -1.0, -1.0])
HOME = np.radians([0.0, -90.0, 90.0, -90.0, -90.0, 0.0])
# The ROS description's joints as (position in the parent, degrees about y, axis).
CHAIN = [
    ((0.0, 0.0, 0.1273), 0.0, (0, 0, 1)),
    ((0.0, 0.220941, 0.0), 90.0, (0, 1, 0)),
    ((0.0, -0.1719, 0.612), 0.0, (0, 1, 0)),
    ((0.0, 0.0, 0.5723), 90.0, (0, 1, 0)),
    ((0.0, 0.1149, 0.0), 0.0, (0, 0, 1)),
    ((0.0, 0.0, 0.1157), 0.0, (0, 1, 0)),
]


def mujoco_flange_poses(q: Array) -> Array:
    """X_LF from MuJoCo's kinematics of the ROS description's chain, (N, 4, 4)."""
    spec = mujoco.MjSpec()
    body = spec.worldbody
    for position, about_y_deg, axis in CHAIN:
        half = math.radians(about_y_deg) / 2
        body = body.add_body(pos=position, quat=[math.cos(half), 0.0, math.sin(half), 0.0])
        body.add_joint(axis=axis)
        body.add_geom(size=[0.01, 0.0, 0.0])
    body.add_site(name="tool0", pos=[0.0, 0.0922, 0.0], quat=[math.sqrt(0.5), -math.sqrt(0.5), 0.0, 0.0])
    model = spec.compile()
    data = mujoco.MjData(model)
    X = np.tile(np.eye(4), (len(q), 1, 1))
    for i, joints in enumerate(q):
        data.qpos[:] = joints
        mujoco.mj_kinematics(model, data)
        X[i, :3, :3] = data.site("tool0").xmat.reshape(3, 3)
        X[i, :3, 3] = data.site("tool0").xpos
    return X


def test_forward_agrees_with_mujoco_on_the_ros_chain_turned_by_half_a_turn() -> None:
    q = np.random.default_rng(1).uniform(-JOINT_LIMIT, JOINT_LIMIT, (500, 6))
    X_LB = Pose(R_LB, np.zeros(3)).matrix
    np.testing.assert_allclose(X_LB @ forward_batch(q), mujoco_flange_poses(q), atol=1e-12, rtol=0)


def test_forward_of_zero_joints_is_the_sum_of_the_links() -> None:
    X_BF = forward(np.zeros(6))
    np.testing.assert_allclose(X_BF.translation, [-0.612 - 0.5723, -0.163941 - 0.0922, 0.1273 - 0.1157], atol=1e-15)
    # Flange z along -y of the base, flange x along the arm's -x, which is +x of frame B.
    np.testing.assert_allclose(X_BF.rotation, [[1, 0, 0], [0, 0, -1], [0, 1, 0]], atol=1e-15)


def test_forward_of_one_equals_its_row_of_a_batch() -> None:
    q = np.random.default_rng(2).uniform(-3, 3, (4, 6))
    np.testing.assert_array_equal(forward(q[2]).matrix, forward_batch(q)[2])


def test_inverse_finds_the_joints_it_came_from_and_only_solutions_that_give_the_pose() -> None:
    q = np.random.default_rng(3).uniform(-math.pi, math.pi, (5000, 6))
    X = forward_batch(q)
    solutions, valid = inverse(X)
    assert solutions.shape == (5000, 8, 6)
    assert valid.shape == (5000, 8)

    distance = np.abs(np.angle(np.exp(1j * (solutions - q[:, None])))).max(axis=2)
    assert np.where(valid, distance, np.inf).min(axis=1).max() < 1e-8

    of_pose = np.repeat(np.arange(5000), 8).reshape(5000, 8)[valid]
    assert len(of_pose) > 2 * 5000
    np.testing.assert_allclose(forward_batch(solutions[valid]), X[of_pose], atol=1e-9, rtol=0)
    assert np.abs(solutions[valid]).max() <= math.pi


def test_inverse_has_an_even_number_of_distinct_solutions() -> None:
    q = np.random.default_rng(4).uniform(-math.pi, math.pi, (1000, 6))
    solutions, valid = inverse(forward_batch(q))
    counts = valid.sum(axis=1)
    assert set(counts.tolist()) == {2, 4, 6, 8}
    apart = np.linalg.norm(np.exp(1j * solutions[:, :, None]) - np.exp(1j * solutions[:, None]), axis=3)
    pairs = valid[:, :, None] & valid[:, None] & ~np.eye(8, dtype=bool)
    assert pairs.any(axis=(1, 2)).all()
    assert apart[pairs].min() > 1e-3


def test_inverse_solutions_carry_the_signs_of_their_branch() -> None:
    q = np.random.default_rng(5).uniform(-math.pi, math.pi, (500, 6))
    X = forward_batch(q)
    solutions, valid = inverse(X)
    assert valid.any(axis=0).all()
    wrist = X[:, None, :2, 3] - 0.0922 * X[:, None, :2, 2]
    along = np.cos(solutions[..., 0]) * wrist[..., 0] + np.sin(solutions[..., 0]) * wrist[..., 1]
    signs = np.sign(np.stack([along, np.sin(solutions[..., 2]), np.sin(solutions[..., 4])], axis=-1))
    np.testing.assert_array_equal(signs[valid], np.broadcast_to(BRANCHES, (500, 8, 3))[valid])


@pytest.mark.parametrize(
    "q_deg",
    [(20, -60, 0, 30, -70, 10), (20, -60, 50, 30, 0, 10), (20, -60, 50, 30, 180, 10)],
    ids=["straight elbow", "wrist 2 at zero", "wrist 2 at half a turn"],
)
def test_inverse_solves_singular_poses_too(q_deg: tuple[float, ...]) -> None:
    X = forward_batch(np.radians([q_deg]))
    solutions, valid = inverse(X)
    assert valid.sum() >= 2
    back = forward_batch(solutions[valid])
    np.testing.assert_allclose(back, np.broadcast_to(X, back.shape), atol=1e-9, rtol=0)


def test_inverse_has_no_solution_for_a_matrix_that_is_no_pose() -> None:
    pose = forward_batch(HOME[np.newaxis])[0]
    stretched, mirrored = pose.copy(), pose.copy()
    stretched[:3, 0] *= 1.0 + 1e-6
    mirrored[:3, 0] *= -1.0
    assert inverse(np.stack([pose, stretched, mirrored]))[1].any(axis=1).tolist() == [True, False, False]


def test_inverse_has_no_solution_inside_the_cylinder_around_the_base_axis() -> None:
    # Wrist 3's joint is never nearer to the base axis than the 0.163941 m that it stands off the arm's plane.
    poses = np.stack([Pose(TOOL_DOWN, np.array([-radius, 0.0, 0.5])).matrix for radius in (0.163, 0.165)])
    assert inverse(poses)[1].any(axis=1).tolist() == [False, True]


def test_inverse_ends_where_the_arm_is_straight() -> None:
    # Tool down, arm level: both links and wrist 2 in line, the flange 0.0922 m below and 0.163941 m to the side.
    reach_x = 0.612 + 0.5723 + 0.1157
    poses = np.stack(
        [Pose(TOOL_DOWN, np.array([-reach_x - beyond, -0.163941, 0.1273 - 0.0922])).matrix for beyond in (-1e-6, 1e-6)]
    )
    assert inverse(poses)[1].any(axis=1).tolist() == [True, False]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: forward(np.zeros(5)), r"joint angles of shape \(6,\), got \(5,\)"),
        (lambda: forward(np.zeros((1, 6))), r"shape \(6,\), got \(1, 6\)"),
        (lambda: forward([0, 0, math.nan, 0, 0, 0]), r"finite joint angles, got nan at index \(2,\)"),
        (lambda: forward_batch(np.zeros(6)), r"shape \(N, 6\), got \(6,\)"),
        (lambda: forward_batch(np.full((1, 6), math.inf)), "finite joint angles, got inf"),
        (lambda: inverse(np.eye(4)), r"flange poses of shape \(N, 4, 4\), got \(4, 4\)"),
        (lambda: inverse(np.full((1, 4, 4), math.nan)), "finite flange poses"),
        (lambda: inverse_path(np.zeros((0, 4, 4)), HOME), "at least one flange pose"),
        (lambda: inverse_path(np.eye(4)[None], np.zeros(7)), r"shape \(6,\), got \(7,\)"),
        (lambda: inverse_on_branch(Pose.identity(), [math.nan] * 6), "finite joint angles"),
    ],
)
def test_bad_input_is_named(call, words) -> None:
    with pytest.raises(KinematicsInputError, match=words) as caught:
        call()
    assert isinstance(caught.value, CellError)
    assert isinstance(caught.value, ValueError)


def test_branch_tables_cannot_be_written_to() -> None:
    with pytest.raises(ValueError, match="read-only"):
        BRANCH[0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        BRANCHES[0, 0] = -1.0
