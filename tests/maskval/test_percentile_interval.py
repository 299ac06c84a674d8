import numpy as np
import pytest

from maskval import bootstrap_mean_interval
from maskval.intervals import percentile_interval


@pytest.mark.parametrize(("level", "fewest"), [(0.95, 40), (0.9, 20), (0.5, 4)])
def test_a_percentile_interval_takes_a_sample_expected_beyond_each_end(level: float, fewest: int) -> None:
    assert percentile_interval(np.arange(fewest - 1), level) is None
    low, high = percentile_interval(np.arange(fewest), level)
    assert (low, high) == pytest.approx(((fewest - 1) * (1 - level) / 2, (fewest - 1) * (1 + level) / 2))


def test_no_statistic_and_one_have_no_interval() -> None:
    assert percentile_interval([]) is None
    assert percentile_interval([4.66]) is None
    assert bootstrap_mean_interval([1.0, 2.0], np.random.default_rng(0), resamples=39) is None
