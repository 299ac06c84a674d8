"""How often a run stops though the mean is the bound itself: at most 5 %, looking after every experiment.

Of 2,000 runs at 5 % exactly, more than 131 stop in one of 1,000 trials: the 99.9 % point of the binomial.
"""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import binom, t

from experiments.statistics.pilot import measure_pilot
from experiments.statistics.planning import plan_difference
from experiments.statistics.sequential import is_above, units_of

RUNS, EXPERIMENTS = 2000, 100
MOST = int(binom.ppf(0.999, RUNS, 0.05))

Draw = Callable[[np.random.Generator], NDArray[np.float64]]


def rates_of_unlike_experiments(rng: np.random.Generator) -> NDArray[np.float64]:
    """AP of 8 attempts; the true rate of an experiment is beta-distributed around .9, with four times the variance."""
    return rng.binomial(8, rng.beta(0.9 * 4 / 3, 0.1 * 4 / 3, EXPERIMENTS)) / 8


def rates_near_one(rng: np.random.Generator) -> NDArray[np.float64]:
    return rng.binomial(8, 0.99, EXPERIMENTS) / 8


def skewed_differences(rng: np.random.Generator) -> NDArray[np.float64]:
    """Parts placed less the other method's: seldom all 8 more, else 2 less; mean 0."""
    return rng.choice([8.0, -2.0], p=[0.2, 0.8], size=EXPERIMENTS)


def rounds_over_worlds(rng: np.random.Generator) -> NDArray[np.float64]:
    """Five worlds of rates .5 to 1, whose mean is .8, in turn."""
    values = rng.binomial(8, np.tile([0.5, 0.7, 0.8, 1.0, 1.0], 40)) / 8
    return np.array(units_of(list(values), list(range(5)) * 40).values)


@pytest.mark.parametrize(
    ("draw", "bound", "low", "high"),
    [
        (rates_of_unlike_experiments, 0.9, 0, 1),
        (rates_near_one, 0.99, 0, 1),
        (skewed_differences, 0.0, -8, 8),
        (rounds_over_worlds, 0.8, 0, 1),
    ],
)
def test_a_run_stops_falsely_in_five_percent_at_most(draw: Draw, bound: float, low: float, high: float) -> None:
    rng = np.random.default_rng(11)
    stops = sum(is_above(draw(rng), bound, low, high).above is not None for _ in range(RUNS))
    assert MOST == 131
    assert stops <= MOST


def test_students_interval_at_every_look_would_stop_falsely_far_more_often() -> None:
    rng = np.random.default_rng(11)
    stops = 0
    for _ in range(300):
        values = skewed_differences(rng)
        counts = np.arange(1, EXPERIMENTS + 1)
        means = np.cumsum(values) / counts
        spreads = np.sqrt(np.maximum(np.cumsum(values**2) / counts - means**2, 1e-12) / np.maximum(counts - 1, 1))
        stops += bool((np.abs(means) > t.ppf(0.975, np.maximum(counts - 1, 1)) * spreads)[9:].any())
    assert stops > 0.15 * 300


@pytest.mark.parametrize(
    ("better", "worse", "most"),
    [(0.97, 0.90, 120), (0.95, 0.80, 70)],  # 0.56 and 1.2 parts per experiment more
)
def test_a_difference_is_found_in_nine_of_ten_runs(better: float, worse: float, most: int) -> None:
    rng = np.random.default_rng(2)
    answers = [
        is_above(rng.binomial(8, better, most).astype(float) - rng.binomial(8, worse, most), 0.0, -8, 8)
        for _ in range(200)
    ]
    assert sum(answer.above is True for answer in answers) >= 180
    assert sum(answer.above is False for answer in answers) <= 10


def test_looking_after_every_experiment_costs_about_three_times_as_many_as_a_plan_for_one_look() -> None:
    # 95 % against 85 % of 8 parts, three quarters of which treat both alike.
    rng = np.random.default_rng(5)

    def differences(count: int) -> NDArray[np.float64]:
        luck = rng.random((count, 8))
        other = np.where(rng.random((count, 8)) < 0.75, luck, rng.random((count, 8)))
        return ((luck < 0.95).sum(axis=1) - (other < 0.85).sum(axis=1)).astype(float)

    planned = plan_difference(measure_pilot([[value] for value in differences(20_000)]), 0.8).experiments
    needed = float(np.median([is_above(differences(150), 0.0, -8, 8).units for _ in range(100)]))
    assert 2.5 * planned < needed < 4 * planned
