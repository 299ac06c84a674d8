import numpy as np
import pytest
from statsmodels.stats.multitest import multipletests

from experiments.statistics.holm import holm


def test_the_smallest_is_multiplied_by_all_and_none_gets_smaller_than_one_before_it() -> None:
    # Sorted .01, .03, .04 with 3, 2, 1: .03, .06, and .04 rises to .06.
    assert holm([0.04, 0.01, 0.03]) == pytest.approx([0.06, 0.03, 0.06])


def test_no_p_exceeds_one_and_one_comparison_keeps_its_own() -> None:
    assert holm([0.6, 0.9]) == [1.0, 1.0]
    assert holm([0.2]) == [0.2]
    assert holm([]) == []


@pytest.mark.parametrize("count", [1, 2, 5, 30])
def test_statsmodels_has_the_same(count: int) -> None:
    p_values = np.random.default_rng(count).random(count) ** 4
    p_values[::3] = p_values[0]  # ties
    assert holm(list(p_values)) == pytest.approx(list(multipletests(p_values, method="holm")[1]), abs=1e-12)


@pytest.mark.parametrize("p_values", [[-0.1], [1.1, 0.5], [float("nan")]])
def test_what_is_no_p_is_refused(p_values: list[float]) -> None:
    with pytest.raises(ValueError, match=r"expected p values in 0\.\.1, got"):
        holm(p_values)
