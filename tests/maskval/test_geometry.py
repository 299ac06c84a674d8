import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from maskval import InvalidPoseError, Pose, angle_between

coordinates = st.floats(-10, 10)
points = st.tuples(coordinates, coordinates, coordinates)
# Angles up to π in any direction, with the ends of the range drawn often.
angles = st.one_of(st.floats(0, math.pi), st.sampled_from([0.0, 1e-12, 1e-7, math.pi - 1e-7, math.pi]))
axes = points.filter(lambda p: math.hypot(*p) > 1e-3).map(lambda p: np.array(p) / math.hypot(*p))
rotvecs = st.tuples(axes, angles).map(lambda drawn: drawn[0] * drawn[1])
poses = st.tuples(rotvecs, points).map(lambda drawn: Pose.from_rotvec(*drawn))


def assert_same(X_AB: Pose, X_AB_expected: Pose) -> None:
    np.testing.assert_allclose(X_AB.matrix, X_AB_expected.matrix, rtol=0, atol=1e-13 * 40)


@given(poses, poses, poses)
def test_composition_is_associative(X_AB, X_BC, X_CD) -> None:
    assert_same((X_AB @ X_BC) @ X_CD, X_AB @ (X_BC @ X_CD))


@given(poses)
def test_a_pose_and_its_inverse_make_the_identity(X_AB) -> None:
    assert_same(X_AB @ X_AB.inverse(), Pose.identity())
    assert_same(X_AB.inverse() @ X_AB, Pose.identity())


@given(poses)
def test_the_identity_is_neutral(X_AB) -> None:
    assert_same(X_AB @ Pose.identity(), X_AB)
    assert_same(Pose.identity() @ X_AB, X_AB)


@given(poses, poses, st.lists(points, min_size=1, max_size=4))
def test_composition_applies_the_right_pose_first(X_AB, X_BC, points_C) -> None:
    np.testing.assert_allclose((X_AB @ X_BC).apply(points_C), X_AB.apply(X_BC.apply(points_C)), rtol=0, atol=1e-12 * 10)


@given(poses, poses)
def test_composition_is_the_product_of_the_matrices(X_AB, X_BC) -> None:
    np.testing.assert_allclose((X_AB @ X_BC).matrix, X_AB.matrix @ X_BC.matrix, rtol=0, atol=1e-12)


@given(poses)
def test_each_form_gives_the_pose_back(X_AB) -> None:
    q = X_AB.quaternion_wxyz
    assert q[0] >= 0
    assert abs(np.linalg.norm(q) - 1) < 1e-15 * 10
    assert_same(Pose.from_quaternion_wxyz(q, X_AB.translation), X_AB)
    assert_same(Pose.from_quaternion_wxyz(-q, X_AB.translation), X_AB)
    assert_same(Pose.from_rotvec(X_AB.rotvec, X_AB.translation), X_AB)
    assert_same(Pose.from_matrix(X_AB.matrix), X_AB)


@given(axes, angles)
def test_rotvec_is_axis_times_angle_up_to_pi(axis, angle) -> None:
    rotvec = Pose.from_rotvec(axis * angle).rotvec
    assert abs(np.linalg.norm(rotvec) - angle) < 1e-14 * 10
    # At π the axis and its opposite are the same rotation.
    distances = [float(np.abs(rotvec - sign * axis * angle).max()) for sign in (1, -1)]
    assert (min(distances) if angle > math.pi - 1e-6 else distances[0]) < 1e-13 * 40


@given(poses, axes, angles)
def test_angle_between_is_the_angle_of_the_rotation_from_one_to_the_other(X_AB, axis, angle) -> None:
    turned = X_AB @ Pose.from_rotvec(axis * angle)
    assert angle_between(X_AB.rotation, turned.rotation) == pytest.approx(angle, abs=1e-14 * 10)


def test_rotvec_and_quaternion_of_a_quarter_turn_about_z() -> None:
    X_AB = Pose.from_rotvec((0, 0, math.pi / 2), (1, 2, 3))
    np.testing.assert_allclose(X_AB.apply((1, 0, 0)), (1, 2 + 1, 3), rtol=0, atol=1e-15 * 10)
    np.testing.assert_allclose(X_AB.quaternion_wxyz, (math.sqrt(0.5), 0, 0, math.sqrt(0.5)), rtol=0, atol=1e-15)


