"""Moves the robot of a station: joint moves to tool or camera poses, straight lines, and back where it came from."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cell.interfaces import Contact, Station, Touch
from cell.layout import Layout
from cell.speed import SpeedPreset
from cell.trajectory import joint_move, line_move
from cell.ur10 import forward, inverse_on_branch
from maskval import Pose

Array = NDArray[np.float64]

EVERYTHING = frozenset(Touch) - {Touch.PRESSED}
HOLDING = EVERYTHING - {Touch.PART}  # the part in the jaws touches them


class Unreachable(Exception):  # noqa: N818  # an expected end of an attempt, caught in the cycle, not an error
    """The pose has no joint angles on the arm's branch, or the line to it leaves them."""


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Turns poses of the tool into motions of the station's arm."""

    station: Station
    layout: Layout
    speed: SpeedPreset

    def joints_for(self, X_BT: Pose) -> Array:
        """Joint angles that bring the tool there, near to the present ones.

        Raises:
            Unreachable: there are none.
        """
        q = inverse_on_branch(X_BT @ self.layout.gripper.X_FT.inverse(), self.station.q)
        if q is None:
            raise Unreachable(f"no joint angles for the tool at {X_BT.translation.round(3)} m in the base")
        return q

    def to_tool(self, X_BT: Pose, watch: frozenset[Touch] = EVERYTHING) -> Contact | None:
        """A joint move that ends with the tool at X_BT."""
        return self.to_joints(self.joints_for(X_BT), watch)

    def joints_for_camera(self, X_BC: Pose) -> Array:
        """Joint angles that bring the camera there, near to the present ones.

        Raises:
            Unreachable: there are none.
        """
        return self.joints_for(X_BC @ self.layout.X_FC.inverse() @ self.layout.gripper.X_FT)

    def to_camera(self, X_BC: Pose) -> Contact | None:
        """A joint move that ends with the camera at X_BC."""
        return self.to_joints(self.joints_for_camera(X_BC))

    def to_joints(self, q: Array, watch: frozenset[Touch] = EVERYTHING) -> Contact | None:
        """A joint move."""
        return self.station.follow(joint_move(self.station.q, q, self.speed, self.station.time_step), watch)

    def line_to(self, X_BT: Pose, watch: frozenset[Touch] = EVERYTHING) -> Contact | None:
        """A straight line of the tool from where it is.

        Raises:
            Unreachable: the arm cannot follow the line.
        """
        q = self.station.q
        X_TF = self.layout.gripper.X_FT.inverse()
        trajectory = line_move(forward(q), X_BT @ X_TF, q, self.speed, self.station.time_step)
        if trajectory is None:
            raise Unreachable(f"no straight line to the tool at {X_BT.translation.round(3)} m in the base")
        return self.station.follow(trajectory, watch)

    @property
    def X_BT(self) -> Pose:
        """Where the tool is now."""
        return forward(self.station.q) @ self.layout.gripper.X_FT
