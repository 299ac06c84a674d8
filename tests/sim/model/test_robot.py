"""The arm as the model has it: against the DH table, its data sheet and itself."""

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from cell.arm.ur10 import JOINT_LIMIT, TORQUE_LIMITS, forward
from cell.layout import Layout
from sim.model.conditions import Conditions
from sim.model.robot import FINGERS, JOINTS
from sim.model.scene import robot_touches
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


def servo_gains(model: mujoco.MjModel) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """k_p and k_v of the joints' servos."""
    rows = [model.actuator(name).id for name in JOINTS]
    return -model.actuator_biasprm[rows, 1], -model.actuator_biasprm[rows, 2]


def test_the_servos_are_stable_wherever_the_arm_is_since_its_inertia_is_more_than_the_armature(
    antenna_world: World,
) -> None:
    model = antenna_world.mj_model
    kp, kv = servo_gains(model)
    assert kp.min() > 0
    assert kv.min() > 0
    dt, armature = model.opt.timestep, model.dof_armature[[model.joint(name).dofadr[0] for name in JOINTS]]
    # v' = v − dt M⁻¹ (K_v v + K_p e), e' = e + dt v' decays where 2 M − dt K_v − dt²/2 K_p is positive definite.
    assert (dt * kv + dt**2 / 2 * kp < 2 * armature).all()


def test_in_all_of_the_reach_an_error_of_the_servos_decays(antenna_world: World) -> None:
    model, data = antenna_world.mj_model, mujoco.MjData(antenna_world.mj_model)
    kp, kv = servo_gains(model)
    dt, rng = model.opt.timestep, np.random.default_rng(0)
    arm, dofs = ([model.joint(name).qposadr[0] for name in JOINTS], [model.joint(name).dofadr[0] for name in JOINTS])
    inertia, radii = np.zeros((model.nv, model.nv)), []
    for _ in range(300):
        data.qpos[arm] = rng.uniform(-np.pi, np.pi, 6)
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, inertia)
        M = inertia[np.ix_(dofs, dofs)] + dt * np.diag(model.dof_damping[dofs])  # Euler takes a joint's own implicitly
        to_speed = np.eye(6) - dt * np.linalg.solve(M, np.diag(kv)), -dt * np.linalg.solve(M, np.diag(kp))
        step = np.block([[to_speed[0], to_speed[1]], [dt * to_speed[0], np.eye(6) + dt * to_speed[1]]])
        radii.append(np.abs(np.linalg.eigvals(step)).max())
    assert len(radii) == 300
    assert max(radii) < 1.0


def test_friction_of_the_jaws_takes_most_of_a_sliding_speed_in_a_step_and_stays_stable(antenna_world: World) -> None:
    model = antenna_world.mj_model
    dt = model.opt.timestep
    assert model.npair >= 2
    for pair in range(model.npair):
        dmax = model.pair_solimp[pair][1]
        beta = -dt * model.pair_solreffriction[pair][1] / dmax  # MuJoCo's scaling of negative numbers
        assert 1.0 < beta < 2.0
        assert abs(1 / beta - 1 / 2) < 0.5 / 2.9  # the drift, in dt times the centripetal acceleration: a third of 1/2
        np.testing.assert_allclose(model.pair_solref[pair], (2 * dt, 1.0))  # across the contact: β is 1
