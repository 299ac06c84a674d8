import math

import numpy as np
import pytest

from maskval import (
    Camera,
    InvalidPoseError,
    Pose,
    SymmetryAxis,
    add,
    add_s,
    mdd,
    mspd,
    mssd,
    rotation_error,
    symmetry_poses,
    translation_error,
)
from tests.maskval import shapes

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


def test_add_s_is_the_mean_distance_to_the_nearest_estimated_point() -> None:
    points = np.array([[0.0, 0, 0], [0.1, 0, 0], [0.4, 0, 0]])
    # Moved by 0.1: the true points 0, 0.1, 0.4 have estimates at 0.1, 0.2, 0.5.
    assert add_s(Pose.from_translation((0.1, 0, 0)), Pose.identity(), points) == pytest.approx((0.1 + 0 + 0.1) / 3)
    # Moved by 0.2, they have estimates at 0.2, 0.3, 0.6.
    assert add_s(Pose.from_translation((0.2, 0, 0)), Pose.identity(), points) == pytest.approx((0.2 + 0.1 + 0.1) / 3)


def test_add_s_by_brute_force() -> None:
    rng = np.random.default_rng(0)
    points = rng.normal(size=(50, 3))
    X_AO_est, X_AO_true = shapes.random_poses(seed=1, count=2)
    estimated, true = X_AO_est.apply(points), X_AO_true.apply(points)
    nearest = np.linalg.norm(true[:, None] - estimated[None], axis=2).min(axis=1)
    assert add_s(X_AO_est, X_AO_true, points) == pytest.approx(nearest.mean(), rel=1e-12)


CAMERA = Camera(600.0, 500.0, 320.0, 240.0, 640, 480)
IDENTITY = (Pose.identity(),)
# A square looks alike after each quarter turn, a disc after every turn.
SQUARE_POINTS = np.array([[0.1, 0, 0], [0, 0.1, 0], [-0.1, 0, 0], [0, -0.1, 0]])
Z_AXIS = SymmetryAxis(np.array([0, 0, 2.0]), np.zeros(3))
QUARTERS = symmetry_poses([Z_AXIS.turn(k * math.pi / 2) for k in (1, 2, 3)])


def test_without_symmetries_mssd_is_mdd() -> None:
    X_AO_est, X_AO_true = shapes.random_poses(seed=2, count=2)
    assert mssd(X_AO_est, X_AO_true, POINTS, IDENTITY) == mdd(X_AO_est, X_AO_true, POINTS)


def test_symmetry_forgives_the_turns_that_nobody_can_see() -> None:
    X_CO_true = Pose.from_rotvec((0.3, 0.2, 0.1), (0, 0, 0.6))
    assert len(QUARTERS) == 4
    for k, over in ((0, 0.0), (1, 0.01), (2, -0.02), (3, 0.1)):
        X_CO_est = X_CO_true @ Z_AXIS.turn(k * math.pi / 2 + over)
        chord = 2 * 0.1 * math.sin(abs(over) / 2)
        assert mssd(X_CO_est, X_CO_true, SQUARE_POINTS, QUARTERS) == pytest.approx(chord, abs=1e-14)
        assert (mspd(X_CO_est, X_CO_true, SQUARE_POINTS, QUARTERS, CAMERA) < 1e-9) == (over == 0)


def test_mspd_of_a_shift_is_focal_length_times_shift_over_depth() -> None:
    sheet = shapes.square().vertices
    X_CO_true = Pose.from_translation((0.1, -0.1, 0.5))
    X_CO_est = Pose.from_translation((0.13, -0.06, 0.5))
    expected = math.hypot(600 * 0.03 / 0.5, 500 * 0.04 / 0.5)
    assert mspd(X_CO_est, X_CO_true, sheet, IDENTITY, CAMERA) == pytest.approx(expected, rel=1e-12)


def test_an_axis_is_sampled_as_finely_as_bop_does() -> None:
    # π / 0.01 steps: the farthest vertex, half a diameter away, moves by π / 315 < 1 % of the diameter.
    assert len(symmetry_poses(axes=[Z_AXIS])) == math.ceil(math.pi / 0.01) == 315
    found = symmetry_poses([Z_AXIS.turn(math.pi)], [Z_AXIS], maximum_step=math.pi / 4)
    assert len(found) == 2 * 4
    np.testing.assert_allclose(found[0].matrix, np.eye(4), rtol=0, atol=0)
    np.testing.assert_allclose(found[5].rotvec, (0, 0, -math.pi / 2), rtol=0, atol=1e-12)


def test_a_turn_about_an_axis_keeps_its_points() -> None:
    axis = SymmetryAxis(np.array([0, 3.0, 0]), np.array([0.5, 0, -0.2]))
    on_axis = np.array([[0.5, 0, -0.2], [0.5, 7.0, -0.2]])
    np.testing.assert_allclose(axis.turn(1.3).apply(on_axis), on_axis, rtol=0, atol=1e-15)
    assert rotation_error(axis.turn(1.3), Pose.identity()) == pytest.approx(1.3, rel=1e-12)


def test_rotation_and_translation_errors() -> None:
    X_AO_true = Pose.from_rotvec((1, 2, 0.5), (1, 1, 1))
    X_AO_est = Pose(X_AO_true.rotation @ Pose.from_rotvec((0, 0.3, 0)).rotation, np.array([1, 1.3, 1.4]))
    assert rotation_error(X_AO_est, X_AO_true) == pytest.approx(0.3, rel=1e-12)
    assert translation_error(X_AO_est, X_AO_true) == pytest.approx(0.5, rel=1e-12)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: mssd(Pose.identity(), Pose.identity(), POINTS, ()), "at least the identity"),
        (lambda: mspd(Pose.identity(), Pose.identity(), POINTS, IDENTITY, CAMERA), "in front of the camera"),
        (lambda: SymmetryAxis(np.zeros(3), np.zeros(3)), "must have a direction"),
        (lambda: SymmetryAxis(np.ones(3), np.ones(2)), "offset_O must be three finite numbers"),
        (
            lambda: symmetry_poses(axes=[Z_AXIS], maximum_step=0.0),
            r"maximum_step must be in \[0.0001, 3.14159\], but is 0.0",
        ),
    ],
)
def test_bad_arguments_are_refused(call, words) -> None:
    with pytest.raises(InvalidPoseError, match=words):
        call()
