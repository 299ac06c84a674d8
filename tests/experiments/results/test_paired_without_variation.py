"""Equal differences in all worlds are evidence, not proof: their interval is the bound of none of n."""

import pytest

from experiments.results.paired import difference_interval, pair
from tests.experiments.results.test_paired import count, singles


def test_equal_differences_of_twenty_experiments_are_bounded_by_none_of_n() -> None:
    # 160 slots correlated by a half within experiments of 8 count as 160 / 4.5; none of n: 1 - .025^(1/n).
    share = 1 - 0.025 ** (4.5 / 160)
    (row,) = pair(
        "antenna",
        {"maskval": singles(*20 * [count(4, 0)]), "none": singles(*20 * [count(5, 0)])},
    )
    assert row.placed_ci == pytest.approx((1 - 8 * share, 1 + 8 * share))
    assert row.failed_ci == pytest.approx((-8 * share, 8 * share))
    assert 8 * share == pytest.approx(0.79, abs=0.005)


def test_fewer_worlds_have_a_wider_bound_and_more_experiments_in_them_hardly_a_narrower_one() -> None:
    few, many = (difference_interval(n * [0.0], n * [[8]]) for n in (2, 40))
    assert few[0] < many[0] < 0 < many[1] < few[1]
    again = difference_interval(2 * [0.0], 2 * [[8, 8, 8, 8]])
    assert 0.85 * few[1] < again[1] < few[1]


def test_a_difference_is_never_more_than_all_parts() -> None:
    assert difference_interval([7.0, 7.0], [[8], [8]])[1] == 8.0
    assert difference_interval([-7.0, -7.0], [[8], [8]])[0] == -8.0


def test_differences_that_vary_keep_students_interval_and_one_world_has_none() -> None:
    assert difference_interval([1.0, 3.0], [[8], [8]]) == pytest.approx((2 - 12.706, 2 + 12.706), abs=1e-3)
    assert difference_interval([1.0], [[8, 8]]) is None
    assert difference_interval([], []) is None
