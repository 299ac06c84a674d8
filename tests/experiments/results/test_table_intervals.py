"""The intervals of the table are those of its points: means over experiments that come in worlds."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from cell.records import Tally
from experiments.commands.config import Compare
from experiments.results.table import make_cell
from experiments.setup.actors import Actors
from experiments.setup.experiment import ExperimentResult
from experiments.units.summary import counted_of, make_cells
from experiments.units.unit import unit_of
from maskval.statistics.cluster_intervals import clustered_rate_interval

HANDLE = ("handle", "none", "always")
PREDICTION = Path(__file__).parents[3] / "docs" / "results" / "predict.json"


def count(tp: int, fp: int, fn: int) -> Tally:
    return Tally(parts=8, tp=tp, fp=fp, fn=fn, void=0, unreachable=0, timeouts=8 - tp - fp, duration=100.0)


def test_the_interval_is_of_the_mean_over_experiments_and_not_of_the_pooled_counts() -> None:
    # Experiments with few attempts fail most: the mean is .75, the pooled rate 42/44.
    counts = 10 * [count(4, 0, 4), count(1, 1, 7)]
    cell = make_cell(HANDLE, counts)
    assert cell.ap_ci == clustered_rate_interval(10 * [1.0, 0.5], 10 * [4, 2], range(20))
    assert cell.ar_ci == clustered_rate_interval(10 * [4 / 8, 1 / 8], 10 * [8, 8], range(20))


def test_every_point_of_the_prediction_lies_in_its_interval() -> None:
    cells = json.loads(PREDICTION.read_text(encoding="utf-8"))["variants"]["base"]["cells"]
    assert len(cells) == 6
    outside_pooled = 0
    for found in cells:
        for experiment in range(10):
            cell = make_cell(
                (found["object"], found["method"], ""), [count(*row[experiment][:3]) for row in found["counts"]]
            )
            for name in ("ap", "ar"):
                low, high = getattr(cell, f"{name}_ci")
                assert low <= getattr(cell, name) <= high
            low, high = cell.ap_pooled_ci
            outside_pooled += not low <= cell.ap <= high
    assert outside_pooled > 0  # what was wrong with the pooled interval


def test_experiments_without_attempts_are_left_out_of_the_interval_of_ap() -> None:
    few = [count(4, 4, 4), count(6, 2, 2)]
    assert make_cell(HANDLE, [*few, count(0, 0, 8)]).ap_ci == make_cell(HANDLE, few).ap_ci


def test_experiments_of_one_world_are_one_cluster() -> None:
    counts = [count(8 - n, n, n) for n in (0, 1, 2, 3, 4, 5, 6, 5, 4, 3, 2, 1)]
    twice = make_cell(HANDLE, counts + counts, [*range(12), *range(12)])
    apart = make_cell(HANDLE, counts + counts)
    assert (twice.worlds, apart.worlds) == (12, 24)
    assert twice.ap == apart.ap
    assert twice.ap_ci[1] - twice.ap_ci[0] > 1.2 * (apart.ap_ci[1] - apart.ap_ci[0])


def test_compare_takes_experiments_with_one_error_model_for_one_world() -> None:
    config = Compare(objects=("handle",), methods=("none",), experiments=21, actors=Actors(gap="fitted"), jobs=1)
    specs = config.specs()
    results = [ExperimentResult(spec, count(4, 4, 4), None, {"attempts": [], "estimates": []}) for spec in specs]
    (cell,) = make_cells([counted_of(unit_of(result)) for result in results])
    assert (cell.experiments, cell.worlds) == (21, 20)
    plain = [replace(result, spec=replace(result.spec, noise=())) for result in results]
    (cell,) = make_cells([counted_of(unit_of(result)) for result in plain])
    assert cell.worlds == 21


def test_a_world_whose_only_experiment_failed_is_none() -> None:
    assert make_cell(HANDLE, [count(4, 4, 4), None], [0, 1]).worlds == 1


def test_labels_must_be_as_many_as_experiments() -> None:
    with pytest.raises(ValueError, match="shorter"):
        make_cell(HANDLE, [count(4, 4, 4)], [])
