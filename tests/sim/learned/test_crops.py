import math

import cv2
import numpy as np
import pytest

from maskval import Camera, Pose
from sim.learned.crops import CropView, Square, cut
from sim.model.parts import PartModel
from tests.sim.learned.perfect import CAMERA, SKEWED, mask_of

X_CO = Pose.from_rotvec((0.4, -0.7, 0.9), (0.06, -0.05, 0.55))


def bar(length: float, width: float, angle: float, center: tuple[float, float]) -> np.ndarray:
    box = cv2.boxPoints((center, (length, width), math.degrees(angle)))
    mask = np.zeros((480, 640), dtype=np.uint8)
    cv2.fillConvexPoly(mask, np.rint(box).astype(np.int32), 1)
    return mask > 0


@pytest.mark.parametrize("angle", [-1.2, -0.4, 0.0, 0.7, 1.4])
def test_the_square_lies_along_the_mask_and_around_it(angle: float) -> None:
    square = Square.around(bar(160, 40, angle, (300.0, 200.0)))
    assert square.center_px == pytest.approx((300.5, 200.5), abs=0.3)
    assert math.remainder(square.angle - angle, math.pi) == pytest.approx(0.0, abs=0.02)
    # A bar's variance along its length L is L² / 12: four of its roots are 1.155 L.
    assert square.side_px == pytest.approx(1.35 * 4 * math.sqrt(160**2 / 12), rel=0.03)


def test_an_empty_mask_has_a_small_square_in_the_middle() -> None:
    square = Square.around(np.zeros((480, 640), dtype=np.bool_))
    assert square.center_px == (320.0, 240.0)
    assert 0 < square.side_px < 50


@pytest.mark.parametrize("camera", [CAMERA, SKEWED], ids=["square pixels", "skewed"])
def test_the_crops_camera_sees_points_where_the_crop_shows_them(camera: Camera) -> None:
    points_C = X_CO.apply(np.random.default_rng(0).uniform(-0.1, 0.1, (20, 3)))
    square = Square((350.0, 190.0), 0.8, 170.0)
    view, affine = CropView(square, camera, 64), square.affine(64)
    expected = camera.project(points_C) @ affine[:, :2].T + affine[:, 2]
    assert view.camera.project(view.X_VC.apply(points_C)) == pytest.approx(expected, abs=1e-9)
    back = square.inverse_affine(64)
    assert expected @ back[:, :2].T + back[:, 2] == pytest.approx(camera.project(points_C), abs=1e-9)


def test_a_crop_is_the_mean_of_what_it_shows(antenna: PartModel) -> None:
    mask = mask_of(antenna.part.mesh, X_CO, CAMERA)
    square = Square.around(mask)
    crop = cut(mask.astype(np.uint8) * 255, square, 64)
    inside = mask_of(antenna.part.mesh, CropView(square, CAMERA, 64).X_VC @ X_CO, CropView(square, CAMERA, 64).camera)
    assert ((crop > 127) == inside).mean() > 0.99
    # The crop's pixels have an area of (side / 64)² image pixels each.
    assert crop.sum() / 255 * (square.side_px / 64) ** 2 == pytest.approx(mask.sum(), rel=0.01)


def test_what_lies_beyond_the_image_is_black() -> None:
    white = np.full((480, 640, 3), 255, dtype=np.uint8)
    crop = cut(white, Square((0.0, 240.0), 0.0, 128.0), 64)
    assert (crop[:, :31] == 0).all()
    assert (crop[:, 33:] == 255).all()


def test_the_points_of_a_depth_image_project_to_their_pixels() -> None:
    view = CropView(Square((350.0, 190.0), 0.8, 170.0), SKEWED, 16)
    depth = np.linspace(0.4, 0.8, 256, dtype=np.float32).reshape(16, 16)
    v, u = np.indices((16, 16))
    assert view.camera.project(view.points(depth)) == pytest.approx(np.stack((u, v), axis=-1) + 0.5)
