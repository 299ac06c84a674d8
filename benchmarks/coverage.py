"""`python -m benchmarks.coverage FILE`: how often a 95 % interval of a rate contains the true rate.

Draws worlds with replacement from docs/results/predict.json, whose mean is then the true rate; and simulates worlds
whose success rates are beta-distributed, so that an experiment of 8 parts has up to 4 times the binomial variance.
Writes the share of intervals that contain the true rate, and their mean width, in %, to FILE as JSON.
"""

import json
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from experiments.results.provenance import write_json
from maskval import proportion_interval
from maskval.statistics.cluster_intervals import clustered_rate_interval

PREDICTION = Path(__file__).parents[1] / "docs" / "results" / "predict.json"
WORLDS = (20, 10, 5)
PARTS = 8
MEANS, DESIGN_EFFECTS = (0.5, 0.8, 0.9, 0.97), (1.0, 2.0, 3.0, 4.0)
_RESAMPLES = 999

Array = NDArray[np.float64]
Interval = tuple[float, float]


class Sample(NamedTuple):
    """Rates of experiments, the trials behind each, and their worlds; (N,) each."""

    rates: Array
    trials: Array
    worlds: NDArray[np.int64]


Draw = Callable[[np.random.Generator], Sample]


def recorded(counts: NDArray[np.int64], rate: str, worlds: int, experiments: int) -> tuple[Draw, float]:
    """Draws from a cell of predict.json, (W, E, 4), and its rate, the mean over the experiments that have one."""
    hits, trials = counts[..., 0], counts[..., 0] + counts[..., {"ap": 1, "ar": 2}[rate]]
    rates = np.where(trials > 0, hits / np.maximum(trials, 1), np.nan)

    def draw(rng: np.random.Generator) -> Sample:
        world = rng.integers(len(counts), size=(worlds, 1))
        chosen = world, rng.integers(counts.shape[1], size=(worlds, experiments))
        label = np.broadcast_to(np.arange(worlds)[:, None], chosen[1].shape)
        there = trials[chosen] > 0
        return Sample(rates[chosen][there], trials[chosen][there].astype(np.float64), label[there])

    return draw, float(np.nanmean(rates))


def simulated(mean: float, design_effect: float, worlds: int) -> Draw:
    """Draws of one experiment in each world, of 8 parts: binomial, the worlds' rates beta-distributed."""
    correlation = (design_effect - 1) / (PARTS - 1)

    def draw(rng: np.random.Generator) -> Sample:
        size = 1 / correlation - 1 if correlation > 0 else np.inf
        rate = rng.beta(mean * size, (1 - mean) * size, worlds) if correlation > 0 else np.full(worlds, mean)
        return Sample(rng.binomial(PARTS, rate) / PARTS, np.full(worlds, float(PARTS)), np.arange(worlds))

    return draw


def of_the_table(sample: Sample) -> Interval | None:
    """What the table prints."""
    return clustered_rate_interval(sample.rates, sample.trials, sample.worlds.tolist())


def pooled(sample: Sample) -> Interval | None:
    """Clopper-Pearson of all attempts, as if they were independent."""
    return proportion_interval(round(float(sample.rates @ sample.trials)), round(float(sample.trials.sum())))


def student(sample: Sample) -> Interval | None:
    """Student's, with the variance between worlds."""
    sums, sizes, _ = _resampled(sample)
    mean, error = _mean_and_error(sums, sizes, np.ones(len(sums)))
    reach = float(stats.t.ppf(0.975, len(sums) - 1)) * error
    return max(float(mean - reach), 0.0), min(float(mean + reach), 1.0)


def bca(sample: Sample) -> Interval | None:
    """The bias-corrected and accelerated bootstrap over worlds; the table's where no world differs."""
    sums, sizes, weights = _resampled(sample)
    mean = sums.sum() / sizes.sum()
    means = np.sort(weights @ sums / (weights @ sizes))
    if means[-1] - means[0] < 1e-9:
        return of_the_table(sample)
    below = np.mean(means < mean - 1e-9) + np.mean(np.abs(means - mean) <= 1e-9) / 2
    bias = stats.norm.ppf(np.clip(below, 1 / len(means), 1 - 1 / len(means)))
    without = (sums.sum() - sums) / (sizes.sum() - sizes)
    off = without.mean() - without
    acceleration = (off**3).sum() / (6 * (off**2).sum() ** 1.5)
    shifted = bias + stats.norm.ppf([0.025, 0.975])
    low, high = np.quantile(means, stats.norm.cdf(bias + shifted / (1 - acceleration * shifted)))
    return float(low), float(high)


