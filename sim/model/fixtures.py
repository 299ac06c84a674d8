"""What stands around the robot: floor, belt, the tray at a moving belt's end, and the container."""

import mujoco
import numpy as np

from cell.layout import Belt, Container, Layout
from sim.model.apply_conditions import BELT_MATERIAL
from sim.model.bodies import FURNITURE_FRICTION

BELT_RGBA = (0.38, 0.47, 0.42, 1.0)
FRAME_RGBA = (0.62, 0.64, 0.66, 1.0)
FLOOR_RGBA = (0.74, 0.75, 0.76, 1.0)
CONTAINER_RGBA = (0.20, 0.36, 0.60, 1.0)
FLOOR_MATERIAL = "floor"
TRAY_MARGIN = 0.05  # m by which the tray is wider than the belt, to either side

_BOX = mujoco.mjtGeom.mjGEOM_BOX


def add_furniture(spec: mujoco.MjSpec, layout: Layout, slot_size: tuple[float, float]) -> None:
    """Adds it to `spec`.

    Args:
        spec: the cell under construction.
        layout: where everything stands.
        slot_size: inner size of the container's slots along W's x and y, m.
    """
    _add_surroundings(spec, layout)
    _add_belt(spec, layout.belt, layout.floor_z)
    if layout.belt.speed:
        _add_tray(spec, layout.belt)
    _add_container(spec, layout.container, slot_size, layout.floor_z)


def _add_surroundings(spec: mujoco.MjSpec, layout: Layout) -> None:
    spec.add_material(name=FLOOR_MATERIAL, rgba=FLOOR_RGBA, reflectance=0.0)
    body = spec.worldbody.add_body(name="floor", pos=(0, 0, layout.floor_z))
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE, size=[4, 4, 0.1], material=FLOOR_MATERIAL, friction=FURNITURE_FRICTION
    )
    body.add_geom(
        type=_BOX, size=[0.13, 0.13, -layout.floor_z / 2], pos=[0, 0, -layout.floor_z / 2], rgba=[0.25, 0.27, 0.30, 1]
    )


def _add_belt(spec: mujoco.MjSpec, belt: Belt, floor_z: float) -> None:
    body = spec.worldbody.add_body(name="belt", pos=(belt.center_x, belt.upstream / 2, belt.top_z))
    # Specular and shininess of a body without a material; its reflectance is a matter of the conditions.
    spec.add_material(name=BELT_MATERIAL, rgba=BELT_RGBA, specular=0.5, shininess=0.5, reflectance=0.0)
    half_x, half_y, thickness = belt.width / 2, (belt.length + belt.upstream) / 2, 0.03
    solid = {"type": _BOX, "friction": FURNITURE_FRICTION}
    body.add_geom(
        name="belt",
        size=[half_x, half_y, thickness / 2],
        pos=[0, 0, -thickness / 2],
        material=BELT_MATERIAL,
        # Declared as moving so that the engine looks at it at all; sim.runtime.world sets the speed, zero during a run.
        surfacevel=[0, 1e-9, 0, 0, 0, 0],
        **solid,
    )
    for side in (-1, 1):
        rail_x = side * (half_x + 0.015)
        body.add_geom(size=[0.014, half_y + 0.03, 0.045], pos=[rail_x, 0, -0.033], rgba=FRAME_RGBA, **solid)
        end_y = side * (half_y + 0.03)
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            size=[0.028, half_x, 0],
            pos=[0, side * half_y, -0.031],
            quat=[np.sqrt(0.5), 0, np.sqrt(0.5), 0],
            rgba=BELT_RGBA,
            contype=0,
            conaffinity=0,
        )
        for leg_x in (-half_x, half_x):
            height = belt.top_z - floor_z
            body.add_geom(
                size=[0.02, 0.02, height / 2],
                pos=[leg_x, 0.8 * end_y, -height / 2 - 0.02],
                rgba=FRAME_RGBA,
                contype=0,
                conaffinity=0,
                type=_BOX,
            )


def _add_tray(spec: mujoco.MjSpec, belt: Belt) -> None:
    """What parts fall into that the belt carries over its end, 0.10 m below it."""
    half_x, half_y, half_z, wall = belt.width / 2 + TRAY_MARGIN, 0.25, 0.06, 0.01
    body = spec.worldbody.add_body(
        name="tray", pos=(belt.center_x, -belt.length / 2 - 0.04 - half_y, belt.top_z - 0.10 - 2 * half_z)
    )
    solid = {"type": _BOX, "friction": FURNITURE_FRICTION, "rgba": FRAME_RGBA}
    body.add_geom(size=[half_x, half_y, wall], pos=[0, 0, -wall], **solid)
    for side in (-1, 1):
        body.add_geom(size=[wall, half_y, half_z], pos=[side * half_x, 0, half_z], **solid)
        body.add_geom(size=[half_x, wall, half_z], pos=[0, side * half_y, half_z], **solid)


def _add_container(spec: mujoco.MjSpec, container: Container, slot_size: tuple[float, float], floor_z: float) -> None:
    body = spec.worldbody.add_body(name="container", pos=(container.center_x, container.center_y, container.floor_z))
    wall, height = container.wall_thickness, container.wall_height
    length_x = container.columns * (slot_size[0] + wall) + wall
    length_y = container.rows * (slot_size[1] + wall) + wall
    solid = {"type": _BOX, "rgba": CONTAINER_RGBA, "friction": FURNITURE_FRICTION}
    body.add_geom(size=[length_x / 2, length_y / 2, 0.005], pos=[0, 0, -0.005], **solid)
    for column in range(container.columns + 1):
        x = (column - container.columns / 2) * (slot_size[0] + wall)
        body.add_geom(size=[wall / 2, length_y / 2, height / 2], pos=[x, 0, height / 2], **solid)
    for row in range(container.rows + 1):
        y = (row - container.rows / 2) * (slot_size[1] + wall)
        body.add_geom(size=[length_x / 2, wall / 2, height / 2], pos=[0, y, height / 2], **solid)
    table = container.floor_z - 0.010 - floor_z
    body.add_geom(
        type=_BOX,
        size=[length_x / 2, length_y / 2, table / 2],
        pos=[0, 0, -0.010 - table / 2],
        rgba=FRAME_RGBA,
        friction=FURNITURE_FRICTION,
    )
