"""`graspcell gap`: the domain gap that the paper's robot without uncertainty quantification speaks for."""

import numpy as np

from cell.records import Tally
from experiments.prediction.config import FitGap
from experiments.prediction.counting import count_all
from experiments.prediction.gap_fit import GapFit, design, fit_gap
from experiments.prediction.robot_targets import robot_targets
from experiments.prediction.setting import Setting
from experiments.results.provenance import write_json
from experiments.setup.checks import writable_folder
from experiments.setup.error_models import cycled, error_model, load_ensemble
from experiments.setup.options_file import write_manifest
from experiments.setup.thresholds import load_thresholds
from sim.model.parts import load_part
from sim.networks.noise_model import load_noise


def gap(config: FitGap) -> int:
    """Runs the grid, prints it and the fit, and writes the results; returns the exit code.

    Raises:
        UsageError: an invalid argument.
        ExperimentsFailedError: an experiment has no result.
    """
    config.check()
    folder = writable_folder(config.out)
    model = load_part(config.part)
    noise, name = model.noise, model.part.name
    rendered = load_noise(noise)
    members = load_ensemble(noise, rendered)
    setting = Setting(load_thresholds("paper"), seed=config.seed)
    specs = [
        setting.spec(config.part, "none", error_model(rendered, cycled(members, experiment), one), experiment)
        for one in design()
        for experiment in range(config.experiments)
    ]
    counted = [one.count for one in count_all(specs, config.workers, config.part)]
    grid = [counted[start : start + config.experiments] for start in range(0, len(specs), config.experiments)]
    paper = robot_targets(config.part, config.targets)
    found = fit_gap(grid, paper)
    draws = found.draw(config.draws, np.random.default_rng(np.random.SeedSequence(config.seed, spawn_key=(3,))))
    write_json(
        folder / "gap.json",
        {
            "object": name,
            "paper": dict(zip(("ap", "ar"), paper, strict=True)),
            "mode": found.mode,
            "expected": dict(zip(("ap", "ar"), found.expected, strict=True)),
            "misfit": found.misfit,
            "core_scale_ci": found.interval(0),
            "outlier_odds_ci": found.interval(1),
            "grid": [{"gap": one, "counts": row} for one, row in zip(design(), grid, strict=True)],
            "draws": draws,
        },
    )
    write_manifest(folder, "gap", config, seed=config.seed)
    print(_report(name, paper, grid, found))
    print(f"results in {folder}")
    return 0


def _report(part: str, paper: tuple[float, float], grid: list[list[Tally]], found: GapFit) -> str:
    lines = [
        f"{part} without uncertainty quantification; the paper has AP {paper[0]:.1%}, AR {paper[1]:.1%}",
        "core scale  outlier odds   AP %   AR %  void  time-outs",
    ]
    for one, row in zip(design(), grid, strict=True):
        ap, ar = ([rate for count in row if (rate := getattr(count, name)) is not None] for name in ("ap", "ar"))
        lines.append(
            f"{one.core_scale:10.2f} {one.outlier_odds:13.1f} {_mean(ap)} {_mean(ar)} "
            f"{sum(count.void for count in row):5} {sum(count.timeouts for count in row):10}"
        )
    mode = found.mode
    reached = "" if found.misfit < 6.0 else ": out of reach of these gaps"
    lines += [
        f"most probable: core scale {mode.core_scale:.2f} {_interval(found, 0)}, outlier odds {mode.outlier_odds:.1f} "
        f"{_interval(found, 1)}; 95 % in brackets",
        f"there AP {found.expected[0]:.1%}, AR {found.expected[1]:.1%}; misfit {found.misfit:.1f}{reached}",
    ]
    return "\n".join(lines)


def _mean(rates: list[float]) -> str:
    return f"{100 * np.mean(rates):6.1f}" if rates else "     –"


def _interval(found: GapFit, axis: int) -> str:
    low, high = found.interval(axis)
    return f"[{low:.2f}, {high:.1f}]"
