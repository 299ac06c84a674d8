"""AP, AR and ARU at every uncertainty threshold, and their curves over the error threshold at a demanded AP.

With TP and FP the kept poses (u <= u_T) of error <= e_t and > e_t, and FN the eligible parts that are not found:

    AP = TP / (TP + FP)        AR = TP / (TP + FN)        ARU = TP / (TP of all poses, kept or not)

each of every image, then the mean over the images in which it is defined (0/0 is not), or of all images' counts.
"""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from maskval.errors import InvalidEvaluationError
from maskval.evaluation.matching import NO_PART, Counting, Evaluation
from maskval.inputs.arrays import check_number, floats

# Sums of thousands of precisions: a demanded AP is met if it is missed by rounding only.
ROUNDING = 1e-12
# The paper demands an AP of 99 % and draws its curves up to 3 cm.
DEMANDED_AP = 0.99
MAXIMUM_ERROR_M = 0.03

Choice = Literal["largest", "first violation"]  # the largest u_T that reaches the AP, or the last before the first miss


class Mean(NamedTuple):
    """A mean at each threshold: a sum, and the number of its terms (0 where the mean is undefined)."""

    total: NDArray[np.float64]
    terms: NDArray[np.float64]

    def at(self, index: int) -> float | None:
        """The mean at one threshold, or None where it is undefined."""
        return float(self.total[index] / self.terms[index]) if self.terms[index] else None


@dataclass(frozen=True, slots=True, eq=False)
class Sweep:
    """AP, AR and ARU at M + 1 uncertainty thresholds.

    Args:
        u: The thresholds: keep nothing (-inf), and then each distinct u of the poses, rising, (M + 1,).
        ap: Average precision.
        ar: Average recall.
        aru: Average recall of what the unfiltered poses found.
    """

    u: NDArray[np.float64]
    ap: Mean
    ar: Mean
    aru: Mean

    def __post_init__(self) -> None:
        self.u.setflags(write=False)

    def index(self, u_T: float) -> int:
        """The threshold of the sweep that keeps what u_T keeps."""
        return int(np.searchsorted(self.u, u_T, side="right")) - 1

    def reaching(self, demanded_ap: float, choice: Choice = "largest") -> int | None:
        """Index of the threshold to take for an AP, or None where none reaches it."""
        index = int(chosen(reaches(self.ap, demanded_ap)[1:], choice)) + 1  # the first threshold keeps nothing
        return index or None


class Rates(NamedTuple):
    """AP, AR and ARU at one threshold, in [0, 1]; None where there is nothing to average."""

    ap: float | None
    ar: float | None
    aru: float | None


@dataclass(frozen=True, slots=True, eq=False)
class RecallCurve:
    """What can be kept at a demanded AP, over the error threshold.

    Args:
        errors_m: Error thresholds e_t, (M,), metres.
        u: The u_T that reaches the AP at each e_t; None where none does, and its AR and ARU are 0.
        ar: Average recall at that threshold, (M,).
        aru: Average recall of what the unfiltered poses found, (M,).
        ar_star: Average recall AR* of the unfiltered poses, the optimum of AR, (M,).
    """

    errors_m: NDArray[np.float64]
    u: tuple[float | None, ...]
    ar: NDArray[np.float64]
    aru: NDArray[np.float64]
    ar_star: NDArray[np.float64]

    def __post_init__(self) -> None:
        for name in ("errors_m", "ar", "aru", "ar_star"):
            array = floats(name, getattr(self, name), InvalidEvaluationError)
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @property
    def auc(self) -> float:
        """Area under AR over e_t, divided by the range of e_t, in [0, 1]."""
        return float(np.trapezoid(self.ar, self.errors_m) / np.ptp(self.errors_m))


def rates(evaluation: Evaluation, e_t: float, u_T: float = np.inf, counting: Counting | None = None) -> Rates:
    """AP, AR and ARU of the poses of u <= u_T.

    Args:
        evaluation: Poses and parts.
        e_t: Greatest error of a true positive, metres.
        u_T: Greatest uncertainty of a pose that is kept; all are by default.
        counting: What the paper leaves open.
    """
    check_number("u_T", u_T, InvalidEvaluationError)
    found = sweep(evaluation, e_t, counting)
    index = found.index(u_T)
    return Rates(found.ap.at(index), found.ar.at(index), found.aru.at(index))


def recall_curve(
    evaluation: Evaluation,
    errors_m: ArrayLike,
    demanded_ap: float = DEMANDED_AP,
    counting: Counting | None = None,
    choice: Choice = "largest",
) -> RecallCurve:
    """AR, ARU and AR* over the error threshold, each at a u_T that reaches the demanded AP.

    Args:
        evaluation: Poses and parts.
        errors_m: Error thresholds e_t, (M,), rising, M >= 2, metres; the paper's are 0 to 0.03.
        demanded_ap: Least AP, in (0, 1].
        counting: What the paper leaves open.
        choice: Which u_T is taken of those that reach it.
    """
    thresholds = floats("errors_m", errors_m, InvalidEvaluationError)
    if thresholds.ndim != 1 or len(thresholds) < 2 or not (np.diff(thresholds) > 0).all():
        raise InvalidEvaluationError(f"errors_m must be at least two rising thresholds, but are {thresholds}")
    check_number("demanded_ap", demanded_ap, InvalidEvaluationError, least=0, most=1, ends="(]")
    u: list[float | None] = []
    rows = []
    for e_t in thresholds:
        found = sweep(evaluation, float(e_t), counting)
        index = found.reaching(demanded_ap, choice)
        u.append(None if index is None else float(found.u[index]))
        kept = (0.0, 0.0) if index is None else (found.ar.at(index) or 0.0, found.aru.at(index) or 0.0)
        rows.append((*kept, found.ar.at(-1) or 0.0))
    ar, aru, ar_star = np.array(rows).T
    return RecallCurve(thresholds, tuple(u), ar, aru, ar_star)


