"""Where everything stands in the cell: what an integrator would measure with a tape.

Frames: `W` world (z up, origin at the middle of the robot's foot), `B` robot base, `F` flange, `T` tool centre point,
`C` camera, `V` conveyor (origin in the middle of the belt's surface, y along the belt), `K` one slot of the container
(origin in the middle of its floor). Lengths in metres.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from maskval import Camera, Pose


def default_camera() -> Camera:
    """The wrist camera: 640 × 480, 56° wide; OpenGL's pixel centres put the axis at exactly half of the image."""
    return Camera(fx=600.0, fy=600.0, cx=320.0, cy=240.0, width=640, height=480)


def default_camera_pose() -> Pose:
    """X_FC: beside the gripper, looking along the tool, the image's width along the jaws' closing direction."""
    return Pose(
        rotation=np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
        translation=np.array([0.10, 0.0, 0.04]),
    )


@dataclass(frozen=True)
class Belt:
    """The conveyor belt: a flat top of `width` (W's x) by `length` (W's y), and what lies upstream of it.

    Where it moves, it carries parts along −y, towards the container's end, past the arm.
    """

    center_x: float = 0.68
    length: float = 1.9
    width: float = 0.40
    top_z: float = -0.05
    loading_length: float = 1.40  # the stretch in the middle that the arm reaches, and that parts are put on
    speed: float = 0.0  # m/s along −y
    upstream: float = 0.0  # m of belt beyond the end at +length / 2: where parts come from, out of the arm's reach

    @property
    def v_W(self) -> np.ndarray:
        """Velocity of the belt's surface, (3,) m/s."""
        return np.array([0.0, -self.speed, 0.0])


@dataclass(frozen=True)
class Container:
    """The sequence container: `columns` × `rows` open slots, numbered row by row from least x and most y."""

    center_x: float = 0.05
    center_y: float = -0.82
    floor_z: float = -0.10
    wall_height: float = 0.040
    wall_thickness: float = 0.008
    columns: int = 2
    rows: int = 4

    def slot_center(self, slot: int, slot_size: tuple[float, float]) -> np.ndarray:
        """p_WK of a slot, (3,) m; `slot_size` is the inner size along W's x and y."""
        if not 0 <= slot < self.columns * self.rows:
            raise IndexError(f"slot must lie in 0..{self.columns * self.rows - 1}, got {slot}")
        row, column = divmod(slot, self.columns)
        pitch_x, pitch_y = (size + self.wall_thickness for size in slot_size)
        x = self.center_x + (column - (self.columns - 1) / 2) * pitch_x
        y = self.center_y - (row - (self.rows - 1) / 2) * pitch_y
        return np.array([x, y, self.floor_z])


@dataclass(frozen=True)
class Gripper:
    """A parallel gripper with two coupled jaws; T lies between the pads, z forward, y along the closing direction."""

    tcp_from_flange: float = 0.190
    tip_below_tcp: float = 0.015
    max_half_opening: float = 0.055
    finger_thickness: float = 0.021  # pad included, along y
    finger_width: float = 0.021  # along x
    body_length: float = 0.150  # along y
    body_width: float = 0.064  # along x
    body_height: float = 0.080
    grip_force: float = 120.0  # N per finger

    @property
    def X_FT(self) -> Pose:
        """The tool centre point seen from the flange."""
        return Pose.from_translation(np.array([0.0, 0.0, self.tcp_from_flange]))


@dataclass(frozen=True)
class Layout:
    """The whole cell; `X_FC` is where the controller believes the camera to be."""

    belt: Belt = field(default_factory=Belt)
    container: Container = field(default_factory=Container)
    gripper: Gripper = field(default_factory=Gripper)
    camera: Camera = field(default_factory=default_camera)
    X_FC: Pose = field(default_factory=default_camera_pose)
    floor_z: float = -0.85

    @cached_property
    def X_WB(self) -> Pose:
        """Robot base: B is the base of the DH table, half a turn about z from W."""
        return Pose(rotation=np.diag([-1.0, -1.0, 1.0]), translation=np.zeros(3))
