"""The options of `graspcell tolerance`."""

# ruff: noqa: PLC0415  # the engine is loaded when a job begins: --help does not wait for it, nor need OpenGL

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from experiments.commands.config import Speed
from experiments.errors import UsageError
from experiments.setup.checks import all_at_least, check_cell, check_part_and_method, worker_count

if TYPE_CHECKING:
    from experiments.setup.experiment import ExperimentSpec


@dataclass(frozen=True)
class Tolerance:
    """Measure how wrong a pose may be before the grasp fails: one attempt per trial, with an error of this size.

    The error's direction, its axis and the share of shift and turn are random. Prints the share of parts placed and
    the outcomes of the others; writes tolerance.json and manifest.json to --out.
    """

    objects: tuple[str, ...] = ("antenna", "handle")
    """Parts: names, or TOML files of your own."""
    mdd_mm: tuple[float, ...] = (0, 2.5, 5, 7.5, 10, 12.5, 15, 20, 25, 30, 40, 60)
    """Errors of the pose: largest distance by which a point of the part is off, mm, 0 to 100."""
    trials: int = 40
    """Attempts per part and error."""
    seed: int = 0
    """Root of all random numbers."""
    speed: Speed = "ur-default"
    jobs: int = 0
    """Processes to run trials in; 0 takes one per core. The results do not depend on it."""
    figure: bool = False
    """Also draw tolerance.png; needs the extra graspcell[figures]."""
    out: Path = Path("out/tolerance")
    """Folder for the results; made if missing."""

    def specs(self, part: str) -> "list[ExperimentSpec]":
        """One experiment with one part per trial.

        Raises:
            UsageError: an invalid argument.
        """
        from experiments.setup.experiment import ExperimentSpec
        from experiments.setup.thresholds import load_thresholds

        check_cell(1, self.seed, self.speed)
        all_at_least(self, trials=1, jobs=0)
        for mdd_mm in self.mdd_mm:
            if not 0 <= mdd_mm <= 100:
                raise UsageError(f"expected --mdd-mm in 0..100, got {mdd_mm:g}")
        check_part_and_method(part, "none", load_thresholds("paper"))
        return [
            ExperimentSpec(
                part=part,
                method="none",
                estimator="oracle",
                thresholds=load_thresholds("paper"),
                speed=self.speed,
                parts=1,
                seed=self.seed,
                experiment=trial,
            )
            for trial in range(self.trials)
        ]

    @property
    def workers(self) -> int:
        """Processes to use."""
        return worker_count(self.jobs)
