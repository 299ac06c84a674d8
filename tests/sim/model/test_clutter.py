"""Clutter: how near parts come to one another, and what distractors are to camera, networks and robot."""

from itertools import combinations

import mujoco
import numpy as np
import pytest

from cell.interfaces import Outcome, Touch
from cell.layout import Layout
from maskval import Pose, silhouette
from sim.errors import ConditionsError
from sim.instance_ids import NO_INSTANCE, PIXEL_CENTER
from sim.model.clutter import CLEARANCES, DISTRACTOR_CLEARANCE, DISTRACTORS
from sim.model.conditions import Conditions
from sim.model.parts import PartModel
from sim.model.placement import CLEARANCE
from sim.networks.ground_truth import LatestTruth
from sim.networks.random_streams import Streams
from sim.polygons import convex_outline, gap
from sim.runtime.episode import starting_poses
from sim.runtime.referee import SimReferee
from sim.runtime.station import SimStation
from sim.runtime.world import World
from sim.runtime.wrist_camera import WristCamera
from tests.sim.conftest import on_belt, standing

PARTS = 6
BELT = Layout().belt


@pytest.fixture(scope="module")
def cluttered(antenna: PartModel) -> World:
    return World(Layout(), antenna, PARTS, Conditions(clutter="distractors"))


def outlines_of(model: PartModel, poses: list[Pose]) -> list[np.ndarray]:
    return [convex_outline(pose.apply(model.part.mesh.vertices)) for pose in poses]


@pytest.mark.parametrize(("clutter", "least_mm", "most_mm"), [("close", 15.0, None), ("touching", 0.4, 1.0)])
def test_parts_lie_as_near_as_the_level_says(
    antenna: PartModel, clutter: str, least_mm: float, most_mm: float | None
) -> None:
    world = World(Layout(), antenna, PARTS, Conditions(clutter=clutter))
    for seed in range(5):
        outlines = outlines_of(antenna, starting_poses(world, Streams(seed, 0, "antenna")))
        gaps = [1000 * gap(one, other) for one, other in combinations(outlines, 2)]
        assert len(gaps) == PARTS * (PARTS - 1) // 2
        assert min(gaps) >= least_mm
        for one in outlines:
            assert np.all(np.abs(one[:, 0] - BELT.center_x) <= BELT.width / 2 - CLEARANCE + 1e-9)
        if most_mm is not None:  # as many near pairs as parts were pushed against another
            assert sum(distance <= most_mm for distance in gaps) >= PARTS - 1
    assert CLEARANCES["none"] == CLEARANCE


def test_distractors_lie_among_the_parts_and_move_none_of_them(antenna: PartModel, cluttered: World) -> None:
    streams = Streams(3, 0, "antenna")
    poses = starting_poses(cluttered, streams)
    plain = starting_poses(World(Layout(), antenna, PARTS), streams)
    assert len(poses) == PARTS + len(DISTRACTORS)
    assert all(np.array_equal(one.matrix, other.matrix) for one, other in zip(poses, plain, strict=False))
    outlines = outlines_of(antenna, poses[:PARTS])
    for thing, pose in zip(DISTRACTORS, poses[PARTS:], strict=True):
        middle = pose.translation[:2]
        nearest = min(np.linalg.norm(outline - middle, axis=1).min() for outline in outlines)
        assert nearest >= thing.radius + DISTRACTOR_CLEARANCE - 2e-3  # between corners the outline is nearer
    cluttered.reset(poses)
    heights = [cluttered.data.body(f"distractor_{index}").xpos[2] for index in range(len(DISTRACTORS))]
    assert heights == pytest.approx([BELT.top_z + thing.half_height for thing in DISTRACTORS], abs=1e-3)


def put(world: World, antenna: PartModel, over: Pose) -> None:
    """One part in the first search view with the first distractor at a pose; everything else far away."""
    away = [on_belt(antenna, BELT.center_x, -0.1 * index, standing(antenna)) for index in range(1, PARTS)]
    things = [over, *(Pose.from_translation(np.array([0.62 + 0.09 * i, -0.85, 0.0])) for i in range(3))]
    world.reset([on_belt(antenna, BELT.center_x, 0.4, standing(antenna)), *away, *things])


def test_a_distractor_hides_a_part_and_is_no_part_itself(antenna: PartModel, cluttered: World) -> None:
    put(cluttered, antenna, Pose.from_translation(np.array([BELT.center_x, 0.4, 0.15])))
    # Hold it over the part: between camera and part there is now a box.
    joint = cluttered.mj_model.joint("distractor_0").qposadr[0]
    cluttered.data.qpos[joint : joint + 3] = [BELT.center_x, 0.4, 0.15]
    mujoco.mj_forward(cluttered.mj_model, cluttered.data)
    numbers = WristCamera(cluttered).instance_ids([cluttered.X_CO(part) for part in range(PARTS)])
    whole = silhouette(antenna.part.mesh, cluttered.X_CO(0), cluttered.layout.camera, pixel_center=PIXEL_CENTER).mask
    hidden = whole & (numbers == NO_INSTANCE)
    assert hidden.sum() > 0.3 * whole.sum()
    assert numbers.max() < PARTS


def test_striking_a_distractor_is_a_collision_with_a_part_and_touches_no_part(
    antenna: PartModel, cluttered: World
) -> None:
    put(cluttered, antenna, Pose.from_translation(np.array([BELT.center_x - 0.12, 0.4, BELT.top_z + 0.021])))
    station = SimStation(cluttered, WristCamera(cluttered), LatestTruth())
    referee = SimReferee(cluttered, station)
    referee.attempt_begins(0)
    # A box that is suddenly where a finger is.
    finger = cluttered.X_WF() @ cluttered.layout.gripper.X_FT @ Pose.from_translation(np.array([0.0, 0.06, 0.0]))
    joint = cluttered.mj_model.joint("distractor_0")
    cluttered.data.qpos[joint.qposadr[0] : joint.qposadr[0] + 3] = finger.translation
    cluttered.data.qvel[joint.dofadr[0]] = 1e-3  # wakes it
    contact = station.wait(0.1, frozenset({Touch.PART}))
    assert contact is not None
    assert referee.verdict(contact) is Outcome.COLLISION_PART
    assert station.touched_parts() == []
    assert referee.verdict(None) is Outcome.VOID


def test_clutter_and_a_moving_belt_exclude_each_other_and_levels_are_named() -> None:
    with pytest.raises(ConditionsError, match="--clutter none on a moving belt, got close"):
        Conditions(clutter="close", belt_speed=0.1)
    with pytest.raises(ConditionsError, match="unknown clutter 'heap': expected one of none, close, touching, distr"):
        Conditions(clutter="heap")
