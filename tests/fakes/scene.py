"""A small cell and a brick in it."""

from collections.abc import Sequence

import numpy as np

from cell.layout import Belt, Layout
from cell.part import Grasp, Part
from maskval import Camera, Mesh, Pose


def small_layout(belt_speed: float = 0.0) -> Layout:
    """The cell with 20 times fewer pixels per side, and the same field of view."""
    camera = Camera(fx=30.0, fy=30.0, cx=16.0, cy=12.0, width=32, height=24)
    return Layout(belt=Belt(speed=belt_speed), camera=camera)


def box_mesh(low: Sequence[float], high: Sequence[float]) -> Mesh:
    """A closed box between two corners in frame O, m."""
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return Mesh(corners, np.array([face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]))


def grasp(name: str, p_OT: Sequence[float], approach: Sequence[float], closing: Sequence[float]) -> Grasp:
    """A grasp at a point, from a direction, closing along another, all in frame O."""
    z, y = np.array(approach, dtype=np.float64), np.array(closing, dtype=np.float64)
    return Grasp(name, Pose(np.column_stack([np.cross(y, z), y, z]), np.array(p_OT)), half_opening=0.045)


def brick() -> Part:
    """A box of 120 × 50 × 40 mm, O in none of its middles, with one grasp for each of the four sides it can lie on."""
    middle = (0.01, 0.005, 0.02)
    return Part(
        name="brick",
        mesh=box_mesh((-0.05, -0.02, 0.0), (0.07, 0.03, 0.04)),
        grasps=(
            grasp("from above", middle, (0, 0, -1), (0, 1, 0)),
            grasp("from below", middle, (0, 0, 1), (0, 1, 0)),
            grasp("from left", middle, (0, -1, 0), (0, 0, 1)),
            grasp("from right", middle, (0, 1, 0), (0, 0, 1)),
        ),
        slot_size=(0.20, 0.13),
    )


def turned(roll_deg: float = 0.0, pitch_deg: float = 0.0, yaw_deg: float = 0.0) -> Pose:
    """Rotated about the fixed x, then y, then z axis."""
    angles = np.radians([roll_deg, pitch_deg, yaw_deg])
    roll, pitch, yaw = (Pose.from_rotvec(axis * angle) for axis, angle in zip(np.eye(3), angles, strict=True))
    return yaw @ pitch @ roll


def on_belt(part: Part, layout: Layout, rotation: Pose, x_W: float = 0.68, y_W: float = 0.0) -> Pose:
    """X_BO of a part of this rotation in the world, its middle over a point, its lowest vertex on the belt."""
    vertices_W = rotation.apply(part.mesh.vertices)
    low, high = vertices_W.min(axis=0), vertices_W.max(axis=0)
    middle = (low + high) / 2
    p_WO = np.array([x_W - middle[0], y_W - middle[1], layout.belt.top_z - low[2]])
    return layout.X_WB.inverse() @ Pose(rotation.rotation, p_WO)
