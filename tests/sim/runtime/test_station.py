import numpy as np
import pytest

from cell.arm.limits import PRESETS
from cell.arm.trajectory import hold
from cell.arm.ur10 import forward
from cell.interfaces import Image, Touch
from cell.motion import EVERYTHING, HOLDING, Motion
from maskval import Pose
from sim.model.parts import PartModel
from sim.runtime.station import COLLISION_FORCE, PRESSING_FORCE, SimStation
from sim.runtime.world import World

NOBODY: frozenset[Touch] = frozenset()
DOWNWARDS = np.diag([1.0, -1.0, -1.0])  # R_WT: the tool looks down, the jaws close along the belt


@pytest.fixture
def motion(station: SimStation, antenna_world: World) -> Motion:
    return Motion(station, antenna_world.layout, PRESETS["ur-default"])


def tool(world: World, x: float, y: float, z: float) -> Pose:
    """X_BT of the tool over a place in W."""
    return world.layout.X_WB.inverse() @ Pose(DOWNWARDS, np.array([x, y, z]))


def belt_x(world: World) -> float:
    return world.layout.belt.center_x


def grasp_of_first(world: World) -> Pose:
    """X_BT of the fin's grasp of part 0."""
    fin = world.part_model.part.grasps[0]
    return world.layout.X_WB.inverse() @ world.X_WO(0) @ fin.X_OT


def raised(X: Pose, height: float) -> Pose:
    return Pose(X.rotation, X.translation + [0.0, 0.0, height])


def pick_first(motion: Motion, world: World) -> None:
    """Grasps part 0 by its fin and lifts it by 0.16 m."""
    grip = grasp_of_first(world)
    station = motion.station
    station.command_jaws(0.045)
    assert motion.to_tool(raised(grip, 0.12)) is None
    assert motion.line_to(grip) is None
    station.command_jaws(-0.02)
    assert station.wait(0.4, HOLDING) is None
    assert motion.line_to(raised(grip, 0.16), HOLDING) is None


def test_a_motion_takes_the_time_of_its_trajectory(station: SimStation) -> None:
    station.follow(hold(station.q, 0.5, station.time_step), EVERYTHING)
    samples = round(0.5 / station.time_step) + 1
    assert station.time == pytest.approx(samples * station.time_step)


def test_waiting_lets_the_clock_run(station: SimStation) -> None:
    station.wait(0.25, NOBODY)
    assert station.time == pytest.approx(0.25)


def test_the_jaws_go_where_they_are_sent(station: SimStation) -> None:
    for half_opening in (0.02, 0.05, 0.0):
        station.command_jaws(half_opening)
        station.wait(0.5, NOBODY)
        assert station.jaw_half_opening == pytest.approx(half_opening, abs=2e-4)


def test_striking_the_belt_stops_the_motion_at_once(motion: Motion, antenna_world: World) -> None:
    world = antenna_world
    assert motion.to_tool(tool(world, belt_x(world), 0.0, 0.10)) is None
    contact = motion.line_to(tool(world, belt_x(world), 0.0, world.layout.belt.top_z - 0.03))
    assert contact is not None
    assert contact.touch is Touch.BELT
    assert contact.force > COLLISION_FORCE
    # The finger tips end 15 mm below the tool centre point: they have stopped at the belt, not where they were sent.
    tip = (world.layout.X_WB @ motion.X_BT).translation[2] - world.layout.gripper.tip_below_tcp
    assert tip == pytest.approx(world.layout.belt.top_z, abs=0.003)
    assert contact.time == pytest.approx(motion.station.time)


def test_an_unwatched_contact_does_not_stop_the_motion(motion: Motion, antenna_world: World) -> None:
    world = antenna_world
    motion.to_tool(tool(world, belt_x(world), 0.0, 0.10))
    below = tool(world, belt_x(world), 0.0, world.layout.belt.top_z + 0.005)
    assert motion.line_to(below, NOBODY) is None


