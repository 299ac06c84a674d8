import numpy as np
import pytest

from maskval import ContourDistance, Estimates, Pose, chamfer_distance, silhouette
from maskval.methods.outline_agreement import outline
from tests.maskval import shapes
from tests.maskval.shapes import VGA

AHEAD = Pose.from_translation((0, 0, 0.6))


def box(top: int, left: int, height: int, width: int, size: tuple[int, int] = (480, 640)) -> np.ndarray:
    mask = np.zeros(size, dtype=bool)
    mask[top : top + height, left : left + width] = True
    return mask


def disc(radius: float, center: tuple[int, int] = (120, 160), size: tuple[int, int] = (240, 320)) -> np.ndarray:
    v, u = np.indices(size)
    return (v - center[0]) ** 2 + (u - center[1]) ** 2 <= radius**2


def u_of(poses: list[Pose], masks: list[np.ndarray]) -> np.ndarray:
    return ContourDistance()(Estimates(VGA, shapes.square(), np.array(masks), (tuple(poses),), np.ones(len(masks))))


def test_the_outline_of_a_box_is_its_frame() -> None:
    found = {tuple(pixel) for pixel in outline(box(3, 5, 4, 6))}
    expected = {(v, u) for v in range(3, 7) for u in range(5, 11) if v in (3, 6) or u in (5, 10)}
    assert len(expected) == 2 * 6 + 2 * 2
    assert found == expected


def test_the_images_border_is_no_outline() -> None:
    assert {tuple(pixel) for pixel in outline(box(0, 0, 3, 4, (10, 12)))} == {
        *((2, u) for u in range(4)),
        *((v, 3) for v in range(3)),
    }
    assert len(outline(np.ones((10, 12), dtype=bool))) == 0
    assert outline(np.zeros((10, 12), dtype=bool)).shape == (0, 2)


def test_shifted_lines_are_their_shift_apart() -> None:
    # Masks that go through the image from border to border have one edge each, all of it equally far away.
    assert chamfer_distance(box(0, 0, 480, 100), box(0, 0, 480, 117)) == pytest.approx(17)


def test_the_distance_of_shifted_squares_is_that_of_their_frames() -> None:
    # A square of n px, shifted by d to the right, seen from the other one, and by symmetry the other way round.
    n, d = 100, 10
    right_side = n * d  # each of its pixels, with its two corners, is d beyond the other's right side
    sticking_out = 2 * sum(range(1, d))  # top and bottom: 1, 2, ... d - 1 beyond it
    left_side = sum(min(d, v, n - 1 - v) for v in range(n))  # inside the other: its left, top or bottom is nearest
    found = chamfer_distance(box(100, 100, n, n), box(100, 100 + d, n, n))
    assert found == pytest.approx((right_side + sticking_out + left_side) / (4 * n - 4), rel=1e-12)


def test_discs_of_two_radii_are_their_difference_apart() -> None:
    assert chamfer_distance(disc(60), disc(80)) == pytest.approx(20, abs=0.5)


def test_the_distance_is_symmetric_and_does_not_change_with_a_shift_of_both() -> None:
    a, b = disc(30), disc(40, (110, 170))
    distance = chamfer_distance(a, b)
    assert distance is not None
    assert chamfer_distance(b, a) == pytest.approx(distance, rel=1e-12)
    moved = [np.roll(mask, (13, -21), axis=(0, 1)) for mask in (a, b)]
    assert chamfer_distance(*moved) == pytest.approx(distance, rel=1e-12)


def test_u_is_the_distance_in_radii_of_the_mask() -> None:
    # The square of 0.1 m at 0.6 m is 100 px wide: columns 270..369.
    shifted = box(190, 280, 100, 100)
    expected = chamfer_distance(box(190, 270, 100, 100), shifted) / np.sqrt(100 * 100 / np.pi)
    assert u_of([AHEAD], [shifted]) == pytest.approx([expected])
    assert u_of([AHEAD], [silhouette(shapes.square(), AHEAD, VGA).mask]).tolist() == [0.0]


def test_u_does_not_depend_on_how_near_the_object_is() -> None:
    near, far = (Pose.from_translation((0, 0, z)) for z in (0.3, 0.6))
    shifts = [Pose.from_translation((0.01, 0, 0)) @ pose for pose in (near, far)]
    masks = [silhouette(shapes.square(), pose, VGA).mask for pose in (near, far)]
    u = u_of(shifts, masks)
    assert u[0] == pytest.approx(u[1], rel=0.02)
    assert u[0] > 0.05


def test_u_rises_with_the_shift_up_to_1() -> None:
    mask = silhouette(shapes.square(), AHEAD, VGA).mask
    shifts = [Pose.from_translation((0.02 * i, 0, 0)) @ AHEAD for i in range(10)]
    u = u_of(shifts, [mask] * 10)
    assert u[0] == 0.0
    assert u[-1] == 1.0
    assert (np.diff(u) >= 0).all()


@pytest.mark.parametrize("mask", [box(0, 0, 0, 0), box(0, 0, 480, 640)], ids=["empty", "all of the image"])
def test_a_mask_without_outline_agrees_with_nothing(mask: np.ndarray) -> None:
    assert u_of([AHEAD], [mask]).tolist() == [1.0]


def test_a_silhouette_outside_of_the_image_agrees_with_nothing() -> None:
    assert u_of([Pose.from_translation((2, 0, 0.6))], [box(190, 280, 100, 100)]).tolist() == [1.0]
