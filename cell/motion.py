"""Moves the robot of a station: joint moves to tool or camera poses, straight lines, and back where it came from."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cell.arm.conveyor_tracking import RAMP_TIME, BeltSpeed, Way, at_speed, carried, joining, leaving, track
from cell.arm.limits import SpeedPreset
from cell.arm.trajectory import joint_move, line_move, line_poses
from cell.arm.ur10 import forward, inverse_on_branch
from cell.interfaces import Contact, Station, Touch
from cell.layout import Layout
from maskval import Pose

Array = NDArray[np.float64]

EVERYTHING = frozenset(Touch) - {Touch.PRESSED}
LONGEST_WAIT = 10.0  # s for something to come along the belt into reach: 1 m and more
WAIT_STEP = 0.1  # s between the times that are tried

HOLDING = EVERYTHING - {Touch.PART}  # the part in the jaws touches them


class Unreachable(Exception):  # noqa: N818  # an expected end of an attempt, caught in the cycle, not an error
    """The pose has no joint angles on the arm's branch, or the line to it leaves them."""


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Turns poses of the tool into motions of the station's arm.

    Attributes:
        station: whose arm.
        layout: where everything stands.
        speed: limits of the arm's motions.
        belt: how fast the belt is, as far as that has been learned; None for the layout's speed.
    """

    station: Station
    layout: Layout
    speed: SpeedPreset
    belt: BeltSpeed | None = None

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

    def line_to(self, X_BT: Pose, watch: frozenset[Touch] = EVERYTHING, tracking: bool = False) -> Contact | None:
        """A straight line of the tool from where it is.

        Args:
            X_BT: its end; if the tool tracks a moving belt, where that is now.
            watch: contacts that stop it.
            tracking: whether the tool moves with the belt, if the belt moves.

        Raises:
            Unreachable: the arm cannot follow the line.
        """
        q, step = self.station.q, self.station.time_step
        X_BF = X_BT @ self.layout.gripper.X_FT.inverse()
        if tracking and self.belt_moves:
            return self._track(line_poses(forward(q), X_BF, self.speed, step), at_speed, watch)
        trajectory = line_move(forward(q), X_BF, q, self.speed, step)
        if trajectory is None:
            raise Unreachable(f"no straight line to the tool at {X_BT.translation.round(3)} m in the base")
        return self.station.follow(trajectory, watch)

    @property
    def belt_moves(self) -> bool:
        """Whether the belt carries parts along."""
        return self.layout.belt.speed > 0.0

    def carried(self, X_BA: Pose, since: float, until: float | None = None) -> Pose:
        """Where something on the belt is at a time (s; now without one), given where it was at another."""
        until = self.station.time if until is None else until
        return carried(X_BA, self.v_B, until - since)

    def meeting_time(self, q_at: Callable[[float], Array]) -> float | None:
        """The earliest time, s, at which the arm can have the joint angles that are wanted then; None if it never can.

        Args:
            q_at: the joint angles that are wanted at a time, s; raises Unreachable where there are none.
        """
        now, q_now = self.station.time, self.station.q
        for wait in np.arange(0.0, LONGEST_WAIT, WAIT_STEP):
            try:
                q = q_at(now + wait)
            except Unreachable:
                continue
            if joint_move(q_now, q, self.speed, self.station.time_step).duration_s <= wait:
                return float(now + wait)
        return None

    def join_belt(self, start: float, watch: frozenset[Touch] = EVERYTHING) -> Contact | None:
        """Waits until a time (s) and then comes to the belt's speed; nothing on a belt that stands still."""
        if not self.belt_moves:
            return None
        contact = self.station.wait(max(start - self.station.time, 0.0), watch)
        return contact or self._track(self._standing(RAMP_TIME), joining, watch)

    def leave_belt(self, watch: frozenset[Touch] = EVERYTHING) -> Contact | None:
        """Comes to rest from the belt's speed; nothing on a belt that stands still."""
        return self._track(self._standing(RAMP_TIME), leaving, watch) if self.belt_moves else None

    def wait_on_belt(self, duration: float, watch: frozenset[Touch]) -> Contact | None:
        """Stands still as seen from the belt for a time, s."""
        if not self.belt_moves:
            return self.station.wait(duration, watch)
        return self._track(self._standing(duration), at_speed, watch)

    def _standing(self, duration: float) -> Array:
        return np.repeat(forward(self.station.q).matrix[np.newaxis], round(duration / self.station.time_step), axis=0)

    def _track(self, X_BF: Array, way: Way, watch: frozenset[Touch]) -> Contact | None:
        trajectory = track(X_BF, self.station.q, self.v_B, way, self.station.time_step)
        if trajectory is None:
            raise Unreachable(f"the arm cannot track the belt from {X_BF[0, :3, 3].round(3)} m in the base")
        return self.station.follow(trajectory, watch)

    @property
    def v_B(self) -> Array:
        """The belt's velocity as it is believed now, (3,) m/s."""
        v_B: Array = self.layout.X_WB.rotation.T @ replace(self.layout.belt, speed=self.belt_speed).v_W
        return v_B

    @property
    def belt_speed(self) -> float:
        """The belt's speed as it is believed now, m/s."""
        return self.layout.belt.speed if self.belt is None else self.belt.speed

    @property
    def X_BT(self) -> Pose:
        """Where the tool is now."""
        return forward(self.station.q) @ self.layout.gripper.X_FT
