"""Confidence intervals of rates whose observations come in clusters that are alike within."""

from collections.abc import Hashable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import stdtrit

from maskval.errors import InvalidArgumentError
from maskval.inputs.arrays import check_number, floats
from maskval.statistics.intervals import clopper_pearson

FEWEST_CLUSTERS = 10  # below, the variance between them is too uncertain: with it, intervals of 5 covered 88 %
# The correlation within a cluster where it cannot be estimated: as much as the most correlated cell of
# docs/results/predict.json has. A beta-binomial of this correlation gives narrower bounds than the rule below.
ASSUMED_CORRELATION = 0.5

Array = NDArray[np.float64]


def clustered_rate_interval(
    rates: ArrayLike, trials: ArrayLike, clusters: Sequence[Hashable], level: float = 0.95
) -> tuple[float, float] | None:
    """The two-sided interval of a mean of rates, in [0, 1], which it always contains; None without rates.

    Korn and Graubard's (Survey Methodology 24, 1998): Clopper-Pearson's with the effective number of trials n* for the
    number of trials and m n* for that of successes, m being the mean and V its variance as estimated between clusters,

        n* = min(m (1 - m) / V, n) (t(n - 1) / t(clusters - 1))²,

    with t for the quantiles of Student's distribution. With fewer than `FEWEST_CLUSTERS` clusters, or if all rates are
    0 or all are 1, V says nothing; then n* = n / (1 + (s - 1) ρ), with s for the size of a trial's cluster, on average
    over trials, and ρ = `ASSUMED_CORRELATION`.

    Args:
        rates: Shares of successes, (N,), in [0, 1]; each weighs the same in the mean.
        trials: Number of trials behind each, (N,), >= 1.
        clusters: Label of the cluster of each, (N,); clusters are independent of one another.
        level: Confidence level, in (0, 1).
    """
    values, sizes = floats("rates", rates), floats("trials", trials)
    if not values.shape == sizes.shape == (len(clusters),):
        raise InvalidArgumentError(
            f"expected rates, trials and clusters of one shape (N,), got {values.shape}, {sizes.shape} and "
            f"{len(clusters)} clusters"
        )
    if not ((values >= 0) & (values <= 1)).all() or not ((sizes >= 1) & np.isfinite(sizes)).all():
        raise InvalidArgumentError("expected rates in 0..1 and at least 1 trial behind each")
    check_number("level", level, least=0, most=1, ends="()")
    if len(values) == 0:
        return None
    labels = {label: index for index, label in enumerate(dict.fromkeys(clusters))}
    cluster = np.array([labels[label] for label in clusters])
    mean = float(values.mean())
    if len(labels) < FEWEST_CLUSTERS or (values == 0).all() or (values == 1).all():
        effective = _assumed_size(np.bincount(cluster, sizes).astype(np.float64))
    else:
        effective = _estimated_size(values, sizes, cluster, level)
    low, high = clopper_pearson(mean * effective, effective, (1 - level) / 2)
    return min(low, mean), max(high, mean)


def _assumed_size(sizes: Array) -> float:
    """The effective number of trials in clusters of these sizes, (C,), if they are correlated as assumed."""
    total = float(sizes.sum())
    return total / (1 + (float(sizes @ sizes) / total - 1) * ASSUMED_CORRELATION)


def _estimated_size(values: Array, sizes: Array, cluster: NDArray[np.int64], level: float) -> float:
    """The effective number of trials by the variance between clusters, (N,) each."""
    mean, total, count = float(values.mean()), float(sizes.sum()), int(cluster.max()) + 1
    residuals = np.bincount(cluster, values - mean) / len(values)
    variance = float(residuals @ residuals) * count / (count - 1)
    effective = min(mean * (1 - mean) / variance, total) if variance > 0 else total
    quantiles = [float(stdtrit(freedom, (1 + level) / 2)) for freedom in (total - 1, count - 1)]
    return effective * (quantiles[0] / quantiles[1]) ** 2
