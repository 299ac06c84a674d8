import math

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cell.errors import CellError, KinematicsInputError
from cell.ur10 import (
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
