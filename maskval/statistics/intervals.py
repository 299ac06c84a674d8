"""Confidence intervals."""

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray
from scipy.special import betaincinv

from maskval.errors import InvalidArgumentError
from maskval.inputs.arrays import check_number, floats


def proportion_interval(successes: int, trials: int, level: float = 0.95) -> tuple[float, float] | None:
    """The exact (Clopper-Pearson) two-sided interval of a proportion, or None without trials.

    Args:
        successes: Number of successes, 0 to trials.
        trials: Number of independent trials, >= 0.
        level: Confidence level, in (0, 1).
    """
    check_number("trials", trials, least=0)
    check_number("successes", successes, least=0, most=trials)
    _check_level(level)
    if trials == 0:
        return None
    return clopper_pearson(successes, trials, (1 - level) / 2)


def clopper_pearson(successes: float, trials: float, tail: float) -> tuple[float, float]:
    """The proportions beyond which the binomial tails hold less than `tail` each.

    Args:
        successes: In 0..trials; an effective number need not be whole.
        trials: Above 0, likewise.
        tail: Probability, in (0, 0.5).
    """
    failures = trials - successes
    low = float(betaincinv(successes, failures + 1, tail)) if successes > 0 else 0.0
    high = float(betaincinv(successes + 1, failures, 1 - tail)) if failures > 0 else 1.0
    return low, high


def mean_interval(values: ArrayLike, level: float = 0.95) -> tuple[float, float] | None:
    """Student's two-sided interval of a mean, in the unit of the values; None of fewer than two, or if all are equal.

    For few observations, where the bootstrap is too sure; exact for normal ones.

    Args:
        values: Independent observations, (N,), finite.
        level: Confidence level, in (0, 1).
    """
    sample = _sample(values)
    _check_level(level)
    if len(sample) < 2 or (sample == sample[0]).all():
        return None
    reach = scipy.stats.t.ppf((1 + level) / 2, len(sample) - 1) * sample.std(ddof=1) / np.sqrt(len(sample))
    return float(sample.mean() - reach), float(sample.mean() + reach)


def bootstrap_mean_interval(
    values: ArrayLike, rng: np.random.Generator, level: float = 0.95, resamples: int = 2000
) -> tuple[float, float] | None:
    """The percentile bootstrap interval of a mean, in the unit of the values; None without values or with few samples.

    Args:
        values: Independent observations, (N,), finite.
        rng: Source of the resampling.
        level: Confidence level, in (0, 1).
        resamples: Number of bootstrap samples, >= 1.
    """
    sample = _sample(values)
    check_number("resamples", resamples, least=1)
    _check_level(level)
    if len(sample) == 0:
        return None
    return percentile_interval(
        [sample[rng.integers(len(sample), size=len(sample))].mean() for _ in range(resamples)], level
    )


def percentile_interval(statistics: ArrayLike, level: float = 0.95) -> tuple[float, float] | None:
    """The middle share of bootstrap statistics, as its two ends; None of fewer than 2 / (1 - level): 40 for 95 %.

    Of fewer, less than one would be expected beyond each end.

    Args:
        statistics: The statistic of each bootstrap sample, (R,).
        level: Share that lies between the ends, in (0, 1).
    """
    _check_level(level)
    drawn = floats("statistics", statistics)
    if len(drawn) < round(2 / (1 - level)):
        return None
    low, high = np.quantile(drawn, ((1 - level) / 2, (1 + level) / 2))
    return float(low), float(high)


def _sample(values: ArrayLike) -> NDArray[np.float64]:
    sample = floats("values", values)
    if sample.ndim != 1 or not np.isfinite(sample).all():
        raise InvalidArgumentError(f"values must be finite and of shape (N,), but have shape {sample.shape}")
    return sample


def _check_level(level: float) -> None:
    check_number("level", level, least=0, most=1, ends="()")
