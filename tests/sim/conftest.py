"""Worlds and cameras are dear (half a second each), so that the tests of a module share them and reset before use."""

from collections.abc import Iterator

import numpy as np
import pytest

from cell.layout import Layout
from maskval import Pose
from sim.model.parts import PartModel, load_part
from sim.model.renderer import Renderer
from sim.networks.ground_truth import LatestTruth
from sim.runtime.station import SimStation
from sim.runtime.world import World
from sim.runtime.wrist_camera import WristCamera


def on_belt(model: PartModel, x: float, y: float, side: int = 0, yaw: float = 0.0) -> Pose:
    """X_WO of a part that lies on its side number `side` at a place of the belt's surface."""
    resting = model.resting_poses[side]
    c, s = np.cos(yaw), np.sin(yaw)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    z = Layout().belt.top_z + resting.height + 0.0005
    return Pose(turn @ resting.rotation, np.array([x, y, z]))


def standing(model: PartModel) -> int:
    """Number of the resting pose with the part's z axis up."""
    return next(i for i, pose in enumerate(model.resting_poses) if pose.rotation[2, 2] > 0.999)


@pytest.fixture(scope="session")
def antenna() -> PartModel:
    return load_part("antenna")


@pytest.fixture(scope="session")
def handle() -> PartModel:
    return load_part("handle")


@pytest.fixture(scope="session")
def antenna_world(antenna: PartModel) -> World:
    return World(Layout(), antenna, parts=2)


@pytest.fixture(scope="session")
def antenna_camera(antenna_world: World) -> Iterator[Renderer]:
    camera = Renderer(antenna_world.mj_model, 480, 640)
    yield camera
    camera.close()


@pytest.fixture(scope="session")
def wrist_camera(antenna_world: World) -> Iterator[WristCamera]:
    camera = WristCamera(antenna_world)
    yield camera
    camera.close()


@pytest.fixture
def station(antenna: PartModel, antenna_world: World, wrist_camera: WristCamera) -> SimStation:
    """A fresh station over two standing antennas at y = 0.3 and −0.3 in the middle of the belt."""
    x = antenna_world.layout.belt.center_x
    antenna_world.reset([on_belt(antenna, x, y, standing(antenna)) for y in (0.3, -0.3)])
    return SimStation(antenna_world, wrist_camera, LatestTruth())
