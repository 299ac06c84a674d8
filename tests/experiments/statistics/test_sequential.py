from fractions import Fraction
from itertools import pairwise, product
from math import comb, log

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import hyp2f1
from scipy.stats import beta

from experiments.statistics.sequential import confidence_sequence, is_above, log_capital, units_of

rates = st.lists(st.integers(0, 8).map(lambda hits: hits / 8), min_size=1, max_size=12)


def capital(observations: list[Fraction], m: Fraction) -> Fraction:
    """Half staked fully, half over Beta(½, ½), whose k-th moment is C(2k, k) / 4^k: exact."""
    everything, powers = Fraction(1), [Fraction(1)]  # powers: the coefficients of b^k in the product
    for x in observations:
        everything *= x / m
        gain = x / m - 1
        powers = [a + gain * b for a, b in zip([*powers, Fraction(0)], [Fraction(0), *powers], strict=True)]
    spread = sum(coefficient * comb(2 * k, k) / Fraction(4) ** k for k, coefficient in enumerate(powers))
    return (everything + spread) / 2


@settings(max_examples=40)
@given(st.lists(st.fractions(0, 1, max_denominator=8), min_size=1, max_size=12), st.fractions("1/10", 1))
def test_the_capital_is_the_exact_one_of_half_staked_and_half_spread(observations, m) -> None:
    found = np.exp(log_capital(np.array(observations, dtype=np.float64), float(m)))
    exact = [float(capital(observations[: n + 1], m)) for n in range(len(observations))]
    assert found == pytest.approx(exact, rel=1e-9, abs=1e-12)


def test_the_spread_half_is_an_integral_over_its_shares() -> None:
    observations, m = np.array([1.0, 0.5, 0.875, 1.0, 0.0, 1.0]), 0.7

    def at(share: float) -> float:
        return float(np.prod(1 + share * (observations / m - 1)) * beta.pdf(share, 0.5, 0.5))

    assert 2 * np.exp(log_capital(observations, m)[-1]) == pytest.approx(quad(at, 0, 1, limit=200)[0], rel=1e-6)


def test_the_capital_grows_by_nothing_on_average_if_the_mean_is_right() -> None:
    # All outcomes of three experiments with rates 0, ½, 1 at .2, .3, .5: mean .65.
    shares = {0.0: 0.2, 0.5: 0.3, 1.0: 0.5}
    expected = sum(
        np.prod([weight for _, weight in outcome]) * np.exp(log_capital(np.array([x for x, _ in outcome]), 0.65)[-1])
        for outcome in product(shares.items(), repeat=3)
    )
    assert expected == pytest.approx(1.0)


@given(rates, st.randoms(use_true_random=False))
def test_the_order_of_experiments_does_not_move_the_capital(observations, random) -> None:
    mixed = list(observations)
    random.shuffle(mixed)
    last = [log_capital(np.array(some), 0.6)[-1] for some in (observations, mixed)]
    assert last[0] == pytest.approx(last[1], abs=1e-9)


@settings(max_examples=20)
@given(rates)
def test_the_interval_has_the_means_whose_capital_never_reached_its_target(observations) -> None:
    values = np.array(observations)
    low, high = confidence_sequence(values, 0, 1)
    means = np.linspace(0.001, 0.999, 37)
    above = np.array([log_capital(values, m).max() for m in means])
    below = np.array([log_capital(1 - values, 1 - m).max() for m in means])
    inside = (above < log(40)) & (below < log(40))
    assert (inside == ((means > low) & (means < high))).all()


@settings(max_examples=20)
@given(rates)
def test_the_interval_shrinks_with_every_experiment_and_an_answer_is_where_it_leaves_the_bound(observations) -> None:
    ends = [confidence_sequence(observations[:n], 0, 1, alpha=0.5) for n in range(len(observations) + 1)]
    assert ends[0] == (0.0, 1.0)
    assert all(old[0] <= new[0] + 1e-9 and new[1] <= old[1] + 1e-9 for old, new in pairwise(ends))
    answer = is_above(observations, 0.5, 0, 1, alpha=0.5)
    left = [n for n, (low, high) in enumerate(ends) if low > 0.5 or high < 0.5]
    assert answer.units == (left[0] if left else len(observations))
    assert answer.above == (ends[left[0]][0] > 0.5 if left else None)


