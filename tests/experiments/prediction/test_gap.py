import json

import numpy as np
import pytest

from cell.records import Tally
from experiments.errors import UsageError
from experiments.prediction.gap_fit import CORE_SCALES, OUTLIER_ODDS, design, fit_gap
from experiments.setup.error_models import error_model, error_model_of, load_ensemble, load_gaps
from sim.networks.domain_gap import Gap
from sim.networks.noise_model import load_noise


def count(tp: int, fp: int, fn: int) -> Tally:
    return Tally(parts=8, tp=tp, fp=fp, fn=fn, void=0, unreachable=0, timeouts=8 - tp - fp, duration=100.0)


def test_a_gap_scales_the_core_and_multiplies_the_odds() -> None:
    handle = load_noise("handle")
    values = Gap(core_scale=2.0, outlier_odds=10.0).noise(handle)
    assert values["pose.lateral_mm"] == pytest.approx(2 * handle.pose.lateral_mm)
    assert values["pose.rotation_deg"] == pytest.approx(2 * handle.pose.rotation_deg)
    before, after = handle.pose.outlier_probability, values["pose.outlier_probability"]
    assert after / (1 - after) == pytest.approx(10 * before / (1 - before))
    assert len(values) == 3


def test_no_gap_changes_nothing() -> None:
    antenna = load_noise("antenna")
    (gap,) = load_gaps("antenna", "none")
    values = gap.noise(antenna)
    assert values == pytest.approx({name: antenna.number(name) for name in values})


def test_a_world_puts_the_gap_on_top_of_the_accepted_parameters() -> None:
    handle = load_noise("handle")
    values = dict(error_model(handle, {"pose.lateral_mm": 0.8, "mask.field_cells": 0.2}, Gap(core_scale=1.5)))
    assert values["pose.lateral_mm"] == pytest.approx(1.2)
    assert values["mask.field_cells"] == 0.2
    assert values["pose.rotation_deg"] == pytest.approx(1.5 * handle.pose.rotation_deg)


def test_a_model_without_an_ensemble_is_its_only_member(tmp_path) -> None:
    assert load_ensemble(str(tmp_path / "mine.toml"), load_noise("handle")) == [{}]


@pytest.mark.parametrize("part", ["antenna", "handle"])
def test_every_member_of_the_ensembles_is_a_model(part) -> None:
    rendered = load_noise(part)
    members = load_ensemble(part, rendered)
    assert members[0] == {}
    for member in members:
        rendered.changed(member)


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_a_gap_that_cannot_be_is_refused(value) -> None:
    with pytest.raises(ValueError, match="expected outlier_odds above 0"):
        Gap(outlier_odds=value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "malformed"),
        ("[" * 5000, "malformed"),
        ('{"object": "antenna", "draws": []}', "of antenna, but the part is handle"),
        ('{"object": "handle", "draws": []}', "holds no draws"),
        (
            '{"object": "handle", "draws": [{"core": 1}]}',
            "malformed: expected draws\\[0\\] with core_scale and outlier_odds, got {.core.: 1}",
        ),
        ('{"object": "handle", "draws": [{}]}', "expected draws\\[0\\] with core_scale and outlier_odds, got {}"),
        ('{"object": "handle", "draws": [3]}', "expected draws\\[0\\] with .* got 3"),
        (
            '{"object": "handle", "draws": [{"core_scale": true, "outlier_odds": 1}]}',
            "core_scale to be a number, got True",
        ),
        (
            '{"object": "handle", "draws": [{"core_scale": "2", "outlier_odds": 1}]}',
            "core_scale to be a number, got .2",
        ),
        (
            '{"object": "handle", "draws": [{"core_scale": 1, "outlier_odds": -1}]}',
            "expected outlier_odds above 0, got -1",
        ),
        ('{"object": "handle"}', "malformed: the key .draws. is missing"),
    ],
)
def test_a_malformed_gap_file_is_refused_with_the_reason(tmp_path, text, words) -> None:
    path = tmp_path / "gap.json"
    path.write_text(text)
    with pytest.raises(UsageError, match=words):
        load_gaps("handle", str(path))


def test_draws_of_a_gap_file_are_read_back(tmp_path) -> None:
    path = tmp_path / "gap.json"
    path.write_text(json.dumps({"object": "handle", "draws": [{"core_scale": 1.5, "outlier_odds": 9.0}]}))
    assert load_gaps("handle", str(path)) == [Gap(1.5, 9.0)]


def grid(rate) -> list[list[Tally]]:
    """Twenty experiments of 8 parts per gap whose expected AP and AR are rate(gap)."""
    rng = np.random.default_rng(1)
    rows = []
    for gap in design():
        tp = rng.binomial(8, rate(gap), size=20)
        rows.append([count(int(n), 8 - int(n), 8 - int(n)) for n in tp])
    return rows


def test_the_fit_finds_the_gap_whose_cell_does_as_the_papers() -> None:
    # AP = AR = .9, .7, .5, .3 at odds of 1, 4, 16, 64, whatever the scale: .6 lies between 4 and 16, near 8.
    rates = dict(zip(OUTLIER_ODDS, (0.9, 0.7, 0.5, 0.3), strict=True))
    found = fit_gap(grid(lambda gap: rates[gap.outlier_odds]), (0.6, 0.6))
    low, high = found.interval(1)
    assert low < 8.0 < high
    assert 4.0 < found.mode.outlier_odds < 16.0
    assert found.expected == pytest.approx((0.6, 0.6), abs=0.05)
    assert found.misfit < 1.0
    # Nothing speaks for a scale: the interval is nearly all of the grid.
    assert found.interval(0)[0] < 1.1
    assert found.interval(0)[1] > 2.0


def test_a_row_that_no_gap_gives_is_said_to_be_out_of_reach() -> None:
    found = fit_gap(grid(lambda gap: 0.95), (0.3, 0.3))
    assert found.misfit > 6.0


def test_a_gap_at_which_nothing_is_grasped_is_refused() -> None:
    rows = grid(lambda gap: 0.9)
    rows[5] = [count(0, 0, 8)] * 19 + [count(8, 0, 0)]  # an experiment of time-outs alone has no AP
    with pytest.raises(UsageError, match=r"at least 2 experiments .* got 1 at core scale 1\.5, outlier odds 4: more"):
        fit_gap(rows, (0.6, 0.6))


def test_draws_follow_the_probability_and_stay_on_the_grid() -> None:
    rates = dict(zip(OUTLIER_ODDS, (0.9, 0.7, 0.5, 0.3), strict=True))
    found = fit_gap(grid(lambda gap: rates[gap.outlier_odds]), (0.6, 0.6))
    assert found.probability.sum() == pytest.approx(1.0)
    draws = found.draw(2000, np.random.default_rng(0))
    low, high = found.interval(1)
    inside = np.mean([low <= one.outlier_odds <= high for one in draws])
    assert 0.93 < inside <= 1.0
    assert all(CORE_SCALES[0] <= one.core_scale <= CORE_SCALES[-1] * 1.0001 for one in draws)


@pytest.mark.parametrize("draw", [{"core_scale": 1e9, "outlier_odds": 1}, {"core_scale": 1e300, "outlier_odds": 1e300}])
def test_a_gap_that_no_error_model_can_have_is_refused_before_anything_runs(tmp_path, draw) -> None:
    path = tmp_path / "gap.json"
    path.write_text(json.dumps({"object": "handle", "draws": [{"core_scale": 1.5, "outlier_odds": 9}, draw]}))
    with pytest.raises(UsageError, match=r"draws\[1\] leads to errors that cannot be: changed noise: "):
        error_model_of("handle", str(path), 0)
