"""From tool velocities to joint motions, step by step; the jaws show when an attempt is over."""

import numpy as np
from numpy.typing import NDArray

from cell.arm.trajectory import JointTrajectory
from cell.arm.ur10 import SPEED_LIMITS, forward, inverse_on_branch
from cell.attempt import CLOSING_TIME, GRIP, RELEASE_TIME
from cell.interfaces import Contact, Station, Touch
from cell.layout import Layout
from cell.motion import EVERYTHING, HOLDING
from maskval import Pose

Array = NDArray[np.float64]

STEP_TIME = 0.05  # s, 20 Hz
MAX_SPEED = 0.25  # m/s along each axis of B: PolyScope's default for lines
MAX_TURN = 1.0  # rad/s about each axis of B
PRESSING = 0.001  # m by which the jaws are sent further together than they are while they close or hold
VERDICT_TIME = 0.5  # s after letting go, when a part has come to rest


class VelocityController:
    """Moves a station's tool at wanted velocities, step by step."""

    def __init__(self, station: Station, layout: Layout) -> None:
        self._station, self._gripper = station, layout.gripper
        self._q, self._qd = station.q, np.zeros(6)
        self._gripping_since: float | None = None
        self._gripped_until = -np.inf  # when the jaws last pressed
        self._has_gripped = False

    @property
    def X_BT(self) -> Pose:
        """Where the tool is, by the measured joints."""
        return forward(self._station.q) @ self._gripper.X_FT

    def move(self, action: Array) -> tuple[bool, Contact | None]:
        """Ramps to a velocity within one step.

        Args:
            action: shares in [−1, 1] of the largest linear (3) and angular (3) speeds along B's axes, and of the jaws'
                range from gripping (−1) to open (1), (7,).

        Returns:
            Whether the arm stands still because it cannot go there, and the contact that stopped it.
        """
        jaws = GRIP + (action[6] + 1.0) / 2.0 * (self._gripper.max_half_opening - GRIP)
        self._station.command_jaws(jaws)
        self._notice(jaws)
        qd = self._joint_speeds(action[:3] * MAX_SPEED, action[3:6] * MAX_TURN)
        goal, step = np.zeros(6) if qd is None else qd, self._station.time_step
        t = np.arange(1, round(STEP_TIME / step) + 1)[:, np.newaxis] * step
        acceleration = (goal - self._qd) / STEP_TIME
        positions = self._q + self._qd * t + acceleration * t**2 / 2.0
        trajectory = JointTrajectory(step, positions, self._qd + acceleration * t)
        contact = self._station.follow(trajectory, self._watch())
        self._q, self._qd = positions[-1], goal
        return qd is None, contact

    @property
    def has_let_go(self) -> bool:
        """Whether the jaws had closed, are open again, and what they held has come to rest: an attempt is over."""
        return self._has_gripped and self._station.time >= self._gripped_until + VERDICT_TIME

    def forget(self) -> None:
        """Begins the next attempt."""
        self._has_gripped = False

    def _joint_speeds(self, v_B: Array, w_B: Array) -> Array | None:
        """Joint speeds for this tool velocity, (6,) rad/s, scaled down to the arm's limits; None out of reach."""
        X_BT = forward(self._q) @ self._gripper.X_FT
        rotation = Pose.from_rotvec(w_B * STEP_TIME).rotation @ X_BT.rotation
        moved = Pose(rotation, X_BT.translation + v_B * STEP_TIME)
        q = inverse_on_branch(moved @ self._gripper.X_FT.inverse(), self._q)
        if q is None:
            return None
        qd = (q - self._q) / STEP_TIME
        slowed: Array = qd / max(1.0, float(np.abs(qd / SPEED_LIMITS).max()))
        return slowed

    def _watch(self) -> frozenset[Touch]:
        """While and just after the jaws close, parts may be touched, but none may be pressed against the container."""
        gripping = self._station.time < self._gripped_until + RELEASE_TIME
        return HOLDING | {Touch.PRESSED} if gripping else EVERYTHING

    def _notice(self, jaws: float) -> None:
        """Notes whether the jaws close or hold."""
        now = self._station.time
        if jaws >= self._station.jaw_half_opening - PRESSING:
            self._gripping_since = None
            return
        self._gripping_since = now if self._gripping_since is None else self._gripping_since
        self._gripped_until = now
        self._has_gripped |= now - self._gripping_since >= CLOSING_TIME
