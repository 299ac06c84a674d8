"""The arm as the model has it: against the DH table, its data sheet and itself."""

import mujoco
import numpy as np
import pytest

from cell.layout import Layout
from cell.ur10 import JOINT_LIMIT, TORQUE_LIMITS, forward
from sim.errors import MeshesMissingError
from sim.model.conditions import Conditions
from sim.model.robot import FINGERS, JOINTS
from sim.model.scene import robot_touches
from sim.model.vendor_meshes import maker_meshes
from sim.runtime.world import World


def test_the_models_flange_and_camera_are_where_the_dh_table_puts_them(antenna_world: World) -> None:
    world, layout, rng = antenna_world, Layout(), np.random.default_rng(0)
    count = 100
    for _ in range(count):
        q = rng.uniform(-JOINT_LIMIT, JOINT_LIMIT, 6)
        world.data.qpos[[world.mj_model.joint(name).qposadr[0] for name in JOINTS]] = q
        mujoco.mj_kinematics(world.mj_model, world.data)
        mujoco.mj_camlight(world.mj_model, world.data)
        X_WF = layout.X_WB @ forward(q)
        assert world.X_WF().matrix == pytest.approx(X_WF.matrix, abs=1e-12)
        assert world.X_WC().matrix == pytest.approx((X_WF @ layout.X_FC).matrix, abs=1e-12)


def test_joint_and_torque_limits_are_the_data_sheets(antenna_world: World) -> None:
    model = antenna_world.mj_model
    for name, torque in zip(JOINTS, TORQUE_LIMITS, strict=True):
        joint = model.joint(name)
        assert joint.range == pytest.approx([-2 * np.pi, 2 * np.pi])
        assert model.jnt_actfrcrange[joint.id] == pytest.approx([-torque, torque])
    assert TORQUE_LIMITS == (330.0, 330.0, 150.0, 54.0, 54.0, 54.0)


def test_gravity_does_not_pull_the_arm_down(antenna_world: World) -> None:
    model, data = antenna_world.mj_model, mujoco.MjData(antenna_world.mj_model)
    data.qpos[[model.joint(name).qposadr[0] for name in JOINTS]] = antenna_world.q_home
    mujoco.mj_forward(model, data)
    arm = [model.joint(name).dofadr[0] for name in (*JOINTS, *FINGERS)]
    assert np.abs(data.qfrc_bias[arm]).max() > 40.0  # N m: gravity is there
    assert data.qfrc_gravcomp[arm] == pytest.approx(data.qfrc_bias[arm], abs=1e-9)


def test_the_arm_feels_itself(antenna_world: World) -> None:
    model, data = antenna_world.mj_model, mujoco.MjData(antenna_world.mj_model)
    row = model.sensor(robot_touches("itself")).adr[0]
    arm = [model.joint(name).qposadr[0] for name in JOINTS]
    forces = {}
    folded = [0.0, -1.5, 2.95, -1.5, -1.5, 0.0]  # rad: the elbow bent until the forearm lies in the upper arm
    for name, q in (("home", antenna_world.q_home), ("folded", folded)):
        mujoco.mj_resetData(model, data)
        data.qpos[arm] = q
        mujoco.mj_forward(model, data)
        forces[name] = np.linalg.norm(data.sensordata[row : row + 3])
    assert forces["home"] == 0.0
    assert forces["folded"] > 30.0


def test_the_jaws_press_with_the_force_of_the_layout(antenna_world: World) -> None:
    model = antenna_world.mj_model
    low, high = model.actuator_forcerange[model.actuator("jaws").id]
    # The tendon's length is the mean of both fingers' ways, so its force is shared by halves.
    assert (high / 2, low / 2) == (Layout().gripper.grip_force, -Layout().gripper.grip_force)


def test_missing_meshes_are_named_with_the_extra_that_has_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sim.model.vendor_meshes._PACKAGE", "no-such-package")
    with pytest.raises(MeshesMissingError, match=r"pip install 'graspcell\[meshes\]'"):
        maker_meshes()


def test_a_hand_eye_error_moves_the_true_camera_only(antenna_world: World) -> None:
    layout = Layout()
    error = Conditions(hand_eye_error_mm=(3.0, 0.0, 4.0), hand_eye_error_deg=(0.0, 2.0, 0.0))
    world = World(layout, antenna_world.part_model, 1, error)
    world.data.qpos[[world.mj_model.joint(name).qposadr[0] for name in JOINTS]] = world.q_home
    mujoco.mj_kinematics(world.mj_model, world.data)
    mujoco.mj_camlight(world.mj_model, world.data)
    X_WC_believed = layout.X_WB @ forward(world.q_home) @ layout.X_FC
    off = X_WC_believed.inverse() @ world.X_WC()
    assert np.linalg.norm(off.translation) == pytest.approx(0.005)  # 3-4-5
    assert off.rotvec == pytest.approx(np.radians([0.0, 2.0, 0.0]), abs=1e-9)
