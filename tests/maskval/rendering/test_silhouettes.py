"""Silhouettes of scenes whose pixels can be counted by hand."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from maskval import Camera, InvalidMaskError, Mesh, PackedMasks, Pose, silhouette, silhouette_iou
from maskval.rendering.silhouettes import silhouette_areas
from maskval.rendering.views import FULL_MARGIN_PX, NEAR_M
from tests.maskval import shapes
from tests.maskval.rasteriser import rasterise
from tests.maskval.rendering.cases import both, both_shapes
from tests.maskval.shapes import VGA


@both
def test_a_mesh_behind_the_camera_has_no_silhouette_and_visibility_0(implementation) -> None:
    found = silhouette(Mesh(*shapes.torus()), Pose.from_translation((0, 0, -0.5)), VGA, implementation=implementation)
    assert not found.mask.any()
    assert (found.area_px, found.visibility) == (0, 0.0)


def test_a_mesh_that_touches_the_cameras_plane_from_behind_has_no_silhouette() -> None:
    mesh = Mesh(*shapes.star(height=0.04))
    for depth in (-0.02, -0.02 + 0.5 * NEAR_M):
        assert silhouette(mesh, Pose.from_translation((0, 0, depth)), VGA).area_px == 0


@both
def test_a_square_covers_the_pixels_that_its_projection_holds(implementation) -> None:
    # 0.1 m at 0.6 m with f = 600 px: 100 px wide, u from 320 - 50 to 320 + 50, v from 240 - 50 to 240 + 50.
    found = silhouette(shapes.square(0.1), Pose.from_translation((0, 0, 0.6)), VGA, implementation=implementation)
    rows, columns = np.nonzero(found.mask)
    assert (rows.min(), rows.max() + 1) == (190, 290)
    assert (columns.min(), columns.max() + 1) == (270, 370)
    assert found.area_px == np.count_nonzero(found.mask) == 100 * 100


@both
@pytest.mark.parametrize(("pixel_center", "first"), [(0.0, 6), (0.25, 6), (0.5, 5)])
def test_pixel_center_says_where_a_pixel_is_sampled(implementation, pixel_center, first) -> None:
    # u and v from 5.3 to 9.3: the first sampling point inside is 6, 6.25 (5.25 is outside), and 5.5.
    camera = Camera(400.0, 400.0, 7.3, 7.3, 16, 16)
    mask = silhouette(
        shapes.square(0.01),
        Pose.from_translation((0, 0, 1)),
        camera,
        pixel_center=pixel_center,
        implementation=implementation,
    ).mask
    expected = np.zeros((16, 16), dtype=bool)
    expected[first : first + 4, first : first + 4] = True
    np.testing.assert_array_equal(mask, expected)


@both
def test_visibility_is_the_share_of_the_silhouette_inside_the_image(implementation) -> None:
    # 100 px wide, centred on the border u = 0 and then on the corner: a half and a quarter are inside.
    for X_CO, share in (((-0.32, 0, 0.6), 1 / 2), ((-0.32, -0.24, 0.6), 1 / 4), ((-0.38, 0, 0.6), 0.0)):
        found = silhouette(shapes.square(), Pose.from_translation(X_CO), VGA, implementation=implementation)
        assert found.area_px == 100 * 100
        assert found.visibility == share
        iou, visibility = silhouette_iou(
            shapes.square(), [Pose.from_translation(X_CO)], found.mask, VGA, implementation=implementation
        )
        assert visibility.tolist() == [share]
        assert iou.tolist() == [[1.0 if share else 0.0]]


@both
def test_canvas_3x3_ends_the_whole_silhouette_one_image_beyond_the_border(implementation) -> None:
    # A square of 6 m at 0.6 m is 6000 px wide: the full projection, or the 3 x 3 images, around 640 x 480.
    X_CO = Pose.from_translation((0, 0, 0.6))
    full = silhouette(shapes.square(6.0), X_CO, VGA, implementation=implementation)
    bop = silhouette(shapes.square(6.0), X_CO, VGA, canvas="3x3", implementation=implementation)
    assert full.area_px == 6000 * 6000
    assert bop.area_px == 9 * 640 * 480
    assert bop.visibility == 1 / 9
    vast = silhouette(shapes.square(6.0), Pose.from_translation((0, 0, 0.01)), VGA, implementation=implementation)
    assert vast.area_px == (640 + 2 * FULL_MARGIN_PX) * (480 + 2 * FULL_MARGIN_PX)


@both_shapes
def test_the_area_is_that_of_the_silhouette_in_a_larger_image(shape) -> None:
    larger = Camera(VGA.fx, VGA.fy, VGA.cx + 640, VGA.cy + 480, 3 * 640, 3 * 480)
    for X_CO in shapes.random_poses(seed=8, count=20, reach=0.5):
        whole = np.count_nonzero(rasterise(*shape(), X_CO, larger))
        found = silhouette(Mesh(*shape()), X_CO, VGA, canvas="3x3")
        assert found.area_px == whole
        assert found.visibility == np.count_nonzero(found.mask) / whole


@both
@pytest.mark.parametrize("shift", [0, 1, 30, 63, 64, 65, 99, 100, 200])
def test_iou_of_a_shifted_square_is_its_arithmetic(implementation, shift) -> None:
    mask = np.zeros((1, 480, 640), dtype=np.uint8)
    mask[0, 190:290, 270 + shift : 370 + shift] = 1
    iou, visibility = silhouette_iou(
        shapes.square(0.1), [Pose.from_translation((0, 0, 0.6))], mask, VGA, implementation=implementation
    )
    overlap = max(100 - shift, 0) * 100
    assert iou.tolist() == [[overlap / (2 * 100 * 100 - overlap)]]
    assert visibility.tolist() == [1.0]


@both
@pytest.mark.parametrize("width", [5, 63, 64, 65, 130])
def test_iou_counts_the_common_pixels_in_an_image_of_any_width(implementation, width) -> None:
    camera = Camera(60.0, 60.0, width / 2, 20.0, width, 40)
    mesh = Mesh(*shapes.torus())
    poses = shapes.random_poses(seed=9, count=6, depth=(0.15, 0.3), reach=0.1)
    masks = np.random.default_rng(10).random((3, 40, width)) > 0.5
    iou, _ = silhouette_iou(mesh, poses, masks, camera, implementation=implementation)
    drawn = [silhouette(mesh, X_CO, camera).mask for X_CO in poses]
    assert sum(image.any() for image in drawn) >= 4
    expected = [[np.count_nonzero(a & b) / np.count_nonzero(a | b) for b in masks] for a in drawn]
    assert iou.tolist() == expected


@both
def test_paired_is_the_diagonal_and_packed_masks_are_masks(implementation) -> None:
    mesh = Mesh(*shapes.star())
    poses = shapes.random_poses(seed=13, count=5)
    masks = np.array([silhouette(mesh, X_CO, VGA).mask for X_CO in shapes.random_poses(seed=13, count=5, reach=0.29)])
    iou, v = silhouette_iou(mesh, poses, masks, VGA, implementation=implementation)
    paired, v_paired = silhouette_iou(
        mesh, poses, PackedMasks.pack(masks), VGA, paired=True, implementation=implementation
    )
    assert (np.diagonal(iou) > 0.5).sum() >= 4
    np.testing.assert_array_equal(paired, np.diagonal(iou))
    np.testing.assert_array_equal(v_paired, v)


@both
@pytest.mark.parametrize(("poses", "masks"), [(0, 0), (0, 3), (2, 0)])
def test_no_poses_or_no_masks_give_empty_tables(implementation, poses, masks) -> None:
    iou, visibility = silhouette_iou(
        shapes.square(),
        [Pose.from_translation((0, 0, 0.6))] * poses,
        np.zeros((masks, 480, 640), dtype=bool),
        VGA,
        implementation=implementation,
    )
    assert iou.shape == (poses, masks)
    assert visibility.tolist() == [1.0] * poses


@both
def test_iou_of_nothing_with_nothing_is_0(implementation) -> None:
    iou, visibility = silhouette_iou(
        shapes.square(),
        [Pose.from_translation((0, 0, -1))],
        np.zeros((1, 480, 640), dtype=bool),
        VGA,
        implementation=implementation,
    )
    assert (iou.tolist(), visibility.tolist()) == ([[0.0]], [0.0])


SQUARE_AHEAD = [Pose.from_translation((0, 0, 0.6))]


@pytest.mark.parametrize(
    ("options", "masks", "error", "words"),
    [
        ({}, np.zeros((1, 640, 480), dtype=bool), InvalidMaskError, r"480 x 640 \(H x W\).*have 640 x 480"),
        ({}, np.full((1, 480, 640), 255, dtype=np.uint8), InvalidMaskError, "hold 0 and 1, but holds 255"),
        ({}, np.zeros((1, 480, 640)), InvalidMaskError, "bool or uint8, but is float64"),
        ({}, np.zeros(480, dtype=bool), InvalidMaskError, r"shape \(H, W\) or \(K, H, W\), but has \(480,\)"),
        ({"paired": True}, np.zeros((2, 480, 640), dtype=bool), InvalidMaskError, "as many as the 1 poses, but are 2"),
        ({"pixel_center": 1.0}, np.zeros((1, 480, 640), dtype=bool), ValueError, r"in \[0, 1\).*but is 1.0"),
        ({"canvas": "5x5"}, np.zeros((1, 480, 640), dtype=bool), ValueError, "'full' or '3x3', but is '5x5'"),
        ({"implementation": "gl"}, np.zeros((1, 480, 640), dtype=bool), ValueError, "'numba', 'numpy'.*but is 'gl'"),
    ],
)
def test_bad_arguments_are_refused(options, masks, error, words) -> None:
    with pytest.raises(error, match=words):
        silhouette_iou(shapes.square(), SQUARE_AHEAD, masks, VGA, **options)


def test_importing_maskval_does_not_import_numba() -> None:
    code = "import sys, maskval; sys.exit('numba' in sys.modules)"
    root = str(Path(__file__).parents[3])
    assert (
        subprocess.run([sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": root}, check=False).returncode
        == 0
    )


@both
def test_areas_are_those_of_the_silhouettes(implementation) -> None:
    mesh = Mesh(*shapes.torus())
    poses = [*shapes.random_poses(seed=41, count=6, reach=0.4), Pose.from_translation((0, 0, -1))]
    found = silhouette_areas(mesh, poses, VGA, pixel_center=0.5, implementation=implementation)
    each = [silhouette(mesh, X_CO, VGA, pixel_center=0.5) for X_CO in poses]
    assert found.tolist() == [[one.area_px, np.count_nonzero(one.mask)] for one in each]
    assert found[-1].tolist() == [0, 0]
    assert (found[:, 0] > found[:, 1]).any()
    assert silhouette_areas(mesh, [], VGA, implementation=implementation).shape == (0, 2)
