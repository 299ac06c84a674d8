import numpy as np
import pytest
from scipy.stats import chi2

from experiments.statistics.pilot import Pilot, correlation_within, measure_pilot
from maskval.statistics.cluster_intervals import ASSUMED_CORRELATION


def test_the_variance_is_divided_into_between_worlds_and_within() -> None:
    # Means 1, 3 and 8 of two experiments each, 1 either way of them: within 2, among 2 · 13, so 26 = 2 + 2 · 12.
    pilot = measure_pilot([[0, 2], [2, 4], [7, 9]])
    assert (pilot.mean, pilot.worlds, pilot.experiments) == (4.0, 3, 6)
    assert (pilot.within, pilot.between) == (pytest.approx(2.0), pytest.approx(12.0))
    assert pilot.total == pytest.approx(14.0)


def test_worlds_more_alike_than_chance_have_no_variance_between() -> None:
    pilot = measure_pilot([[0, 4], [4, 0], [1, 3]])
    assert pilot.between == 0.0
    assert pilot.within == pytest.approx((8 + 8 + 2) / 3)


def test_one_experiment_in_each_world_tells_the_sum_alone() -> None:
    pilot = measure_pilot([[1.0], [], [2.0], [6.0]])
    assert (pilot.within, pilot.worlds) == (None, 3)
    assert pilot.total == pytest.approx(np.var([1, 2, 6], ddof=1))


def test_the_parts_are_found_again_in_unequal_worlds() -> None:
    rng = np.random.default_rng(6)
    worlds = [rng.normal(rng.normal(0.5, 2.0), 1.0, rng.integers(1, 8)) for _ in range(4000)]
    pilot = measure_pilot(worlds)
    assert pilot.between == pytest.approx(4.0, rel=0.08)  # three standard errors of a variance of 4,000 worlds
    assert pilot.within == pytest.approx(1.0, rel=0.05)


def test_a_cautious_pilot_has_the_upper_end_of_its_variance() -> None:
    rng = np.random.default_rng(7)
    held = sum(measure_pilot(rng.normal(0, 1, (6, 1))).cautious(0.8).total >= 1.0 for _ in range(2000))
    assert held == pytest.approx(1600, abs=3 * np.sqrt(2000 * 0.8 * 0.2))
    assert Pilot(0, 2.0, 1.0, 11, 30).cautious().within == pytest.approx(10 / chi2.ppf(0.2, 10))


def test_the_correlation_within_is_found_again() -> None:
    # Beta-binomials of a + b = 4 are correlated by 1 / (a + b + 1) = .2.
    rng = np.random.default_rng(3)
    trials = rng.integers(2, 9, 20_000)
    found = correlation_within(rng.binomial(trials, rng.beta(3.2, 0.8, 20_000)).tolist(), trials.tolist())
    assert found == pytest.approx(0.2, abs=0.01)
    independent = correlation_within(rng.binomial(trials, 0.8).tolist(), trials.tolist())
    assert independent == pytest.approx(0.0, abs=0.01)


def test_experiments_that_are_all_or_nothing_are_fully_correlated() -> None:
    assert correlation_within([8, 0, 8, 8, 0], [8, 8, 8, 8, 8]) == pytest.approx(1.0)


@pytest.mark.parametrize(("successes", "trials"), [([8, 8], [8, 8]), ([0], [5]), ([], []), ([1, 0, 1], [1, 1, 1])])
def test_where_nothing_is_known_of_the_correlation_it_is_the_tables(successes: list[int], trials: list[int]) -> None:
    assert correlation_within(successes, trials) == ASSUMED_CORRELATION


def test_what_is_no_pilot_is_refused() -> None:
    with pytest.raises(ValueError, match="expected finite differences of at least two worlds, got 1"):
        measure_pilot([[1.0, 2.0], []])
    with pytest.raises(ValueError, match="expected finite differences"):
        measure_pilot([[1.0], [np.nan]])
    with pytest.raises(ValueError, match=r"expected successes in 0\.\.trials, got \[9\] of \[8\]"):
        correlation_within([9], [8])
    with pytest.raises(ValueError, match=r"expected a confidence in \(0, 1\), got 1"):
        measure_pilot([[1.0], [2.0]]).cautious(1)
