"""Bodies stand where the physics has them."""

import mujoco
import numpy as np
import pytest

from maskval import Pose
from sim.runtime.bodies import Bodies
from sim.runtime.world import World
from tests.sim.conftest import on_belt

AXES_OF_OPENCV = np.diag([1.0, -1.0, -1.0])  # MuJoCo's cameras look along -z with y up


@pytest.fixture(scope="module")
def bodies(antenna_world: World) -> Bodies:
    return Bodies(antenna_world)


def test_every_body_stands_where_the_world_has_it(antenna_world: World, bodies: Bodies) -> None:
    model = antenna_world.part_model
    antenna_world.reset([on_belt(model, 0.4, 0.0), on_belt(model, 0.1, 0.05, yaw=1.0)])
    data = mujoco.MjData(antenna_world.mj_model)
    data.qpos[:] = antenna_world.data.qpos
    mujoco.mj_kinematics(antenna_world.mj_model, data)
    places, _ = bodies.at()
    assert {"part_0", "part_1", "flange"} < places.keys()
    assert places.keys() == {shape.body for shape in bodies.shapes}
    for name, place in places.items():
        body = antenna_world.mj_model.body(name).id
        assert place == pytest.approx(np.concatenate((data.xpos[body], data.xquat[body])), abs=1e-12)


def test_places_are_those_of_the_positions_that_are_asked_for_and_the_world_stays(
    antenna_world: World, bodies: Bodies
) -> None:
    before = antenna_world.data.qpos.copy()
    asked = before.copy()
    joint = antenna_world.mj_model.body("part_0").jntadr[0]
    start = antenna_world.mj_model.jnt_qposadr[joint]
    asked[start : start + 7] = (0.3, -0.2, 0.9, 0.0, 1.0, 0.0, 0.0)
    places, _ = bodies.at(asked)
    assert places["part_0"] == pytest.approx([0.3, -0.2, 0.9, 0.0, 1.0, 0.0, 0.0], abs=1e-12)
    assert np.array_equal(antenna_world.data.qpos, before)


def test_the_wrist_camera_is_where_the_renderer_has_it_with_the_axes_of_opencv(
    antenna_world: World, bodies: Bodies
) -> None:
    data = mujoco.MjData(antenna_world.mj_model)
    data.qpos[:] = antenna_world.data.qpos
    mujoco.mj_forward(antenna_world.mj_model, data)
    camera = antenna_world.mj_model.camera("wrist").id
    _, X_WC = bodies.at()
    expected = Pose(data.cam_xmat[camera].reshape(3, 3) @ AXES_OF_OPENCV, data.cam_xpos[camera])
    assert X_WC.matrix == pytest.approx(expected.matrix, abs=1e-12)


def test_a_part_has_its_triangles(antenna_world: World, bodies: Bodies) -> None:
    mesh = antenna_world.part_model.part.mesh
    for name in ("part_0", "part_1"):
        vertices = np.concatenate([shape.vertices for shape in bodies.shapes if shape.body == name])
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        assert np.array([vertices.min(axis=0), vertices.max(axis=0)]) == pytest.approx(np.array([low, high]), abs=1e-6)
