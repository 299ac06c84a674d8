"""How well an uncertainty ranks poses, whatever its scale: rank correlation, AUROC, and risk against coverage."""

from collections.abc import Callable

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from maskval.errors import InvalidEvaluationError
from maskval.evaluation.matching import Evaluation
from maskval.inputs.arrays import floats
from maskval.statistics.intervals import percentile_interval


def spearman(u: ArrayLike, errors: ArrayLike) -> float | None:
    """Spearman's rank correlation of uncertainty and error, in [-1, 1]; None when one of them is constant.

    Args:
        u: Uncertainty of each pose, (N,).
        errors: True error of each pose, (N,); poses without a true part have none and are left out by the caller.
    """
    uncertainty, error = _pair(u, errors)
    if len(error) < 2 or np.ptp(uncertainty) == 0 or np.ptp(error) == 0:
        return None
    return float(scipy.stats.spearmanr(uncertainty, error).statistic)


def auroc(u: ArrayLike, bad: ArrayLike) -> float | None:
    """The probability that a bad pose has the greater u of a bad and a good one, ties counting half; or None.

    It is None when there are no bad poses, or no good ones.

    Args:
        u: Uncertainty of each pose, (N,).
        bad: Whether each pose is a false positive, (N,).
    """
    uncertainty, flags = _pair(u, bad)
    wrong = flags > 0
    bads = np.count_nonzero(wrong)
    goods = len(wrong) - bads
    if bads == 0 or goods == 0:
        return None
    ranks = scipy.stats.rankdata(uncertainty)
    return float((ranks[wrong].sum() - bads * (bads + 1) / 2) / (bads * goods))


def aurc(u: ArrayLike, losses: ArrayLike) -> float | None:
    """The area under risk over coverage: the mean over k of the mean loss of the k least uncertain poses; or None.

    It is in the unit of the loss (0 and 1 for good and bad poses, or metres), and None without poses. Poses of equal
    u come in random order: the area is its expectation.

    Args:
        u: Uncertainty of each pose, (N,).
        losses: Loss of each pose, (N,), finite.
    """
    uncertainty, loss = _pair(u, losses)
    if len(loss) == 0:
        return None
    _, group, counts = np.unique(uncertainty, return_inverse=True, return_counts=True)
    expected = (np.bincount(group, loss) / counts).repeat(counts)
    return float(np.mean(np.cumsum(expected) / np.arange(1, len(loss) + 1)))


def bootstrap_interval(
    evaluation: Evaluation,
    statistic: Callable[[Evaluation], float | None],
    rng: np.random.Generator,
    level: float = 0.95,
    resamples: int = 1000,
) -> tuple[float, float] | None:
    """The percentile bootstrap interval of any metric, by resampling whole images; or None.

    Poses of one image share its light and its clutter, so images are drawn, not poses. Samples in which the statistic
    is undefined are left out; of fewer than 2 / (1 - level) others the interval is None.

    Args:
        evaluation: Poses and parts.
        statistic: The metric, for example `lambda sample: spearman(sample.u, sample.errors_m)`.
        rng: Source of the resampling.
        level: Confidence level, in (0, 1).
        resamples: Number of bootstrap samples, >= 1.
    """
    if evaluation.images < 1 or resamples < 1:
        raise InvalidEvaluationError(f"a bootstrap needs images and resamples, not {evaluation.images} and {resamples}")
    values = (
        statistic(evaluation.of_images(rng.integers(evaluation.images, size=evaluation.images)))
        for _ in range(resamples)
    )
    defined = [value for value in values if value is not None]
    return percentile_interval(defined, level)


def _pair(u: ArrayLike, other: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    first, second = (floats("both", values, InvalidEvaluationError) for values in (u, other))
    if first.ndim != 1 or first.shape != second.shape:
        raise InvalidEvaluationError(f"both must have one shape (N,), but have {first.shape} and {second.shape}")
    if not (np.isfinite(first).all() and np.isfinite(second).all()):
        raise InvalidEvaluationError("uncertainties, errors and losses must be finite: leave out poses without a part")
    return first, second
