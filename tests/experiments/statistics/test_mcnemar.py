"""Robostats' own Tango interval and exact test are the independent code; the published examples are Tango's (1998)."""

from math import comb, inf, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from robostats import PairedResult, mcnemar, paired_difference
from scipy.optimize import minimize_scalar
from scipy.stats import beta

from experiments.statistics.mcnemar import PairedParts, count_parts, discordant_odds, mcnemar_p, tango_interval

counts = st.tuples(*4 * [st.integers(0, 40)]).filter(any)


def theirs(parts: PairedParts) -> PairedResult:
    return PairedResult(
        policy_id_a="a",
        policy_id_b="b",
        n_both_success=parts.both,
        n_a_success_b_failure=parts.first_only,
        n_b_success_a_failure=parts.second_only,
        n_both_failure=parts.neither,
        scenario_ids=tuple(str(number) for number in range(parts.parts)),
        dropped_from_a=0,
        dropped_from_b=0,
        protocol_fingerprints_a=(),
        protocol_fingerprints_b=(),
        replicates=None,
    )


def test_parts_are_counted_by_who_succeeded() -> None:
    first, second = np.array([1, 1, 1, 0, 0, 0, 0], bool), np.array([1, 1, 0, 1, 1, 1, 0], bool)
    parts = count_parts(first, second)
    assert parts == PairedParts(both=2, first_only=1, second_only=3, neither=1)
    assert (parts.parts, parts.discordant, parts.difference) == (7, 4, -2 / 7)


def test_mcnemars_p_is_both_tails_of_a_fair_coin() -> None:
    # 1 of 7 discordant parts: 2 (1 + 7) / 2^7.
    assert mcnemar_p(PairedParts(12, 1, 6, 1)) == pytest.approx(2 * (comb(7, 0) + comb(7, 1)) / 2**7)
    assert mcnemar_p(PairedParts(0, 5, 5, 0)) == 1.0


def test_without_discordant_parts_nothing_differs() -> None:
    assert mcnemar_p(PairedParts(30, 0, 0, 10)) == 1.0
    assert discordant_odds(PairedParts(30, 0, 0, 10)) is None


def test_tangos_interval_is_that_of_his_examples() -> None:
    # Section 6.2: sleeping difficulties of 32 pairs. Section 6.1: soft contact lenses of 44, 90 %, lower end.
    assert tango_interval(PairedParts(16, 9, 3, 4)) == pytest.approx((-0.027, 0.390), abs=5e-4)
    assert tango_interval(PairedParts(43, 0, 1, 0), level=0.9)[0] == pytest.approx(-0.096, abs=5e-4)


@given(counts)
def test_robostats_has_the_same_p_and_interval(cells: tuple[int, int, int, int]) -> None:
    parts = PairedParts(*cells)
    other = paired_difference(theirs(parts))
    assert tango_interval(parts) == pytest.approx((other.lower, other.upper), abs=1e-8)
    assert mcnemar_p(parts) == pytest.approx(mcnemar(theirs(parts)).p_value)


@pytest.mark.parametrize("cells", [(10, 6, 2, 3), (5, 3, 0, 1), (0, 4, 9, 2)])
def test_tangos_ends_are_where_the_score_is_the_normal_quantile(cells: tuple[int, int, int, int]) -> None:
    # By the definition: q maximises the likelihood of the counts among the distributions with this difference.
    parts = PairedParts(*cells)
    n, b, c = parts.parts, parts.first_only, parts.second_only

    def score(delta: float) -> float:
        def loss(q: float) -> float:
            shares = np.array([q + delta, q, 1 - 2 * q - delta])
            return -float(np.array([b, c, n - b - c]) @ np.log(np.maximum(shares, 1e-300)))

        bounds = (max(0.0, -delta), (1 - delta) / 2)
        q = minimize_scalar(loss, bounds=bounds, method="bounded", options={"xatol": 1e-12}).x
        return (b - c - n * delta) / sqrt(n * (2 * q + delta * (1 - delta)))

    low, high = tango_interval(parts)
    assert (score(low), score(high)) == pytest.approx((1.959964, -1.959964), abs=1e-4)


@given(counts)
def test_the_interval_turns_with_the_methods_and_holds_the_difference(cells: tuple[int, int, int, int]) -> None:
    both, first, second, neither = cells
    parts, turned = PairedParts(both, first, second, neither), PairedParts(both, second, first, neither)
    low, high = tango_interval(parts)
    assert tango_interval(turned) == pytest.approx((-high, -low), abs=1e-9)
    assert -1 <= low <= parts.difference <= high <= 1
    assert high - low > 0.01


def test_a_method_that_wins_every_part_has_an_open_end() -> None:
    low, high = tango_interval(PairedParts(0, 8, 0, 0))
    assert high == 1.0
    assert 0 < low < 1
    assert tango_interval(PairedParts(0, 0, 8, 0)) == (-1.0, pytest.approx(-low))


def test_the_odds_are_those_of_the_discordant_parts_alone() -> None:
    found = discordant_odds(PairedParts(100, 6, 2, 50))
    assert found is not None
    odds, (low, high) = found
    assert odds == pytest.approx(3.0)
    shares = [low / (1 + low), high / (1 + high)]  # Clopper and Pearson's of 6 in 8
    assert shares == pytest.approx([beta.ppf(0.025, 6, 3), beta.ppf(0.975, 7, 2)])


def test_odds_without_a_part_for_the_other_method_are_open() -> None:
    found = discordant_odds(PairedParts(0, 5, 0, 0))
    assert found is not None
    assert (found[0], found[1][1]) == (inf, inf)
    assert found[1][0] == pytest.approx(0.025 ** (1 / 5) / (1 - 0.025 ** (1 / 5)))
    assert discordant_odds(PairedParts(0, 0, 5, 0))[:1] == (0.0,)


@pytest.mark.parametrize("cells", [(-1, 1, 1, 1), (0, 0, 0, 0)])
def test_counts_that_cannot_be_are_refused(cells: tuple[int, int, int, int]) -> None:
    with pytest.raises(ValueError, match="expected counts >= 0 and at least one part"):
        PairedParts(*cells)


@pytest.mark.parametrize(("first", "second"), [([True], [True, False]), ([1, 0], [0, 1]), ([[True]], [[True]])])
def test_outcomes_that_do_not_pair_are_refused(first: list, second: list) -> None:
    with pytest.raises(ValueError, match=r"expected two \(N,\) of bool"):
        count_parts(first, second)


@pytest.mark.parametrize("level", [0.0, 1.0])
def test_a_level_outside_0_and_1_is_refused(level: float) -> None:
    with pytest.raises(ValueError, match=r"level (in|must be in) \(0, 1\)"):
        tango_interval(PairedParts(1, 1, 1, 1), level)
