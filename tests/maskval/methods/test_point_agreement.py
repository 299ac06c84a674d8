from dataclasses import replace

import numpy as np
import pytest

from maskval import Camera, Correspondences, Estimates, InvalidEstimatesError, Mesh, Pose, needs_of
from maskval.methods.point_agreement import InlierShare, PnpCovariance, greatest_deviation

CAMERA = Camera(600.0, 600.0, 320.0, 240.0, 640, 480)
X_CO = Pose.from_rotvec((0.2, 0.4, -0.3), (0.02, 0.01, 0.5))
CORNERS = np.array([[x, y, z] for x in (-0.05, 0.05) for y in (-0.03, 0.03) for z in (-0.02, 0.02)])
FACES = np.array(
    [
        [0, 1, 3],
        [0, 3, 2],
        [4, 6, 7],
        [4, 7, 5],
        [0, 4, 5],
        [0, 5, 1],
        [2, 3, 7],
        [2, 7, 6],
        [0, 2, 6],
        [0, 6, 4],
        [1, 5, 7],
        [1, 7, 3],
    ]
)
MESH = Mesh(CORNERS, FACES)


def estimates(*points: Correspondences) -> Estimates:
    count = len(points)
    masks = np.zeros((count, 480, 640), dtype=np.bool_)
    return Estimates(CAMERA, MESH, masks, ((X_CO,) * count,), np.ones(count), correspondences=points)


def seen(error_px: np.ndarray, sigma_px: float = 1.0) -> Correspondences:
    pixels = CAMERA.project(X_CO.apply(CORNERS)) + error_px
    return Correspondences(CORNERS, pixels, np.full(len(CORNERS), sigma_px))


def test_inliers_are_counted_up_to_two_pixels() -> None:
    errors = np.zeros((8, 2))
    errors[:3, 0] = 1.9
    errors[3:5, 1] = 2.1
    assert InlierShare()(estimates(seen(errors))) == pytest.approx([2 / 8])
    assert InlierShare(within_px=1.0)(estimates(seen(errors))) == pytest.approx([5 / 8])


def test_a_pose_without_correspondences_is_as_uncertain_as_can_be() -> None:
    nothing = Correspondences(np.zeros((0, 3)), np.zeros((0, 2)), np.zeros(0))
    for method in (InlierShare(), PnpCovariance()):
        assert method(estimates(nothing)) == pytest.approx([1.0])


def test_the_covariance_is_the_scatter_of_poses_fitted_to_noisy_pixels() -> None:
    sigma_px, rng = 0.3, np.random.default_rng(0)
    points_O = rng.uniform(-0.05, 0.05, (60, 3))
    exact = CAMERA.project(X_CO.apply(points_O))
    found = Correspondences(points_O, exact, np.full(60, sigma_px))
    moved = [
        _fitted(points_O, exact + sigma_px * rng.normal(size=exact.shape)).apply(CORNERS) - X_CO.apply(CORNERS)
        for _ in range(400)
    ]
    scatter = np.sqrt((np.array(moved) ** 2).sum(axis=2).mean(axis=0)).max()
    # 400 samples tell a standard deviation to 3.5 %; the greatest of 8 corners, which differ by more, hardly worse.
    assert greatest_deviation(X_CO, found, CORNERS, CAMERA) == pytest.approx(scatter, rel=0.1)


def _fitted(points_O: np.ndarray, pixels: np.ndarray) -> Pose:
    import cv2  # noqa: PLC0415

    turn, shift = np.array([0.2, 0.4, -0.3]), X_CO.translation.copy()
    _, turn, shift = cv2.solvePnP(points_O, pixels, CAMERA.K, None, turn, shift, useExtrinsicGuess=True)
    return Pose.from_rotvec(turn.ravel(), shift.ravel())


def test_the_covariance_says_one_half_where_the_deviation_is_the_error() -> None:
    points = seen(np.zeros((8, 2)))
    deviation = greatest_deviation(X_CO, points, CORNERS, CAMERA)
    assert PnpCovariance(error_m=deviation)(estimates(points)) == pytest.approx([0.5])
    twice = PnpCovariance(error_m=deviation)(estimates(seen(np.zeros((8, 2)), sigma_px=2.0)))
    assert twice == pytest.approx([2 / 3])


def test_points_on_one_line_of_sight_tell_no_pose() -> None:
    line = np.outer(np.linspace(-0.02, 0.02, 8), X_CO.rotation.T @ X_CO.translation / 0.5)
    points = Correspondences(line, CAMERA.project(X_CO.apply(line)), np.ones(8))
    assert greatest_deviation(X_CO, points, CORNERS, CAMERA) == np.inf


def test_both_ask_for_correspondences_and_say_so_without() -> None:
    for method, name in ((InlierShare(), "inliers"), (PnpCovariance(), "pnp-covariance")):
        assert needs_of(method).correspondences
        with pytest.raises(InvalidEstimatesError, match=f"{name} needs the correspondences"):
            method(replace(estimates(seen(np.zeros((8, 2)))), correspondences=None))


def test_as_many_correspondences_as_masks_are_expected() -> None:
    points = seen(np.zeros((8, 2)))
    with pytest.raises(InvalidEstimatesError, match="each of 1 masks, but are 2"):
        replace(estimates(points), correspondences=(points, points))


@pytest.mark.parametrize("value", [0.0, -1.0, np.inf, "2"])
def test_unfit_settings_are_refused(value: float) -> None:
    with pytest.raises(InvalidEstimatesError, match="within_px"):
        InlierShare(within_px=value)
    with pytest.raises(InvalidEstimatesError, match="error_m"):
        PnpCovariance(error_m=value)
