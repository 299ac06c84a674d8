from itertools import product

import numpy as np
import pytest
from scipy.stats import permutation_test, ttest_1samp, ttest_rel

from experiments.statistics.clusters import ratio, ratio_difference, sign_flip_p

RNG = np.random.default_rng(5)


def test_a_ratio_is_that_of_the_sums_with_students_interval_over_worlds() -> None:
    # Times 90, 110, 100 s for 5 parts each: 20 s per part, worlds depart by -2, 2, 0 thirds; t at 2 freedoms is 4.3027.
    found = ratio([90.0, 110.0, 100.0], [5, 5, 5], "abc")
    assert (found.value, found.worlds) == (20.0, 3)
    standard_error = np.std([18, 22, 20], ddof=1) / np.sqrt(3)
    assert found.interval == pytest.approx((20 - 4.3027 * standard_error, 20 + 4.3027 * standard_error), abs=1e-3)


def test_experiments_of_one_world_count_as_one() -> None:
    rng = np.random.default_rng(1)
    above, below = rng.random(12), 1 + rng.random(12)
    one_each = ratio(above, below, range(12))
    twice = ratio(np.repeat(above, 2), np.repeat(below, 2), np.repeat(range(12), 2).tolist())
    apart = ratio(np.repeat(above, 2), np.repeat(below, 2), range(24))
    assert twice.interval == pytest.approx(one_each.interval)
    assert twice.worlds == 12
    assert np.diff(apart.interval) < 0.75 * np.diff(one_each.interval)


def test_with_equal_denominators_the_interval_is_the_paired_t_tests() -> None:
    first, second = RNG.binomial(8, 0.9, 15).astype(float), RNG.binomial(8, 0.7, 15).astype(float)
    found = ratio_difference((first, np.ones(15)), (second, np.ones(15)), range(15))
    theirs = ttest_rel(first, second).confidence_interval(0.95)
    assert found.interval == pytest.approx((theirs.low, theirs.high))
    assert found.value == pytest.approx((first - second).mean())


def test_the_standard_error_of_a_ratio_agrees_with_the_jackknife() -> None:
    first = RNG.binomial(8, 0.9, 200).astype(float), RNG.integers(6, 9, 200).astype(float)
    second = first[0] - RNG.binomial(2, 0.3, 200), RNG.integers(6, 9, 200).astype(float)
    found = ratio_difference(first, second, range(200))

    def without(world: int) -> float:
        sums = [np.delete(numbers, world).sum() for numbers in (*first, *second)]
        return sums[0] / sums[1] - sums[2] / sums[3]

    left_out = np.array([without(world) for world in range(200)])
    jackknife = np.sqrt(199 / 200 * ((left_out - left_out.mean()) ** 2).sum())
    assert (found.interval[1] - found.interval[0]) / 2 == pytest.approx(1.97196 * jackknife, rel=0.01)


def test_few_worlds_have_a_wide_interval_and_no_p_below_two_in_two_to_their_number() -> None:
    # Five worlds that all favour the first method: 2.776 standard errors either way, and 2 of 32 choices of signs.
    more = np.array([1.0, 2.0, 2.0, 3.0, 2.0])
    found = ratio_difference((more, np.ones(5)), (np.zeros(5), np.ones(5)), range(5))
    reach = 2.7764 * np.std(more, ddof=1) / np.sqrt(5)
    assert found.interval == pytest.approx((2 - reach, 2 + reach), abs=1e-3)
    assert found.p == 2 / 2**5


def test_one_world_and_worlds_that_agree_have_no_interval() -> None:
    one = ratio_difference(([3.0, 4.0], [8, 8]), ([2.0, 4.0], [8, 8]), ["a", "a"])
    assert (one.value, one.interval, one.p) == (1 / 16, None, 1.0)
    assert ratio([8, 8, 8], [8, 8, 8], range(3)).interval is None
    same = ratio_difference(([5, 6], [8, 8]), ([5, 6], [8, 8]), range(2))
    assert (same.value, same.interval, same.p) == (0.0, None, 1.0)


