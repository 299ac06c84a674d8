"""How many experiments a question needs, with the scatter that a pilot run had."""

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil, inf, log, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.special import bdtr, nctdtr, stdtrit

from experiments.statistics.pilot import Pilot
from maskval.statistics.cluster_intervals import clustered_rate_interval

Array = NDArray[np.float64]

SAMPLES = 500  # simulated runs for a power: a standard error of 1.8 % at 80 %
_MOST = 10**7  # more experiments than anybody runs
_LONGEST = 10**4  # as many are simulated at most
_ENDLESS = 10**4  # rounds over all worlds after which only these differ


@dataclass(frozen=True, slots=True)
class DifferencePlan:
    """How many experiments tell a difference between two methods.

    Attributes:
        experiments: in all; None if no number of them suffices in so many worlds.
        worlds: over how many worlds they are spread, evenly.
        power: chance to find the difference with them, in [0, 1]; the most that can be had if `experiments` is None.
    """

    experiments: int | None
    worlds: int
    power: float


@dataclass(frozen=True, slots=True)
class BoundPlan:
    """How many experiments show a rate above a bound.

    Attributes:
        attempts: how many would do if all were independent.
        failures: of those, how many may fail.
        experiments: in all, with attempts that are alike; None if no number suffices in so many worlds.
        power: chance that the table's interval shows the bound with them, in [0, 1], of `SAMPLES` simulated runs; the
            most that was found if `experiments` is None.
    """

    attempts: int
    failures: int
    experiments: int | None
    power: float


def plan_difference(
    pilot: Pilot, wanted: float, power: float = 0.8, alpha: float = 0.05, worlds: int | None = None
) -> DifferencePlan:
    """The fewest experiments with which Student's test over worlds finds a difference.

    Args:
        pilot: Scatter of the paired differences.
        wanted: The true difference to be found, in the unit of the pilot, not 0.
        power: Chance to find it, in (alpha, 1).
        alpha: Level of the two-sided test, in (0, 1).
        worlds: How many there are; None if each experiment has another one.

    Raises:
        ValueError: an argument is out of range, or worlds are to repeat and the pilot has no two experiments of one.
    """
    if not (0 < alpha < power < 1) or wanted == 0 or not abs(wanted) < inf or pilot.total <= 0:
        raise ValueError(
            f"expected 0 < alpha < power < 1, a difference other than 0 and a pilot with scatter, got alpha {alpha}, "
            f"power {power}, a difference of {wanted} and a variance of {pilot.total}"
        )
    if worlds is None:
        count = _fewest(lambda n: student_power(wanted / sqrt(pilot.total / n), n - 1, alpha) >= power, 2)
        return DifferencePlan(count, count, student_power(wanted / sqrt(pilot.total / count), count - 1, alpha))
    if worlds < 2 or pilot.within is None:
        raise ValueError(f"expected two worlds or more, and two pilot experiments in one of them, got {worlds} worlds")
    between, within = pilot.between, pilot.within

    def reached(each: float) -> float:
        variance = (between + within / each) / worlds
        return student_power(wanted / sqrt(variance) if variance > 0 else inf, worlds - 1, alpha)

    if reached(inf) < power:
        return DifferencePlan(None, worlds, reached(inf))
    each = _fewest(lambda n: reached(n) >= power, 1)
    return DifferencePlan(each * worlds, worlds, reached(each))


