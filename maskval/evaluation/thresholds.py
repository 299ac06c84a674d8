"""Uncertainty thresholds: the paper's, and two that hold for poses not yet seen, or abstain."""

from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from maskval.errors import InvalidEvaluationError
from maskval.evaluation.matching import Counting, Evaluation
from maskval.evaluation.metrics import DEMANDED_AP, sweep
from maskval.inputs.arrays import check_number, floats

# Thresholds that are looked at for a guarantee: few, because each has to hold against the luck of all.
GRID = tuple(np.arange(1, 21) / 20)


class Certificate(NamedTuple):
    """A threshold that bounds the share of bad poses among the kept ones.

    Args:
        u_T: The threshold.
        kept: Calibration poses that it keeps.
        bad: Bad ones among them.
        bound: Upper bound of the share of bad poses that holds with the confidence asked for, in [0, 1].
    """

    u_T: float
    kept: int
    bad: int
    bound: float


def paper_threshold(
    evaluation: Evaluation, e_t: float, demanded_ap: float = DEMANDED_AP, counting: Counting | None = None
) -> float | None:
    """The paper's u_T: the largest at which the AP of these poses reaches the demanded one, or None.

    The AP of new poses may be lower: the threshold is fitted to the poses that it is judged by.

    Args:
        evaluation: Poses and parts.
        e_t: Greatest error of a true positive, metres.
        demanded_ap: Least AP, in (0, 1].
        counting: What the paper leaves open.
    """
    check_number("demanded_ap", demanded_ap, InvalidEvaluationError, least=0, most=1, ends="(]")
    found = sweep(evaluation, e_t, counting)
    index = found.reaching(demanded_ap)
    return None if index is None else float(found.u[index])


def certified_threshold(
    u: ArrayLike,
    bad: ArrayLike,
    *,
    maximum_risk: float = 1 - DEMANDED_AP,
    confidence: float = 0.95,
    grid: ArrayLike = GRID,
) -> Certificate | None:
    """The largest u_T under which the share of bad poses is certified, or None where no data can tell.

    With at least this confidence over the draw of the calibration poses, a new pose of u <= u_T is bad with at most
    the maximum risk. The bound is Clopper and Pearson's at each threshold of a grid fixed beforehand, the doubt shared
    among its thresholds (Bonferroni). The poses must be independent and from where the new ones come: take one per
    image. To certify 1 % with 95 % confidence takes some 600 kept poses without a bad one.

    Args:
        u: Uncertainty of each calibration pose, (N,), in [0, 1].
        bad: Whether each is a false positive, (N,).
        maximum_risk: Greatest share of bad poses among the kept, in (0, 1).
        confidence: Probability with which the guarantee holds, in (0, 1).
        grid: Thresholds that are tried, not chosen by the calibration poses.
    """
    uncertainty, flags = _calibration(u, bad, maximum_risk)
    check_number("confidence", confidence, InvalidEvaluationError, least=0, most=1, ends="()")
    thresholds = np.unique(floats("grid", grid, InvalidEvaluationError))
    for u_T in thresholds[::-1]:
        kept = int(np.count_nonzero(uncertainty <= u_T))
        wrong = int(np.count_nonzero(flags & (uncertainty <= u_T)))
        if kept == 0:
            continue
        doubt = (1 - confidence) / len(thresholds)
        test = scipy.stats.binomtest(wrong, kept, alternative="less")
        bound = float(test.proportion_ci(1 - doubt, method="exact").high)
        if bound <= maximum_risk:
            return Certificate(float(u_T), kept, wrong, bound)
    return None


def conformal_threshold(u: ArrayLike, bad: ArrayLike, *, maximum_risk: float = 1 - DEMANDED_AP) -> float | None:
    """The largest u_T by conformal risk control, or None where the poses are too few.

    A new pose, exchangeable with these, is kept and bad with at most the maximum risk, on average over the calibration
    poses. This bounds bad poses among all, not among the kept, and needs far fewer of them than a certificate.

    Args:
        u: Uncertainty of each calibration pose, (N,), in [0, 1].
        bad: Whether each is a false positive, (N,).
        maximum_risk: Greatest share of kept bad poses among all, in (0, 1).
    """
    uncertainty, flags = _calibration(u, bad, maximum_risk)
    order = np.argsort(uncertainty, kind="stable")
    ordered = uncertainty[order]
    # Poses of equal u are kept together: the risk at a threshold counts the last of them.
    last = np.append(np.diff(ordered) > 0, True)[: len(ordered)]
    risk = (np.cumsum(flags[order])[last] + 1) / (len(ordered) + 1)
    allowed = np.flatnonzero(risk <= maximum_risk)
    return float(ordered[last][allowed[-1]]) if len(allowed) else None


def _calibration(u: ArrayLike, bad: ArrayLike, maximum_risk: float) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    uncertainty, flags = floats("u", u, InvalidEvaluationError), floats("bad", bad, InvalidEvaluationError) != 0
    if uncertainty.ndim != 1 or flags.shape != uncertainty.shape or not np.isfinite(uncertainty).all():
        raise InvalidEvaluationError(
            f"u and bad must be finite and of one shape (N,), but have {uncertainty.shape} and {flags.shape}"
        )
    check_number("maximum_risk", maximum_risk, InvalidEvaluationError, least=0, most=1, ends="()")
    return uncertainty, flags
