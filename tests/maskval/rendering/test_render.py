"""pyrender beside the kernel: an oracle that shares nothing with it, and what it draws for pictures."""

import sys

import numpy as np
import pytest

from maskval import Camera, Mesh, MissingRendererError, Pose, depth_image, silhouette
from maskval.rendering.render import Renderer
from tests.maskval import shapes

CAMERA = Camera(600.0, 620.0, 310.0, 250.0, 640, 480, skew=8.0)
# Vertices are snapped to 1/256 px: 0.009 % was measured.
GREATEST_DISAGREEMENT = 0.02 / 100
SHAPES = [shapes.torus, shapes.star, shapes.antenna, shapes.handle]
every_shape = pytest.mark.parametrize("shape", SHAPES, ids=[shape.__name__ for shape in SHAPES])


@every_shape
@pytest.mark.parametrize("count", [12, pytest.param(300, marks=pytest.mark.study)])
@pytest.mark.parametrize("pixel_center", [0.5, 0.0])
def test_silhouette_and_depth_agree_with_pyrender(shape, pixel_center, count) -> None:
    mesh = Mesh(*shape())
    pixels = wrong = 0
    errors: list[float] = []
    with Renderer(mesh, CAMERA, pixel_center=pixel_center) as renderer:
        for X_CO in shapes.random_poses(seed=41, count=count):
            mask = silhouette(mesh, X_CO, CAMERA, pixel_center=pixel_center).mask
            rendered = renderer.depth(X_CO)
            pixels += np.count_nonzero(mask)
            wrong += np.count_nonzero(mask != (rendered > 0))
            np.testing.assert_array_equal(renderer.silhouette(X_CO), rendered > 0)
            depth = depth_image(mesh, X_CO, CAMERA, pixel_center=pixel_center)
            errors += np.abs(depth - rendered)[mask & (rendered > 0)].tolist()
    assert pixels > 2_000 * count
    assert wrong <= GREATEST_DISAGREEMENT * pixels
    assert np.quantile(errors, 0.999, method="lower") < 2e-4


def test_an_open_and_flipped_mesh_is_drawn_from_both_sides() -> None:
    vertices, faces = shapes.star()
    kept = np.random.default_rng(0).random(len(faces)) > 0.3
    mesh = Mesh(vertices, np.where((np.arange(len(faces)) % 2 == 0)[:, None], faces, faces[:, ::-1])[kept])
    pixels = wrong = 0
    with Renderer(mesh, CAMERA) as renderer:
        for X_CO in shapes.random_poses(seed=42, count=8):
            mask = silhouette(mesh, X_CO, CAMERA, pixel_center=0.5).mask
            pixels += np.count_nonzero(mask)
            wrong += np.count_nonzero(mask != renderer.silhouette(X_CO))
    assert pixels > 10_000
    assert wrong <= GREATEST_DISAGREEMENT * pixels


def test_overlay_changes_the_pixels_of_the_silhouette_only() -> None:
    image = np.random.default_rng(0).integers(0, 256, size=(480, 640, 3), dtype=np.uint8)
    X_CO = Pose.from_rotvec((0.3, 0.4, 0.5), (0.02, 0.03, 0.5))
    with Renderer(shapes.cube(), CAMERA, colour=(1.0, 0.0, 0.0)) as renderer:
        mask = renderer.silhouette(X_CO)
        laid = renderer.overlay(X_CO, image, opacity=1.0)
        half = renderer.overlay(X_CO, image, opacity=0.5)
        np.testing.assert_array_equal(renderer.overlay(X_CO, image, opacity=0.0), image)
    np.testing.assert_array_equal(laid[~mask], image[~mask])
    drawn = laid[mask].astype(int)
    assert (drawn[:, 0] > drawn[:, 1] + 20).all()
    # Three faces of the cube are seen, each in another shade.
    assert len(np.unique(drawn[:, 0])) >= 3
    np.testing.assert_allclose(half[mask], (drawn + image[mask]) / 2, rtol=0, atol=1)


def test_overlay_refuses_another_picture() -> None:
    with Renderer(shapes.cube(), CAMERA) as renderer:
        for image, opacity in ((np.zeros((480, 640, 4), np.uint8), 0.5), (np.zeros((480, 640, 3)), 0.5)):
            with pytest.raises(ValueError, match=r"uint8 of shape \(480, 640, 3\) .* but are"):
                renderer.overlay(Pose.from_translation((0, 0, 0.5)), image, opacity=opacity)
        with pytest.raises(ValueError, match=r"opacity in \[0, 1\], but are .* and 1.5"):
            renderer.overlay(Pose.identity(), np.zeros((480, 640, 3), np.uint8), opacity=1.5)


def test_without_pyrender_the_error_says_what_to_install(monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "pyrender", None)
    with pytest.raises(MissingRendererError, match=r"pip install 'graspcell\[render\]'"):
        Renderer(shapes.cube(), CAMERA)
