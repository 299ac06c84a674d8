"""Looks change no result: the physics with them is the physics without them, bit for bit."""

import mujoco
import numpy as np
import pytest

from cell.interfaces import Image
from cell.layout import Layout
from sim.errors import MeshesMissingError
from sim.model.conditions import Conditions
from sim.model.parts import PartModel
from sim.networks.estimators import make_estimators
from sim.networks.ground_truth import LatestTruth
from sim.networks.noise_model import load_noise
from sim.networks.random_streams import Streams
from sim.runtime.episode import belt_under, starting_poses
from sim.runtime.pictures import scenery_of
from sim.runtime.world import World
from sim.scenery.robot_looks import gripper_pieces
from sim.scenery.vendor_meshes import maker_meshes

CELLS = {
    "default": Conditions(),
    "distractors": Conditions(clutter="distractors"),
    "moving belt": Conditions(belt_speed=0.1),
}


@pytest.fixture(params=CELLS)
def world(request: pytest.FixtureRequest, handle: PartModel) -> World:
    conditions = CELLS[request.param]
    return World(Layout(belt=belt_under(conditions, 2)), handle, 2, conditions)


def test_a_step_with_looks_is_a_step_without_them_bit_for_bit(world: World) -> None:
    world.reset(starting_poses(world, Streams(0, 0, "handle")))
    plain, dressed = world.mj_model, scenery_of(world)
    assert dressed.ngeom > plain.ngeom
    belt = [model.geom("belt").id for model in (plain, dressed)]
    dressed.geom_surfacevel[belt[1]] = plain.geom_surfacevel[belt[0]]  # as fast as the world's belt has been set
    states = []
    for model in (plain, dressed):
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:], data.ctrl[:] = world.data.qpos, 0.01, world.data.ctrl
        rows = []
        for _ in range(200):
            mujoco.mj_step(model, data)
            rows.append(np.concatenate((data.qpos, data.qvel, data.sensordata)))
        states.append(np.array(rows))
    assert np.ptp(states[0], axis=0).max() > 1e-3  # something moves
    assert np.array_equal(*states)


def test_looks_touch_nothing_and_weigh_nothing(world: World) -> None:
    plain, dressed = world.mj_model, scenery_of(world)
    for name in ("nq", "nv", "nu", "nbody", "nsensordata"):
        assert getattr(dressed, name) == getattr(plain, name), name
    for name in ("body_mass", "body_inertia", "body_ipos", "dof_armature", "qpos0"):
        assert np.array_equal(getattr(dressed, name), getattr(plain, name)), name
    touching = [
        [tuple(row) for row in np.column_stack((model.geom_bodyid, model.geom_type, model.geom_size))[solid]]
        for model in (plain, dressed)
        if (solid := (model.geom_contype | model.geom_conaffinity).astype(bool) & (model.geom_type != 0)).any()
    ]
    assert len(touching[0]) > 40
    assert touching[0] == touching[1]


def test_the_model_that_physics_runs_on_has_no_looks(world: World) -> None:
    assert (world.mj_model.nlight, world.mj_model.ntex) == (0, 0)
    assert world.mj_model.nmesh == 1 + len(world.part_model.pieces)


@pytest.mark.parametrize("kind", ["noisy", "oracle"])
def test_the_simulated_networks_read_no_picture(antenna: PartModel, kind: str) -> None:
    streams = Streams(0, 0, "antenna")
    detector, networks = make_estimators(kind, LatestTruth(), antenna.part, load_noise("antenna"), streams)
    assert len(networks) == 2
    for estimator in (detector, *networks):
        assert Image.RGB not in estimator.images


def test_the_fingers_looks_end_where_the_fingers_do() -> None:
    gripper = Layout().gripper
    tip = gripper.tip_below_tcp + gripper.tcp_from_flange - 0.030 - gripper.body_height
    for side, name in ((1.0, "finger_left"), (-1.0, "finger_right")):
        points = np.concatenate([solid.vertices for body, _, solid in gripper_pieces(gripper) if body == name])
        assert points[:, 2].max() == pytest.approx(tip, abs=1e-9)
        assert (side * points[:, 1]).min() == pytest.approx(0.0, abs=1e-9)  # the pad's face
        below = points[points[:, 2] > 0.045]
        assert (side * below[:, 1]).max() == pytest.approx(gripper.finger_thickness)
        assert np.ptp(below[:, 0]) == pytest.approx(gripper.finger_width)


def test_missing_meshes_are_named_with_the_extra_that_has_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sim.scenery.vendor_meshes._PACKAGE", "no-such-package")
    with pytest.raises(MeshesMissingError, match=r"pip install 'graspcell\[meshes\]'"):
        maker_meshes()
