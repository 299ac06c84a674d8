"""`graspcell tolerance`: how wrong may a pose be before the grasp fails? Measured in physics, one part at a time."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from cell.errors import CellError
from cell.interfaces import Outcome
from cell.records import AttemptRecord
from experiments.commands.tolerance_config import Tolerance
from experiments.progress import counted
from experiments.results.provenance import write_json
from experiments.results.tolerance_curve import CurvePoint, format_curve
from experiments.setup.checks import writable_folder
from experiments.setup.experiment import ExperimentSpec, kept_cell, make_cycle
from experiments.setup.options_file import write_manifest
from experiments.setup.pool import run_all
from maskval import MaskvalError, proportion_interval
from sim.errors import SimError
from sim.model.parts import load_part
from sim.networks.estimators import ErrorPoses, OracleMasks
from sim.networks.ground_truth import LatestTruth
from sim.networks.noise_model import load_noise
from sim.networks.random_streams import Streams


@dataclass(frozen=True, slots=True)
class Trial:
    """One attempt on one part whose pose is wrong by exactly `mdd_mm`."""

    spec: ExperimentSpec
    mdd_mm: float


def tolerance(config: Tolerance) -> int:
    """Runs all trials, prints the curve and writes tolerance.json and manifest.json; returns the exit code.

    Raises:
        UsageError: an invalid argument.
    """
    trials = [Trial(spec, mdd_mm) for part in config.objects for mdd_mm in config.mdd_mm for spec in config.specs(part)]
    folder = writable_folder(config.out)
    outcomes = list(counted(run_all(run_trial, trials, config.workers), "trial", total=len(trials)))
    levels = summarise(trials, outcomes)
    write_json(folder / "tolerance.json", {"levels": levels})
    write_manifest(folder, "tolerance", config, seed=config.seed)
    if config.figure:
        from experiments.results.figures import draw_tolerance  # noqa: PLC0415  # needs an extra

        draw_tolerance(levels, folder / "tolerance.png")
    print(format_curve(levels))
    print(f"results in {folder}")
    return 0


def run_trial(trial: Trial) -> str:
    """The outcome of the first attempt on the part, or why none was made in the part's time."""
    spec = trial.spec
    cell = kept_cell(*spec.cell)
    model = cell.world.part_model
    latest_truth = LatestTruth()
    noise = load_noise(model.noise)
    streams = Streams(spec.seed, spec.experiment, model.part.name)
    poses = ErrorPoses(latest_truth, model.part, noise, streams, trial.mdd_mm / 1000.0)
    attempts: list[AttemptRecord] = []

    def listen(record: object) -> None:
        if isinstance(record, AttemptRecord):
            attempts.append(record)

    try:
        make_cycle(
            spec, cell, latest_truth, listen, estimators=(OracleMasks(latest_truth, noise), (poses, poses))
        ).run()
    except (CellError, SimError, MaskvalError) as error:
        return f"failed by {type(error).__name__}"
    return attempts[0].outcome.value if attempts else "no attempt"


def summarise(trials: Sequence[Trial], outcomes: Sequence[str]) -> list[CurvePoint]:
    """One level per part and error, in the order of the trials."""
    groups: dict[tuple[str, float], list[str]] = {}
    for trial, outcome in zip(trials, outcomes, strict=True):
        groups.setdefault((load_part(trial.spec.part).part.name, trial.mdd_mm), []).append(outcome)
    levels = []
    for (part, mdd_mm), group in groups.items():
        placed = group.count(Outcome.PLACED.value)
        levels.append(
            CurvePoint(
                object=part,
                mdd_mm=mdd_mm,
                trials=len(group),
                placed=placed,
                rate=placed / len(group),
                rate_ci=proportion_interval(placed, len(group)),
                outcomes=dict(sorted(Counter(group).items())),
            )
        )
    return levels
