import numpy as np
import pytest

from maskval import Camera, Mesh, Pose, depth_image, silhouette
from maskval.masks import Implementation
from maskval.rendering.z_buffer import NOTHING, ZBuffer
from tests.maskval import shapes
from tests.maskval.rendering.cases import SMALL, both, everything
from tests.maskval.shapes import VGA


def ahead(z: float, x: float = 0.0) -> Pose:
    return Pose.from_translation((x, 0.0, z))


@both
def test_the_nearer_of_two_bodies_is_seen_whichever_is_drawn_first(implementation: Implementation) -> None:
    # At 0.6 m and at 1.2 m a sheet of 0.1 m is 100 and 50 px wide: the far one shows where it is 0.1 m to the right.
    near, far = (shapes.square(), ahead(0.6), 3), (shapes.square(), ahead(1.2, x=0.1), 5)
    for order in ((near, far), (far, near)):
        image = ZBuffer(VGA, pixel_center=0.5, implementation=implementation)
        for body in order:
            image.draw(*body)
        expected = np.full((480, 640), NOTHING)
        expected[215:265, 345:395] = 5
        expected[190:290, 270:370] = 3
        np.testing.assert_array_equal(image.numbers, expected)
        depth = np.select([expected == 3, expected == 5], [0.6, 1.2])
        np.testing.assert_allclose(image.depth(), depth, rtol=1e-7)


@both
def test_of_equally_near_bodies_the_first_is_seen(implementation: Implementation) -> None:
    image = ZBuffer(VGA, implementation=implementation)
    image.draw(shapes.square(), ahead(0.6), 7)
    image.draw(shapes.square(), ahead(0.6), 8)
    assert np.count_nonzero(image.numbers == 7) == 100 * 100
    assert not (image.numbers == 8).any()


@both
def test_what_hides_has_no_number_and_a_body_around_the_camera_hides_nothing(implementation: Implementation) -> None:
    image = ZBuffer(VGA, implementation=implementation)
    image.draw(shapes.square(), ahead(0.6), 1)
    before = image.numbers.copy()
    around = shapes.cube(0.2)
    image.hide(around.edges, ahead(0.0).rotation, ahead(0.0).translation, is_solid=True)
    np.testing.assert_array_equal(image.numbers, before)
    # At 0.55 m, where its front is, the cube of 0.1 m is 109.09 px wide: columns 265.45 to 374.55 about the middle.
    right = ahead(0.6, x=0.055)
    image.hide(shapes.cube(0.1).edges, right.rotation, right.translation, is_solid=True)
    rows, columns = np.nonzero(image.numbers == 1)
    assert columns.min() == 270
    assert columns.max() == 325  # the cube's front begins 5 mm right of the middle: 320 + 600 · 0.005 / 0.55 = 325.45
    assert len(rows) == 100 * 56


def test_a_body_alone_is_its_silhouette_and_its_depth() -> None:
    mesh = Mesh(*shapes.torus())
    for X_CO in shapes.random_poses(seed=31, count=6, reach=0.4):
        image = ZBuffer(VGA)
        image.draw(mesh, X_CO, 0)
        np.testing.assert_array_equal(image.numbers == 0, silhouette(mesh, X_CO, VGA).mask)
        np.testing.assert_array_equal(image.depth(), depth_image(mesh, X_CO, VGA))


@pytest.mark.parametrize("camera", [SMALL, VGA], ids=["small", "vga"])
def test_numba_and_numpy_draw_the_same_bits(camera: Camera) -> None:
    meshes = (Mesh(*shapes.star()), Mesh(*everything(*shapes.torus())), shapes.cube(0.05))
    far = shapes.random_poses(32, 6, depth=(0.4, 0.8), reach=0.3)
    cut_off = shapes.random_poses(33, 4, depth=(-0.05, 0.1), reach=0.2)
    fast, plain = (ZBuffer(camera, near=0.01, implementation=name) for name in ("numba", "numpy"))
    shown = []
    for number, X_CO in enumerate((*far, *cut_off)):
        mesh = meshes[number % 3]
        for image in (fast, plain):
            if X_CO in far:
                image.draw(mesh, X_CO, number)
            else:
                image.hide(mesh.edges, X_CO.rotation, X_CO.translation, is_solid=mesh.is_solid)
        shown.append(np.count_nonzero(fast.numbers != NOTHING))
        np.testing.assert_array_equal(fast.numbers, plain.numbers)
        np.testing.assert_array_equal(fast.depth(), plain.depth())
    assert min(np.diff(shown[:6])) > 100
    assert shown[-1] < shown[5]


@both
def test_what_is_nearer_than_the_near_plane_is_not_seen(implementation: Implementation) -> None:
    image = ZBuffer(VGA, near=0.5, implementation=implementation)
    image.draw(shapes.square(), ahead(0.4), 0)
    image.draw(shapes.cube(0.3), ahead(0.6), 1)  # its front at 0.45 m is cut off, its back looks away
    assert not (image.numbers == 0).any()
    assert image.depth()[image.numbers == 1].min(initial=1.0) >= 0.5
