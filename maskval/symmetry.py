"""Poses that an object looks alike in: discrete symmetries and turns about an axis, as BOP lists them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
import scipy
from numpy.typing import NDArray

from maskval.errors import InvalidPoseError
from maskval.geometry import Pose, PosesLike, as_poses
from maskval.inputs.arrays import check_number, floats
from maskval.mesh import Mesh

# BOP's evaluation turns an object so that its farthest vertex moves by at most 1 % of the diameter per step.
MAXIMUM_STEP = 0.01
_SAME_VERTEX = 1e-6  # of the diameter: rounding, not shape


@dataclass(frozen=True, slots=True, eq=False)
class SymmetryAxis:
    """An axis about which every turn leaves the object as it looks.

    Args:
        axis_O: Direction, (3,), not zero; it is normalised.
        offset_O: A point on the axis, (3,), metres.
    """

    axis_O: NDArray[np.float64]
    offset_O: NDArray[np.float64]

    def __post_init__(self) -> None:
        for name in ("axis_O", "offset_O"):
            vector = floats(name, getattr(self, name), InvalidPoseError)
            if vector.shape != (3,) or not np.isfinite(vector).all():
                raise InvalidPoseError(f"{name} must be three finite numbers, but is {vector}")
            if name == "axis_O":
                length = float(np.linalg.norm(vector))
                if length == 0:
                    raise InvalidPoseError("axis_O must have a direction, but is zero")
                vector /= length
            vector.setflags(write=False)
            object.__setattr__(self, name, vector)

    def turn(self, angle: float) -> Pose:
        """The pose of the object turned about the axis, in its own frame.

        Args:
            angle: Radians.
        """
        turn = Pose.from_rotvec(angle * self.axis_O)
        return Pose(turn.rotation, self.offset_O - turn.rotation @ self.offset_O)


def right_angle_symmetries(mesh: Mesh) -> tuple[Pose, ...]:
    """The turns by multiples of 90° about the middle of the mesh's box that map its vertices onto one another.

    The identity is not among them, nor is any other turn, nor a symmetry of the surface that its vertices do not have.

    Args:
        mesh: The object.
    """
    middle = mesh.center
    points = mesh.vertices - middle
    tree = scipy.spatial.cKDTree(points)
    found = []
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            R = np.eye(3)[list(order)] * signs + 0.0  # no −0
            if np.linalg.det(R) < 0 or np.array_equal(R, np.eye(3)):
                continue
            distances, _ = tree.query(points @ R.T)
            if distances.max() <= _SAME_VERTEX * mesh.diameter:
                found.append(Pose(R, middle - R @ middle))
    return tuple(found)


def symmetry_poses(
    discrete: PosesLike = (), axes: Sequence[SymmetryAxis] = (), *, maximum_step: float = MAXIMUM_STEP
) -> tuple[Pose, ...]:
    """BOP's set of poses that an object looks alike in, in its own frame; the identity is the first.

    Args:
        discrete: The discrete symmetries without the identity.
        axes: The axes of continuous symmetry, each sampled in ceil(π / maximum_step) turns.
        maximum_step: Greatest way of the farthest vertex in one turn, as a share of the diameter, in [0.0001, π].
    """
    check_number("maximum_step", maximum_step, InvalidPoseError, least=1e-4, most=math.pi)
    steps = math.ceil(math.pi / maximum_step)
    turns = [axis.turn(2 * math.pi * i / steps) for axis in axes for i in range(steps)] or [Pose.identity()]
    return tuple(turn @ fixed for fixed in (Pose.identity(), *as_poses(discrete)) for turn in turns)
