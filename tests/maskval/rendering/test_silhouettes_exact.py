"""No pixel differs: from triangles in float64, on spoilt meshes, and between Numba and NumPy."""

import numpy as np
import pytest

from maskval import Camera, Mesh, Pose, silhouette, silhouette_iou
from maskval.rendering import kernels
from maskval.rendering.lines import lines, view
from maskval.rendering.views import NEAR_M, frame, stacked
from tests.maskval import shapes
from tests.maskval.rasteriser import rasterise
from tests.maskval.rendering.cases import (
    IMPLEMENTATIONS,
    SMALL,
    both,
    both_shapes,
    crumpled,
    doubled,
    everything,
    flipped,
    opened,
    unwelded,
)
from tests.maskval.shapes import VGA

SHAPES = [shapes.torus, shapes.star, shapes.antenna, shapes.handle]
every_shape = pytest.mark.parametrize("shape", SHAPES, ids=[shape.__name__ for shape in SHAPES])


def differing_pixels(arrays: shapes.Arrays, poses: list[Pose], camera: Camera, pixel_center: float = 0.0) -> list[int]:
    mesh = Mesh(*arrays)
    return [
        np.count_nonzero(
            silhouette(mesh, X_CO, camera, pixel_center=pixel_center).mask
            != rasterise(*arrays, X_CO, camera, pixel_center=pixel_center)
        )
        for X_CO in poses
    ]


@every_shape
@pytest.mark.parametrize("pixel_center", [0.0, 0.5])
def test_no_pixel_differs_from_float64_triangles_in_100_random_poses(shape, pixel_center) -> None:
    poses = shapes.random_poses(seed=1, count=100, reach=0.3)
    seen = [silhouette(Mesh(*shape()), X_CO, VGA, pixel_center=pixel_center).visibility for X_CO in poses]
    assert sum(visibility == 1 for visibility in seen) > 50
    assert sum(0 < visibility < 1 for visibility in seen) > 10
    assert differing_pixels(shape(), poses, VGA, pixel_center) == [0] * 100


@pytest.mark.study
@every_shape
def test_no_pixel_differs_from_float64_triangles_in_2000_random_poses(shape) -> None:
    assert differing_pixels(shape(), shapes.random_poses(seed=2, count=2000), VGA) == [0] * 2000


def test_a_crumpled_mesh_has_rows_that_are_sorted_by_counting() -> None:
    mesh = Mesh(*crumpled(*shapes.torus()))
    seen = frame(VGA, pixel_center=0.0, canvas="full")
    (rotation,), (translation,) = stacked(shapes.random_poses(seed=6, count=1))
    _, rows = lines(mesh.edges, seen, view(mesh.edges, seen, rotation, translation))
    crossings = [np.count_nonzero((rows[:, 0] <= row) & (row < rows[:, 1])) for row in range(VGA.height)]
    assert max(crossings) > 2 * kernels.BUSY_ROW


@pytest.mark.parametrize("spoil", [opened, flipped, unwelded, doubled, crumpled, everything])
@every_shape
def test_no_pixel_differs_on_a_mesh_that_is(spoil, shape) -> None:
    assert differing_pixels(spoil(*shape()), shapes.random_poses(seed=6, count=20), VGA) == [0] * 20


@both
@every_shape
@pytest.mark.parametrize("spoil", [lambda *arrays: arrays, everything], ids=["closed", "spoilt"])
def test_no_pixel_differs_when_the_mesh_crosses_the_near_plane(spoil, shape, implementation) -> None:
    arrays = spoil(*shape())
    poses = shapes.random_poses(seed=7, count=15, depth=(-0.03, 0.03), reach=0.05)
    straddling = 0
    for X_CO in poses:
        depths = X_CO.apply(arrays[0])[:, 2]
        straddling += depths.min() < NEAR_M < depths.max()
        found = silhouette(Mesh(*arrays), X_CO, SMALL, implementation=implementation).mask
        np.testing.assert_array_equal(found, rasterise(*arrays, X_CO, SMALL))
    assert straddling >= 14


@both_shapes
@pytest.mark.parametrize("spoil", [lambda *arrays: arrays, everything], ids=["closed", "spoilt"])
def test_numba_and_numpy_give_the_same_bits(shape, spoil) -> None:
    mesh = Mesh(*spoil(*shape()))
    poses = shapes.random_poses(seed=11, count=25) + shapes.random_poses(12, 15, depth=(-0.1, 0.12), reach=0.1)
    masks = np.array([silhouette(mesh, X_CO, SMALL).mask for X_CO in poses])
    for X_CO, mask in zip(poses, masks, strict=True):
        plain = silhouette(mesh, X_CO, SMALL, implementation="numpy")
        np.testing.assert_array_equal(mask, plain.mask)
        assert silhouette(mesh, X_CO, SMALL).area_px == plain.area_px
    for paired in (False, True):
        fast, plain = (
            silhouette_iou(mesh, poses, masks, SMALL, paired=paired, implementation=implementation)
            for implementation in IMPLEMENTATIONS
        )
        assert fast[0].shape == ((40,) if paired else (40, 40))
        np.testing.assert_array_equal(fast[0], plain[0])
        np.testing.assert_array_equal(fast[1], plain[1])
