import numpy as np
import pytest

from maskval import Camera, Correspondences, InvalidEstimatesError, Pose
from maskval.correspondences import jacobian

CAMERA = Camera(610.0, 595.0, 320.0, 241.0, 640, 480, skew=2.0)
X_CO = Pose.from_rotvec((0.3, -0.5, 1.1), (0.04, -0.02, 0.6))
POINTS_O = np.random.default_rng(0).uniform(-0.1, 0.1, (7, 3))


def test_correspondences_that_were_projected_have_no_error() -> None:
    points = Correspondences(POINTS_O, CAMERA.project(X_CO.apply(POINTS_O)), np.ones(7))
    assert points.errors_px(X_CO, CAMERA) == pytest.approx(0.0, abs=1e-9)
    assert len(points) == 7


def test_a_shift_along_u_moves_a_point_by_focal_length_over_depth() -> None:
    point = Correspondences(np.zeros((1, 3)), [[320.0, 241.0]], [1.0])
    errors = point.errors_px(Pose.from_translation((0.01, 0.0, 0.5)), CAMERA)
    assert errors == pytest.approx(np.array([[610.0 * 0.01 / 0.5, 0.0]]))


def test_points_behind_the_camera_are_infinitely_wrong() -> None:
    points = Correspondences(np.zeros((1, 3)), [[0.0, 0.0]], [1.0])
    assert np.isinf(points.errors_px(Pose.from_translation((0.0, 0.0, -0.5)), CAMERA)).all()


def test_the_jacobian_is_the_limit_of_finite_turns_and_shifts() -> None:
    J = jacobian(X_CO.apply(POINTS_O), X_CO.translation, CAMERA)
    step = 1e-6
    for axis in range(6):
        change = np.zeros(6)
        change[axis] = step

        def moved(sign: float, change: np.ndarray = change) -> np.ndarray:
            turn = Pose.from_rotvec(sign * change[:3])
            pose = Pose(turn.rotation @ X_CO.rotation, X_CO.translation + sign * change[3:])
            return CAMERA.project(pose.apply(POINTS_O))

        assert J[:, :, axis] == pytest.approx((moved(1.0) - moved(-1.0)) / (2 * step), rel=1e-5, abs=1e-4)


@pytest.mark.parametrize(
    ("points_O", "pixels", "sigma_px", "words"),
    [
        (np.zeros((2, 3)), np.zeros((3, 2)), np.ones(2), ["pixels", "(2, 2)", "(3, 2)"]),
        (np.zeros((2, 2)), np.zeros((2, 2)), np.ones(2), ["points_O", "(2, 3)", "(2, 2)"]),
        (np.full((2, 3), np.nan), np.zeros((2, 2)), np.ones(2), ["points_O", "finite"]),
        (np.zeros((2, 3)), np.zeros((2, 2)), (1.0, 0.0), ["sigma_px", "> 0", "0"]),
    ],
)
def test_unfit_correspondences_are_refused(
    points_O: np.ndarray, pixels: np.ndarray, sigma_px: np.ndarray, words: list[str]
) -> None:
    with pytest.raises(InvalidEstimatesError) as error:
        Correspondences(points_O, pixels, sigma_px)
    assert all(word in str(error.value) for word in words)
