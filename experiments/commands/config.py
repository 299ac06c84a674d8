"""The options of the commands that run the cell, and the experiments that they ask for."""

# ruff: noqa: PLC0415  # the engine is loaded when a job begins: --help does not wait for it, nor need OpenGL

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from cell.motion_limits import PRESETS
from experiments.errors import UsageError
from experiments.setup.actors import Actors
from experiments.setup.checks import all_at_least, check_cell, check_part_and_method, one_of, worker_count
from experiments.setup.names import METHOD_NAMES, OWN
from sim.model.conditions import Conditions

if TYPE_CHECKING:
    from experiments.setup.experiment import ExperimentSpec
    from experiments.setup.thresholds import Thresholds

ConditionOptions = tyro.conf.OmitArgPrefixes[Conditions]  # --light, not --conditions.light
Speed = Annotated[str, tyro.conf.arg(help=f"How fast the arm moves: {', '.join(PRESETS)}.")]
ActorOptions = tyro.conf.OmitArgPrefixes[Actors]


@dataclass(frozen=True)
class CellOptions:
    """The common options of compare and run: the cell, the estimators and the policy."""

    parts: int = 8
    """Parts on the belt per experiment, each with 20 s of time; 1 to 8."""
    seed: int = 0
    """Root of all random numbers."""
    actors: ActorOptions = field(default_factory=Actors)
    """The estimators and the policy."""
    thresholds: str = "derived"
    """A preset (derived, paper), or a TOML file of the same form, such as graspcell dataset writes."""
    speed: Speed = "ur-default"
    fresh_look: bool = True
    """On a moving belt, look at a part again before it is grasped."""
    conditions: ConditionOptions = field(default_factory=Conditions)
    """What disturbs the cell."""

    def _check(self, objects: Sequence[str], methods: Sequence[str], thresholds: "Thresholds") -> None:
        """Raises UsageError unless each object can be run with each method."""
        names = {check_part_and_method(part, method, thresholds) for method in methods for part in objects}
        if len(names) < len(objects):
            raise UsageError(f"expected parts of different names for --objects, got {' '.join(objects)}")
        for part, method in product(objects, methods):
            self.actors.check(part, method, thresholds)

    def _spec(self, part: str, method: str, thresholds: "Thresholds", experiment: int) -> "ExperimentSpec":
        from experiments.setup.experiment import ExperimentSpec

        return ExperimentSpec(
            part=part,
            method=method,
            estimator=self.actors.estimator,
            thresholds=thresholds,
            speed=self.speed,
            parts=self.parts,
            seed=self.seed,
            experiment=experiment,
            conditions=self.conditions,
            fresh_look=self.fresh_look,
            policy=self.actors.policy,
            recorded=self.actors.recorded,
            time_limit=self.actors.time_limit,
            noise=self.actors.noise(part, experiment),
        )


@dataclass(frozen=True)
class Compare(CellOptions):
    """Compare uncertainty methods by grasp success: the paper's robot experiment, for every object and method.

    Prints the table beside the paper's and writes table.json, manifest.json and the logs to --out.
    """

    objects: tuple[str, ...] = ("antenna", "handle")
    """Parts to be sequenced: names, or TOML files of your own."""
    methods: Annotated[
        tuple[str, ...],
        tyro.conf.arg(help=f"Uncertainty methods: {', '.join(METHOD_NAMES)}; {OWN}; or all for all of these."),
    ] = ("none", "ensemble-add", "maskval")
    experiments: int = 5
    """Experiments per object and method; experiment i meets the same parts in the same poses with every method."""
    u_grasp: tuple[str, ...] = ()
    """Grasping thresholds of your own for all objects, METHOD=U; they take precedence over --thresholds."""
    jobs: int = 0
    """Processes to run experiments in; 0 takes one per core. The results do not depend on it."""
    out: Path = Path("out/compare")
    """Folder for the results; made if missing."""

    def specs(self) -> "list[ExperimentSpec]":
        """The experiments, object by object, method by method.

        Raises:
            UsageError: an invalid argument.
        """
        from experiments.setup.estimators import check_not_recorded
        from experiments.setup.methods import named_methods
        from experiments.setup.thresholds import load_thresholds

        check_cell(self.parts, self.seed, self.speed)
        all_at_least(self, experiments=1, jobs=0)
        methods = named_methods(self.methods)
        for name, chosen in (("--objects", self.objects), ("--methods", methods)):
            if not chosen:
                raise UsageError(f"expected at least one name for {name}, got none")
            if len(set(chosen)) < len(chosen):
                raise UsageError(f"expected different names for {name}, got {' '.join(chosen)}")
        thresholds = load_thresholds(self.thresholds).with_told(self.u_grasp, methods)
        self._check(self.objects, methods, thresholds)
        check_not_recorded(self.out, self.actors.recorded)
        return [
            self._spec(part, method, thresholds, experiment)
            for part, method, experiment in product(self.objects, methods, range(self.experiments))
        ]

    @property
    def workers(self) -> int:
        """Processes to use."""
        return worker_count(self.jobs)


