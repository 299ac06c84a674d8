"""`graspcell predict`: the paper's robot table as a prediction, with the assumptions varied one at a time."""

from collections.abc import Iterator, Sequence
from typing import Any

from experiments.checks import writable_folder
from experiments.paper import ROBOT_TABLE
from experiments.prediction.cells import PredictedCell, Rate, agreement, predict_cell
from experiments.prediction.config import Predict
from experiments.prediction.counting import count_all
from experiments.prediction.gap import load_gaps
from experiments.prediction.variants import VARIANTS
from experiments.prediction.worlds import Noise, Setting, load_ensemble, taken, world
from experiments.provenance import manifest, write_json
from experiments.thresholds import load_thresholds
from sim.noise import load_noise
from sim.parts import load_part

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
    worlds = {part: _worlds(part, config) for part in config.objects}
    names = list(VARIANTS) if "all" in config.variants else list(config.variants)
    write_json(folder / "manifest.json", {**manifest(config), "seed": config.seed})
    results: dict[str, Any] = {}
    found = {"worlds": {part: [dict(one) for one in rows] for part, rows in worlds.items()}, "variants": results}
    for name in names:
        setting = VARIANTS[name](Setting(load_thresholds("paper"), seed=config.seed))
        cells = _cells(config, setting, worlds, name)
        results[name] = {
            "cells": cells,
            "agreement": agreement(cells),
            "agreement_predicted": agreement(_predicted(cells)),
        }
        write_json(folder / "predict.json", found)  # after each variant: an interrupted job keeps those it finished
        print(_table(name, cells), flush=True)
    print(f"results in {folder}")
    return 0


def _worlds(part: str, config: Predict) -> list[Noise]:
    noise = load_part(part).noise
    rendered = load_noise(noise)
    members, gaps = load_ensemble(noise, rendered), load_gaps(part, config.gap)
    return [world(rendered, taken(members, index), taken(gaps, index)) for index in range(config.worlds)]


def _cells(config: Predict, setting: Setting, worlds: dict[str, list[Noise]], name: str) -> list[PredictedCell]:
    """One cell per part and method; a world's experiments have the same numbers with every method."""
    size = config.experiments
    specs = [
        setting.spec(part, method, one, index * size + experiment)
        for part in config.objects
        for method in config.methods
        for index, one in enumerate(worlds[part])
        for experiment in range(size)
    ]
    counts = count_all(specs, config.workers, name)
    rows = [counts[start : start + size] for start in range(0, len(counts), size)]
    return [
        predict_cell(
            part,
            method,
            rows[number * config.worlds : (number + 1) * config.worlds],
            ROBOT_TABLE.get((part, method)),
            config.seed,
        )
        for number, (part, method) in enumerate((part, method) for part in config.objects for method in config.methods)
    ]


def _table(name: str, cells: Sequence[PredictedCell]) -> str:
    lines = [
        f"{name}: mean [95 % of the means over 5 experiments] paper, in %; ! where the paper's lies outside",
        f"{'object':8} {'method':13} {'AP':>{_COLUMN}} {'AR':>{_COLUMN}}    TP   FP   FN  time-outs  experiments",
    ]
    for cell in cells:
        lines.append(
            f"{cell.object:8} {cell.method:13} {_cell(cell.ap)} {_cell(cell.ar)} {cell.tp:5} {cell.fp:4} {cell.fn:4} "
            f"{cell.timeouts:10} {cell.experiments:12}"
        )
    lines += [f"all rows, {line}" for line in _agreement(cells)]
    lines += [f"without the row that the gap is fitted to, {line}" for line in _agreement(_predicted(cells))]
    return "\n".join(lines) + "\n"


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
