from collections.abc import Iterator, Sequence
from contextlib import closing
from typing import get_args

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import norm

from cell.layout import default_camera
from experiments.rendering.config import Style
from sim.images import pictures, textures
from sim.images.generated import Recipe, make_image, scatter
from sim.images.heap import drop
from sim.images.photo_renderer import Photograph, PhotoRenderer
from sim.images.photo_scene import SurfacedBody
from sim.images.pictures import HEAP, STYLES, LabelledPicture, Shot, expose, paste
from sim.images.textures import background, texture
from sim.instance_ids import NO_INSTANCE
from sim.model.parts import PartModel
from sim.networks.random_streams import Streams

CAMERA = default_camera()


def test_the_styles_are_those_of_the_command_line() -> None:
    assert tuple(STYLES) == get_args(Style)


@pytest.fixture(scope="module")
def renderer() -> Iterator[PhotoRenderer]:
    with closing(PhotoRenderer(CAMERA, 1)) as made:
        yield made


@pytest.fixture(scope="module")
def pasted(renderer: PhotoRenderer, handle: PartModel) -> LabelledPicture:
    return STYLES["s2"](handle, renderer, Streams(5, 1, "handle"), Shot())


def test_a_pasted_picture_shows_what_make_image_scatters(pasted: LabelledPicture, handle: PartModel) -> None:
    truth = make_image(handle.part.mesh, CAMERA, Recipe(), Streams(5, 1, "handle")).truth
    assert len(truth.X_CO_true) == len(pasted.truth.X_CO_true) >= 2
    for X, expected in zip(pasted.truth.X_CO_true, truth.X_CO_true, strict=True):
        assert np.array_equal(X.matrix, expected.matrix)
    assert np.array_equal(pasted.truth.instance_ids, truth.instance_ids)
    assert np.array_equal(pasted.truth.visibility, truth.visibility)


def test_only_bodies_have_depth_in_a_pasted_picture(pasted: LabelledPicture) -> None:
    on_parts = pasted.truth.instance_ids != NO_INSTANCE
    assert (pasted.depth[on_parts] > 0.2).all()
    assert np.mean(pasted.depth == 0) > 0.3
    assert pasted.X_CW is None