@pytest.mark.parametrize(("bound", "low", "high"), [(0.9, 0, 1), (0.0, -8, 8)])
def test_an_answer_is_the_mirrored_ones_contrary(bound: float, low: float, high: float) -> None:
    rng = np.random.default_rng(3)
    values = low + (high - low) * rng.binomial(8, 0.97, 120) / 8
    answer, mirrored = is_above(values, bound, low, high), is_above(-values, -bound, -high, -low)
    assert answer.above is True
    assert (mirrored.above, mirrored.units) == (False, answer.units)
    ends, turned = (confidence_sequence(sign * values, *sorted((sign * low, sign * high))) for sign in (1, -1))
    assert ends == pytest.approx((-turned[1], -turned[0]), abs=1e-6)


@pytest.mark.parametrize("bound", [0.9, 0.99])
def test_failure_free_experiments_show_a_bound_when_their_closed_form_does(bound: float) -> None:
    # Without failures the mean of (1 + g b)^n over Beta(½, ½) is the hypergeometric 2F1(-n, ½; 1; -g), g = 1/m - 1.
    def grown(n: int) -> float:
        return float(bound**-n + hyp2f1(-n, 0.5, 1, 1 - 1 / bound)) / 2

    needed = next(n for n in range(1, 1000) if grown(n) >= 40)
    answer = is_above(np.ones(1000), bound, 0, 1)
    assert (answer.above, answer.units) == (True, needed)
    assert is_above(np.ones(needed - 1), bound, 0, 1).above is None
    assert log(40) / -log(bound) < needed < log(80) / -log(bound)


def test_experiments_in_worlds_of_their_own_are_the_units() -> None:
    units = units_of([0.5, None, 1.0], ["a", "b", "c", "d"])
    assert (units.values, units.experiments) == ((0.5, 1.0), (1, 3))


def test_repeated_worlds_make_rounds_that_wait_for_every_world() -> None:
    worlds = ["a", "b", "a", "b", "a", "b"]
    assert units_of([1.0, 0.0], worlds).values == (0.5,)
    assert units_of([1.0], worlds).values == ()
    units = units_of([1.0, 0.0, 0.5, 0.5, 1.0], worlds)
    assert (units.values, units.experiments) == ((0.5, 0.5), (2, 4))


def test_a_world_without_a_value_gives_its_next_one_to_the_round() -> None:
    worlds = ["a", "b", "a", "b", "a", "b"]
    units = units_of([1.0, None, 0.5, 0.25, 0.0, 0.75], worlds)
    assert (units.values, units.experiments) == ((0.625, 0.625), (4, 6))


def test_worlds_that_will_repeat_are_no_units_before_they_do() -> None:
    assert units_of([1.0, 1.0], ["a", "b", "c"]).values == (1.0, 1.0)
    assert units_of([1.0, 1.0], ["a", "b", "c", "a"]).values == ()
    assert units_of([], ["a"]).values == ()


@pytest.mark.parametrize(
    ("observations", "bound", "alpha", "words"),
    [
        ([0.5], 1.0, 0.05, "expected a bound between 0 and 1, got 1"),
        ([1.5], 0.5, 0.05, r"expected observations \(N,\) in 0\.\.1"),
        ([np.nan], 0.5, 0.05, r"expected observations \(N,\) in 0\.\.1"),
        ([0.5], 0.5, 0.0, r"expected an error rate in \(0, 1\), got 0"),
    ],
)
def test_what_cannot_be_asked_is_refused(observations, bound, alpha, words) -> None:
    with pytest.raises(ValueError, match=words):
        is_above(observations, bound, 0, 1, alpha)


def test_more_values_than_planned_experiments_are_refused() -> None:
    with pytest.raises(ValueError, match="expected a world for each of 2 values, got 1"):
        units_of([1.0, 1.0], ["a"])
