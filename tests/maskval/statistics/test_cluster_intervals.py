import numpy as np
import pytest
from scipy.stats import beta, t

from maskval.statistics.cluster_intervals import ASSUMED_CORRELATION, FEWEST_CLUSTERS, clustered_rate_interval


def tails(successes: float, trials: float, interval: tuple[float, float]) -> tuple[float, float]:
    """What Clopper-Pearson's ends leave below the successes and above them, as Beta probabilities."""
    low, high = interval
    return (
        float(beta.cdf(low, successes, trials - successes + 1)),
        float(beta.sf(high, successes + 1, trials - successes)),
    )


def test_trials_count_by_the_variance_between_clusters() -> None:
    # Ten clusters at .3 and .7: the variance of the mean is .04 / 9, and .25 / (.04 / 9) = 56.25 trials of 80.
    rates, trials = 5 * [0.3, 0.7], 10 * [8]
    effective = 56.25 * (t.ppf(0.975, 79) / t.ppf(0.975, 9)) ** 2
    interval = clustered_rate_interval(rates, trials, range(10))
    assert interval is not None
    assert tails(0.5 * effective, effective, interval) == pytest.approx((0.025, 0.025))


def test_experiments_of_one_cluster_bring_no_more_than_their_mean() -> None:
    # Equal experiments within a cluster add no knowledge of the variance between: only the t-quantile of n moves.
    rates = np.array(2 * [0.1, 0.9, 0.4, 0.6, 0.2, 0.8])
    once = clustered_rate_interval(rates, 12 * [8], range(12))
    thrice = clustered_rate_interval(np.repeat(rates, 3), 36 * [8], np.repeat(range(12), 3).tolist())
    apart = clustered_rate_interval(np.repeat(rates, 3), 36 * [8], range(36))
    assert once == pytest.approx(thrice, abs=0.01)
    assert apart[1] - apart[0] < 0.7 * (thrice[1] - thrice[0])


def test_clusters_more_equal_than_chance_count_as_independent_trials() -> None:
    effective = 80 * (t.ppf(0.975, 79) / t.ppf(0.975, 9)) ** 2
    interval = clustered_rate_interval(10 * [0.75], 10 * [8], range(10))
    assert interval is not None
    assert tails(0.75 * effective, effective, interval) == pytest.approx((0.025, 0.025))


@pytest.mark.parametrize("clusters", [1, 2, FEWEST_CLUSTERS - 1, 20])
def test_all_or_none_is_clopper_pearsons_of_trials_correlated_by_a_half(clusters: int) -> None:
    assert ASSUMED_CORRELATION == 0.5
    effective = clusters * 8 / (1 + 7 / 2)
    labels = range(clusters)
    low, high = clustered_rate_interval(clusters * [1.0], clusters * [8], labels) or (None, None)
    assert (low, high) == (pytest.approx(0.025 ** (1 / effective)), 1.0)
    assert clustered_rate_interval(clusters * [0.0], clusters * [8], labels) == (0.0, pytest.approx(1 - low))


def test_few_clusters_are_not_asked_for_their_variance() -> None:
    few = FEWEST_CLUSTERS - 1
    effective = few * 8 / 4.5
    interval = clustered_rate_interval(few * [0.5], few * [8], range(few))
    assert interval is not None
    assert tails(0.5 * effective, effective, interval) == pytest.approx((0.025, 0.025))


def test_unequal_clusters_count_by_the_cluster_of_the_average_trial() -> None:
    # 6 trials in one cluster, 2 in another: the average trial has 6 · 6/8 + 2 · 2/8 = 5 in its own.
    effective = 8 / (1 + 4 / 2)
    assert clustered_rate_interval([1, 1, 1], [4, 2, 2], ["a", "a", "b"]) == (
        pytest.approx(0.025 ** (1 / effective)),
        1.0,
    )


def test_an_interval_holds_its_mean_lies_within_0_and_1_and_does_not_hang_on_the_order() -> None:
    rng = np.random.default_rng(7)
    for number in range(300):
        size = int(rng.integers(1, 30))
        trials = rng.integers(1, 9, size=size)
        rates = rng.binomial(trials, rng.choice([0.02, 0.5, 0.98])) / trials
        clusters = rng.integers(1 + number % 12, size=size).tolist()
        low, high = clustered_rate_interval(rates, trials, clusters) or (2.0, -1.0)
        assert 0 <= low <= rates.mean() <= high <= 1
        order = rng.permutation(size)
        again = clustered_rate_interval(rates[order], trials[order], [clusters[place] for place in order])
        assert again == pytest.approx((low, high), abs=1e-9)


def test_no_rates_have_no_interval_and_a_higher_level_a_wider_one() -> None:
    assert clustered_rate_interval([], [], []) is None
    rates = [0.2, 0.4, 0.6, 0.8, 1.0]
    narrow, wide = (clustered_rate_interval(rates, 5 * [8], range(5), level) for level in (0.8, 0.99))
    assert wide[0] < narrow[0] < narrow[1] < wide[1]


@pytest.mark.parametrize(
    ("rates", "trials", "clusters", "level", "words"),
    [
        ([0.5, 0.5], [8], [0, 1], 0.95, r"got \(2,\), \(1,\) and 2 clusters"),
        ([0.5], [8], [0, 1], 0.95, r"got \(1,\), \(1,\) and 2 clusters"),
        ([1.1], [8], [0], 0.95, r"expected rates in 0\.\.1"),
        ([np.nan], [8], [0], 0.95, r"expected rates in 0\.\.1"),
        ([0.5], [0], [0], 0.95, "at least 1 trial"),
        ([0.5], [8], [0], 1.0, r"level must be in \(0, 1\), but is 1"),
    ],
)
def test_what_is_no_sample_of_rates_is_refused(rates, trials, clusters, level, words) -> None:
    with pytest.raises(ValueError, match=words):
        clustered_rate_interval(rates, trials, clusters, level)
