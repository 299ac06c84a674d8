"""How uncertain a pose is, judged by the distance of its silhouette's outline from the outline of its mask."""

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from maskval.estimates import Estimates
from maskval.rendering.silhouettes import silhouette


@dataclass(frozen=True, slots=True)
class ContourDistance:
    """The Chamfer distance of both outlines (Barrow et al. 1977), relative to the mask's radius.

    u = min(1, d / r). d is the mean distance of a pixel of one outline from the nearest pixel of the other, averaged
    over both directions, in pixels; r is the radius of a disc as large as the mask. So u does not depend on how near
    the object is, 0 is the same outline, and 1 are outlines as far apart as the mask is large. The image's border is
    no outline; where there is none, nothing agrees: u = 1.
    """

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        """The relative distance of each pose, (N,), in [0, 1]."""
        u = np.ones(len(estimates))
        for i, (X_CO, mask) in enumerate(zip(estimates.poses[0], estimates.masks, strict=True)):
            seen = silhouette(estimates.mesh, X_CO, estimates.camera, pixel_center=estimates.pixel_center)
            distance = chamfer_distance(seen.mask, mask)
            if distance is not None:
                u[i] = min(1.0, distance / np.sqrt(np.count_nonzero(mask) / np.pi))
        return u


def chamfer_distance(a: NDArray[np.bool_], b: NDArray[np.bool_]) -> float | None:
    """The symmetric Chamfer distance of two masks' outlines, pixels; None where one has no outline.

    Args:
        a: (H, W).
        b: Mask of the same size.
    """
    first, second = outline(a), outline(b)
    if len(first) == 0 or len(second) == 0:
        return None
    there, _ = scipy.spatial.cKDTree(second).query(first)
    back, _ = scipy.spatial.cKDTree(first).query(second)
    return float(there.mean() + back.mean()) / 2.0


def outline(mask: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Row and column of the mask's pixels that have a pixel beside, above or below them outside of it, (M, 2).

    Args:
        mask: (H, W); what lies beyond the image's border counts as inside.
    """
    rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    if len(rows) == 0:
        return np.empty((0, 2), dtype=np.int64)
    # With one pixel around it, where the image has one: repeating the last row there continues the mask beyond it.
    top, left = max(rows[0] - 1, 0), max(columns[0] - 1, 0)
    crop = mask[top : rows[-1] + 2, left : columns[-1] + 2]
    padded = np.pad(crop, 1, mode="edge")
    inner = padded[:-2, 1:-1] & padded[2:, 1:-1] & padded[1:-1, :-2] & padded[1:-1, 2:]
    return np.asarray(np.argwhere(crop & ~inner) + (top, left))
