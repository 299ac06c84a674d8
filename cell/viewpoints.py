"""Viewpoints of the camera: the search run along the belt, and second looks at a part."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cell.grasping import look_at
from cell.layout import Layout
from cell.motion import Motion, Unreachable
from cell.records import DecisionRecord
from cell.rounding import rounded
from maskval import Pose

SEARCH_DISTANCE = 0.60  # m above the belt: the image's height covers the belt's width up to 60 mm over it
SEARCH_STEP = 0.20  # m along the belt
REFINE_DISTANCE = 0.40  # m from the estimated part


@dataclass(frozen=True, slots=True, eq=False)
class SearchRun:
    """Camera poses X_BC along the belt, there and back again."""

    views: tuple[Pose, ...]

    def view(self, index: int) -> Pose:
        """The index-th view of an endless run to and fro; the ends are looked at once per turn."""
        last = len(self.views) - 1
        position = index % max(2 * last, 1)
        return self.views[min(position, 2 * last - position)]


def search_run(layout: Layout) -> SearchRun:
    """Views over the loaded stretch of the belt, beginning at the end away from the container.

    On a moving belt that first view is the only one: parts come to it.
    """
    belt = layout.belt
    half_view = SEARCH_DISTANCE * layout.camera.width / (2 * layout.camera.fx)
    reach = max(belt.loading_length / 2 - half_view, 0.0)
    count = 1 if belt.speed > 0.0 else int(np.ceil(rounded(2 * reach / SEARCH_STEP))) + 1
    X_BW = layout.X_WB.inverse()
    points_W = [np.array([belt.center_x, y, belt.top_z]) for y in np.linspace(reach, -reach, count)]
    return SearchRun(tuple(look_at(X_BW.apply(point), SEARCH_DISTANCE) for point in points_W))


def refinement_view(X_BO_est: Pose, center_O: np.ndarray, distance: float = REFINE_DISTANCE) -> Pose:
    """X_BC of a nearer view, straight above the estimated middle of the part."""
    return look_at(X_BO_est.apply(center_O), distance)


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

    def view(self, seen: DecisionRecord) -> Pose:
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

    def tells_speed(self, before: DecisionRecord, seen: DecisionRecord) -> bool:
        """Learns the belt's speed from two looks at a part, as far as they belong together; returns whether they do."""
        motion = self.motion
        if motion.belt is None:
            return False
        p_BO, p_BO_before = (look.X_BO_est.apply(self.center_O) for look in (seen, before))
        duration = seen.observation.frame.time - before.observation.frame.time
        return motion.belt.learn(p_BO - p_BO_before, motion.v_B / np.linalg.norm(motion.v_B), duration)
