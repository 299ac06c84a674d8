"""A 95 % interval of the table contains the true rate in at least 93 % of samples of 20 worlds."""

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.coverage import INTERVALS, WORLDS, coverage, of_the_table, pooled, settings, simulated

RESULTS = Path(__file__).parents[1] / "docs" / "results" / "coverage.json"
SETTINGS = list(settings(20))


def least(setting: str, samples: int) -> float:
    draw, truth = settings(20)[setting]
    return coverage(draw, truth, of_the_table, samples, SETTINGS.index(setting))[0]


@pytest.mark.parametrize(
    "setting",
    [
        "antenna × ensemble-add, ap, 1 per world",
        "handle × maskval, ap, 1 per world",
        "simulated, rate 0.5, design effect 1",
        "simulated, rate 0.9, design effect 4",
    ],
)
def test_intervals_of_twenty_worlds_contain_the_rate(setting: str) -> None:
    assert least(setting, 400) >= 0.93


def test_the_pooled_interval_does_not() -> None:
    draw, truth = settings(20)["handle × ensemble-add, ap, 1 per world"]
    assert coverage(draw, truth, pooled, 200, 0)[0] < 0.7


def test_simulated_experiments_have_the_design_effect_that_they_are_named_for() -> None:
    rng = np.random.default_rng(3)
    for effect in (1.0, 4.0):
        rates = simulated(0.8, effect, 20_000)(rng).rates
        assert rates.mean() == pytest.approx(0.8, abs=0.01)
        assert rates.var() == pytest.approx(effect * 0.8 * 0.2 / 8, rel=0.05)


def test_the_committed_coverages_are_of_every_setting_and_interval() -> None:
    found = json.loads(RESULTS.read_text(encoding="utf-8"))["[coverage, mean width] in %"]
    assert list(found) == [f"{worlds} worlds" for worlds in WORLDS]
    for rows in found.values():
        assert list(rows) == SETTINGS
        assert all(list(row) == list(INTERVALS) for row in rows.values())
    assert min(row["table"][0] for row in found["20 worlds"].values()) >= 93


@pytest.mark.study
@pytest.mark.parametrize("setting", SETTINGS)
def test_intervals_of_twenty_worlds_contain_the_rate_in_every_setting(setting: str) -> None:
    assert least(setting, 2000) >= 0.93