def test_apply_keeps_the_shape_of_the_points() -> None:
    X_AB = Pose.from_translation((1, 0, 0))
    for shape in ((3,), (0, 3), (4, 3), (2, 5, 3)):
        moved = X_AB.apply(np.zeros(shape))
        assert moved.shape == shape
        assert (moved[..., 0] == 1).all()


@settings(max_examples=5)
@given(poses)
def test_nobody_can_write_to_a_pose(X_AB) -> None:
    made = (X_AB, X_AB @ X_AB, X_AB.inverse(), Pose.identity(), Pose.from_matrix(X_AB.matrix))
    for pose in made:
        for array in (pose.rotation, pose.translation):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 1


def test_a_pose_keeps_copies() -> None:
    rotation, translation = np.eye(3), np.zeros(3)
    X_AB = Pose(rotation, translation)
    rotation[0, 0] = translation[0] = 7
    assert_same(X_AB, Pose.identity())


def test_composition_with_something_else_is_a_type_error() -> None:
    with pytest.raises(TypeError):
        Pose.identity() @ np.eye(4)


@given(poses, st.integers(0, 2), st.integers(0, 2))
def test_a_rotation_that_is_mirrored_or_off_by_more_than_1e_6_in_any_number_is_refused(X_AB, row, column) -> None:
    R = X_AB.rotation.copy()
    assert (Pose(R, np.zeros(3)).rotation == R).all()
    R[row] *= -1
    with pytest.raises(InvalidPoseError, match="it mirrors"):
        Pose(R, np.zeros(3))
    R[row] *= -1
    # One number off by d moves R Rᵀ by d times the others of its column, the longest of which is at least 1/√3.
    R[row, column] += 4e-6
    with pytest.raises(InvalidPoseError, match="orthonormal"):
        Pose(R, np.zeros(3))


SHEAR = np.array([[1, 0.01, 0], [0, 1, 0], [0, 0, 1]])
BOTTOM = np.diag([1, 1, 1, 2])


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Pose(SHEAR, np.zeros(3)), "orthonormal to 1e-06, but R Rᵀ differs from I by 0.01"),
        (lambda: Pose(np.diag([1, 1, -1]), np.zeros(3)), r"determinant \+1, but has -1"),
        (lambda: Pose(np.full((3, 3), 1e200), np.zeros(3)), "orthonormal to 1e-06, but R Rᵀ differs from I by inf"),
        (lambda: Pose(np.eye(4), np.zeros(3)), r"rotation must have shape \(3, 3\), but has \(4, 4\)"),
        (lambda: Pose(np.full((3, 3), np.nan), np.zeros(3)), "rotation must be finite"),
        (lambda: Pose(np.eye(3), np.zeros((3, 1))), r"translation must have shape \(3,\), but has \(3, 1\)"),
        (lambda: Pose(np.eye(3), np.array([0, np.inf, 0])), "translation must be finite"),
        (lambda: Pose.from_translation((0, 0)), r"translation must have shape \(3,\), but has \(2,\)"),
        (lambda: Pose.from_matrix(BOTTOM), "last row .* must be 0 0 0 1, but is .*2"),
        (lambda: Pose.from_matrix(np.eye(3)), r"matrix must have shape \(4, 4\)"),
        (lambda: Pose.from_quaternion_wxyz((1, 1, 0, 0)), "norm 1 to 1e-06, but has 1.41421356"),
        (lambda: Pose.from_quaternion_wxyz((1, 0, 0)), r"quaternion_wxyz must have shape \(4,\)"),
        (lambda: Pose.from_rotvec((1, np.nan, 0)), "rotvec must be finite"),
        (lambda: Pose.identity().apply(np.zeros((3, 2))), r"points_B must have shape \(\.\.\., 3\), but has \(3, 2\)"),
    ],
)
def test_bad_poses_are_refused(make, words) -> None:
    with pytest.raises(InvalidPoseError, match=words):
        make()
