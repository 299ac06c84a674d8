"""Bootstrap samples of the paper's figures, without evaluating each sample anew.

A sample of whole images is how often each image is in it. A mean over images is then a weighted sum, and one sweep over
the poses of the whole set gives every pose's share in it: only the weights change from sample to sample.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from experiments.dataset.metrics import ERROR_THRESHOLD, ERRORS_M, Figures, area, figures
from experiments.dataset.rules import Rules
from maskval import Evaluation
from maskval.evaluation.metrics import Mean, chosen, reaches, sweep

_TOGETHER = 25  # samples in memory at a time

Array = NDArray[np.float64]
Weights = NDArray[np.int64]


def draw_weights(images: int, resamples: int, rng: np.random.Generator) -> Weights:
    """How often each image is in each bootstrap sample, (R, I)."""
    return rng.multinomial(images, np.full(images, 1.0 / images), size=resamples)


def resample(evaluation: Evaluation, rules: Rules, weights: Weights) -> Iterator[Figures]:
    """The figures of each bootstrap sample.

    Args:
        evaluation: The whole set.
        rules: How it is counted.
        weights: How often each image is in each sample, (R, I).
    """
    if rules.averaging == "pooled":  # no mean over images: each sample is evaluated anew
        for row in weights:
            yield figures(evaluation.of_images(np.repeat(np.arange(evaluation.images), row)), rules)
        return
    swept = _Swept(evaluation, rules)
    for start in range(0, len(weights), _TOGETHER):
        some = weights[start : start + _TOGETHER]
        yield from map(Figures, _spearman(evaluation, some), *swept.figures(some))


class _Shares(NamedTuple):
    """What each pose, by rising u, adds to a mean over images: to its sum, and to the number of its terms."""

    total: Array
    terms: Array


class _Swept:
    """A set swept once at every error threshold.

    Attributes:
        u: uncertainties, rising, (N,).
        image: image of each pose, (N,).
        ends: the last pose of each u, (M,).
    """

    def __init__(self, evaluation: Evaluation, rules: Rules) -> None:
        order = np.argsort(evaluation.u, kind="stable")
        place = np.empty(len(order))
        place[order] = np.arange(len(order))
        self._rules = rules
        self.u, self.image = evaluation.u[order], evaluation.pose_image[order]
        self.ends = np.flatnonzero(np.append(np.diff(self.u) > 0, True)[: len(order)])
        eligible = evaluation.part_visibility >= rules.counting.visibility_threshold
        self._owed = np.bincount(evaluation.part_image[eligible], minlength=evaluation.images) > 0
        # Without ties each pose is a threshold of its own, and its share is a difference.
        ranked = replace(evaluation, u=place)
        sweeps = [sweep(ranked, float(e_t), rules.counting) for e_t in ERRORS_M]
        self._ap = [_shares(one.ap).total for one in sweeps]
        self._ap_terms = _shares(sweeps[0].ap).terms  # a pose is kept or not, whatever its error
        self._ar = [_shares(one.ar) for one in sweeps]

    def figures(self, weights: Weights) -> tuple[list[float], list[float | None]]:
        """AUC AR and u_tg of each sample."""
        often = weights[:, self.image].astype(np.float64)
        # An image without remaining poses may count as AP 1: then all images are terms from the start.
        start = float(weights.shape[1]) if self._rules.empty_images == "one" else 0.0
        eligible = (weights @ self._owed).astype(np.float64)
        terms = start + np.cumsum(often * self._ap_terms, axis=1)[:, self.ends]
        ar = np.zeros((len(weights), len(ERRORS_M)))
        reached = np.zeros(ar.shape, dtype=np.bool_)
        u_tg: list[float | None] = []
        for e, (precision, recall) in enumerate(zip(self._ap, self._ar, strict=True)):
            total = start + np.cumsum(often * precision, axis=1)[:, self.ends]
            # A threshold below all poses of the sample does not exist in it: it must not count as a violation.
            ends = chosen(reaches(Mean(total, terms)) | (terms == 0), self._rules.threshold)
            kept = [often[row, : self.ends[end] + 1] if end >= 0 else often[row, :0] for row, end in enumerate(ends)]
            reached[:, e] = [one.any() for one in kept]
            for row in np.flatnonzero(reached[:, e]):
                count = len(kept[row])
                ar_terms = eligible[row] + kept[row] @ recall.terms[:count]
                ar[row, e] = kept[row] @ recall.total[:count] / ar_terms if ar_terms > 0 else 0.0
            if e == ERROR_THRESHOLD:
                u_tg = [float(self.u[np.flatnonzero(one)[-1]]) if one.any() else None for one in kept]
        return area(ar, reached, self._rules.auc_range).tolist(), u_tg


def _shares(mean: Mean) -> _Shares:
    return _Shares(np.diff(mean.total), np.diff(mean.terms))


def _spearman(evaluation: Evaluation, weights: Weights) -> Iterator[float | None]:
    """Spearman's correlation of u and error in each sample."""
    owned = np.isfinite(evaluation.errors_m)
    image = evaluation.pose_image[owned]
    groups = [np.unique(values[owned], return_inverse=True)[1] for values in (evaluation.u, evaluation.errors_m)]
    for row in weights:
        often = row[image].astype(np.float64)
        ranks = [_middle_ranks(group, often) for group in groups]
        yield _correlation(ranks[0], ranks[1], often)


def _middle_ranks(group: NDArray[np.int64], often: Array) -> Array:
    """The rank of each value in a sample, less the middle one; equal values share the mean of their ranks."""
    size = np.bincount(group, often)
    middle: Array = np.cumsum(size) - size / 2 - often.sum() / 2
    return np.asarray(middle[group])


def _correlation(a: Array, b: Array, often: Array) -> float | None:
    variances = float(often @ a**2) * float(often @ b**2)
    return float(often @ (a * b)) / variances**0.5 if variances > 0 else None
