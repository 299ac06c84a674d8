import numpy as np
import pytest
from numpy.typing import NDArray

from maskval import Camera, InvalidPoseError, Mesh, Pose, silhouette, silhouette_boxes
from maskval.evaluation.visible_surface import vsd
from maskval.rendering.depth import depth_crop, depth_image
from maskval.rendering.views import NEAR_M
from tests.maskval import shapes
from tests.maskval.rendering.cases import SMALL, both, both_shapes, everything, flipped
from tests.maskval.shapes import VGA


def ray_depth(arrays: shapes.Arrays, X_CO: Pose, camera: Camera, pixels: NDArray[np.int64]) -> NDArray[np.float64]:
    """The least depth at which the ray through each pixel [v, u] meets a triangle (Möller and Trumbore), or inf."""
    rays = np.linalg.solve(camera.K, np.column_stack((pixels[:, ::-1], np.ones(len(pixels)))).T).T
    a, b, c = np.moveaxis(X_CO.apply(arrays[0])[arrays[1]], 1, 0)
    normal = np.cross(b - a, c - a)
    depths = np.full(len(pixels), np.inf)
    for i, ray in enumerate(rays):
        facing = normal @ ray
        with np.errstate(divide="ignore", invalid="ignore"):
            depth = np.einsum("ij,ij->i", normal, a) / facing
            point = depth[:, None] * ray - a
            beta = np.einsum("ij,ij->i", np.cross(point, c - a), normal) / np.einsum("ij,ij->i", normal, normal)
            gamma = np.einsum("ij,ij->i", np.cross(b - a, point), normal) / np.einsum("ij,ij->i", normal, normal)
        hit = (facing != 0) & (depth >= NEAR_M) & (beta >= 0) & (gamma >= 0) & (beta + gamma <= 1)
        depths[i] = depth[hit].min(initial=np.inf)
    return depths


@both
def test_the_depth_of_a_cubes_front_is_its_distance(implementation) -> None:
    # The front of a cube of 0.1 m at 0.6 m is at 0.55 m; f = 550 px makes it 100 px wide: u from 270.3 to 370.3.
    camera = Camera(550.0, 550.0, 320.3, 240.3, 640, 480)
    image = depth_image(shapes.cube(0.1), Pose.from_translation((0, 0, 0.6)), camera, implementation=implementation)
    assert image.dtype == np.float32
    np.testing.assert_allclose(image[191:291, 271:371], 0.55, rtol=1e-7)
    assert np.count_nonzero(image) == 100 * 100


@both
def test_the_depth_of_a_slanted_sheet_is_that_of_its_plane(implementation) -> None:
    X_CO = Pose.from_rotvec((0.4, -0.7, 0.2), (0.01, 0.02, 0.6))
    image = depth_image(shapes.square(0.3), X_CO, VGA, implementation=implementation)
    v, u = np.nonzero(image)
    assert len(v) > 10_000
    rays = np.linalg.solve(VGA.K, np.stack((u, v, np.ones(len(u)))))
    normal = X_CO.rotation[:, 2]
    np.testing.assert_allclose(image[v, u], normal @ X_CO.translation / (normal @ rays), rtol=2e-7)


@both_shapes
@pytest.mark.parametrize("spoil", [lambda *arrays: arrays, flipped], ids=["closed", "flipped"])
def test_the_depth_is_that_of_rays_and_its_pixels_are_the_silhouette(shape, spoil) -> None:
    arrays = spoil(*shape())
    mesh = Mesh(*arrays)
    rng = np.random.default_rng(0)
    for X_CO in shapes.random_poses(seed=20, count=12):
        image = depth_image(mesh, X_CO, VGA)
        np.testing.assert_array_equal(image > 0, silhouette(mesh, X_CO, VGA).mask)
        pixels = rng.permutation(np.argwhere(image > 0))[:100]
        if len(pixels):
            np.testing.assert_allclose(image[tuple(pixels.T)], ray_depth(arrays, X_CO, VGA, pixels), rtol=1e-6)