def studentised(sample: Sample) -> Interval | None:
    """The bootstrap-t over worlds; the table's where no world differs."""
    sums, sizes, weights = _resampled(sample)
    mean, error = _mean_and_error(sums, sizes, np.ones(len(sums)))
    if error < 1e-9:
        return of_the_table(sample)
    means, errors = _mean_and_error(sums, sizes, weights)
    t = np.where(np.abs(means - mean) < 1e-9, 0.0, (means - mean) / np.maximum(errors, 1e-12))
    low, high = np.quantile(t, (0.025, 0.975), method="inverted_cdf")
    return max(float(mean - high * error), 0.0), min(float(mean - low * error), 1.0)


INTERVALS = {
    "table": of_the_table,
    "pooled": pooled,
    "student": student,
    "bca": bca,
    "studentised": studentised,
}


def coverage(
    draw: Draw, truth: float, interval: Callable[[Sample], Interval | None], samples: int, seed: int
) -> tuple[float, float]:
    """The share of intervals that contain the truth, and their mean width.

    Args:
        draw: Draws a sample.
        truth: The rate.
        interval: What is asked; one that is not given contains nothing.
        samples: How many.
        seed: Of the samples; equal ones for every interval.
    """
    rng = np.random.default_rng(np.random.SeedSequence(seed))
    found = [interval(draw(rng)) or (np.inf, np.inf) for _ in range(samples)]
    hit = [low - 1e-9 <= truth <= high + 1e-9 for low, high in found]
    return float(np.mean(hit)), float(np.mean([high - low for low, high in found if np.isfinite(low)]))


def settings(worlds: int) -> dict[str, tuple[Draw, float]]:
    """Everything that is drawn from, with its rate, by name."""
    found = {}
    for cell in json.loads(PREDICTION.read_text(encoding="utf-8"))["variants"]["base"]["cells"]:
        for rate in ("ap", "ar"):
            for experiments in (1, 10):
                name = f"{cell['object']} × {cell['method']}, {rate}, {experiments} per world"
                found[name] = recorded(np.array(cell["counts"]), rate, worlds, experiments)
    for mean in MEANS:
        for effect in DESIGN_EFFECTS:
            found[f"simulated, rate {mean:g}, design effect {effect:g}"] = simulated(mean, effect, worlds), mean
    return found


def _resampled(sample: Sample) -> tuple[Array, Array, Array]:
    """By world: the sum of its rates, their number, and how often it is in each bootstrap sample, (R, W)."""
    _, world = np.unique(sample.worlds, return_inverse=True)
    sums = np.bincount(world, sample.rates)
    return sums, np.bincount(world).astype(np.float64), _weights(len(sums))


@cache
def _weights(worlds: int) -> Array:
    rng = np.random.default_rng(np.random.SeedSequence(0))
    return rng.multinomial(worlds, np.full(worlds, 1 / worlds), size=_RESAMPLES).astype(np.float64)


def _mean_and_error(sums: Array, sizes: Array, weights: Array) -> tuple[Array, Array]:
    """The mean of the rates and its linearised standard error, of each row of weights."""
    number = weights @ sizes
    mean = weights @ sums / number
    squares = weights @ sums**2 - 2 * mean * (weights @ (sums * sizes)) + mean**2 * (weights @ sizes**2)
    count = len(sums)
    return mean, np.sqrt(np.maximum(squares, 0.0) * count / (count - 1)) / number


def main(file: Path, samples: int = 2000) -> None:
    """Draws, prints the least coverage of each interval and writes all of them."""
    found: dict[str, dict[str, dict[str, tuple[float, float]]]] = {}
    for worlds in WORLDS:
        rows = {
            setting: {name: coverage(draw, truth, interval, samples, seed) for name, interval in INTERVALS.items()}
            for seed, (setting, (draw, truth)) in enumerate(settings(worlds).items())
        }
        found[f"{worlds} worlds"] = {
            setting: {name: (round(100 * hit, 1), round(100 * width, 1)) for name, (hit, width) in row.items()}
            for setting, row in rows.items()
        }
        for name in INTERVALS:
            least = min(rows, key=lambda setting: rows[setting][name][0])
            print(f"{worlds:2} worlds, {name:11} least coverage {100 * rows[least][name][0]:.1f} %: {least}")
    write_json(
        file,
        {"command": f"python -m benchmarks.coverage {file}", "samples": samples, "[coverage, mean width] in %": found},
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]))
