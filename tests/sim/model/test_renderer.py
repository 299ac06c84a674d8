import numpy as np
import pytest

from cell.layout import Layout
from maskval import silhouette
from sim.errors import GraphicsError
from sim.instance_ids import NO_INSTANCE, PIXEL_CENTER
from sim.model.parts import PartModel
from sim.model.renderer import Renderer
from sim.runtime.world import World
from tests.sim.conftest import on_belt, standing


@pytest.fixture
def viewed(antenna_world: World, antenna: PartModel) -> World:
    """Two antennas in the first search view, one standing and one on its side."""
    x, y = antenna_world.layout.belt.center_x, 0.45
    antenna_world.reset([on_belt(antenna, x, y, standing(antenna)), on_belt(antenna, x + 0.05, y - 0.15, 0, yaw=1.0)])
    return antenna_world


def test_part_numbers_are_the_silhouettes_of_the_true_poses(viewed: World, antenna_camera: Renderer) -> None:
    numbers = antenna_camera.instance_ids(viewed.data, "wrist")
    seen, wrong = 0, 0
    for part in range(2):
        mesh, camera = viewed.part_model.part.mesh, viewed.layout.camera
        expected = silhouette(mesh, viewed.X_CO(part), camera, pixel_center=PIXEL_CENTER).mask
        seen += int(expected.sum())
        wrong += int((expected ^ (numbers == part)).sum())
    assert seen > 10_000
    # The rasteriser snaps vertices to 1/256 pixel: the silhouette study allows 0.02 % in pixels on the outline.
    assert wrong <= 5e-4 * seen


def test_pixels_without_a_part_show_nothing(viewed: World, antenna_camera: Renderer) -> None:
    numbers = antenna_camera.instance_ids(viewed.data, "wrist")
    assert set(np.unique(numbers)) == {NO_INSTANCE, 0, 1}
    assert numbers.shape == (480, 640)


def test_depth_is_the_distance_along_the_axis_to_the_belt(viewed: World, antenna_camera: Renderer) -> None:
    depth = antenna_camera.depth(viewed.data, "wrist")
    height = viewed.X_WC().translation[2] - viewed.layout.belt.top_z
    on_the_belt = (antenna_camera.instance_ids(viewed.data, "wrist") == NO_INSTANCE)[100:380]
    assert on_the_belt.sum() > 50_000
    assert depth[100:380][on_the_belt] == pytest.approx(height, abs=2e-4)


def test_rgb_is_a_picture_and_repeats_bit_for_bit(viewed: World, antenna_camera: Renderer) -> None:
    first = antenna_camera.rgb(viewed.data, "wrist")
    antenna_camera.depth(viewed.data, "wrist")
    numbers = antenna_camera.instance_ids(viewed.data, "wrist")
    assert (first.shape, first.dtype) == ((480, 640, 3), np.uint8)
    assert np.array_equal(antenna_camera.rgb(viewed.data, "wrist"), first)
    # The antenna is black, the belt is green.
    assert first[numbers == 0].mean() < 60 < first[numbers == NO_INSTANCE].mean()


def test_without_opengl_the_error_names_the_packages(antenna_world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*arguments: object) -> None:
        raise AttributeError("'NoneType' object has no attribute 'eglQueryString'")

    monkeypatch.setattr("sim.model.renderer.mujoco.Renderer", broken)
    with pytest.raises(GraphicsError, match="apt-get install libegl1 libgl1 libosmesa6"):
        Renderer(antenna_world.mj_model, 480, 640)


def test_the_camera_of_the_layout_is_the_camera_of_the_model(antenna_world: World) -> None:
    model, camera = antenna_world.mj_model, Layout().camera
    wrist = model.camera("wrist").id
    assert tuple(model.cam_resolution[wrist]) == (camera.width, camera.height)
