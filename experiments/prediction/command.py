"""`graspcell predict`: the paper's robot table as a prediction, with the assumptions varied one at a time."""

from collections.abc import Iterator, Sequence
from itertools import chain, product
from typing import Any

from experiments.prediction.cells import PredictedCell, Rate, agreement, predict_cell
from experiments.prediction.config import Predict
from experiments.prediction.counting import count_all
from experiments.prediction.setting import Setting
from experiments.prediction.variants import VARIANTS
from experiments.results.paired import Paired, format_paired, pair
from experiments.results.paper import ROBOT_TABLE
from experiments.results.provenance import manifest, write_json
from experiments.setup.checks import writable_folder
from experiments.setup.error_models import ErrorModel, error_model_of
from experiments.setup.thresholds import load_thresholds
from sim.networks.domain_gap import BASE_REACH, Reach

FITTED = "none"  # the method whose row of the robot table the gap is fitted to
_COLUMN = 27


def predict(config: Predict) -> int:
    """Runs the experiments of every variant, prints a table for each and writes the results; returns the exit code.

    Raises:
        UsageError: an argument that cannot be.
        ExperimentsFailedError: an experiment has no result.
    """
    config.check()
    folder = writable_folder(config.out)
    worlds = _worlds(config, BASE_REACH)
    names = list(VARIANTS) if "all" in config.variants else list(config.variants)
    write_json(folder / "manifest.json", {**manifest(config), "seed": config.seed})
    results: dict[str, Any] = {}
    found = {"worlds": {part: [dict(one) for one in rows] for part, rows in worlds.items()}, "variants": results}
    for name in names:
        setting = VARIANTS[name](Setting(load_thresholds("paper"), seed=config.seed))
        cells, pairs = _cells(config, setting, _worlds(config, setting.reach), name)
        results[name] = {
            "cells": cells,
            "paired": pairs,
            "agreement": agreement(cells),
            "agreement_predicted": agreement(_predicted(cells)),
        }
        write_json(folder / "predict.json", found)  # after each variant: an interrupted job keeps those it finished
        print(_table(name, cells, pairs), flush=True)
    print(f"results in {folder}")
    return 0


def _worlds(config: Predict, reach: Reach) -> dict[str, list[ErrorModel]]:
    """The worlds of each part, where S2 and the detector feel so much of the gap."""
    return {
        part: [error_model_of(part, config.gap, index, reach) for index in range(config.worlds)]
        for part in config.objects
    }


def _cells(
    config: Predict, setting: Setting, worlds: dict[str, list[ErrorModel]], name: str
) -> tuple[list[PredictedCell], list[Paired]]:
    """One cell per part and method, and the methods side by side; a world's experiments are the same with every one."""
    size, keys = config.experiments, list(product(config.objects, config.methods))
    specs = [
        setting.spec(part, method, one, index * size + experiment)
        for part, method in keys
        for index, one in enumerate(worlds[part])
        for experiment in range(size)
    ]
    counts = count_all(specs, config.workers, name)
    rows = [counts[start : start + size] for start in range(0, len(counts), size)]
    groups = {key: rows[number * config.worlds : (number + 1) * config.worlds] for number, key in enumerate(keys)}
    cells = [
        predict_cell(
            part,
            method,
            [[one.count for one in row] for row in group],
            ROBOT_TABLE.get((part, method)),
            config.seed,
            firsts=[[one.first for one in row] for row in group],
        )
        for (part, method), group in groups.items()
    ]
    pairs = [
        pair(part, {method: [[one.count for one in row] for row in groups[part, method]] for method in config.methods})
        for part in config.objects
    ]
    return cells, list(chain.from_iterable(pairs))


def _table(name: str, cells: Sequence[PredictedCell], pairs: Sequence[Paired]) -> str:
    width = max(len(cell.method) for cell in cells)
    lines = [
        f"{name}: mean [95 % of the means over 5 experiments] paper, in %; ! where the paper's lies outside",
        f"{'object':8} {'method':{width}} {'AP':>{_COLUMN}} {'AR':>{_COLUMN}}    TP   FP   FN  time-outs  experiments",
    ]
    for cell in cells:
        lines.append(
            f"{cell.object:8} {cell.method:{width}} {_cell(cell.ap)} {_cell(cell.ar)} "
            f"{cell.tp:5} {cell.fp:4} {cell.fn:4} {cell.timeouts:10} {cell.experiments:12}"
        )
    lines += [f"all rows, {line}" for line in _agreement(cells)]
    lines += [f"without the row that the gap is fitted to, {line}" for line in _agreement(_predicted(cells))]
    return "\n".join([*lines, format_paired(pairs)]) + "\n"


def _predicted(cells: Sequence[PredictedCell]) -> list[PredictedCell]:
    return [cell for cell in cells if cell.method != FITTED]


def _agreement(cells: Sequence[PredictedCell]) -> Iterator[str]:
    for rate, row in agreement(cells).items():
        correlation = "–" if row["pearson"] is None else f"{row['pearson']:.2f}"
        yield (
            f"{rate.upper()}: {row['agree']} of {row['cells']} cells agree; "
            f"MMRV {row['mmrv']:.3f}, Pearson {correlation}"
        )


def _cell(rate: Rate) -> str:
    if rate.mean is None or rate.interval is None:
        return f"{'–':>{_COLUMN}}"
    low, high = rate.interval
    paper = "" if rate.paper is None else f" {100 * rate.paper:.1f}" + ("" if rate.agrees else " !")
    return f"{f'{100 * rate.mean:.1f} [{100 * low:.1f}, {100 * high:.1f}]{paper}':>{_COLUMN}}"
