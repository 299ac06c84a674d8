import numpy as np
import pytest

from maskval import Camera, InvalidCameraError, InvalidPoseError

CAMERA = Camera(600.0, 500.0, 320.0, 240.0, 640, 480, skew=3.0)


def test_project_is_the_pinhole_equation() -> None:
    # x = 0.1 m right, y = 0.2 m down, z = 0.5 m ahead.
    uv = CAMERA.project((0.1, 0.2, 0.5))
    np.testing.assert_allclose(uv, ((600 * 0.1 + 3 * 0.2) / 0.5 + 320, 500 * 0.2 / 0.5 + 240), rtol=1e-15)


def test_project_is_K_times_the_points() -> None:
    points_C = np.random.default_rng(0).uniform((-1, -1, 0.1), (1, 1, 2), size=(4, 5, 3))
    homogeneous = points_C @ CAMERA.K.T
    np.testing.assert_allclose(CAMERA.project(points_C), homogeneous[..., :2] / homogeneous[..., 2:], rtol=1e-13)


def test_a_camera_is_that_of_its_K() -> None:
    assert Camera.from_K(CAMERA.K, 640, 480) == CAMERA


def test_a_size_of_whole_numbers_is_a_number_of_pixels() -> None:
    camera = Camera(1, 1, 0, 0, 640.0, np.int64(480))
    assert (type(camera.width), type(camera.height)) == (int, int)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Camera(0.0, 1, 0, 0, 4, 4), "fx must be > 0 px, but is 0"),
        (lambda: Camera(1, -600.0, 0, 0, 4, 4), "fy must be > 0 px, but is -600"),
        (lambda: Camera(1, 1, float("nan"), 0, 4, 4), "cx must be a number, but is nan"),
        (lambda: Camera(1, 1, 0, 0, 0, 4), "width must be a whole number of pixels >= 1, but is 0"),
        (lambda: Camera(1, 1, 0, 0, float("inf"), 4), "width must be a whole number of pixels >= 1, but is inf"),
        (lambda: Camera(1, 1, 0, 0, 4, 4.5), "height must be a whole number of pixels >= 1, but is 4.5"),
        (lambda: Camera.from_K(np.eye(4), 4, 4), r"K must have shape \(3, 3\), but has \(4, 4\)"),
        (lambda: Camera.from_K([[1, 0, 0], [0, 1, 0], [0, 0, np.inf]], 4, 4), "K must be finite"),
        (lambda: Camera.from_K([[1, 0, 0], [2, 1, 0], [0, 0, 1]], 4, 4), "upper triangular"),
        (lambda: Camera.from_K([[1, 0, 0], [0, 1, 0], [0, 0, 2]], 4, 4), "last row 0 0 1"),
        (lambda: Camera.from_K([[-1, 0, 0], [0, 1, 0], [0, 0, 1]], 4, 4), "fx must be > 0 px, but is -1"),
    ],
)
def test_bad_cameras_are_refused(make, words) -> None:
    with pytest.raises(InvalidCameraError, match=words):
        make()


@pytest.mark.parametrize(
    ("points_C", "words"),
    [
        ([[0, 0, 1], [0, 0, -0.25]], "in front of the camera, but the least z is -0.25 m"),
        ([[0, 0]], r"points_C must have shape \(\.\.\., 3\), but has \(1, 2\)"),
    ],
)
def test_points_without_an_image_are_refused(points_C, words) -> None:
    with pytest.raises(InvalidPoseError, match=words):
        CAMERA.project(points_C)
