"""What a pilot run tells of the scatter: between worlds and within them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtri

from maskval.statistics.cluster_intervals import ASSUMED_CORRELATION


@dataclass(frozen=True, slots=True)
class Pilot:
    """Moments of paired differences per experiment, such as of parts placed.

    Attributes:
        mean: over experiments, in the unit of the differences.
        between: variance of the worlds' means, in that unit squared.
        within: variance of experiments of one world; None if no world has two, and `between` is then the sum.
        worlds: number of worlds.
        experiments: number of experiments.
    """

    mean: float
    between: float
    within: float | None
    worlds: int
    experiments: int

    @property
    def total(self) -> float:
        """Variance of an experiment in a world of its own."""
        return self.between + (self.within or 0.0)

    def cautious(self, confidence: float = 0.8) -> "Pilot":
        """With variances at the upper end of their one-sided interval, for a pilot of few worlds.

        A plan by estimated variances has the wanted power in about half of all cases, one by their upper end in
        `confidence` of them (Browne, Stat. Med. 14, 1995, 1933-1940).
        """
        if not 0 < confidence < 1:
            raise ValueError(f"expected a confidence in (0, 1), got {confidence}")
        factor = (self.worlds - 1) / float(chdtri(self.worlds - 1, confidence))
        within = None if self.within is None else self.within * factor
        return replace(self, between=self.between * factor, within=within)


def measure_pilot(differences: Sequence[Sequence[float]]) -> Pilot:
    """The moments of a pilot run, by the analysis of variance for one random factor.

    Args:
        differences: Of each world, those of its experiments; at least two worlds.
    """
    groups = [np.asarray(group, dtype=np.float64) for group in differences if len(group)]
    if len(groups) < 2 or not all(np.isfinite(group).all() for group in groups):
        raise ValueError(f"expected finite differences of at least two worlds, got {len(groups)}")
    everything = np.concatenate(groups)
    worlds, count = len(groups), len(everything)
    mean = float(everything.mean())
    sizes = np.array([len(group) for group in groups], dtype=np.float64)
    means = np.array([group.mean() for group in groups])
    among = float(sizes @ (means - mean) ** 2) / (worlds - 1)
    if count == worlds:
        return Pilot(mean, among, None, worlds, count)
    within = sum(float(((group - group.mean()) ** 2).sum()) for group in groups) / (count - worlds)
    size = (count - float(sizes @ sizes) / count) / (worlds - 1)
    return Pilot(mean, max(0.0, (among - within) / size), within, worlds, count)


def correlation_within(successes: Sequence[int], trials: Sequence[int]) -> float:
    """The correlation of two attempts of one experiment (or world), in [0, 1], by the analysis of variance.

    The estimator of Ridout, Demétrio and Firth (Biometrics 55, 1999, 137-148). If all or none succeeded, or no
    experiment has two attempts, nothing is known of it, and it is `ASSUMED_CORRELATION`, that of the table's intervals.

    Args:
        successes: Of each experiment, (N,).
        trials: Attempts of each, (N,); experiments without one are left out.
    """
    hits, sizes = (np.asarray(numbers, dtype=np.float64) for numbers in (successes, trials))
    if hits.shape != sizes.shape or hits.ndim != 1 or not ((hits >= 0) & (hits <= sizes)).all():
        raise ValueError(f"expected successes in 0..trials, got {list(successes)} of {list(trials)}")
    hits, sizes = hits[sizes > 0], sizes[sizes > 0]
    total, count = float(sizes.sum()), len(sizes)
    share = float(hits.sum()) / total if count else 0.0
    if count < 2 or total == count or share in (0.0, 1.0):
        return ASSUMED_CORRELATION
    within = float((hits * (sizes - hits) / sizes).sum()) / (total - count)
    among = float((sizes * (hits / sizes - share) ** 2).sum()) / (count - 1)
    size = (total - float(sizes @ sizes) / total) / (count - 1)
    return float(np.clip((among - within) / (among + (size - 1) * within), 0.0, 1.0))