def test_striking_a_part_names_the_part(
    motion: Motion, station: SimStation, antenna_world: World, antenna: PartModel
) -> None:
    world = antenna_world
    top = world.X_WO(0).apply(antenna.part.mesh.vertices)[:, 2].max()
    place = grasp_of_first(world)
    station.command_jaws(0.002)  # closed jaws meet the fin from above
    motion.to_tool(raised(place, 0.12))
    contact = motion.line_to(place)
    assert contact is not None
    assert contact.touch is Touch.PART
    assert station.touched_parts() == [0]
    tip = (world.layout.X_WB @ motion.X_BT).translation[2] - world.layout.gripper.tip_below_tcp
    assert tip == pytest.approx(top, abs=0.004)


def test_free_motions_touch_nothing(motion: Motion, station: SimStation, antenna_world: World) -> None:
    world = antenna_world
    for y in (0.3, -0.3, 0.0):
        assert motion.to_tool(tool(world, belt_x(world), y, 0.15)) is None
    assert station.touched_parts() == []


def test_the_gripper_holds_a_300_gram_part_within_a_millimetre(
    motion: Motion, station: SimStation, antenna_world: World, antenna: PartModel
) -> None:
    world = antenna_world
    assert antenna.mass == 0.3
    pick_first(motion, world)
    X_FO = world.X_WF().inverse() @ world.X_WO(0)
    above_slot = tool(world, 0.05, -0.8, 0.16)
    assert motion.to_tool(above_slot, HOLDING) is None
    assert motion.to_tool(tool(world, belt_x(world), 0.3, 0.15), HOLDING) is None
    station.wait(2.0, HOLDING)
    X_FO_later = world.X_WF().inverse() @ world.X_WO(0)
    vertices = antenna.part.mesh.vertices
    slip = np.linalg.norm(X_FO_later.apply(vertices) - X_FO.apply(vertices), axis=1).max()
    # Two transfers and two seconds of hold; the issue asks for one transfer.
    assert slip < 0.001


def test_pressing_the_held_part_into_the_container_stops_the_motion(motion: Motion, antenna_world: World) -> None:
    world = antenna_world
    pick_first(motion, world)
    slot = world.layout.container.slot_center(0, world.part_model.part.slot_size)
    assert motion.to_tool(tool(world, slot[0], slot[1], 0.10), HOLDING) is None
    contact = motion.line_to(tool(world, slot[0], slot[1], world.layout.container.floor_z), HOLDING | {Touch.PRESSED})
    assert contact is not None
    assert contact.touch is Touch.PRESSED
    assert contact.force > PRESSING_FORCE


def test_a_frame_holds_what_was_asked_for_and_the_believed_camera_pose(
    station: SimStation, antenna_world: World
) -> None:
    plain = station.take_frame(frozenset())
    both = station.take_frame(frozenset({Image.RGB, Image.DEPTH}))
    assert (plain.rgb, plain.depth, plain.index) == (None, None, 0)
    assert both.rgb is not None
    assert both.depth is not None
    assert both.index == 1
    X_BC = forward(station.q) @ antenna_world.layout.X_FC
    assert np.array_equal(plain.X_BC.matrix, X_BC.matrix)


def test_touches_can_be_forgotten(motion: Motion, station: SimStation, antenna_world: World) -> None:
    pick_first(motion, antenna_world)
    assert station.touched_parts() == [0]
    station.forget_touches()
    assert station.touched_parts() == []


def test_a_contact_holds_the_joints_where_they_are(motion: Motion, antenna_world: World) -> None:
    world = antenna_world
    over_belt = tool(world, belt_x(world), 0.0, world.layout.belt.top_z + 0.05)
    assert motion.to_tool(over_belt) is None
    assert motion.line_to(tool(world, belt_x(world), 0.0, world.layout.belt.top_z - 0.03)) is not None
    q = world.q
    motion.station.wait(0.3, NOBODY)
    servos = world._engine.servos  # angle, speed and torque of each
    np.testing.assert_allclose(servos, np.column_stack((q, np.zeros((6, 2)))), atol=1e-9)
    np.testing.assert_allclose(world.q, q, atol=2e-3)  # the belt gives the tool back a little
