import hashlib

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from cell.arm.limits import PRESETS
from cell.arm.trajectory import joint_move, line_move
from cell.arm.ur10 import forward
from cell.layout import Belt, Layout
from maskval import Pose
from sim.errors import DivergenceError
from sim.model.parts import PartModel
from sim.model.placement import place_parts
from sim.networks.ground_truth import LatestTruth
from sim.runtime.referee import SimReferee
from sim.runtime.station import SimStation
from sim.runtime.world import World
from sim.runtime.wrist_camera import WristCamera
from tests.sim.conftest import on_belt, standing

TO_CONTAINER = np.radians([-80.0, 5.0, 10.0, -15.0, 0.0, 20.0])  # from home, about a transfer's way


def setpoint(*of_joints: NDArray[np.float64]) -> NDArray[np.float64]:
    """One setpoint of angles, speeds and accelerations."""
    return np.stack(of_joints, axis=1)[np.newaxis]


def test_parts_settle_within_a_hundredth_of_a_millimetre(antenna_world: World, antenna: PartModel) -> None:
    for seed in range(3):
        antenna_world.reset(place_parts(antenna, 2, antenna_world.layout.belt, np.random.default_rng(seed)))
        before = [antenna_world.X_WO(part).matrix for part in range(2)]
        for _ in range(1000):
            antenna_world.step()
        after = [antenna_world.X_WO(part).matrix for part in range(2)]
        assert np.abs(np.subtract(before, after)).max() < 1e-5


def test_the_tool_stays_within_half_a_millimetre_of_its_way_at_default_speed(
    antenna_world: World, antenna: PartModel
) -> None:
    world = antenna_world
    world.reset([on_belt(antenna, 0.68, y, standing(antenna)) for y in (0.3, -0.3)])
    home, preset = world.q_home, PRESETS["ur-default"]
    X_BF = forward(home)
    down = line_move(X_BF, Pose(X_BF.rotation, X_BF.translation - [0, 0, 0.2]), home, preset, world.time_step)
    assert down is not None
    ways = [
        down,
        joint_move(down.positions[-1], home, preset, world.time_step),
        joint_move(home, home + TO_CONTAINER, preset, world.time_step),
        joint_move(home + TO_CONTAINER, home, preset, world.time_step),
    ]
    X_FT = world.layout.gripper.X_FT
    errors = []
    for way in ways:
        for q, qd, qdd in zip(way.positions, way.velocities, way.accelerations, strict=True):
            errors.append(np.linalg.norm((forward(world.q) @ X_FT).translation - (forward(q) @ X_FT).translation))
            world.follow(setpoint(q, qd, qdd), *world._unwatched())
    assert len(errors) > 1500
    assert max(errors) < 0.0005


def test_the_belt_carries_parts_at_its_speed_and_stops_with_them(antenna: PartModel) -> None:
    world = World(Layout(), antenna, 2)
    world.reset([on_belt(antenna, 0.68, y, side) for y, side in ((-0.4, 0), (0.0, standing(antenna)))])
    speed, duration = 0.15, 1.0
    start = [world.X_WO(part).translation[1] for part in range(2)]
    world.move_belt(speed)
    for _ in range(round(duration / world.time_step)):
        world.step()
    moved = [world.X_WO(part).translation[1] - y for part, y in zip(range(2), start, strict=True)]
    # Sliding up to speed on friction 0.7, the larger of belt's and part's, loses v²/(2 μ g) = 1.6 mm.
    slip = speed**2 / (2 * 0.7 * 9.81)
    for way in moved:
        assert speed * duration - 1.5 * slip < way <= speed * duration + 1e-3
    world.move_belt(0.0)
    for _ in range(round(0.5 / world.time_step)):
        world.step()
    stopped = [world.X_WO(part).matrix for part in range(2)]
    for _ in range(round(0.5 / world.time_step)):
        world.step()
    assert np.abs(np.subtract(stopped, [world.X_WO(part).matrix for part in range(2)])).max() < 1e-5


def test_what_a_moving_belt_carries_over_its_end_falls_into_the_tray_and_counts_as_left(antenna: PartModel) -> None:
    belt = Belt(speed=0.15, upstream=1.0)
    world = World(Layout(belt=belt), antenna, 2)
    near_end, upstream = -belt.length / 2 + 0.05, belt.length / 2 + 0.5
    world.reset([on_belt(antenna, belt.center_x, y, standing(antenna)) for y in (near_end, upstream)])
    start = world.X_WO(1).translation[1]
    for _ in range(round(2.0 / world.time_step)):
        world.step()
    fallen, coming = (world.X_WO(part).translation for part in range(2))
    assert belt.top_z - 0.25 < fallen[2] < belt.top_z - 0.10
    assert fallen[1] < -belt.length / 2
    assert coming[1] - start == pytest.approx(-0.15 * 2.0, abs=2.5e-3)  # slip, see above
    referee = SimReferee(world, SimStation(world, WristCamera(world), LatestTruth()))
    assert [referee.is_on_belt(part) for part in range(2)] == [False, True]
    assert referee.parts_on_belt() == 2


def history(world: World, antenna: PartModel, seed: int) -> str:
    """Digest of positions and speeds over a second in which the arm moves."""
    world.reset(place_parts(antenna, 2, world.layout.belt, np.random.default_rng(seed)))
    digest = hashlib.sha256()
    way = joint_move(world.q_home, world.q_home + TO_CONTAINER / 4, PRESETS["ur-default"], world.time_step)
    for q, qd, qdd in zip(way.positions, way.velocities, way.accelerations, strict=True):
        world.follow(setpoint(q, qd, qdd), *world._unwatched())
        digest.update(world.data.qpos.tobytes() + world.data.qvel.tobytes())
    return digest.hexdigest()


def test_two_worlds_and_a_used_one_step_bit_for_bit_alike(antenna: PartModel) -> None:
    one, other = (World(Layout(), antenna, 2) for _ in range(2))
    first = history(one, antenna, seed=1)
    assert history(other, antenna, seed=2) != first
    other.move_belt(0.1)
    assert history(other, antenna, seed=1) == first
    assert history(one, antenna, seed=1) == first


def test_a_state_that_is_not_finite_is_an_error(antenna_world: World, antenna: PartModel) -> None:
    antenna_world.reset([on_belt(antenna, 0.68, y, standing(antenna)) for y in (0.3, -0.3)])
    antenna_world.check()
    antenna_world.data.qvel[-1] = np.nan
    with pytest.raises(DivergenceError, match="not finite"):
        antenna_world.check()


def test_a_diverging_physics_is_an_error(antenna_world: World, antenna: PartModel) -> None:
    antenna_world.reset([on_belt(antenna, 0.68, y, standing(antenna)) for y in (0.3, -0.3)])
    antenna_world.data.qvel[-6:] = 1e12
    antenna_world.step()
    with pytest.raises(DivergenceError, match="diverged"):
        antenna_world.check()
    mujoco.mj_resetData(antenna_world.mj_model, antenna_world.data)
