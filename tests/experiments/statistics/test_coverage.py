"""How often the interval of a difference contains the truth, and how often the bootstrap over the same worlds does.

Two methods meet the same parts in worlds that differ: 8 parts per experiment, of which each method tries about nine in
ten; seven in ten parts treat both alike. Pooled AP, and cycle time, whose numerator is a time.
"""

import numpy as np
import pytest
from numpy.typing import NDArray

from experiments.statistics.clusters import ratio_difference

SAMPLES, RESAMPLES = 1000, 999
Array = NDArray[np.float64]
Sums = tuple[Array, Array]

CASES = [(0.90, 0.90, 0.3), (0.97, 0.97, 1.0), (0.95, 0.85, 1.0)]  # rates, spread of the worlds' logits


def draw(rng: np.random.Generator, worlds: int, each: int, case: tuple[float, float, float]) -> tuple[Sums, Sums]:
    """Parts placed and tried, summed by world, of both methods, (W,)."""
    *means, spread = case
    logits = np.log(np.array(means) / (1 - np.array(means)))[:, None]
    shifts = rng.normal(0, spread, worlds) + rng.normal(0, spread / 2, (2, worlds))
    rates = 1 / (1 + np.exp(-logits - shifts))
    luck = rng.random((worlds, each, 8))
    other = np.where(rng.random(luck.shape) < 0.7, luck, rng.random(luck.shape))
    tried = np.arange(8) < 8 - rng.binomial(8, 0.1, (2, worlds, each, 1))
    placed = np.stack([luck, other]) < rates[:, :, None, None]
    counts = (placed & tried).sum(axis=(2, 3)).astype(float), tried.sum(axis=(2, 3)).astype(float)
    return (counts[0][0], counts[1][0]), (counts[0][1], counts[1][1])


def as_time(rng: np.random.Generator, sums: Sums, each: int) -> Sums:
    """Time (s) and parts placed: 20 s per slot, 3 s less for a part that was placed."""
    placed, _ = sums
    return 160.0 * each - 3 * placed + rng.normal(0, 5, len(placed)), placed


def difference(first: Sums, second: Sums) -> float:
    return float(first[0].sum() / first[1].sum() - second[0].sum() / second[1].sum())


def percentiles(rng: np.random.Generator, first: Sums, second: Sums) -> tuple[float, float]:
    chosen = rng.integers(len(first[0]), size=(RESAMPLES, len(first[0])))
    sums = [numbers[chosen].sum(axis=1) for numbers in (*first, *second)]
    there = (sums[1] > 0) & (sums[3] > 0)
    sums = [numbers[there] for numbers in sums]
    low, high = np.quantile(sums[0] / sums[1] - sums[2] / sums[3], (0.025, 0.975))
    return float(low), float(high)


@pytest.mark.study
@pytest.mark.parametrize("figure", ["ap", "cycle time"])
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("each", [1, 5])
@pytest.mark.parametrize("worlds", [5, 10, 20, 50])
def test_students_interval_over_worlds_contains_the_truth_and_the_bootstraps_less_often(
    worlds: int, each: int, case: tuple[float, float, float], figure: str
) -> None:
    rng = np.random.default_rng([worlds, each])

    def sample(count: int) -> tuple[Sums, Sums]:
        pair = draw(rng, count, each, case)
        return pair if figure == "ap" else (as_time(rng, pair[0], each), as_time(rng, pair[1], each))

    truth = difference(*sample(200_000 // each))
    held = {"student": 0, "bootstrap": 0}
    for _ in range(SAMPLES):
        first, second = sample(worlds)
        found = ratio_difference(first, second, range(worlds)).interval
        held["student"] += found is None or found[0] <= truth <= found[1]
        low, high = percentiles(rng, first, second)
        held["bootstrap"] += low <= truth <= high
    assert held["student"] >= 0.90 * SAMPLES, held
    assert held["student"] >= held["bootstrap"] - (10 if worlds == 50 else 0), held  # they meet where worlds are many
