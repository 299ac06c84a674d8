"""Conveyor tracking: motions of the tool relative to a moving belt, and the belt's speed learned from pairs of looks.

Every path is one on a belt that stands still, carried along by the belt's own way. The arm joins and leaves the belt
with a smooth change of speed; between, its lines have the same profiles as on a belt that stands still.
"""

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cell.arm.trajectory import JointTrajectory
from cell.arm.ur10 import SPEED_LIMITS, inverse_path
from maskval import Pose

Array = NDArray[np.float64]

RAMP_TIME = 0.3  # s from rest to the belt's speed: 0.75 m/s² at 0.15 m/s, of the 2.5 m/s² that lines have
TRACKING_TIME = 2.6  # s from joining to leaving: two ramps, 0.12 m down, 0.4 s of closing, 0.16 m up

Way = Callable[[Array], Array]  # what is carried along has covered, (N,) s, from 0 to 1 s of the belt's way


def carried(X_AB: Pose, v_A: ArrayLike, duration: float) -> Pose:
    """Where a pose is after a time (s, negative for before) on something that moves at v_A, (3,) m/s."""
    velocity = np.asarray(v_A, dtype=np.float64)
    if duration == 0.0 or not velocity.any():
        return X_AB
    return Pose(X_AB.rotation, X_AB.translation + duration * velocity)


def at_speed(time: Array) -> Array:
    """On the belt all the time."""
    return time


def joining(time: Array) -> Array:
    """From rest to the belt's speed in `RAMP_TIME`, of which half is covered."""
    x = np.minimum(time / RAMP_TIME, 1.0)
    ramp = RAMP_TIME * (x**3 - x**4 / 2)  # the integral of 3 x² − 2 x³: no jump in speed nor acceleration
    return ramp + np.maximum(time - RAMP_TIME, 0.0)


def leaving(time: Array) -> Array:
    """From the belt's speed to rest in `RAMP_TIME`, of which half is covered."""
    return time - joining(time)


def track(X_BF: Array, q_start: ArrayLike, v_B: ArrayLike, way: Way, time_step_s: float) -> JointTrajectory | None:
    """Follows flange poses that are carried along; None when the arm cannot.

    Args:
        X_BF: poses on the belt if it stood still from the first one on, one per time step, (N, 4, 4), N ≥ 2.
        q_start: the joint angles now, (6,) rad, near to the first pose.
        v_B: the belt's velocity, (3,) m/s.
        way: how much of the belt's way is covered.
        time_step_s: time between samples, s; the first is reached one step from now.
    """
    time = time_step_s * np.arange(1.0, len(X_BF) + 1.0)
    carried_along = np.array(X_BF)
    carried_along[:, :3, 3] += way(time)[:, np.newaxis] * np.asarray(v_B)
    positions = inverse_path(carried_along, q_start)
    if positions is None:
        return None
    velocities = np.gradient(positions, time_step_s, axis=0)
    if (np.abs(velocities) > SPEED_LIMITS).any():
        return None
    return JointTrajectory(time_step_s, positions, velocities)


BELT_SD: Final = 0.05  # share of the belt's speed by which it may be off at first; a guess
POSE_SD: Final = 0.005  # m by which a pose that is grasped is off along each axis; more than 10 mm often fails
GATE: Final = 3.0  # standard deviations beyond which two looks show two parts, or one of them a wrong pose


class BeltSpeed:
    """A recursive least-squares estimate of one number: each pair of looks counts by how well it tells the speed.

    Attributes:
        speed: m/s.
    """

    def __init__(self, believed: float) -> None:
        self.speed = believed
        self._variance = (BELT_SD * believed) ** 2

    def learn(self, moved: NDArray[np.float64], direction: NDArray[np.float64], duration: float) -> bool:
        """Corrects the speed; returns whether it did, since looks that do not belong together are left out.

        Args:
            moved: from where a part was seen to where it was seen later, (3,) m.
            direction: the belt's, of length 1, (3,).
            duration: s between the two pictures, above 0.
        """
        variance = 2.0 * POSE_SD**2 / duration**2  # of a speed that two poses tell
        off = moved / duration - self.speed * direction
        along = float(off @ direction)
        aside = float(np.linalg.norm(off - along * direction))
        if abs(along) > GATE * np.sqrt(self._variance + variance) or aside > GATE * np.sqrt(variance):
            return False
        gain = self._variance / (self._variance + variance)
        self.speed += gain * along
        self._variance *= 1.0 - gain
        return True
