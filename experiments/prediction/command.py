"""`graspcell predict`: the paper's robot table as a prediction, with the assumptions varied one at a time."""

from itertools import product

from experiments.prediction.config import Predict
from experiments.prediction.counting import count_all
from experiments.prediction.setting import Setting
from experiments.prediction.summary import Summary, format_summary, summarise
from experiments.prediction.variants import VARIANTS
from experiments.results.provenance import write_json
from experiments.setup.checks import writable_folder
from experiments.setup.error_models import ErrorModel, error_model_of
from experiments.setup.options_file import write_manifest
from experiments.setup.thresholds import load_thresholds
from sim.networks.domain_gap import BASE_REACH, Reach


def predict(config: Predict) -> int:
    """Runs the experiments of every variant, prints a table for each and writes the results; returns the exit code.

    Raises:
        UsageError: an invalid argument.
        ExperimentsFailedError: an experiment has no result.
    """
    config.check()
    folder = writable_folder(config.out)
    worlds = _worlds(config, BASE_REACH)
    names = list(VARIANTS) if "all" in config.variants else list(config.variants)
    write_manifest(folder, "predict", config, seed=config.seed)
    results: dict[str, Summary] = {}
    found = {"worlds": {part: [dict(one) for one in rows] for part, rows in worlds.items()}, "variants": results}
    for name in names:
        setting = VARIANTS[name](Setting(load_thresholds("paper"), seed=config.seed))
        results[name] = _run(config, setting, _worlds(config, setting.reach), name)
        write_json(folder / "predict.json", found)  # after each variant: an interrupted job keeps those it finished
        print(format_summary(name, results[name]), flush=True)
    print(f"results in {folder}")
    return 0


def _worlds(config: Predict, reach: Reach) -> dict[str, list[ErrorModel]]:
    """The worlds of each part, where S2 and the detector feel so much of the gap."""
    return {
        part: [error_model_of(part, config.gap, index, reach) for index in range(config.worlds)]
        for part in config.objects
    }


def _run(config: Predict, setting: Setting, worlds: dict[str, list[ErrorModel]], name: str) -> Summary:
    """The experiments of a variant; a world's are the same with every method."""
    size, keys = config.experiments, list(product(config.objects, config.methods))
    specs = [
        setting.spec(part, method, one, index * size + experiment)
        for part, method in keys
        for index, one in enumerate(worlds[part])
        for experiment in range(size)
    ]
    counted = count_all(specs, config.workers, name)
    rows = [counted[start : start + size] for start in range(0, len(counted), size)]
    groups = {key: rows[number * config.worlds : (number + 1) * config.worlds] for number, key in enumerate(keys)}
    return summarise(
        {key: [[one.count for one in row] for row in group] for key, group in groups.items()},
        {key: [[one.first for one in row] for row in group] for key, group in groups.items()},
        config.seed,
    )
