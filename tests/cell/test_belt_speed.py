"""The belt's speed, learned from pairs of looks."""

import numpy as np
import pytest

from cell.conveyor_tracking import BELT_SD, POSE_SD, BeltSpeed

ALONG = np.array([0.0, 0.6, 0.8])
ASIDE = np.array([1.0, 0.0, 0.0])


def test_one_pair_of_looks_corrects_the_speed_by_the_share_that_the_variances_say() -> None:
    belt = BeltSpeed(0.1)
    assert belt.learn(0.105 * 2.0 * ALONG, ALONG, 2.0)
    prior, measured = (BELT_SD * 0.1) ** 2, 2 * POSE_SD**2 / 2.0**2
    assert belt.speed == pytest.approx(0.1 + 0.005 * prior / (prior + measured))


def test_many_pairs_of_looks_tell_the_speed_whatever_was_believed() -> None:
    belt, rng = BeltSpeed(0.1), np.random.default_rng(0)
    for _ in range(400):
        belt.learn(0.11 * 1.5 * ALONG + rng.normal(0.0, np.sqrt(2) * POSE_SD, 3), ALONG, 1.5)
    # 4 standard deviations of the mean of 400, with the prior worth less than 2 of them.
    assert belt.speed == pytest.approx(0.11, abs=4 * np.sqrt(2) * POSE_SD / 1.5 / 20 + 0.01 * 2 / 400)


@pytest.mark.parametrize("wrong", [0.05 * ALONG, -0.05 * ALONG, 0.05 * ASIDE])
def test_looks_that_do_not_belong_together_teach_nothing(wrong: np.ndarray) -> None:
    belt = BeltSpeed(0.1)
    assert not belt.learn(0.1 * 1.5 * ALONG + wrong, ALONG, 1.5)
    assert belt.speed == 0.1
