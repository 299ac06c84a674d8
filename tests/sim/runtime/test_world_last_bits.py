"""Numbers that differ in the last bit only lead to the same bits of the physics, and nothing is woken by rounding."""

import mujoco
import numpy as np
import pytest

from cell.arm.limits import PRESETS
from cell.arm.trajectory import JointTrajectory, joint_move
from maskval import Pose
from sim.model.parts import PartModel
from sim.runtime.station import SimStation
from sim.runtime.world import World
from tests.sim.conftest import on_belt, standing

ASIDE = np.array([0.3, 0.0, 0.0, 0.0, 0.0, 0.0])


def state(world: World) -> bytes:
    return world.data.qpos.tobytes() + world.data.qvel.tobytes()


def two_antennas(world: World, model: PartModel) -> list[Pose]:
    x = world.layout.belt.center_x
    return [on_belt(model, x, 0.3, standing(model), 0.7), on_belt(model, x, -0.3, 0, 0.4)]


def slid(world: World, speed: float) -> bytes:
    """The state after part 0 was pushed along the belt (m/s) and has come to rest."""
    body = world.mj_model.body("part_0")
    world.data.qvel[body.dofadr[0]] = speed
    for _ in range(200):
        world.step()
    return state(world)


def test_the_last_bits_of_the_starting_poses_change_nothing(antenna_world: World, antenna: PartModel) -> None:
    poses, found = two_antennas(antenna_world, antenna), set()
    for bits in (0.0, 1e-14, -1e-14):
        antenna_world.reset([Pose(X.rotation, X.translation + bits) for X in poses])
        found.add(state(antenna_world))
    assert len(found) == 1


def test_the_last_bits_of_a_sliding_part_are_gone_when_it_rests(antenna_world: World, antenna: PartModel) -> None:
    found = set()
    for speed in (0.3, 0.3 + 1e-14, 0.3 - 1e-14):
        antenna_world.reset(two_antennas(antenna_world, antenna))
        found.add(slid(antenna_world, speed))
    assert len(found) == 1


@pytest.mark.parametrize("periods", range(2))
def test_parts_that_fell_asleep_stay_asleep(periods: int, antenna_world: World, antenna: PartModel) -> None:
    world = antenna_world
    world.reset(two_antennas(world, antenna))
    for _ in range(periods):  # so that they fall asleep at other steps of a period
        world.data.qvel[world.mj_model.body("part_0").dofadr[0]] = 0.1
        world.step()
    for _ in range(100):
        world.step()
    trees = world.mj_model.body_treeid[[world.mj_model.body(f"part_{part}").id for part in range(2)]]
    for _ in range(30):
        world.step()
        assert (world.data.tree_asleep[trees] >= 0).all()


def test_the_last_bits_of_a_command_do_not_reach_the_servos(station: SimStation, antenna_world: World) -> None:
    world, rng = antenna_world, np.random.default_rng(0)
    way = joint_move(world.q_home, world.q_home + ASIDE, PRESETS["ur-default"], world.time_step)
    start, found = world.data.qpos.copy(), set()
    for _ in range(3):
        world.data.qpos[:], world.data.qvel[:], world.data.qacc_warmstart[:] = start, 0.0, 0.0
        mujoco.mj_forward(world.mj_model, world.data)  # the inertia there, by which torques are fed forward
        off = 1e-14 * rng.normal(size=(2, *way.positions.shape))
        station.follow(JointTrajectory(world.time_step, way.positions + off[0], way.velocities + off[1]), frozenset())
        found.add(state(world))
    assert len(found) == 1


def test_what_is_measured_has_nine_decimals(station: SimStation, antenna_world: World) -> None:
    world = antenna_world
    world.data.qpos[world._arm] += 0.123456789e-9
    world.data.qpos[world._jaw] += 0.123456789e-9
    for measured in (station.q, np.array([station.jaw_half_opening])):
        assert measured.tobytes() == np.round(measured, 9).tobytes()
    assert np.abs(station.q - world.data.qpos[world._arm]).max() < 1e-9


def test_after_each_step_the_state_and_the_solvers_start_are_rounded(antenna_world: World, antenna: PartModel) -> None:
    world = antenna_world
    world.reset(two_antennas(world, antenna))
    body = world.mj_model.body("part_0")
    world.data.qvel[body.dofadr[0]] = 0.3
    world.step()
    start = world.mj_model.jnt_qposadr[body.jntadr[0]]
    place = world.data.qpos[start : start + 7]
    assert place.tobytes() == np.round(place, 9).tobytes()
    assert np.abs(world.data.qvel).max() > 0.1
    assert world.data.qvel.tobytes() == np.round(world.data.qvel, 7).tobytes()
    assert np.abs(world.data.qacc_warmstart).max() > 0.1
    assert world.data.qacc_warmstart.tobytes() == np.round(world.data.qacc_warmstart, 3).tobytes()
