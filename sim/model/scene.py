"""Builds the cell as a MuJoCo model: layout and parts in, compiled model out."""

from collections.abc import Sequence

import mujoco

from cell.layout import Layout
from sim.model.apply_conditions import disturb
from sim.model.bodies import add_grips, add_part, add_part_assets, part_body, set_physics
from sim.model.clutter import add_distractor, distractor_body, distractors_of
from sim.model.conditions import Conditions
from sim.model.fixtures import add_furniture
from sim.model.parts import PartModel
from sim.model.robot import TIME_STEP, add_robot

ROBOT = "shoulder"  # root of everything that moves with the robot
SURFACE_VELOCITY_Y = 1  # index into a geom's six surface velocities

_FORCE_OF_STRONGEST_CONTACT = (2, 2, 1)  # data: force; reduce: by largest force; one slot


def robot_touches(other: str) -> str:
    """Name of the sensor for the strongest contact between the robot and `other`."""
    return f"robot_{other}"


def container_presses(index: int) -> str:
    """Name of the sensor for the strongest contact between part `index` and the container."""
    return f"container_part_{index}"


def build_scene(
    layout: Layout, models: Sequence[PartModel], slot_size: tuple[float, float], conditions: Conditions
) -> mujoco.MjModel:
    """The compiled cell with one free body per entry of `models`; equal entries share their meshes.

    Args:
        layout: the cell.
        models: a part model per part on the belt.
        slot_size: inner size of the container's slots along W's x and y, m.
        conditions: what differs from the layout that the controller believes in.
    """
    compiled = describe_scene(layout, models, slot_size, conditions).compile()
    disturb(compiled, conditions)
    return compiled


def describe_scene(
    layout: Layout, models: Sequence[PartModel], slot_size: tuple[float, float], conditions: Conditions
) -> mujoco.MjSpec:
    """The same before it is compiled; light, reflections and friction are not disturbed yet."""
    spec = mujoco.MjSpec()
    spec.modelname = "graspcell"
    spec.compiler.degree = False
    set_physics(spec, TIME_STEP)
    _set_visuals(spec)
    add_furniture(spec, layout, slot_size)
    camera_true, X_FC_true = conditions.camera_true(layout.camera), conditions.X_FC_true(layout.X_FC)
    add_robot(spec, layout.gripper, camera_true, X_FC_true)
    for model in {model.part.name: model for model in models}.values():
        add_part_assets(spec, model)
    for index, model in enumerate(models):
        add_part(spec, index, model, conditions.mass)
        add_grips(spec, index, model)
    distractors = distractors_of(conditions.clutter)
    for index, thing in enumerate(distractors):
        add_distractor(spec, index, thing)
    _add_sensors(spec, len(models), len(distractors))
    return spec


def _set_visuals(spec: mujoco.MjSpec) -> None:
    spec.visual.quality.offsamples = 0  # without multisampling masks and depths are exact
    spec.visual.quality.shadowsize = 1  # masks and depths have none; MuJoCo's own map takes 64 MB of each process
    getattr(spec.visual, "global").offwidth = 1920
    getattr(spec.visual, "global").offheight = 1080
    spec.visual.map.znear = 0.005
    spec.visual.map.zfar = 20.0
    spec.stat.extent, spec.stat.center = 2.0, (0.4, -0.3, 0.1)
    headlight = spec.visual.headlight
    headlight.ambient, headlight.diffuse, headlight.specular = [0.35] * 3, [0.35] * 3, [0.2] * 3


def _add_sensors(spec: mujoco.MjSpec, parts: int, distractors: int) -> None:
    """Contact forces by pair of interest, in newtons: no Python loop over contacts is needed at run time."""
    robot = {"objtype": mujoco.mjtObj.mjOBJ_XBODY, "objname": ROBOT}
    for other in ("belt", "container", "base", *(part_body(index) for index in range(parts))):
        _add_contact_sensor(spec, robot_touches(other), robot, {"reftype": mujoco.mjtObj.mjOBJ_BODY, "refname": other})
    _add_contact_sensor(spec, robot_touches("itself"), robot, {"reftype": mujoco.mjtObj.mjOBJ_XBODY, "refname": ROBOT})
    for index in range(parts):
        _add_contact_sensor(
            spec,
            container_presses(index),
            {"objtype": mujoco.mjtObj.mjOBJ_BODY, "objname": part_body(index)},
            {"reftype": mujoco.mjtObj.mjOBJ_BODY, "refname": "container"},
        )
    for body in map(distractor_body, range(distractors)):
        _add_contact_sensor(spec, robot_touches(body), robot, {"reftype": mujoco.mjtObj.mjOBJ_BODY, "refname": body})


def _add_contact_sensor(spec: mujoco.MjSpec, name: str, one: dict[str, object], other: dict[str, object]) -> None:
    sensor = spec.add_sensor(name=name, type=mujoco.mjtSensor.mjSENS_CONTACT, **one, **other)
    sensor.intprm = [*_FORCE_OF_STRONGEST_CONTACT] if len(sensor.intprm) == 3 else _FORCE_OF_STRONGEST_CONTACT
