"""The search run: where the camera looks in turn."""

from dataclasses import dataclass

import numpy as np

from cell.grasping import look_at
from cell.layout import Layout
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
    count = 1 if belt.speed > 0.0 else int(np.ceil(2 * reach / SEARCH_STEP)) + 1
    X_BW = layout.X_WB.inverse()
    points_W = [np.array([belt.center_x, y, belt.top_z]) for y in np.linspace(reach, -reach, count)]
    return SearchRun(tuple(look_at(X_BW.apply(point), SEARCH_DISTANCE) for point in points_W))


def refinement_view(X_BO_est: Pose, center_O: np.ndarray, distance: float = REFINE_DISTANCE) -> Pose:
    """X_BC of a nearer view, straight above the estimated middle of the part."""
    return look_at(X_BO_est.apply(center_O), distance)