@dataclass(frozen=True)
class Run(CellOptions):
    """Run one experiment and report each step: the detections, u, the decision and its outcome.

    Runs the same experiment as compare does with the same seed and number.
    """

    object: str = "antenna"
    """Part to be sequenced: antenna, handle, or a TOML file of your own."""
    method: Annotated[str, tyro.conf.arg(help=f"Uncertainty method: {', '.join(METHOD_NAMES)}; {OWN}.")] = "maskval"
    experiment: int = 0
    """Number of the experiment."""
    u_grasp: float | None = None
    """Grasping threshold of your own; takes precedence over --thresholds."""
    out: Path | None = None
    """Folder for the logs; none are written without it."""

    def spec(self) -> "ExperimentSpec":
        """The experiment.

        Raises:
            UsageError: an invalid argument.
        """
        from experiments.setup.estimators import check_not_recorded
        from experiments.setup.thresholds import load_thresholds

        check_cell(self.parts, self.seed, self.speed)
        all_at_least(self, experiment=0)
        told = () if self.u_grasp is None else (f"{self.method}={self.u_grasp}",)
        thresholds = load_thresholds(self.thresholds).with_told(told, (self.method,))
        self._check((self.object,), (self.method,), thresholds)
        if self.out is not None:
            check_not_recorded(self.out, self.actors.recorded)
        return self._spec(self.object, self.method, thresholds, self.experiment)


@dataclass(frozen=True)
class Picture:
    """Take a picture of the cell at a moment of an experiment with exact estimates."""

    object: str = "antenna"
    """Part to be sequenced: antenna, handle, or a TOML file of your own."""
    after: int = 3
    """How many time slots are over."""
    state: str = "insert"
    """The state that the robot then enters: search, approach, close, transfer, insert, ..."""
    camera: str = "overview"
    """overview: beside the cell; wrist: what the robot sees."""
    size: tuple[int, int] = (960, 720)
    """Width and height, pixels, up to 1920 × 1080."""
    seed: int = 0
    """Root of all random numbers."""
    maker_meshes: bool = False
    """Draw the arm with its maker's meshes; needs the extra graspcell[meshes]."""
    out: Path = Path("out/cell.png")
    """The picture, .png or .jpg."""

    def spec(self) -> "ExperimentSpec":
        """The experiment that the picture is taken from.

        Raises:
            UsageError: an invalid argument.
        """
        from cell.records import State
        from experiments.setup.experiment import ExperimentSpec
        from experiments.setup.thresholds import load_thresholds

        check_cell(1, self.seed, "ur-default")
        all_at_least(self, after=0)
        one_of("--state", self.state, tuple(state.value for state in State))
        one_of("--camera", self.camera, ("overview", "wrist"))
        width, height = self.size
        if not (1 <= width <= 1920 and 1 <= height <= 1080):
            raise UsageError(f"expected --size within 1 1 and 1920 1080, got {width} {height}")
        if self.out.suffix not in (".png", ".jpg"):
            raise UsageError(f"expected --out to end in .png or .jpg, got {self.out}")
        check_part_and_method(self.object, "none", load_thresholds("paper"))
        return ExperimentSpec(
            part=self.object,
            method="none",
            estimator="oracle",
            thresholds=load_thresholds("paper"),
            speed="ur-default",
            parts=8,
            seed=self.seed,
            experiment=0,
            maker_meshes=self.maker_meshes,
        )


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
