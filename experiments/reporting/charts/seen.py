"""All estimates of one part by one method and policy, as arrays."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from experiments.reporting.data.happened import Rows
from maskval import NO_PART, Evaluation


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """All estimates of one part by one method and policy.

    Attributes:
        u: (N,).
        errors: mm, (N,); infinite for a false detection.
        visible: true visible share, (N,).
        acted: whether an attempt followed, (N,).
        image: number of the look, (N,).
        part: of the looks' parts, numbered through, (N,); `NO_PART` for a false detection.
    """

    u: NDArray[np.float64]
    errors: NDArray[np.float64]
    visible: NDArray[np.float64]
    acted: NDArray[np.bool_]
    image: NDArray[np.int64]
    part: NDArray[np.int64]


def seen_of(experiments: Sequence[Rows]) -> Seen:
    """The estimates of experiments."""
    rows = list(_estimates(experiments))
    columns = list(zip(*rows, strict=True)) if rows else [()] * 6
    kinds = (np.float64, np.float64, np.float64, np.bool_, np.int64, np.int64)
    return Seen(*(np.array(column, dtype=kind) for column, kind in zip(columns, kinds, strict=True)))


def _estimates(experiments: Sequence[Rows]) -> Iterator[tuple[float, float, float, bool, int, int]]:
    image = 0
    for experiment in experiments:
        for _, _, _, _, action, chosen, _, _, detections in experiment["looks"]:
            for detection, (part, u, error, visible) in enumerate(detections):
                acted = action == "grasp" and detection == chosen
                number = NO_PART if part is None else 100 * image + part
                yield u, np.inf if part is None else error, visible or 0.0, acted, image, number
            image += 1


def evaluation_of(one: Seen) -> Evaluation:
    """Poses and the detected parts, as `recall_curve` counts them; the logs do not name parts that no mask shows."""
    parts, first, place = np.unique(one.part, return_index=True, return_inverse=True)
    known = parts != NO_PART
    offset = int(np.count_nonzero(~known))  # NO_PART sorts first
    numbers = np.where(one.part == NO_PART, NO_PART, place - offset)
    return Evaluation(
        images=int(one.image.max()) + 1,
        pose_image=one.image,
        pose_part=numbers,
        errors_m=one.errors / 1000,
        u=one.u,
        part_image=one.image[first[known]],
        part_visibility=one.visible[first[known]],
    )
