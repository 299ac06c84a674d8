"""From a detector's maps to instances: peaks of the centre map, and the pixels that vote for them."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.rounding import rounded

VOTE_SCALE = 32.0  # map pixels for a vote of 1
LEAST_PEAK = 0.3
_PEAK_RADIUS = 3  # map pixels within which the highest peak counts
_REACH = 0.35  # of the distance between centre and farthest pixel: how far beside a peak a vote may fall …
_LEAST_REACH = 6.0  # … but at least so many map pixels
_FEWEST = 12  # map pixels of an instance
_NOT = -6.0  # logit of what belongs to another instance

Array = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class Instance:
    """An instance: its mask, (H, W), and how sure the detector is, in [0, 1]."""

    mask: NDArray[np.bool_]
    score: float


def instances(part: Array, center: Array, votes: Array, size: tuple[int, int]) -> list[Instance]:
    """The instances of an image, the highest peak first.

    Args:
        part: logit of each map pixel to show a part, (h, w).
        center: logit of the middle of a part's visible pixels to lie there, (h, w).
        votes: from each pixel to that middle, along u and v, (2, h, w), in `VOTE_SCALE` map pixels.
        size: height and width of the image.
    """
    probability = 1.0 / (1.0 + np.exp(-rounded(center.astype(np.float64))))
    peaks = _peaks(probability)
    v, u = np.nonzero(part > 0)
    if len(peaks) == 0 or len(u) == 0:
        return []
    aims = np.stack((u, v), axis=1) + VOTE_SCALE * votes[:, v, u].T
    apart = np.linalg.norm(aims[:, None] - peaks[None, :, ::-1], axis=2)
    nearest = rounded(apart).argmin(axis=1)
    own = np.linalg.norm(np.stack((v, u), axis=1) - peaks[nearest], axis=1)
    reach = np.maximum(_LEAST_REACH, _REACH * own)
    belongs = apart[np.arange(len(u)), nearest] <= reach
    found = []
    for number, peak in enumerate(peaks):
        chosen = belongs & (nearest == number)
        if np.count_nonzero(chosen) < _FEWEST:
            continue
        mask, sure = _full_mask(part, (v[chosen], u[chosen]), size)
        if mask.any():
            found.append(Instance(mask, float(probability[tuple(peak)] * sure)))
    return found


def _peaks(probability: NDArray[np.float64]) -> NDArray[np.int64]:
    """Rows and columns of the peaks, (P, 2), the highest first; of equal ones the first in reading order."""
    kernel = np.ones((2 * _PEAK_RADIUS + 1,) * 2, dtype=np.uint8)
    highest = cv2.dilate(probability, kernel)
    found = np.argwhere((probability == highest) & (probability >= LEAST_PEAK))
    order = np.argsort(-probability[tuple(found.T)], kind="stable")
    return found[order]


def _full_mask(
    part: Array, pixels: tuple[NDArray[np.int64], NDArray[np.int64]], size: tuple[int, int]
) -> tuple[NDArray[np.bool_], float]:
    """The mask of one instance in the image, and how sure its pixels are on average."""
    logits = np.minimum(part, _NOT)
    logits[pixels] = part[pixels]
    around = cv2.dilate((logits > 0).astype(np.uint8), np.ones((3, 3), dtype=np.uint8)) > 0
    own_border = around & (part <= 0)
    logits[own_border] = part[own_border]  # where the part ends, its own slope says where between two map pixels
    height, width = size
    fine = cv2.resize(logits, (width, height), interpolation=cv2.INTER_LINEAR)
    sure = float(np.mean(1.0 / (1.0 + np.exp(-part[pixels].astype(np.float64)))))
    return fine > 0, sure