@pytest.mark.parametrize("worlds", [1, 2, 5, 9])
def test_the_p_is_the_share_of_signs_that_go_as_far(worlds: int) -> None:
    departures = RNG.normal(0.5, 1.0, worlds)
    sums = [abs(np.dot(signs, departures)) for signs in product((-1, 1), repeat=worlds)]
    assert sign_flip_p(departures) == np.mean(np.array(sums) >= sums[-1] - 1e-9)


def test_scipys_paired_permutation_test_has_the_same_p() -> None:
    first, second = RNG.normal(0.4, 1.0, 10), RNG.normal(0.0, 1.0, 10)
    theirs = permutation_test(
        (first, second), lambda a, b: np.mean(a - b), permutation_type="samples", n_resamples=np.inf
    )
    assert sign_flip_p(first - second) == pytest.approx(theirs.pvalue)


def test_drawn_signs_and_the_normal_limit_come_near_the_t_test() -> None:
    for worlds in (14, 60, 999, 1000, 3000):
        departures = RNG.normal(2.0, 1.0 * np.sqrt(worlds), worlds)
        share = ttest_1samp(departures, 0).pvalue
        assert sign_flip_p(departures) == pytest.approx(share, abs=0.02)
        assert sign_flip_p(departures) == sign_flip_p(departures)
        assert sign_flip_p(departures, seed=1) == pytest.approx(share, abs=0.02)


def test_the_p_does_not_hang_on_the_unit_or_on_the_last_digit_of_ties() -> None:
    departures = np.array([0.1, 0.2, 0.3, -0.3, 0.1, 0.2, -0.1])
    expected = sign_flip_p(np.rint(10 * departures))
    assert sign_flip_p(departures) == expected
    assert sign_flip_p(1e-9 * departures) == expected


def test_methods_of_equal_ratios_are_seldom_told_apart_though_one_tries_more_often() -> None:
    # 20 worlds of 8 parts, both at 80 %: the second method has half the attempts. Of 1,000 samples 5 % may differ; the
    # 99.9 % point of that binomial is 73.
    rng = np.random.default_rng(8)
    found = 0
    for _ in range(1000):
        rates = np.clip(rng.normal(0.8, 0.1, 20), 0, 1)
        first, second = rng.binomial(8, rates), rng.binomial(4, rates)
        found += ratio_difference((first, np.full(20, 8)), (second, np.full(20, 4)), range(20)).p <= 0.05
    assert 20 <= found <= 73


@pytest.mark.parametrize(
    ("first", "worlds", "words"),
    [
        (([1.0], [1.0, 2.0]), [0, 1], r"one shape \(N,\), got \(1,\), \(2,\) and 2 worlds"),
        (([1.0, 1.0], [0.0, 0.0]), [0, 1], "denominators >= 0 that are not all 0"),
        (([np.nan, 1.0], [1.0, 1.0]), [0, 1], "expected finite numerators"),
        (([1.0, 1.0], [2.0, -1.0]), [0, 1], "denominators >= 0"),
        (([], []), [], "not all 0"),
    ],
)
def test_what_is_no_ratio_is_refused(first, worlds, words) -> None:
    with pytest.raises(ValueError, match=words):
        ratio(*first, worlds)
    with pytest.raises(ValueError, match=words):
        ratio_difference(first, first, worlds)


def test_a_level_or_departures_out_of_range_are_refused() -> None:
    with pytest.raises(ValueError, match=r"expected a level in \(0, 1\), got 1"):
        ratio([1, 2], [1, 1], range(2), level=1.0)
    with pytest.raises(ValueError, match="expected finite departures of at least one world"):
        sign_flip_p([])
    with pytest.raises(ValueError, match="expected finite departures"):
        sign_flip_p([1.0, np.inf])
