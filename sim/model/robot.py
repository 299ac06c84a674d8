"""The UR10 with its gripper and wrist camera as MuJoCo bodies.

Body placement follows ur_description's chain, whose forward kinematics equal the DH table of `cell.arm.ur10` (tested).
Masses are ur_description's; the shells have the arm's dimensions (`sim.model.arm_geometry`). `sim.scenery` says how it
looks.
"""

from dataclasses import dataclass
from itertools import pairwise

import mujoco
import numpy as np

from cell.arm.ur10 import JOINT_LIMIT, TORQUE_LIMITS
from cell.layout import Gripper
from maskval import Camera, Pose
from sim.model.arm_geometry import Shell, arm_shells
from sim.model.renderer import pinhole

TIME_STEP = 0.002  # s of the physics, and of the robot's controller
JOINTS = ("shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3")  # each named as the link that it moves
FINGERS = ("finger_left", "finger_right")
PADS = tuple(f"{finger}_pad" for finger in FINGERS)  # what holds a part

_QUARTER_Y = (np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0)
_UPRIGHT = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class _Link:
    """One moving body: its place in its parent (m), joint axis, mass (kg), its rotor's reflected inertia (kg m²)."""

    name: str
    position: tuple[float, float, float]
    quaternion_wxyz: tuple[float, ...]
    axis: tuple[int, int, int]
    mass: float
    center_of_mass: tuple[float, float, float]
    armature: float
    damping: float


_LINKS = (
    _Link("shoulder", (0, 0, 0.1273), _UPRIGHT, (0, 0, 1), 7.778, (0, 0, 0), 1.0, 0.5),
    _Link("upper_arm", (0, 0.220941, 0), _QUARTER_Y, (0, 1, 0), 12.93, (0, 0, 0.306), 1.0, 0.5),
    _Link("forearm", (0, -0.1719, 0.612), _UPRIGHT, (0, 1, 0), 3.87, (0, 0, 0.28615), 0.6, 0.5),
    _Link("wrist_1", (0, 0, 0.5723), _QUARTER_Y, (0, 1, 0), 1.96, (0, 0.07, 0), 0.15, 0.1),
    _Link("wrist_2", (0, 0.1149, 0), _UPRIGHT, (0, 0, 1), 1.96, (0, 0, 0.07), 0.15, 0.1),
    _Link("wrist_3", (0, 0, 0.1157), _UPRIGHT, (0, 1, 0), 0.202, (0, 0.06, 0), 0.15, 0.1),
)

# Damped by 0.9 to 1 of the critical k_v = 2 √(k_p I), for the inertia I that a joint moves. The setpoint's speed and
# torque are fed forward. A plain position servo lags by k_v/k_p (60 mm at full speed), and by M q̈/k_p in acceleration
# (2 mm). Stable in all positions: Euler's explicit damping holds while dt K_v + dt²/2 K_p < 2 M, and M is more than the
# armature.
_SERVO_KP = np.array([40000.0, 40000.0, 24000.0, 6000.0, 6000.0, 6000.0])  # N m/rad
_SERVO_KV = np.array([900.0, 900.0, 490.0, 78.0, 78.0, 69.0])  # N m s/rad
_CONTROL_POSITION_VELOCITY_TORQUE = 7  # mjINPUT_POS | mjINPUT_VEL | mjINPUT_FF

_JAW_KP = 8000.0  # N/m
_JAW_KV = 250.0  # N s/m
_DMAX = 0.99
GRIP_SOLIMP = (0.95, _DMAX, 0.001, 0.5, 2.0)
GRIP_SOLREF = (2 * TIME_STEP, 1.0)  # as stiff as MuJoCo allows; in jaws, its default (0.02 s) slides out
# MuJoCo solves a contact at the step's beginning, without the change of its direction: a part on a circular way drifts
# in the jaws with (1/β − 1/2) dt a, where a is the centripetal acceleration and β = dt b the share of a sliding speed
# that a step takes away. A time constant of 2 dt has β = 1, and parts slide by more than a millimetre in a transfer;
# 1.5 a third of it. Friction is stable for β < 2. Across the contact, 1.5 throws out what the jaws pinch at an edge.
_SLIP_DAMPING = 1.5  # β, along the contact
_SLIP_STIFFNESS = 0.25  # dt² k of a time constant of 2 dt; without effect, since sliding has nothing to go back to
SLIP_SOLREF = (-_SLIP_STIFFNESS * (_DMAX / TIME_STEP) ** 2, -_SLIP_DAMPING * _DMAX / TIME_STEP)  # −k, −b, unscaled
PAD_FRICTION = (1.0, 0.02, 0.002)

