"""How uncertain a pose is, judged by the depth that it should have and the depth that was measured."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from maskval.errors import InvalidEstimatesError
from maskval.estimates import Estimates, Needs
from maskval.rendering.depth import depth_crop

# BOP's misalignment tolerance of 2018: surfaces farther apart than this are not the same.
MAXIMUM_M = 0.02


@dataclass(frozen=True, slots=True)
class DepthConsistency:
    """How far the object's surface under the pose is from the measured one, inside the mask.

    u = mean over the mask's measured pixels of min(1, |rendered - measured| / maximum); a pixel that the object does
    not cover under the pose counts 1. Where nothing was measured inside the mask, u = 1.

    Args:
        maximum_m: Distance that counts as 1, metres, > 0.
    """

    maximum_m: float = MAXIMUM_M
    needs: ClassVar[Needs] = Needs(depth=True)

    def __post_init__(self) -> None:
        if not 0 < self.maximum_m < np.inf:
            raise InvalidEstimatesError(f"maximum_m must be > 0 and finite, but is {self.maximum_m}")

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        """The mean relative distance of each pose, (N,), in [0, 1].

        Raises:
            InvalidEstimatesError: If there is no depth image.
        """
        if estimates.depth is None:
            raise InvalidEstimatesError("depth consistency needs a depth image, but the estimates hold none")
        u = np.ones(len(estimates))
        for i, (X_CO, mask) in enumerate(zip(estimates.poses[0], estimates.masks, strict=True)):
            measured_px = np.count_nonzero(mask & (estimates.depth > 0))
            if measured_px == 0:
                continue
            crop = depth_crop(estimates.mesh, X_CO, estimates.camera, pixel_center=estimates.pixel_center)
            height, width = crop.depth.shape
            window = (slice(crop.top, crop.top + height), slice(crop.left, crop.left + width))
            both = mask[window] & (estimates.depth[window] > 0) & (crop.depth > 0)
            apart = np.abs(crop.depth[both].astype(np.float64) - estimates.depth[window][both])
            agreeing = np.sum(1.0 - np.minimum(apart / self.maximum_m, 1.0))
            u[i] = max(0.0, 1.0 - agreeing / measured_px)
        return u
