from collections.abc import Callable, Iterator
from contextlib import closing
from functools import partial

import cv2
import numpy as np
import pytest

from maskval import Camera, Pose, depth_image, silhouette
from sim.images import photo_renderer
from sim.images.generated import clutter_shapes
from sim.images.photo_renderer import Photograph, PhotoRenderer
from sim.images.photo_scene import Light, Surface, SurfacedBody, Wall
from sim.instance_ids import NO_INSTANCE, PIXEL_CENTER
from sim.model.parts import PartModel

CAMERA = Camera(300.0, 300.0, 130.0, 150.0, 320, 240)  # its axis is not in the middle of the image
GREY = Surface(np.full((48, 8, 3), 128, dtype=np.uint8), 0.0, 0.0)
HALF = np.full(3, 0.5)  # with the light that is everywhere less than 1, where the renderer saturates
FORWARD = Light(np.array((0.0, 0.0, 1.0)), HALF, np.zeros(3), spot=False, shadow=False)
BOX = clutter_shapes()[0]  # 140 × 90 × 50 mm


def facing(distance: float) -> Wall:
    return Wall(Pose.from_rotvec((np.pi, 0, 0), (0.0, 0.0, distance)), (3.0, 3.0), GREY)


Take = Callable[..., Photograph]


@pytest.fixture(scope="module", params=[1, 3])
def renderer(request: pytest.FixtureRequest) -> Iterator[PhotoRenderer]:
    with closing(PhotoRenderer(CAMERA, request.param)) as made:
        yield made


@pytest.fixture(scope="module")
def take(renderer: PhotoRenderer) -> Take:
    """Pictures of one renderer, 1 or 3 samples per pixel and side."""
    return partial(renderer.photograph, ambient=0.2)


def test_a_part_is_where_its_pose_says_in_depth_and_numbers(take: Take, handle: PartModel) -> None:
    mesh, X_CO = handle.part.mesh, Pose.from_rotvec((0.5, 0.6, 0.7), (0.03, -0.04, 0.5))
    photo = take([SurfacedBody(mesh, X_CO, 3, GREY)], [], [FORWARD])
    mask = silhouette(mesh, X_CO, CAMERA, pixel_center=PIXEL_CENTER).mask
    assert set(np.unique(photo.instance_ids)) == {NO_INSTANCE, 3}
    assert np.count_nonzero(mask) > 1500
    assert np.count_nonzero((photo.instance_ids == 3) ^ mask) <= 2e-4 * np.count_nonzero(mask) + 1
    both = mask & (photo.instance_ids == 3)
    expected = depth_image(mesh, X_CO, CAMERA, pixel_center=PIXEL_CENTER, implementation="numpy")
    assert photo.depth[both] == pytest.approx(expected[both], abs=5e-5)
    assert (photo.depth[photo.instance_ids == NO_INSTANCE] == 0).all()


def test_the_mean_over_a_pixel_is_the_share_that_a_straight_edge_leaves() -> None:
    # The box's front is 0.1 m wide to each side of x = 0.05 m + k/300 · z: an edge within one column of pixels.
    front = 0.5
    shares, thirds = [], PhotoRenderer(CAMERA, 3)
    for third in (0, 1, 2):
        x = (160.0 - CAMERA.cx + third / 3) / CAMERA.fx * front - 0.07
        box = SurfacedBody(BOX, Pose.from_translation((x, 0.0, front + 0.025)), NO_INSTANCE, GREY)
        photo = thirds.photograph([box], [], [FORWARD], 0.2)
        shares.append(float(photo.coverage[150, 160]))
        assert photo.coverage[150, 159] == 1.0
        assert photo.coverage[150, 162] == 0.0
    thirds.close()
    assert shares == pytest.approx([0.0, 1 / 3, 2 / 3], abs=1e-6)


def test_a_wall_is_seen_at_its_depth_behind_a_body_and_is_no_part(take: Take) -> None:
    photo = take([SurfacedBody(BOX, Pose.from_translation((0.0, 0.0, 0.525)), 0, GREY)], [facing(1.5)], [FORWARD])
    assert photo.depth[photo.instance_ids == NO_INSTANCE] == pytest.approx(1.5, abs=3e-4)
    assert photo.depth[photo.instance_ids == 0] == pytest.approx(0.5, abs=5e-5)
    assert (photo.coverage == 1.0).all()


def test_light_falls_from_its_lamp_and_shadows_lie_behind_bodies(take: Take) -> None:
    def wall_brightness(*lights: Light) -> float:
        return float(take([], [facing(1.0)], list(lights)).rgb.mean())

    aside = Light(np.array((0.8, 0.0, 0.6)), HALF, np.zeros(3), spot=False, shadow=False)
    dark, oblique, frontal = wall_brightness(), wall_brightness(aside), wall_brightness(FORWARD)
    assert dark == pytest.approx(0.2 * 128, abs=2)
    assert (oblique - dark) / (frontal - dark) == pytest.approx(0.6, abs=0.02)  # Lambert's cosine
    lamp = Light(np.array((0.0, 0.0, 1.0)), HALF, np.array((0.3, 0.0, 0.1)), spot=True, shadow=True)
    body = SurfacedBody(BOX, Pose.from_translation((0.05, 0.0, 0.5)), NO_INSTANCE, GREY)
    photo = take([body], [facing(1.0)], [lamp])
    # From the lamp the box hides the wall around x = 0.3 − 0.25 · 0.9 / 0.4.
    u = round(CAMERA.cx + CAMERA.fx * (0.3 - 0.25 * 0.9 / 0.4))
    assert float(photo.rgb[150, u].mean()) == pytest.approx(0.2 * 128, abs=2)
    assert float(photo.rgb[150, 250].mean()) > 60


