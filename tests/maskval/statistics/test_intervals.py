import numpy as np
import pytest

from maskval import bootstrap_mean_interval, mean_interval, proportion_interval
from maskval.statistics.intervals import percentile_interval


def test_the_interval_of_no_trials_is_none() -> None:
    assert proportion_interval(0, 0) is None
    assert bootstrap_mean_interval([], np.random.default_rng(0)) is None


@pytest.mark.parametrize(("level", "trials"), [(0.95, 40), (0.9, 7), (0.99, 1)])
def test_the_interval_of_all_successes_ends_where_they_become_unlikely(level, trials) -> None:
    # Clopper-Pearson: p^n = (1 - level) / 2 at the lower end of n successes in n trials.
    low, high = proportion_interval(trials, trials, level)
    assert (low, high) == (pytest.approx(((1 - level) / 2) ** (1 / trials), rel=1e-12), 1.0)
    assert proportion_interval(0, trials, level) == (0.0, pytest.approx(1 - low, rel=1e-12))


def test_the_interval_holds_the_proportion_as_often_as_it_says() -> None:
    rng = np.random.default_rng(1)
    intervals = [proportion_interval(int(k), 30, 0.9) for k in rng.binomial(30, 0.7, size=400)]
    assert sum(low <= 0.7 <= high for low, high in intervals) >= 0.9 * 400


def test_students_interval_holds_the_mean_as_often_as_it_says_even_of_four_values() -> None:
    rng = np.random.default_rng(1)
    intervals = [mean_interval(rng.normal(5, 2, size=4), 0.9) for _ in range(2000)]
    assert sum(low <= 5 <= high for low, high in intervals) / 2000 == pytest.approx(0.9, abs=0.02)  # 3 sd: 0.02


def test_students_interval_needs_two_values_that_differ() -> None:
    # t at 97.5 % with one degree of freedom is 12.706; the standard error of 1 and 3 is 1.
    assert mean_interval([1, 3]) == pytest.approx((2 - 12.706, 2 + 12.706), abs=1e-3)
    assert mean_interval([]) is None
    assert mean_interval([2.0]) is None
    assert mean_interval([2.0, 2.0, 2.0]) is None


def test_the_bootstrap_interval_is_about_the_mean_plus_minus_196_standard_errors() -> None:
    values = np.random.default_rng(2).normal(5, 2, size=400)
    low, high = bootstrap_mean_interval(values, np.random.default_rng(3))
    half = 1.96 * values.std() / np.sqrt(400)
    assert low == pytest.approx(values.mean() - half, abs=0.1 * half)
    assert high == pytest.approx(values.mean() + half, abs=0.1 * half)


def test_the_bootstrap_depends_on_nothing_but_its_generator() -> None:
    first, second, other = (bootstrap_mean_interval([1, 2, 5], np.random.default_rng(seed)) for seed in (4, 4, 5))
    assert first == second
    assert bootstrap_mean_interval([2, 2, 2], np.random.default_rng(6)) == (2, 2)
    assert other is not None


@pytest.mark.parametrize(("level", "fewest"), [(0.95, 40), (0.9, 20), (0.5, 4)])
def test_a_percentile_interval_takes_a_sample_expected_beyond_each_end(level: float, fewest: int) -> None:
    assert percentile_interval(np.arange(fewest - 1), level) is None
    low, high = percentile_interval(np.arange(fewest), level)
    assert (low, high) == pytest.approx(((fewest - 1) * (1 - level) / 2, (fewest - 1) * (1 + level) / 2))


def test_no_statistic_and_one_have_no_interval() -> None:
    assert percentile_interval([]) is None
    assert percentile_interval([4.66]) is None
    assert bootstrap_mean_interval([1.0, 2.0], np.random.default_rng(0), resamples=39) is None


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: proportion_interval(3, 2), r"successes must be in \[0, 2\], but is 3"),
        (lambda: proportion_interval(-1, 2), r"successes must be in \[0, 2\]"),
        (lambda: proportion_interval(1, 2, 1.0), r"level must be in \(0, 1\), but is 1.0"),
        (lambda: bootstrap_mean_interval([1, np.nan], np.random.default_rng(0)), "finite"),
        (lambda: bootstrap_mean_interval([1], np.random.default_rng(0), 0.95, 0), "resamples must be >= 1, but is 0"),
    ],
)
def test_bad_arguments_are_refused(call, words) -> None:
    with pytest.raises(ValueError, match=words):
        call()