def reaches(ap: Mean, demanded_ap: float = DEMANDED_AP) -> NDArray[np.bool_]:
    """Whether an AP is the demanded one at least."""
    return (ap.terms > 0) & (ap.total >= (demanded_ap - ROUNDING) * ap.terms)


def chosen(reached: NDArray[np.bool_], choice: Choice) -> NDArray[np.int64]:
    """Index of the threshold to take, (...), of rising thresholds along the last axis; −1 where there is none."""
    count = reached.shape[-1]
    if count == 0:
        return np.full(reached.shape[:-1], -1)
    if choice == "largest":
        last = count - 1 - np.argmax(reached[..., ::-1], axis=-1)
        return np.where(reached.any(axis=-1), last, -1)
    return np.asarray(np.where(reached.all(axis=-1), count, np.argmin(reached, axis=-1)) - 1)


def sweep(evaluation: Evaluation, e_t: float, counting: Counting | None = None) -> Sweep:
    """AP, AR and ARU at every uncertainty threshold that makes a difference, in one pass over the sorted poses.

    Args:
        evaluation: Poses and parts.
        e_t: Greatest error of a true positive, metres.
        counting: What the paper leaves open.
    """
    check_number("e_t", e_t, InvalidEvaluationError, least=0.0)
    rule = counting or Counting()
    order = np.argsort(evaluation.u, kind="stable")
    u, image, part = evaluation.u[order], evaluation.pose_image[order], evaluation.pose_part[order]
    good = (evaluation.errors_m[order] <= e_t).astype(np.int64)
    eligible = evaluation.part_visibility >= rule.visibility_threshold
    owed = np.bincount(evaluation.part_image[eligible], minlength=evaluation.images)
    valid = np.bincount(image, good, evaluation.images).astype(np.int64)
    finding = (part != NO_PART) & np.append(eligible, False)[part]
    if rule.false_negatives == "no true positive":
        finding &= good > 0
    found = _first_of_each(part, finding)

    if rule.averaging == "pooled":
        image = np.zeros_like(image)
        owed, valid = owed.sum(keepdims=True), valid.sum(keepdims=True)
    ones, zeros = np.ones_like(image), np.zeros_like(image)
    true = _running(good, image)
    missed = owed[image] - _running(found, image)
    ap = _mean(np.zeros_like(owed), (true, good), (_running(ones, image), ones))
    ar = _mean(owed, (true, good), (true + missed, good - found))
    aru = _mean(valid, (true, good), (valid[image], zeros))
    if rule.empty_images == "one" and rule.averaging == "images":
        ap = Mean(ap.total + (evaluation.images - ap.terms), np.full(len(ap.terms), float(evaluation.images)))

    # Poses of equal u are kept together.
    last = np.append(np.diff(u) > 0, True)[: len(u)]
    ends = np.append(0, np.flatnonzero(last) + 1)
    means = (Mean(mean.total[ends], mean.terms[ends]) for mean in (ap, ar, aru))
    return Sweep(np.append(-np.inf, u[last]), *means)


def _first_of_each(part: NDArray[np.int64], chosen: NDArray[np.bool_]) -> NDArray[np.int64]:
    """1 where a pose is the first chosen one of its part, else 0."""
    poses = np.flatnonzero(chosen)
    _, first = np.unique(part[poses], return_index=True)
    flags = np.zeros(len(part), dtype=np.int64)
    flags[poses[first]] = 1
    return flags


def _running(values: NDArray[np.int64], group: NDArray[np.int64]) -> NDArray[np.int64]:
    """The sum of each group's values up to each element."""
    order = np.argsort(group, kind="stable")
    total = np.cumsum(values[order])
    starts = np.flatnonzero(np.diff(group[order], prepend=-1))
    before = np.append(0, total)[starts]
    running = np.empty_like(total)
    running[order] = total - np.repeat(before, np.diff(starts, append=len(total)))
    return running


def _mean(
    owed: NDArray[np.int64],
    top: tuple[NDArray[np.int64], NDArray[np.int64]],
    bottom: tuple[NDArray[np.int64], NDArray[np.int64]],
) -> Mean:
    """The mean of top / bottom over the groups in which bottom is not 0, before the first and after each pose.

    Args:
        owed: Bottom of each group before the first pose, when top is 0.
        top: The top of its group after each pose, and by how much the pose raised it.
        bottom: The same of the bottom.
    """

    def ratio(numerator: NDArray[np.int64], denominator: NDArray[np.int64]) -> NDArray[np.float64]:
        return numerator / np.maximum(denominator, 1)  # where the denominator is 0, so is the numerator

    before = bottom[0] - bottom[1]
    gain = ratio(top[0], bottom[0]) - ratio(top[0] - top[1], before)
    defined = (bottom[0] > 0).astype(np.int64) - (before > 0)
    return Mean(
        np.cumsum(np.append(0.0, gain)), np.cumsum(np.append(np.count_nonzero(owed), defined)).astype(np.float64)
    )