def test_the_same_scene_gives_the_same_picture_bit_for_bit(take: Take, antenna: PartModel) -> None:
    bodies = [SurfacedBody(antenna.part.mesh, Pose.from_translation((0.0, 0.0, 0.5)), 0, GREY)]
    one, same = (take(bodies, [facing(1.0)], [FORWARD]) for _ in range(2))
    for name in ("rgb", "coverage", "depth", "instance_ids"):
        assert np.array_equal(getattr(one, name), getattr(same, name)), name


def test_colours_lie_where_the_numbers_say(take: Take, handle: PartModel) -> None:
    """RGB is OpenGL's, numbers are maskval's: of a bright part before black, the same pixels are bright."""
    mesh, X_CO = handle.part.mesh, Pose.from_rotvec((0.5, 0.6, 0.7), (0.03, -0.04, 0.5))
    black = Surface(np.zeros((8, 8, 3), dtype=np.uint8), 0.0, 0.0)
    wall = Wall(Pose.from_rotvec((np.pi, 0, 0), (0.0, 0.0, 1.0)), (3.0, 3.0), black)
    photo = take([SurfacedBody(mesh, X_CO, 0, GREY)], [wall], [FORWARD])
    assert np.count_nonzero(photo.instance_ids == 0) > 1500
    inner = cv2.erode((photo.instance_ids == 0).astype(np.uint8), np.ones((3, 3))) > 0
    outer = cv2.dilate((photo.instance_ids == 0).astype(np.uint8), np.ones((3, 3))) == 0
    assert photo.rgb[inner].min() > 15
    assert photo.rgb[outer].max() == 0
    bright = photo.rgb[..., 0] > photo.rgb[inner].mean() / 2
    assert np.count_nonzero(bright ^ (photo.instance_ids == 0)) < 0.05 * np.count_nonzero(inner)


def test_a_renderer_shows_nothing_of_the_pictures_before(
    renderer: PhotoRenderer, take: Take, antenna: PartModel
) -> None:
    rng = np.random.default_rng(0)

    def scene(bodies: int, walls: list[Wall]) -> tuple[list[SurfacedBody], list[Wall], list[Light]]:
        surfaces = [Surface(rng.integers(255, size=(48, 8, 3), dtype=np.uint8), 0.5, 0.5) for _ in range(bodies)]
        shapes = [antenna.part.mesh, *clutter_shapes()]
        poses = [Pose.from_rotvec(rng.normal(size=3), (*rng.uniform(-0.1, 0.1, 2), 0.5)) for _ in range(bodies)]
        placed = zip(shapes[-bodies:], poses, surfaces, strict=True)
        return [SurfacedBody(mesh, X_CO, NO_INSTANCE, look) for mesh, X_CO, look in placed], walls, [FORWARD]

    paper = Surface(rng.integers(255, size=(16, 16, 3), dtype=np.uint8), 0.0, 0.0)
    papered = Wall(facing(1.0).X_CP, (3.0, 3.0), paper)
    # More and fewer bodies than before, other shapes and textures, no wall, another wall.
    scenes = [scene(3, [papered]), scene(5, [papered]), scene(2, [facing(1.2)]), scene(4, [])]
    taken = {index: take(*scenes[index]).rgb for index in (1, 3, 0, 2)}
    for index, scene_ in enumerate(scenes):
        with closing(PhotoRenderer(CAMERA, renderer.samples)) as fresh:
            rgb = fresh.photograph(*scene_, 0.2).rgb
        assert np.ptp(rgb) > 50
        assert np.array_equal(rgb, taken[index]), index


def test_the_context_is_made_once_for_pictures_that_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[object] = []

    class Counted(photo_renderer.OpenGLContext):
        def __init__(self, model: object) -> None:
            made.append(model)
            super().__init__(model)

    monkeypatch.setattr(photo_renderer, "OpenGLContext", Counted)
    bodies = [SurfacedBody(mesh, Pose.from_translation((0.0, 0.0, 0.5)), 0, GREY) for mesh in clutter_shapes()[:3]]
    with closing(PhotoRenderer(CAMERA, 1)) as renderer:
        for count in (2, 1, 2):
            renderer.photograph(bodies[:count], [facing(1.0)], [FORWARD], 0.2)
        assert len(made) == 1
        renderer.photograph(bodies, [facing(1.0)], [FORWARD], 0.2)
        assert len(made) == 2


@pytest.mark.parametrize("samples", [0, 2, -1])
def test_samples_have_one_in_the_middle_of_a_pixel(samples: int) -> None:
    with pytest.raises(ValueError, match=r"expected samples of 1, 3, 5, ..., got"):
        PhotoRenderer(CAMERA, samples)
