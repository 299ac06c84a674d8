"""How arm, gripper and wrist camera look: rounded cans and tubes around the shapes that collide."""

from collections.abc import Iterator

import numpy as np

from cell.layout import Gripper
from sim.model.arm_geometry import ALUMINIUM, JOINT_GREY, LID_BLUE, Shell, arm_shells
from sim.model.robot import FINGERS, gripper_base_height
from sim.scenery.solids import Point, Solid, box, rod

Piece = tuple[str, str, Solid]  # body, material, surface in the body's frame

_SEAL = 0.007  # m: the black ring between housing and lid


def arm_pieces() -> Iterator[Piece]:
    """The arm's links in their colours."""
    for body, shells in arm_shells().items():
        for shell in shells:
            for material, solid in _SHAPES[shell.rgba](shell):
                yield body, material, solid


def _housing(shell: Shell) -> Iterator[tuple[str, Solid]]:
    yield "aluminium", rod(shell.start, shell.end, shell.radius, 0.006)


def _lid(shell: Shell) -> Iterator[tuple[str, Solid]]:
    """A seal, and a domed lid."""
    seam = _between(shell.start, shell.end, _SEAL)
    yield "seal", rod(shell.start, seam, 0.975 * shell.radius, 0.001)
    yield "lid", rod(seam, shell.end, shell.radius, 0.002, end_fillet=0.4 * shell.radius)


def _tube(shell: Shell) -> Iterator[tuple[str, Solid]]:
    """A tube; a long one has a collar at each end."""
    length = float(np.linalg.norm(np.subtract(shell.end, shell.start)))
    yield "aluminium", rod(shell.start, shell.end, shell.radius, 0.002)
    if length > 0.2:
        for near in (0.085, length - 0.105):
            ends = _between(shell.start, shell.end, near), _between(shell.start, shell.end, near + 0.020)
            yield "aluminium", rod(*ends, 1.06 * shell.radius, 0.004)
            yield "seal", rod(_between(*ends, 0.008), _between(*ends, 0.012), 1.065 * shell.radius, 0.001)


_SHAPES = {JOINT_GREY: _housing, LID_BLUE: _lid, ALUMINIUM: _tube}


def _between(start: Point, end: Point, distance: float) -> Point:
    """The point at a distance from the start towards the end, m."""
    way = np.subtract(end, start)
    x, y, z = start + distance * way / np.linalg.norm(way)
    return float(x), float(y), float(z)


def gripper_pieces(gripper: Gripper) -> Iterator[Piece]:
    """Adapter, body with its guide, and a carriage with finger and ribbed pad on either side."""
    root = gripper_base_height(gripper)
    adapter = root - gripper.body_height
    length, width = gripper.body_length, gripper.body_width
    yield "flange", "steel", rod((0, 0, 0), (0, 0, 0.010), 0.042)
    yield "flange", "anodised", rod((0, 0, 0.010), (0, 0, adapter), 0.038)
    yield (
        "flange",
        "anodised",
        box((0, 0, (adapter + root) / 2 - 0.004), (width, length, root - adapter - 0.008), 0.008),
    )
    yield "flange", "brushed", box((0, 0, adapter + 0.030), (width + 0.002, 0.84 * length, 0.012), 0.001, axis=1)
    for x in (-0.016, 0.016):
        yield "flange", "steel", box((x, 0, root - 0.006), (0.008, length - 0.012, 0.012), 0.002, axis=1)
    for name, side in zip(FINGERS, (1.0, -1.0), strict=True):
        for material, solid in _finger(gripper, side, gripper.tcp_from_flange + gripper.tip_below_tcp - root):
            yield name, material, solid


def _finger(gripper: Gripper, side: float, length: float) -> Iterator[tuple[str, Solid]]:
    """From the guide at z = 0 to the tip; the pad's face lies at y = 0."""
    pad, blade, width = 0.005, gripper.finger_thickness - 0.005, gripper.finger_width
    middle = side * (pad + blade / 2)
    yield "steel", box((0, middle + side * 0.004, 0.007), (0.048, blade + 0.008, 0.014), 0.003)
    yield "anodised", box((0, middle, 0.026), (0.027, blade, 0.030), 0.003)
    yield "steel", box((0, middle, (0.036 + length) / 2), (width, blade, length - 0.036), 0.003)
    yield "rubber", box((0, side * 0.0032, length - 0.020), (width, 0.0036, 0.040), 0.001)
    for rib in range(8):
        yield "rubber", box((0, side * 0.001, length - 0.003 - 0.0048 * rib), (width, 0.002, 0.003), 0.0009)


def camera_pieces() -> Iterator[Piece]:
    """The wrist camera on its bracket: a housing of two lenses, which looks along the tool."""
    yield "flange", "steel", box((0.052, 0, 0.004), (0.085, 0.050, 0.006), 0.002)
    yield "flange", "brushed", box((0.087, 0, 0.019), (0.026, 0.092, 0.026), 0.008, axis=1)
    yield "flange", "seal", box((0.087, 0, 0.0315), (0.022, 0.084, 0.003), 0.001)
    for y, radius in ((0.0, 0.008), (-0.026, 0.006), (0.026, 0.006)):
        yield "flange", "anodised", rod((0.087, y, 0.031), (0.087, y, 0.0345), radius, 0.001)
        yield "flange", "glass", rod((0.087, y, 0.032), (0.087, y, 0.0355), 0.7 * radius, 0.001)