def plan_bound(
    bound: float,
    expected: float,
    attempts_each: float,
    correlation: float,
    *,
    power: float = 0.8,
    confidence: float = 0.95,
    worlds: int | None = None,
) -> BoundPlan:
    """The fewest experiments that show a rate of at least `bound`, by the table's interval (`clustered_rate_interval`).

    Runs are simulated with beta-binomial successes: of experiments, or of worlds if these repeat. The interval must not
    reach below the bound on its lower side. Counting n alike attempts as n / (1 + (s - 1) ρ) promises too much: the
    variance between experiments is estimated, and unknown without a failure. Plans by it for a power of 80 % had 47 to
    74 %.

    Args:
        bound: To be shown, in (0, 1).
        expected: True rate, above the bound; 1 for a run without failures.
        attempts_each: Mean number of attempts in an experiment, >= 1.
        correlation: Of two attempts of one experiment, or of one world if these repeat, in [0, 1]; see
            `correlation_within`.
        power: Chance to show it, in (0, 1).
        confidence: That the rate is not below the interval, in (0.5, 1): 0.975 for the lower end of the table's.
        worlds: How many there are; None if each experiment has another one.
    """
    if not (0 < bound < expected <= 1 and attempts_each >= 1 and 0 <= correlation <= 1):
        raise ValueError(
            f"expected 0 < bound < expected rate <= 1, at least 1 attempt and a correlation in 0..1, "
            f"got bound {bound}, expected rate {expected}, {attempts_each} attempts and a correlation of {correlation}"
        )
    if not (0 < power < 1 and 0.5 < confidence < 1) or (worlds is not None and worlds < 1):
        raise ValueError(
            f"expected a power in (0, 1), a confidence in (0.5, 1) and a world, got {power}, {confidence}, {worlds}"
        )
    failures = _fewest(lambda count: _shown(count, bound, expected, confidence)[1] >= power, 0)
    attempts = _shown(failures, bound, expected, confidence)[0]

    def reached(units: int) -> float:
        """With so many experiments, or rounds over all worlds."""
        clusters, trials = (units, round(attempts_each)) if worlds is None else (worlds, round(attempts_each * units))
        return _simulated_power(bound, _rates(expected, clusters, trials, correlation), trials, confidence)

    each = 1 if worlds is None else worlds
    if worlds is not None and reached(_ENDLESS) < power:
        return BoundPlan(attempts, failures, None, reached(_ENDLESS))
    units = _fewest(lambda count: reached(count) >= power, ceil(attempts / attempts_each / each), _LONGEST)
    return BoundPlan(attempts, failures, each * units, reached(units))


def _rates(rate: float, clusters: int, trials: int, correlation: float) -> Array:
    """Shares of successes of `SAMPLES` simulated runs, (S, clusters): beta-binomial; one run of ones if all succeed."""
    rng = np.random.default_rng(clusters)
    if rate == 1:
        return np.ones((1, clusters))
    if correlation == 1:
        return rng.binomial(1, rate, (SAMPLES, clusters)).astype(np.float64)
    if correlation == 0:
        return rng.binomial(trials, rate, (SAMPLES, clusters)) / trials
    weight = 1 / correlation - 1
    shares = rng.beta(rate * weight, (1 - rate) * weight, (SAMPLES, clusters))
    return np.asarray(rng.binomial(trials, shares) / trials)


def _simulated_power(bound: float, rates: Array, trials: int, confidence: float) -> float:
    """In how many runs the table's interval of the mean of their rates, (S, clusters), stays above a bound."""
    clusters = rates.shape[1]
    sizes = np.full(clusters, trials)
    found = 0
    for run in rates:
        interval = clustered_rate_interval(run, sizes, range(clusters), 2 * confidence - 1)
        assert interval is not None  # there are rates
        found += interval[0] >= bound
    return found / len(rates)


def _shown(failures: int, bound: float, expected: float, confidence: float) -> tuple[int, float]:
    """How many attempts of which so many fail show the bound, and the chance that no more of them fail."""
    attempts = _fewest(lambda n: bdtr(failures, n, 1 - bound) <= 1 - confidence, failures + 1)
    return attempts, float(bdtr(failures, attempts, 1 - expected))


def failure_free_attempts(bound: float, confidence: float = 0.95) -> int:
    """How many independent attempts without a failure show a rate of at least `bound`: 299 for 0.99.

    Args:
        bound: In (0, 1).
        confidence: In (0, 1).
    """
    if not (0 < bound < 1 and 0 < confidence < 1):
        raise ValueError(f"expected a bound and a confidence in (0, 1), got {bound} and {confidence}")
    return max(1, ceil(log(1 - confidence) / log(bound) - 1e-9))


def student_power(distance: float, freedom: int, alpha: float = 0.05) -> float:
    """Chance that a two-sided t test at `alpha` finds a mean that is `distance` standard errors from 0, in [0, 1].

    Args:
        distance: May be inf.
        freedom: Degrees of freedom, >= 1.
        alpha: Level, in (0, 1).
    """
    if abs(distance) > 1e3:  # where scipy's distribution is nan; the power is 1 but for one degree of freedom
        distance = 1e3
    limit = float(stdtrit(freedom, 1 - alpha / 2))
    return float(1 - nctdtr(freedom, abs(distance), limit) + nctdtr(freedom, abs(distance), -limit))


def _fewest(suffices: Callable[[int], bool], start: int, most: int = _MOST) -> int:
    """The smallest number from `start` on that suffices, if all larger ones do."""
    if suffices(start):
        return start
    low, high = start, max(1, 2 * start)
    while not suffices(high):
        if high > most:
            raise ValueError(f"expected a question that {most:,} experiments can answer; this one needs more")
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if suffices(middle) else (middle, high)
    return high
