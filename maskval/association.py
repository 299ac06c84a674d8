"""Which mask belongs to which pose: the paper's matching algorithm J."""

from typing import Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from maskval.errors import InvalidEstimatesError
from maskval.inputs.arrays import floats

Rule = Literal["greedy", "optimal"]

# The index of the mask of a pose that overlaps no mask left for it.
UNMATCHED = -1


def associate(iou: NDArray[np.float64], rule: Rule) -> NDArray[np.int64]:
    """The mask of each pose, (N,), each mask at most once, or `UNMATCHED`; a pair that does not overlap is none.

    Args:
        iou: Intersection over union of N poses and K masks, (N, K), in [0, 1].
        rule: "greedy" takes the best pair left, the lowest indices first; "optimal" the greatest sum (Hungarian).

    Raises:
        InvalidEstimatesError: If the table has another shape or a value that is none, or the rule is another.
    """
    table = floats("iou", iou, InvalidEstimatesError)
    if table.ndim != 2 or not ((table >= 0) & (table <= 1)).all():
        raise InvalidEstimatesError(f"iou must have shape (N, K) and values in [0, 1], but is {table}")
    if rule == "greedy":
        return _greedy(table)
    if rule == "optimal":
        poses, masks = scipy.optimize.linear_sum_assignment(table, maximize=True)
        matched = np.full(len(table), UNMATCHED)
        matched[poses] = np.where(table[poses, masks] > 0, masks, UNMATCHED)
        return matched
    raise InvalidEstimatesError(f"the association must be 'known', 'greedy' or 'optimal', but is {rule!r}")


def _greedy(iou: NDArray[np.float64]) -> NDArray[np.int64]:
    matched = np.full(len(iou), UNMATCHED)
    taken: set[int] = set()
    order = np.argsort(-iou, axis=None, kind="stable")
    for pose, mask in zip(*(index.tolist() for index in np.unravel_index(order, iou.shape)), strict=True):
        if iou[pose, mask] == 0:
            break
        if matched[pose] == UNMATCHED and mask not in taken:
            matched[pose] = mask
            taken.add(mask)
    return matched
