"""`graspcell tolerance`: how wrong may a pose be before the grasp fails? Measured in physics, one part at a time."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from tqdm import tqdm

from cell.interfaces import Outcome
from cell.records import AttemptRecord
from experiments.config import Tolerance, writable_folder
from experiments.experiment import ExperimentSpec, make_cycle
from experiments.pool import run_all
from experiments.provenance import manifest, write_json
from maskval import proportion_interval
from sim.estimators import ErrorPoses, OracleMasks
from sim.latents import Streams
from sim.noise import load_noise
from sim.parts import load_part
from sim.truth import TruthBooth


@dataclass(frozen=True, slots=True)
class Trial:
    """One attempt on one part whose pose is wrong by exactly `mdd_mm`."""

    spec: ExperimentSpec
    mdd_mm: float


@dataclass(frozen=True, slots=True)
class Level:
    """All trials of one part at one error; rates in [0, 1].

    Attributes:
        object: name of the part.
        mdd_mm: error, mm.
        trials: how many.
        placed: how many ended with the part in its slot.
        rate: share of them.
        rate_ci: its 95 % Clopper-Pearson interval.
        outcomes: how many ended how.
    """

    object: str
    mdd_mm: float
    trials: int
    placed: int
    rate: float
    rate_ci: tuple[float, float] | None
    outcomes: dict[str, int]


def tolerance(config: Tolerance) -> int:
    """Runs all trials, prints the curve and writes tolerance.json and manifest.json; returns the exit code.

    Raises:
        UsageError: an argument that cannot be.
    """
    trials = [Trial(spec, mdd_mm) for part in config.objects for mdd_mm in config.mdd_mm for spec in config.specs(part)]
    folder = writable_folder(config.out)
    outcomes = list(
        tqdm(run_all(run_trial, trials, config.workers), total=len(trials), unit="trial", dynamic_ncols=True)
    )
    levels = summarise(trials, outcomes)
    write_json(folder / "tolerance.json", {"levels": levels})
    write_json(folder / "manifest.json", {**manifest(config), "seed": config.seed})
    if config.figure:
        from experiments.figures import draw_tolerance  # noqa: PLC0415  # needs an extra

        draw_tolerance(levels, folder / "tolerance.png")
    print(format_levels(levels))
    print(f"results in {folder}")
    return 0


def run_trial(trial: Trial) -> Outcome | None:
    """What the first attempt on the part came to; None if none was made in the part's time."""
    model, spec = load_part(trial.spec.part), trial.spec
    booth = TruthBooth()
    noise = load_noise(model.noise)
    streams = Streams(spec.seed, spec.experiment, model.part.name)
    poses = ErrorPoses(booth, model.part, noise, streams, trial.mdd_mm / 1000.0)
    attempts: list[AttemptRecord] = []

    def listen(record: object) -> None:
        if isinstance(record, AttemptRecord):
            attempts.append(record)

    make_cycle(spec, model, booth, listen, estimators=(OracleMasks(booth, noise), (poses, poses))).run()
    return attempts[0].outcome if attempts else None


def summarise(trials: Sequence[Trial], outcomes: Sequence[Outcome | None]) -> list[Level]:
    """One level per part and error, in the order of the trials."""
    groups: dict[tuple[str, float], list[Outcome | None]] = {}
    for trial, outcome in zip(trials, outcomes, strict=True):
        groups.setdefault((load_part(trial.spec.part).part.name, trial.mdd_mm), []).append(outcome)
    levels = []
    for (part, mdd_mm), group in groups.items():
        placed = group.count(Outcome.PLACED)
        counted = Counter("no attempt" if outcome is None else outcome.value for outcome in group)
        levels.append(
            Level(
                object=part,
                mdd_mm=mdd_mm,
                trials=len(group),
                placed=placed,
                rate=placed / len(group),
                rate_ci=proportion_interval(placed, len(group)),
                outcomes=dict(sorted(counted.items())),
            )
        )
    return levels


def format_levels(levels: Sequence[Level]) -> str:
    """The curve as text, one line per part and error."""
    lines = [f"{'object':10} {'MDD mm':>7} {'placed':>9} {'%':>6} {'[95 %]':>8}  what came of the others"]
    for level in levels:
        others = ", ".join(f"{count} {name}" for name, count in level.outcomes.items() if name != Outcome.PLACED.value)
        low, high = level.rate_ci or (0.0, 1.0)
        lines.append(
            f"{level.object:10} {level.mdd_mm:7g} {level.placed:4}/{level.trials:<4} {100 * level.rate:6.1f} "
            f"{100 * low:4.0f}–{100 * high:<3.0f}  {others}"
        )
    return "\n".join(lines)
