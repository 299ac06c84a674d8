import pytest

from experiments.prediction.agreement import mmrv, pearson


def test_equal_rankings_violate_nothing_whatever_the_values() -> None:
    assert mmrv([0.1, 0.5, 0.9], [0.50, 0.51, 0.99]) == 0.0


def test_a_pair_in_the_wrong_order_costs_its_real_difference() -> None:
    # Cells 0 and 1 are swapped: each pays |0.5 - 0.7|; cell 2 stands right towards both. Mean of .2, .2 and 0.
    assert mmrv([0.8, 0.6, 0.9], [0.5, 0.7, 1.0]) == pytest.approx(0.4 / 3)


def test_each_cell_counts_its_costliest_pair_only() -> None:
    # All turned around: the largest real differences are .4 (first), .3 (middle), .4 (last).
    assert mmrv([3, 2, 1], [0.1, 0.2, 0.5]) == pytest.approx((0.4 + 0.3 + 0.4) / 3)


def test_a_tie_in_the_simulation_is_a_violation_of_a_real_difference() -> None:
    # Li et al. compare by "<": of cells that are equal in the simulation the one that is really worse pays.
    assert mmrv([1.0, 1.0], [0.4, 0.7]) == pytest.approx(0.3 / 2)
    assert mmrv([1.0, 1.0], [0.7, 0.7]) == 0.0


def test_pearson_is_one_on_a_line_and_undefined_without_variance() -> None:
    assert pearson([1, 2, 4], [10, 20, 40]) == pytest.approx(1.0)
    assert pearson([1, 2, 4], [3, 2, 0]) == pytest.approx(-1.0)
    assert pearson([1, 1, 1], [3, 2, 0]) is None
    assert pearson([1], [3]) is None
