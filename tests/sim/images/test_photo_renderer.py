import numpy as np
import pytest

from maskval import Camera, Pose, depth_image, silhouette
from sim.images.generated import clutter_shapes
from sim.images.photo_renderer import Light, Photograph, Surface, SurfacedBody, Wall, photograph
from sim.instance_ids import NO_INSTANCE, PIXEL_CENTER
from sim.model.parts import PartModel

CAMERA = Camera(300.0, 300.0, 130.0, 150.0, 320, 240)  # its axis is not in the middle of the image
GREY = Surface(np.full((48, 8, 3), 128, dtype=np.uint8), 0.0, 0.0)
HALF = np.full(3, 0.5)  # with the light that is everywhere less than 1, where the renderer saturates
FORWARD = Light(np.array((0.0, 0.0, 1.0)), HALF, None, shadow=False)
BOX = clutter_shapes()[0]  # 140 × 90 × 50 mm


def facing(distance: float) -> Wall:
    return Wall(Pose.from_rotvec((np.pi, 0, 0), (0.0, 0.0, distance)), (3.0, 3.0), GREY)


def take(bodies: list[SurfacedBody], walls: list[Wall], lights: list[Light], ambient: float = 0.2) -> Photograph:
    return photograph(bodies, walls, lights, ambient, CAMERA)


def test_a_part_is_where_its_pose_says_in_depth_and_numbers(handle: PartModel) -> None:
    mesh, X_CO = handle.part.mesh, Pose.from_rotvec((0.5, 0.6, 0.7), (0.03, -0.04, 0.5))
    photo = take([SurfacedBody(mesh, X_CO, 3, GREY)], [], [FORWARD])
    mask = silhouette(mesh, X_CO, CAMERA, pixel_center=PIXEL_CENTER).mask
    assert set(np.unique(photo.instance_ids)) == {NO_INSTANCE, 3}
    assert np.count_nonzero(mask) > 1500
    # The rasteriser snaps corners to 1/256 of a sample.
    assert np.count_nonzero((photo.instance_ids == 3) ^ mask) <= 5e-4 * np.count_nonzero(mask) + 1
    both = mask & (photo.instance_ids == 3)
    expected = depth_image(mesh, X_CO, CAMERA, pixel_center=PIXEL_CENTER, implementation="numpy")
    assert photo.depth[both] == pytest.approx(expected[both], abs=5e-5)
    assert (photo.depth[photo.instance_ids == NO_INSTANCE] == 0).all()


def test_the_mean_over_a_pixel_is_the_share_that_a_straight_edge_leaves() -> None:
    # The box's front is 0.1 m wide to each side of x = 0.05 m + k/300 · z: an edge within one column of pixels.
    front = 0.5
    shares = []
    for third in (0, 1, 2):
        x = (160.0 - CAMERA.cx + third / 3) / CAMERA.fx * front - 0.07
        photo = take(
            [SurfacedBody(BOX, Pose.from_translation((x, 0.0, front + 0.025)), NO_INSTANCE, GREY)], [], [FORWARD]
        )
        shares.append(float(photo.coverage[150, 160]))
        assert photo.coverage[150, 159] == 1.0
        assert photo.coverage[150, 162] == 0.0
    assert shares == pytest.approx([0.0, 1 / 3, 2 / 3], abs=1e-6)


def test_a_wall_is_seen_at_its_depth_behind_a_body_and_is_no_part() -> None:
    photo = take([SurfacedBody(BOX, Pose.from_translation((0.0, 0.0, 0.525)), 0, GREY)], [facing(1.5)], [FORWARD])
    assert photo.depth[photo.instance_ids == NO_INSTANCE] == pytest.approx(1.5, abs=3e-4)
    assert photo.depth[photo.instance_ids == 0] == pytest.approx(0.5, abs=5e-5)
    assert (photo.coverage == 1.0).all()


def test_light_falls_from_its_lamp_and_shadows_lie_behind_bodies() -> None:
    def wall_brightness(*lights: Light) -> float:
        return float(take([], [facing(1.0)], list(lights)).rgb.mean())

    aside = Light(np.array((0.8, 0.0, 0.6)), HALF, None, shadow=False)
    dark, oblique, frontal = wall_brightness(), wall_brightness(aside), wall_brightness(FORWARD)
    assert dark == pytest.approx(0.2 * 128, abs=2)
    assert (oblique - dark) / (frontal - dark) == pytest.approx(0.6, abs=0.02)  # Lambert's cosine
    lamp = Light(np.array((0.0, 0.0, 1.0)), HALF, np.array((0.3, 0.0, 0.1)), shadow=True)
    body = SurfacedBody(BOX, Pose.from_translation((0.05, 0.0, 0.5)), NO_INSTANCE, GREY)
    photo = take([body], [facing(1.0)], [lamp])
    # From the lamp the box hides the wall around x = 0.3 − 0.25 · 0.9 / 0.4.
    u = round(CAMERA.cx + CAMERA.fx * (0.3 - 0.25 * 0.9 / 0.4))
    assert float(photo.rgb[150, u].mean()) == pytest.approx(0.2 * 128, abs=2)
    assert float(photo.rgb[150, 250].mean()) > 60


def test_the_same_scene_gives_the_same_picture_bit_for_bit(antenna: PartModel) -> None:
    bodies = [SurfacedBody(antenna.part.mesh, Pose.from_translation((0.0, 0.0, 0.5)), 0, GREY)]
    one, same = (take(bodies, [facing(1.0)], [FORWARD]) for _ in range(2))
    for name in ("rgb", "coverage", "depth", "instance_ids"):
        assert np.array_equal(getattr(one, name), getattr(same, name)), name
