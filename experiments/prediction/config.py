"""What a person sets for `graspcell gap` and `graspcell predict`."""

# ruff: noqa: PLC0415  # the parts are loaded when the job begins: --help does not wait for them

from dataclasses import dataclass
from pathlib import Path

from experiments.errors import UsageError
from experiments.setup.checks import all_at_least, one_of, worker_count


@dataclass(frozen=True)
class FitGap:
    """Fit the domain gap of a part: how much worse real images are, by what the paper's robot did without UQ.

    Runs the cell without uncertainty quantification for a grid of gaps (scale of the small errors × odds of outliers),
    and weighs them by the paper's AP and AR. Writes gap.json and manifest.json to --out.
    """

    part: str = "antenna"
    """Part: one of the paper's robot table (antenna, handle), or a TOML file of your own with --targets."""
    targets: Path | None = None
    """TOML file with what a robot without UQ did with the part: ap and ar, in 0..1; by default the paper's figures."""
    experiments: int = 20
    """Experiments per gap of the grid, of 8 parts each."""
    draws: int = 20
    """Gaps to draw, for predictions."""
    seed: int = 0
    """Root of all random numbers."""
    jobs: int = 0
    """Processes; 0 takes one per core. The results do not depend on it."""
    out: Path = Path("out/gap")
    """Folder for the results; made if missing."""

    @property
    def workers(self) -> int:
        """Processes to use."""
        return worker_count(self.jobs)

    def check(self) -> None:
        """Rejects invalid arguments.

        Raises:
            UsageError: says which and why.
        """
        from experiments.prediction.robot_targets import robot_targets

        all_at_least(self, experiments=2, draws=1, seed=0, jobs=0)
        robot_targets(self.part, self.targets)


@dataclass(frozen=True)
class Predict:
    """Predict the paper's robot table: what 5 experiments of 8 parts would give, beside what they gave.

    Every world has an accepted parameter set of the error model and a draw of the domain gap; in each, several
    experiments are run with every method. Prints AP and AR with the 95 % interval of a mean over 5 experiments of one
    world, which of the paper's cells lie outside, how probable its predicted cells are jointly, and whether the
    prediction beats a random table. Writes predict.json and manifest.json to --out.
    """

    objects: tuple[str, ...] = ("antenna", "handle")
    """Parts of the paper's robot table."""
    methods: tuple[str, ...] = ("none", "ensemble-add", "maskval")
    """Uncertainty methods."""
    gap: str = "fitted"
    """Domain gap: none, fitted (as it comes with the package), or a gap.json of `graspcell gap` (one part only)."""
    worlds: int = 20
    """Parameter sets with a gap."""
    experiments: int = 10
    """Experiments per world and method, of 8 parts each."""
    variants: tuple[str, ...] = ("base",)
    """Assumptions to vary, one at a time: names of `experiments.prediction.variants`, or all."""
    seed: int = 0
    """Root of all random numbers."""
    jobs: int = 0
    """Processes; 0 takes one per core. The results do not depend on it."""
    out: Path = Path("out/predict")
    """Folder for the results; made if missing."""

    @property
    def workers(self) -> int:
        """Processes to use."""
        return worker_count(self.jobs)

    def check(self) -> None:
        """Rejects invalid arguments.

        Raises:
            UsageError: says which and why.
        """
        from experiments.prediction.variants import VARIANTS
        from experiments.results.paper import ROBOT_TABLE
        from experiments.setup.methods import METHODS

        for variant in self.variants:
            one_of("--variants", variant, ("all", *VARIANTS))
        for part in self.objects:
            one_of("--objects", part, tuple(dict.fromkeys(name for name, _ in ROBOT_TABLE)))
        for method in self.methods:
            one_of("--methods", method, tuple(METHODS))
        for name, chosen in (
            ("--objects", self.objects),
            ("--methods", self.methods),
            ("--variants", self.variants),
        ):
            if not chosen or len(set(chosen)) < len(chosen):
                raise UsageError(f"{name}: expected at least one name and each once, got {' '.join(chosen) or 'none'}")
        all_at_least(self, worlds=1, experiments=1, seed=0, jobs=0)
