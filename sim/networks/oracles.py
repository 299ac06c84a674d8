"""Uncertainty methods that know the truth: what no method can beat, and what better masks could give.

They are given the latest_truth, as the simulated networks are; no other method can be.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cell.part import pose_error
from maskval import Estimates, MaskVal, Pose
from sim.instance_ids import NO_INSTANCE
from sim.networks.ground_truth import LatestTruth, shown_part

ERROR_THRESHOLD_M = 0.015  # the paper's e_t for its robot


@dataclass(frozen=True, slots=True)
class OracleMdd:
    """The ceiling: ranks poses by their true error, u = 1 - e_t / (e_t + MDD).

    Any rising function of the error ranks as well; this one is 1/2 at the paper's e_t, and 1 where no part is.

    Args:
        latest_truth: Where the truth of the picture that the estimates are from is.
        symmetries: Poses in O in which the part looks the same, see `cell.part.Part`.
    """

    latest_truth: LatestTruth
    symmetries: tuple[Pose, ...] = ()

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        """A rising function of each pose's error, (N,), in [0, 1]."""
        truth = self.latest_truth.newest
        u = np.ones(len(estimates))
        for i, (X_CO, mask) in enumerate(zip(estimates.poses[0], estimates.masks, strict=True)):
            part = shown_part(truth.instance_ids, mask)
            if part != NO_INSTANCE:
                error_m = pose_error(X_CO, truth.X_CO_true[part], estimates.mesh, self.symmetries)
                u[i] = 1.0 - ERROR_THRESHOLD_M / (ERROR_THRESHOLD_M + error_m)
        return u


@dataclass(frozen=True, slots=True)
class OracleMask:
    """MaskVal with the true visible mask of the part that each mask shows; 1 where it shows none.

    Args:
        latest_truth: Where the truth of the picture that the estimates are from is.
    """

    latest_truth: LatestTruth

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        """MaskVal's u with the true masks, (N,), in [0, 1]."""
        truth = self.latest_truth.newest
        parts = [shown_part(truth.instance_ids, mask) for mask in estimates.masks]
        masks = np.zeros(estimates.masks.shape, dtype=np.bool_)
        for mask, part in zip(masks, parts, strict=True):
            if part != NO_INSTANCE:
                np.equal(truth.instance_ids, part, out=mask)
        masks.setflags(write=False)
        return MaskVal()(replace(estimates, masks=masks))