def test_a_heap_picture_has_depth_everywhere_and_parts_above_the_floor(
    renderer: PhotoRenderer, antenna: PartModel
) -> None:
    picture = STYLES["s1"](antenna, renderer, Streams(5, 2, "antenna"), Shot())
    assert (picture.depth > 0.1).all()
    assert picture.X_CW is not None
    X_WC = picture.X_CW.inverse()
    v, u = np.mgrid[:480, :640] + 0.5
    rays = np.stack(((u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy, np.ones_like(u)), axis=-1)
    points_W = X_WC.apply((rays * picture.depth[..., None]).reshape(-1, 3))
    assert points_W[:, 2].min() > -0.003
    heights = points_W[(picture.truth.instance_ids != NO_INSTANCE).ravel(), 2]
    assert len(heights) > 500
    assert heights.max() > 0.01
    floor = np.abs(points_W[:, 2]) < 0.002
    assert floor.mean() > 0.1


@pytest.mark.parametrize(
    ("shot", "least_deg", "span"),
    [(Shot(), 25.0, HEAP.distance), (Shot(distance=(0.35, 0.8), elevation_deg=(50.0, 90.0)), 50.0, (0.35, 0.8))],
)
def test_cameras_stand_in_the_room_look_down_and_have_a_part_in_the_image(
    antenna: PartModel, shot: Shot, least_deg: float, span: tuple[float, float]
) -> None:
    heap = drop(antenna, 3, 4, 0.2, np.random.default_rng(0))
    half_size = np.array((1.6, 2.0))
    rng = np.random.default_rng(1)
    distances = []
    for _ in range(200):
        X_CW = pictures._viewpoint(heap, antenna.part.mesh.center, CAMERA, half_size, shot=shot, rng=rng)
        X_WC = X_CW.inverse()
        assert (np.abs(X_WC.translation[:2]) < half_size).all()
        assert X_WC.translation[2] >= 0.15
        assert X_WC.rotation[2, 2] <= -np.sin(np.radians(least_deg)) + 1e-9
        middles = np.array([(X_CW @ X).apply(antenna.part.mesh.center) for X in heap.X_WO])
        inside = (np.abs(CAMERA.project(middles) - (320, 240)) < (0.3001 * 640, 0.3001 * 480)).all(axis=1)
        aimed = inside & (middles[:, 2] >= span[0]) & (middles[:, 2] <= span[1])
        assert aimed.any()
        distances.append(middles[aimed, 2].min())
    assert min(distances) < span[0] + 0.1
    assert max(distances) > span[1] - 0.1


def test_parts_in_the_air_are_turned_as_on_a_floor_that_is_seen_from_above(handle: PartModel) -> None:
    recipe = Recipe(resting=handle.resting_poses, elevation_deg=(50.0, 90.0), clutter=(0, 0))
    ups = np.array([pose.rotation[2] for pose in handle.resting_poses])  # in O, as is the direction to the camera
    towards = [
        -X_CO.rotation[2]
        for number in range(30)
        for _, X_CO, _ in scatter(handle.part.mesh, CAMERA, recipe, Streams(3, number, "handle"))
    ]
    elevations_deg = np.degrees(np.arcsin((np.array(towards) @ ups.T).max(axis=1)))
    assert elevations_deg.min() >= 50 - 1e-6
    assert elevations_deg.min() < 55
    assert elevations_deg.max() > 80


def test_pasting_shows_the_front_where_it_covers_and_the_background_elsewhere() -> None:
    coverage = np.zeros((40, 60), dtype=np.float32)
    coverage[:, 30:] = 1.0
    depth, numbers = coverage.copy(), np.zeros((40, 60), dtype=np.int8)
    photo = Photograph(np.repeat(200 * coverage[..., None], 3, axis=2), coverage, depth, numbers)
    picture = paste(photo, np.full((40, 60, 3), 50, dtype=np.uint8), 0.8)
    assert picture[:, :25] == pytest.approx(50)
    assert picture[:, 35:] == pytest.approx(200)
    assert picture[:, 29:31].mean() == pytest.approx(125, abs=1)
    assert (np.diff(picture[20, :, 0]) >= -1e-3).all()


def test_exposure_keeps_the_picture_and_differs_each_time() -> None:
    rgb = np.tile(np.linspace(0, 200, 64, dtype=np.float32)[None, :, None], (48, 1, 3))
    rng = np.random.default_rng(0)
    one, other = expose(rgb, rng), expose(rgb, rng)
    assert not np.array_equal(one, other)
    for picture in (one, other):
        assert np.corrcoef(picture[..., 0].ravel(), rgb[..., 0].ravel())[0, 1] > 0.98


def test_textures_and_backgrounds_are_varied_functions_of_their_generator() -> None:
    for make, size in ((texture, (48, 64)), (background, (120, 160))):
        pictures_made = [make(*size, np.random.default_rng(seed)) for seed in range(12)]
        assert np.array_equal(pictures_made[3], make(*size, np.random.default_rng(3)))
        for picture in pictures_made:
            assert (picture.shape, picture.dtype) == ((*size, 3), np.uint8)
            assert picture.std() > 1
        assert np.std([picture.mean() for picture in pictures_made]) > 10
    assert np.mean([picture.std() for picture in pictures_made]) > 25


def test_a_part_without_texture_has_its_own_colour(antenna: PartModel) -> None:
    rng = np.random.default_rng(0)
    plain, any_surface = (pictures.SurfaceSampler(antenna, share, rng) for share in (0.0, 1.0))
    own = np.array([plain.part().picture.mean(axis=(0, 1)) for _ in range(20)])
    assert own.max() < 255 * 0.08 * 2.0 * 1.1 + 1
    assert np.ptp([any_surface.part().picture.mean() for _ in range(20)]) > 50


class Noting(PhotoRenderer):
    """Notes the bodies of each picture and takes none."""

    def __init__(self) -> None:
        super().__init__(CAMERA, 1)
        self.seen: list[Sequence[SurfacedBody]] = []

    def photograph(self, bodies: Sequence[SurfacedBody], *_: object) -> Photograph:
        self.seen.append(bodies)
        raise InterruptedError


def test_a_picture_is_a_function_of_its_streams(antenna: PartModel) -> None:
    noting = Noting()
    for streams in (Streams(1, 0, "a"), Streams(1, 0, "a"), Streams(1, 1, "a"), Streams(2, 0, "a"), Streams(1, 0, "b")):
        with pytest.raises(InterruptedError):
            STYLES["s2"](antenna, noting, streams, Shot())
    first = [bodies[0].X_CO for bodies in noting.seen]
    assert np.array_equal(first[0].matrix, first[1].matrix)
    assert len({X.translation.tobytes() for X in first}) == 4


def test_views_of_one_heap_differ_in_all_but_the_heap(antenna: PartModel) -> None:
    noting = Noting()
    for number in range(5):
        with pytest.raises(InterruptedError):
            STYLES["s1"](antenna, noting, Streams(1, number, "a"), Shot(views_per_heap=2))

    def between_first_two(view: int) -> NDArray[np.float64]:
        one, other = (body.X_CO for body in noting.seen[view][:2])
        return (one.inverse() @ other).matrix

    for view in (0, 2):
        assert between_first_two(view) == pytest.approx(between_first_two(view + 1), abs=1e-9)
        one, other = noting.seen[view][0], noting.seen[view + 1][0]
        assert not np.allclose(one.X_CO.matrix, other.X_CO.matrix)
        assert not np.array_equal(one.surface.picture, other.surface.picture)
    for view in (1, 3):
        assert not np.allclose(between_first_two(view), between_first_two(view + 1))


def test_noise_is_normal_and_of_its_deviation() -> None:
    drawn = textures.noise((1000, 300), 2.0, np.random.default_rng(0))
    assert (drawn.shape, drawn.dtype) == ((1000, 300), np.float32)
    assert drawn.std() == pytest.approx(2.0, rel=0.01)
    for deviations in (0.5, 1.0, 1.5, 2.0):
        beyond = np.mean(drawn > 2.0 * deviations)
        assert beyond == pytest.approx(norm.sf(deviations), abs=1 / 256)  # in 256 steps
    neighbours = np.corrcoef(drawn[:, :-1].ravel(), drawn[:, 1:].ravel())[0, 1]
    assert abs(neighbours) < 0.01


def test_a_picture_has_as_many_parts_and_other_bodies_as_are_asked_for(antenna: PartModel) -> None:
    shot = Shot(parts=(3, 3), clutter=(1, 1), spread=(0.4, 0.4))
    heap = pictures._heap(antenna, Streams(5, 1, "antenna"), shot)
    assert (len(heap.X_WO), len(heap.clutter)) == (3, 1)
    assert any(np.linalg.norm(X.translation[:2]) > 0.2 for X in heap.X_WO)