@both_shapes
@pytest.mark.parametrize("spoil", [lambda *arrays: arrays, everything], ids=["closed", "spoilt"])
def test_depth_before_the_near_plane(shape, spoil) -> None:
    arrays = spoil(*shape())
    mesh = Mesh(*arrays)
    rng = np.random.default_rng(1)
    seen = 0
    for X_CO in shapes.random_poses(seed=21, count=6, depth=(-0.03, 0.03), reach=0.03):
        image = depth_image(mesh, X_CO, SMALL)
        assert image[image > 0].min(initial=1) >= np.float32(NEAR_M)
        pixels = rng.permutation(np.argwhere(image > 0))[:60]
        found, expected = image[tuple(pixels.T)], ray_depth(arrays, X_CO, SMALL, pixels)
        # A ray through the border of the cut may miss the triangle's other side of it.
        assert np.count_nonzero(~np.isclose(found, expected, rtol=1e-5, atol=1e-6)) <= 1
        seen += len(pixels)
    assert seen > 200


@both_shapes
@pytest.mark.parametrize("spoil", [lambda *arrays: arrays, everything], ids=["closed", "spoilt"])
def test_numba_and_numpy_give_the_same_depth_bits(shape, spoil) -> None:
    mesh = Mesh(*spoil(*shape()))
    for X_CO in shapes.random_poses(22, 8) + shapes.random_poses(23, 8, depth=(-0.05, 0.1), reach=0.1):
        fast, plain = (depth_image(mesh, X_CO, SMALL, implementation=name) for name in ("numba", "numpy"))
        np.testing.assert_array_equal(fast, plain)


def test_a_crop_is_its_part_of_the_image() -> None:
    mesh = Mesh(*shapes.torus())
    for X_CO in shapes.random_poses(seed=24, count=10, reach=0.4):
        crop, image = depth_crop(mesh, X_CO, VGA), depth_image(mesh, X_CO, VGA)
        h, w = crop.depth.shape
        np.testing.assert_array_equal(image[crop.top : crop.top + h, crop.left : crop.left + w], crop.depth)
        assert np.count_nonzero(image) == np.count_nonzero(crop.depth)
    assert depth_crop(mesh, Pose.from_translation((0, 0, -1)), VGA).depth.shape == (0, 0)
    assert not depth_image(mesh, Pose.from_translation((5, 0, 1)), VGA).any()


def test_only_a_closed_mesh_with_all_faces_outwards_is_solid() -> None:
    vertices, faces = shapes.torus()
    assert Mesh(vertices, faces).is_solid
    assert shapes.cube().is_solid
    assert Mesh(*shapes.star()).is_solid
    assert not Mesh(vertices, faces[1:]).is_solid
    assert not Mesh(vertices, faces[:, ::-1]).is_solid
    assert not Mesh(*flipped(vertices, faces)).is_solid
    assert not shapes.square().is_solid
    apart = np.concatenate((vertices, vertices + 1))
    assert Mesh(apart, np.concatenate((faces, faces + len(vertices)))).is_solid
    assert not Mesh(apart, np.concatenate((faces, faces[:, ::-1] + len(vertices)))).is_solid


@both
def test_boxes_hold_the_silhouettes(implementation) -> None:
    mesh = Mesh(*shapes.star())
    poses = shapes.random_poses(seed=25, count=15, reach=0.4)
    whole = silhouette_boxes(mesh, poses, VGA, implementation=implementation)
    inside = silhouette_boxes(mesh, poses, VGA, inside_image=True, implementation=implementation)
    larger = Camera(VGA.fx, VGA.fy, VGA.cx + 640, VGA.cy + 480, 3 * 640, 3 * 480)
    border = 0
    for X_CO, box, clipped in zip(poses, whole, inside, strict=True):
        rows, columns = np.nonzero(silhouette(mesh, X_CO, larger).mask)
        left, top = columns.min(), rows.min()
        assert box.tolist() == [left - 640, top - 480, columns.max() + 1 - left, rows.max() + 1 - top]
        mask = silhouette(mesh, X_CO, VGA).mask
        if mask.any():
            rows, columns = np.nonzero(mask)
            left, top = columns.min(), rows.min()
            assert clipped.tolist() == [left, top, columns.max() + 1 - left, rows.max() + 1 - top]
        border += box.tolist() != clipped.tolist()
    assert border >= 3


