"""`graspcell calibrate`: the error model's parameters from the paper's dataset tables."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from experiments.calibration.config import Calibrate
from experiments.calibration.fit import Fit, fit
from experiments.calibration.images import ErrorModelTrial, ImageSet, run_trial
from experiments.calibration.noise_file import rewrite
from experiments.calibration.report import Fitted, Member, as_json, format_report
from experiments.calibration.targets import GROUPS, Calibration, FitTarget, Prior, load_calibration, values_at
from experiments.progress import bar
from experiments.results.files import write_text
from experiments.results.provenance import write_json
from experiments.setup.checks import writable_folder
from experiments.setup.options_file import write_manifest
from experiments.setup.pool import Run, workers
from sim.model.parts import load_part
from sim.networks.noise_model import PartNoise, load_noise, noise_text

DETECTOR_IMAGES = 2_000  # are enough for mask figures, which are far steadier than those of poses
UNREACHED = 100.0  # misses in sd of a figure that does not exist, so that the fit turns back
ACCEPTED = 3.0  # sd of each target within which a parameter set is as good as the fit

Array = NDArray[np.float64]
Figures = Mapping[tuple[str, str], float | None]  # by group and figure, as the targets


def calibrate(config: Calibrate) -> int:
    """Fits, prints what was reached and writes the results; returns the exit code.

    Raises:
        UsageError: an invalid argument.
        BrokenProcessPool: a worker died; nothing is written.
    """
    config.check()
    folder = writable_folder(config.out)
    model = load_part(config.part)
    start = config.start or model.noise
    noise = load_noise(start)
    calibration = load_calibration(config.targets or model.part.name, noise)
    with workers(config.workers) as run, bar("trial") as progress:
        bench = _Bench(run, ImageSet(config.part, config.seed, config.images), progress)
        fitted = _fit(bench, calibration, noise, config)
    write_text(folder / "noise.toml", rewrite(noise_text(start), fitted.lines()))
    write_json(folder / "ensemble.json", [member.values for member in fitted.members if member.accepted])
    write_json(folder / "calibration.json", as_json(model.part.name, config.images, fitted))
    write_manifest(folder, "calibrate", config, seed=config.seed)
    print(format_report(model.part.name, config.images, fitted))
    print(f"results in {folder}")
    return 0


@dataclass(frozen=True, slots=True)
class _Bench:
    """Where error models are tried."""

    run: Run
    images: ImageSet
    progress: Any

    def small(self) -> "_Bench":
        """The first of the images only."""
        return replace(self, images=replace(self.images, images=min(self.images.images, DETECTOR_IMAGES)))

    def figures(self, models: Sequence[PartNoise], *, methods: bool) -> list[Figures]:
        """The figures that each error model gives."""
        found: list[Figures] = []
        for of_masks, of_methods in self.run(run_trial, [ErrorModelTrial(self.images, one, methods) for one in models]):
            groups = {"mask": of_masks, **of_methods}
            found.append(
                {(group, name): value for group, row in groups.items() for name, value in row._asdict().items()}
            )
            self.progress.update()
        return found


def _fit(bench: _Bench, calibration: Calibration, noise: PartNoise, config: Calibrate) -> Fitted:
    """First the detector, whose figures depend on its own parameters only, then the pose networks behind it."""
    fits: dict[str, Fit] = {}
    for section, names in GROUPS.items():
        priors, targets = calibration.priors_of(section), calibration.targets_of(*names)
        if not priors or not targets:
            continue
        misses = partial(_misses, bench.small() if section == "mask" else bench, noise, priors, targets)
        bench.progress.set_description(section)
        start = [prior.z(noise.number(prior.name)) if config.start else 0.0 for prior in priors]
        fits[section] = fit(misses, np.array(start), config.rounds)
        noise = noise.changed(values_at(priors, fits[section].z))
    bench.progress.set_description("ensemble")
    reached = bench.figures([noise], methods=True)[0]
    return Fitted(calibration, fits, reached, _draw(bench, calibration, noise, fits, config))


def _misses(
    bench: _Bench, noise: PartNoise, priors: tuple[Prior, ...], targets: tuple[FitTarget, ...], points: Sequence[Array]
) -> list[Array]:
    """(figure − target) / sd at each of many points."""
    methods = any(target.group != "mask" for target in targets)
    models = [noise.changed(values_at(priors, z)) for z in points]
    return [miss(targets, figures) for figures in bench.figures(models, methods=methods)]


def miss(targets: Sequence[FitTarget], figures: Figures) -> Array:
    """(figure − target) / sd of each target, (T,), held to ± UNREACHED; −UNREACHED for a figure that does not exist."""
    rows = [
        -UNREACHED if (value := figures[target.group, target.figure]) is None else (value - target.value) / target.sd
        for target in targets
    ]
    held: Array = np.clip(rows, -UNREACHED, UNREACHED)
    return held


def _draw(
    bench: _Bench, calibration: Calibration, noise: PartNoise, fits: dict[str, Fit], config: Calibrate
) -> list[Member]:
    """Parameter sets as probable as the targets leave them, tried on the images, corrected once and tried again."""
    rng = np.random.default_rng(np.random.SeedSequence(config.seed, spawn_key=(2,)))
    drawn = [
        dict(zip(fits, row, strict=True))
        for row in zip(*(one.draw(config.draws, rng) for one in fits.values()), strict=True)
    ]
    tried = _try(bench, calibration, noise, drawn)
    drawn = [
        {
            section: one.corrected(z[section], miss(calibration.targets_of(*GROUPS[section]), member.figures))
            for section, one in fits.items()
        }
        for z, member in zip(drawn, tried, strict=True)
    ]
    return _try(bench, calibration, noise, drawn)


def _try(bench: _Bench, calibration: Calibration, noise: PartNoise, drawn: Sequence[dict[str, Array]]) -> list[Member]:
    """The parameter sets at points given by section."""
    sets = [
        {
            name: value
            for section, z in one.items()
            for name, value in values_at(calibration.priors_of(section), z).items()
        }
        for one in drawn
    ]
    tried = bench.figures([noise.changed(values) for values in sets], methods=True)
    return [
        Member(values, figures, bool((np.abs(miss(calibration.targets, figures)) <= ACCEPTED).all()))
        for values, figures in zip(sets, tried, strict=True)
    ]