GRIPPER_RGBA = (0.16, 0.17, 0.19, 1.0)
PAD_RGBA = (0.05, 0.05, 0.05, 1.0)


def add_robot(spec: mujoco.MjSpec, gripper: Gripper, camera_true: Camera, X_FC_true: Pose) -> None:
    """Adds arm, gripper, wrist camera, servos and self-collision exclusions to `spec`."""
    shells = arm_shells()
    body = spec.worldbody.add_body(name="base")
    _add_shells(body, shells["base"])
    for link in _LINKS:
        body = body.add_body(name=link.name, pos=link.position, quat=link.quaternion_wxyz, gravcomp=1.0)
        body.mass, body.ipos, body.inertia = link.mass, link.center_of_mass, _rod_inertia(link.mass)
        body.explicitinertial = True
        body.add_joint(
            name=link.name,
            axis=link.axis,
            range=(-JOINT_LIMIT, JOINT_LIMIT),
            limited=mujoco.mjtLimited.mjLIMITED_TRUE,
            armature=link.armature,
            damping=[link.damping, 0.0, 0.0],
            actfrclimited=mujoco.mjtLimited.mjLIMITED_TRUE,
            actgravcomp=True,
        )
        _add_shells(body, shells[link.name])
    for index, link in enumerate(_LINKS):
        spec.joint(link.name).actfrcrange = (-TORQUE_LIMITS[index], TORQUE_LIMITS[index])
        actuator = spec.add_actuator(name=link.name, target=link.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        actuator.set_to_pid(
            kp=float(_SERVO_KP[index]), kv=float(_SERVO_KV[index]), ctrlspec=_CONTROL_POSITION_VELOCITY_TORQUE
        )
    # The flange: ur_description's tool0, z out of the last joint.
    flange = body.add_body(name="flange", pos=(0, 0.0922, 0), quat=(np.sqrt(0.5), -np.sqrt(0.5), 0, 0), gravcomp=1.0)
    flange.add_site(name="flange", size=[0.005, 0.005, 0.005], group=4)
    _add_gripper(spec, flange, gripper)
    _add_camera(flange, camera_true, X_FC_true)
    _exclude_neighbours(spec)


def _rod_inertia(mass: float) -> tuple[float, float, float]:
    """Diagonal inertia of a compact link, kg m²; small beside the rotors' reflected inertia, which the servo feels."""
    return (0.01 * mass, 0.01 * mass, 0.005 * mass)


def _add_shells(body: mujoco.MjsBody, shells: tuple[Shell, ...]) -> None:
    for shell in shells:
        shell.add_to(body)


def _add_gripper(spec: mujoco.MjSpec, flange: mujoco.MjsBody, gripper: Gripper) -> None:
    adapter = gripper_base_height(gripper) - gripper.body_height
    box, cylinder = mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_CYLINDER
    solid = {"density": 0.0}  # the body's mass is given
    flange.mass, flange.explicitinertial = 1.2, True
    flange.ipos, flange.inertia = (0.0, 0.0, 0.07), (0.003, 0.002, 0.003)
    flange.add_geom(type=cylinder, size=[0.04, adapter / 2, 0], pos=[0, 0, adapter / 2], rgba=GRIPPER_RGBA, **solid)
    flange.add_geom(
        type=box,
        size=[gripper.body_width / 2, gripper.body_length / 2, gripper.body_height / 2],
        pos=[0, 0, adapter + gripper.body_height / 2],
        rgba=GRIPPER_RGBA,
        **solid,
    )
    tip = gripper.tcp_from_flange + gripper.tip_below_tcp
    root = gripper_base_height(gripper)
    pad_thickness, pad_length = 0.005, 0.040
    blade = gripper.finger_thickness - pad_thickness
    for name, side in zip(FINGERS, (1.0, -1.0), strict=True):
        finger = flange.add_body(name=name, pos=(0, 0, root), gravcomp=1.0)
        finger.mass, finger.explicitinertial = 0.2, True
        finger.ipos, finger.inertia = (0, side * 0.013, 0.045), (2e-4, 2e-4, 2e-5)
        finger.add_joint(
            name=name,
            type=mujoco.mjtJoint.mjJNT_SLIDE,
            axis=(0, side, 0),
            range=(0.0, gripper.max_half_opening),
            limited=mujoco.mjtLimited.mjLIMITED_TRUE,
            armature=0.2,
            damping=[5.0, 0.0, 0.0],
        )
        length = tip - root
        finger.add_geom(
            type=box,
            size=[gripper.finger_width / 2, blade / 2, length / 2],
            pos=[0, side * (pad_thickness + blade / 2), length / 2],
            rgba=GRIPPER_RGBA,
            **solid,
        )
        finger.add_geom(
            name=f"{name}_pad",
            type=box,
            size=[gripper.finger_width / 2, pad_thickness / 2, pad_length / 2],
            pos=[0, side * pad_thickness / 2, length - pad_length / 2],
            rgba=PAD_RGBA,
            friction=PAD_FRICTION,
            condim=4,
            priority=1,
            solref=GRIP_SOLREF,
            solimp=GRIP_SOLIMP,
            **solid,
        )
    _couple_jaws(spec, gripper)


def _couple_jaws(spec: mujoco.MjSpec, gripper: Gripper) -> None:
    """Both fingers move alike, driven by one actuator whose force they share."""
    spec.add_equality(
        type=mujoco.mjtEq.mjEQ_JOINT,
        name1=FINGERS[0],
        name2=FINGERS[1],
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        data=[0.0, 1.0, *([0.0] * 10)],
        solref=GRIP_SOLREF,
    )
    tendon = spec.add_tendon(name="jaws")
    for name in FINGERS:
        tendon.wrap_joint(name, 0.5)
    jaws = spec.add_actuator(name="jaws", target="jaws", trntype=mujoco.mjtTrn.mjTRN_TENDON)
    jaws.set_to_position(kp=_JAW_KP, kv=_JAW_KV)
    jaws.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
    jaws.forcerange = (-2 * gripper.grip_force, 2 * gripper.grip_force)


def gripper_base_height(gripper: Gripper) -> float:
    """Where the fingers begin, m from the flange along z: adapter (30 mm) and body."""
    return 0.030 + gripper.body_height


def _add_camera(flange: mujoco.MjsBody, camera: Camera, X_FC: Pose) -> None:
    flange.add_camera(name="wrist", **pinhole(camera, X_FC))
    for size, pos, rgba in (
        ([0.025, 0.045, 0.014], [0.075, 0.0, 0.020], GRIPPER_RGBA),
        ([0.012, 0.012, 0.006], [0.090, 0.0, 0.030], (0.02, 0.02, 0.03, 1.0)),
    ):
        flange.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX, size=size, pos=pos, rgba=rgba, contype=0, conaffinity=0, density=0.0
        )


def _exclude_neighbours(spec: mujoco.MjSpec) -> None:
    """Links that share a joint touch by construction; every other pair of links may collide."""
    chain = ["base", *(link.name for link in _LINKS), "flange"]
    for first, second in pairwise(chain):
        spec.add_exclude(bodyname1=first, bodyname2=second)
    spec.add_exclude(bodyname1=FINGERS[0], bodyname2=FINGERS[1])  # they meet when the gripper closes on nothing