def test_boxes_of_nothing_are_empty() -> None:
    behind = Pose.from_translation((0, 0, -1))
    assert silhouette_boxes(shapes.square(), [behind], VGA).tolist() == [[0, 0, 0, 0]]
    assert silhouette_boxes(shapes.square(), [], VGA).shape == (0, 4)


AHEAD = Pose.from_translation((0, 0, 0.6))
NOTHING_MEASURED = np.zeros((480, 640))


def test_vsd_of_the_true_pose_is_0_and_of_one_elsewhere_1() -> None:
    sheet = shapes.square()
    measured = depth_image(sheet, AHEAD, VGA)
    for scene in (measured, NOTHING_MEASURED):
        assert vsd(sheet, AHEAD, AHEAD, scene, VGA, taus_m=[0.01, 0.05]).tolist() == [0, 0]
        assert vsd(sheet, Pose.from_translation((0.2, 0, 0.6)), AHEAD, scene, VGA, taus_m=[0.01]).tolist() == [1]


def test_vsd_of_a_shifted_sheet_counts_the_pixels_that_do_not_overlap() -> None:
    # 30 of 100 columns aside: 70 in both, 130 in either; the sheet stays in its plane, so distances agree.
    found = vsd(shapes.square(), Pose.from_translation((0.03, 0, 0.6)), AHEAD, NOTHING_MEASURED, VGA, taus_m=[0.01])
    assert found.tolist() == [1 - 70 / 130]


def test_vsd_of_a_sheet_too_far_depends_on_tau() -> None:
    # At 0.62 m instead of 0.60 the sheet is 96.77 px wide: columns 272..368. Distances differ by 20 mm and a bit.
    behind = Pose.from_translation((0, 0, 0.62))
    found = vsd(shapes.square(), behind, AHEAD, NOTHING_MEASURED, VGA, taus_m=[0.01, 0.0199, 0.03])
    assert found.tolist() == [1, 1, 1 - 97 * 97 / (100 * 100)]


def test_vsd_does_not_count_what_is_hidden() -> None:
    # Something at 0.4 m covers the image's left half: the sheet's right 50 columns are visible in the true pose,
    # and of the estimate, 10 px to the right, the 50 that overlap those or are visible themselves, and 10 more.
    measured = depth_image(shapes.square(), AHEAD, VGA)
    measured[:, :320] = 0.4
    found = vsd(shapes.square(), Pose.from_translation((0.01, 0, 0.6)), AHEAD, measured, VGA, taus_m=[0.01])
    assert found.tolist() == [1 - 50 / 60]
    assert vsd(shapes.square(), AHEAD, AHEAD, np.full((480, 640), 0.4), VGA, taus_m=[0.01]).tolist() == [1]


@pytest.mark.parametrize(
    ("depth", "taus", "words"),
    [
        (np.zeros((640, 480)), [0.1], r"shape \(480, 640\) \(H, W\), but has \(640, 480\)"),
        (np.full((480, 640), np.nan), [0.1], "depth must be finite and >= 0 m"),
        (NOTHING_MEASURED, [0.0], "taus_m must be > 0"),
    ],
)
def test_bad_depths_are_refused(depth, taus, words) -> None:
    with pytest.raises(InvalidPoseError, match=words):
        vsd(shapes.square(), AHEAD, AHEAD, depth, VGA, taus_m=taus)
