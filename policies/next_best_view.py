"""The paper's rule with the second look from the view that would show errors of the pose best."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cell.interfaces import Action, Decision, Observation
from cell.rounding import rounded
from cell.setup import PolicySetup
from maskval import Camera, Mesh, Pose, silhouette, silhouette_iou
from policies.threshold import ThresholdPolicy
from policies.views import views_around

ERROR = 0.010  # m by which the six errors below move the part, or its farthest point: twice what every grasp forgives


class NextBestView:
    """Like `ThresholdPolicy`, but takes the second look from the view in reach that shows errors of the pose best.

    A pose can be wrong in six ways: shifted along x, y or z, or turned about them. An error is visible in a view by the
    share of the silhouette that it changes, s = 1 − IoU of the silhouettes before and after. The present view already
    shows some errors, so the best view V has the greatest min over errors of s(present) + s(V). It makes the error that
    is hardest to see in both views together as visible as possible.
    """

    def __init__(self, setup: PolicySetup) -> None:
        self._setup = setup
        self._rule = ThresholdPolicy(setup.u_grasp, setup.u_refine)

    def decide(self, observation: Observation) -> Decision:
        """See `cell.interfaces.Policy`."""
        decision = self._rule.decide(observation)
        if decision.action is not Action.REFINE or decision.detection is None:
            return decision
        mesh, camera = self._setup.part.mesh, observation.frame.camera
        X_BO_est = observation.X_BO_est(decision.detection)
        known = visible_errors(mesh, X_BO_est, observation.frame.X_BC, camera)
        views = views_around(observation, decision.detection, self._setup)
        if not views:
            return decision
        shown = [float((known + visible_errors(mesh, X_BO_est, X_BC, camera)).min()) for X_BC in views]
        return replace(decision, X_BC=views[int(np.argmax(rounded(shown)))])  # of equals the first: from above


def visible_errors(mesh: Mesh, X_BO: Pose, X_BC: Pose, camera: Camera) -> NDArray[np.float64]:
    """How well each of six small errors of a pose shows in a view, 1 − IoU of the silhouettes, (6,), in [0, 1].

    A part that is not in the picture has no silhouette there: its errors do not show.

    Args:
        mesh: the part.
        X_BO: its pose.
        X_BC: the view.
        camera: its pinhole model.
    """
    X_CB = X_BC.inverse()
    before = silhouette(mesh, X_CB @ X_BO, camera).mask
    if not before.any():
        return np.zeros(6)
    after = [X_CB @ X_BO_wrong for X_BO_wrong in _displaced(mesh, X_BO)]
    iou, _ = silhouette_iou(mesh, after, before[np.newaxis], camera)
    return 1.0 - iou[:, 0]


def _displaced(mesh: Mesh, X_BO: Pose) -> list[Pose]:
    """The pose shifted along, then turned about, B's axes, about the part's middle."""
    center_O = mesh.center
    radius = float(np.linalg.norm(mesh.vertices - center_O, axis=1).max())
    to_center = Pose.from_translation(X_BO.apply(center_O))
    shifts = [Pose.from_translation(ERROR * axis) for axis in np.eye(3)]
    turns = [to_center @ Pose.from_rotvec(ERROR / radius * axis) @ to_center.inverse() for axis in np.eye(3)]
    return [error @ X_BO for error in (*shifts, *turns)]
