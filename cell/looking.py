"""Where the camera goes to look at a part again."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cell.motion import Motion, Unreachable
from cell.records import Seen
from cell.search import refinement_view
from maskval import Pose


@dataclass(frozen=True, slots=True, eq=False)
class SecondLook:
    """Plans second looks, and learns from them.

    Attributes:
        motion: of the arm that carries the camera.
        center_O: the part's middle, (3,) m in O.
        distance: m from there to the camera, where the policy asks for no view of its own.
        settle_time: s between the camera's arrival and the picture.
    """

    motion: Motion
    center_O: NDArray[np.float64]
    distance: float
    settle_time: float

    def view(self, seen: Seen) -> Pose:
        """X_BC of the view that the policy asks for, or of the one straight above the part.

        Where the belt moves, both are carried along with the part, to the earliest time at which the camera meets it.

        Raises:
            Unreachable: the camera never meets the part.
        """
        X_BC, seen_at = seen.decision.X_BC, seen.observation.frame.time
        if X_BC is None:
            X_BC = refinement_view(seen.X_BO_est, self.center_O, self.distance)
        motion = self.motion

        def view_at(time: float) -> Pose:
            return motion.carried(X_BC, seen_at, time + self.settle_time)

        if not motion.belt_moves:
            return X_BC
        meeting = motion.meeting_time(lambda time: motion.joints_for_camera(view_at(time)))
        if meeting is None:
            raise Unreachable("the part will be out of the camera's reach")
        return view_at(meeting)

    def tells_speed(self, before: Seen, seen: Seen) -> bool:
        """Learns the belt's speed from two looks at a part, as far as they belong together; returns whether they do."""
        motion = self.motion
        if motion.belt is None:
            return False
        p_BO, p_BO_before = (look.X_BO_est.apply(self.center_O) for look in (seen, before))
        duration = seen.observation.frame.time - before.observation.frame.time
        return motion.belt.learn(p_BO - p_BO_before, motion.v_B / np.linalg.norm(motion.v_B), duration)
