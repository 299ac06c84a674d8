"""VSD compares distances along each pixel's ray: off the axis they are longer than depths."""

import numpy as np
import pytest
from numpy.typing import NDArray

from maskval import Camera, Pose
from maskval.evaluation.visible_surface import vsd
from tests.maskval import shapes

# Wide, oblique and with its axis near a corner: no two of its signs may be exchanged.
CAMERA = Camera(40.0, 50.0, 12.0, 33.0, 60, 45, skew=9.0)
WALL = shapes.square(7.0)  # it fills the image
NEAR, FAR = (Pose.from_translation((0, 0, z)) for z in (0.60, 0.62))


def lengths(pixel_center: float) -> NDArray[np.float64]:
    """The length of each pixel's ray up to depth 1, from the inverse of K, rising."""
    v, u = np.indices((CAMERA.height, CAMERA.width)).reshape(2, -1) + pixel_center
    return np.sort(np.linalg.norm(np.linalg.solve(CAMERA.K, np.stack((u, v, np.ones(len(u))))), axis=0))


@pytest.mark.parametrize("pixel_center", [0.0, 0.5])
def test_two_walls_match_where_the_ray_between_them_is_shorter_than_tau(pixel_center: float) -> None:
    rays = lengths(pixel_center)
    # Between rays of clearly different length: the depth images round to 1e-7.
    matching = np.array([start + np.argmax(np.diff(rays[start - 1 : start + 99])) for start in (100, 700, 1500, 2400)])
    assert (rays[matching] - rays[matching - 1] > 5e-5).all()
    taus_m = 0.02 * (rays[matching - 1] + rays[matching]) / 2
    nothing = np.zeros((CAMERA.height, CAMERA.width))
    found = vsd(WALL, FAR, NEAR, nothing, CAMERA, taus_m=taus_m, pixel_center=pixel_center)
    np.testing.assert_allclose(found, 1 - matching / len(rays), rtol=0, atol=1e-12)


def test_a_wall_is_hidden_where_the_ray_from_what_was_measured_is_longer_than_15_mm() -> None:
    rays, seen = lengths(0.0), 1000
    ahead = 0.015 / ((rays[seen - 1] + rays[seen]) / 2)  # m of depth
    measured = np.full((CAMERA.height, CAMERA.width), 0.6 - ahead)
    # All that is seen of the true wall matches; the estimate lies on what was measured: all of it is seen.
    nearer = Pose.from_translation((0, 0, 0.6 - ahead))
    found = vsd(WALL, nearer, NEAR, measured, CAMERA, taus_m=[1.0])
    np.testing.assert_allclose(found, [1 - seen / len(rays)], rtol=0, atol=1e-12)
