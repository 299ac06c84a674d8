"""The options of the commands that run the cell, and the experiments that they ask for."""

# ruff: noqa: PLC0415  # the engine is loaded when a job begins: --help does not wait for it, nor need OpenGL

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from cell.arm.limits import PRESETS
from experiments.errors import UsageError
from experiments.setup.actors import Actors
from experiments.setup.checks import all_at_least, check_cell, check_part_and_method, one_of, worker_count
from experiments.setup.names import METHOD_NAMES, OWN, POLICY_NAMES, VIEWS
from sim.model.conditions import Conditions

if TYPE_CHECKING:
    from experiments.setup.experiment import ExperimentSpec
    from experiments.setup.thresholds import Thresholds

ConditionOptions = tyro.conf.OmitArgPrefixes[Conditions]  # --light, not --conditions.light
Speed = Annotated[str, tyro.conf.arg(help=f"How fast the arm moves: {', '.join(PRESETS)}.")]
_DIGITS = 6  # of the number of shares
_POLICIES = f"{', '.join(POLICY_NAMES)}, {OWN}; without it each method has its own: always for none, else threshold."
ActorOptions = tyro.conf.OmitArgPrefixes[Actors]


@dataclass(frozen=True)
class CellOptions:
    """The common options of compare and run: the cell and its estimators."""

    parts: int = 8
    """Parts on the belt per experiment, each with 20 s of time; 1 to 8."""
    seed: int = 0
    """Root of all random numbers."""
    actors: ActorOptions = field(default_factory=Actors)
    """The estimators."""
    thresholds: str = "derived"
    """A preset (derived, paper), or a TOML file of the same form, such as graspcell dataset writes."""
    speed: Speed = "ur-default"
    fresh_look: bool = True
    """On a moving belt, look at a part again before it is grasped."""
    conditions: ConditionOptions = field(default_factory=Conditions)
    """What disturbs the cell."""

    def _check(
        self, objects: Sequence[str], methods: Sequence[str], policies: Sequence[str | None], thresholds: "Thresholds"
    ) -> None:
        """Raises UsageError unless each object can be run with each method and policy."""
        from experiments.setup.policies import check_policy

        for method in methods:
            self.actors.check_method(method)
        names = {check_part_and_method(part, method, thresholds) for method in methods for part in objects}
        if len(names) < len(objects):
            raise UsageError(f"expected parts of different names for --objects, got {' '.join(objects)}")
        for part in objects:
            self.actors.check(part)
        for part, method, policy in product(objects, methods, policies):
            check_policy(policy, part, method, thresholds)

    def _spec(
        self, part: str, method: str, policy: str | None, thresholds: "Thresholds", experiment: int
    ) -> "ExperimentSpec":
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
            policy=policy,
            recorded=self.actors.recorded,
            networks=self.actors.networks,
            time_limit=self.actors.time_limit,
            noise=self.actors.noise(part, experiment),
        )


@dataclass(frozen=True)
class Compare(CellOptions):
    """Compare uncertainty methods by grasp success: the paper's robot experiment, for every object and method.

    Prints the table beside the paper's and writes table.json, manifest.json and the logs to --out. Each experiment is
    kept as it ends: the same command in the same folder goes on where it stopped, and one with more experiments,
    methods, policies or objects adds them.
    """

    objects: tuple[str, ...] = ("antenna", "handle")
    """Parts to be sequenced: names, or TOML files of your own."""
    methods: Annotated[
        tuple[str, ...],
        tyro.conf.arg(help=f"Uncertainty methods: {', '.join(METHOD_NAMES)}; {OWN}; or all for all of these."),
    ] = ("none", "ensemble-add", "maskval")
    policy: Annotated[tuple[str, ...], tyro.conf.arg(help=f"Policies, each with every method: {_POLICIES}")] = ()
    experiments: int = 5
    """Experiments per object and method; experiment i meets the same parts in the same poses with every method."""
    u_grasp: tuple[str, ...] = ()
    """Grasping thresholds of your own for all objects, METHOD=U; they take precedence over --thresholds."""
    until: tuple[str, ...] = ()
    """Conditions such as "ap(maskval) >= 0.99" or "placed(maskval) > placed(ensemble-add)": stop before all experiments
    where each of them is answered, yes or no, which errs in 5 percent of runs at most."""
    jobs: int = 0
    """Processes to run experiments in; 0 takes one per core. The results do not depend on it."""
    ray: str | None = None
    """Run the experiments on a Ray cluster: local starts one on this machine with --jobs cores; auto joins the one that
    runs here; HOST:PORT the one whose head node is there."""
    shard: str | None = None
    """I/N: run the I-th of N shares of the experiments, to be joined by graspcell merge."""
    retry_failed: bool = False
    """Try the experiments again that failed."""
    overwrite: bool = False
    """Remove the results that are in --out first."""
    out: Path = Path("out/compare")
    """Folder for the results; made if missing."""

    def specs(self) -> "list[ExperimentSpec]":
        """The experiments, object by object, method by method, policy by policy.

        Raises:
            UsageError: an invalid argument.
        """
        from experiments.setup.estimators import check_not_recorded
        from experiments.setup.methods import named_methods
        from experiments.setup.thresholds import load_thresholds

        check_cell(self.parts, self.seed, self.speed)
        all_at_least(self, experiments=1, jobs=0)
        methods = named_methods(self.methods, networks=self.actors.are_networks)
        policies = self.policy or (None,)
        thresholds = load_thresholds(self.thresholds, networks=self.actors.are_networks).with_told(
            self.u_grasp, methods
        )
        self._check(self.objects, methods, policies, thresholds)
        check_not_recorded(self.out, self.actors.recorded)
        return [
            self._spec(part, method, policy, thresholds, experiment)
            for part, method, policy, experiment in product(self.objects, methods, policies, range(self.experiments))
        ]

    @property
    def share(self) -> tuple[int, int]:
        """Which share to run, from 1, and of how many.

        Raises:
            UsageError: `shard` is not I/N.
        """
        if self.shard is None:
            return 1, 1
        number, slash, shares = self.shard.partition("/")
        form = slash and self.shard.isascii() and number.isdecimal() and shares.isdecimal() and len(shares) <= _DIGITS
        if not (form and 1 <= int(number) <= int(shares)):
            raise UsageError(f"expected --shard I/N with I in 1..N, got {self.shard!r}")
        return int(number), int(shares)

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
    policy: Annotated[str | None, tyro.conf.arg(help=f"Policy: {_POLICIES}")] = None
    experiment: int = 0
    """Number of the experiment."""
    u_grasp: float | None = None
    """Grasping threshold of your own; takes precedence over --thresholds."""
    view: Annotated[
        tuple[str, ...] | None,
        tyro.conf.arg(
            metavar="[{window,web}]",
            help="Watch it in real time: in MuJoCo's window, which needs a display; or web, in a browser on this "
            "machine, with pictures, estimated poses, u, pause and step (extra view).",
        ),
    ] = None
    rerun: Path | None = None
    """A recording for the Rerun viewer, .rrd (extra rerun)."""
    out: Path | None = None
    """Folder for the logs; none are written without it."""

    @property
    def where(self) -> str | None:
        """Where it is to be watched; None for nowhere.

        Raises:
            UsageError: there is no such place.
        """
        if self.view is None:
            return None
        if len(self.view) > 1:
            raise UsageError(f"expected --view, --view window or --view web, got {' '.join(self.view)}")
        where = self.view[0] if self.view else VIEWS[0]
        one_of("--view", where, VIEWS)
        return where

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
        thresholds = load_thresholds(self.thresholds, networks=self.actors.are_networks).with_told(told, (self.method,))
        self._check((self.object,), (self.method,), (self.policy,), thresholds)
        if self.out is not None:
            check_not_recorded(self.out, self.actors.recorded)
        if self.rerun is not None and self.rerun.suffix != ".rrd":
            raise UsageError(f"expected --rerun to end in .rrd, got {self.rerun}")
        return self._spec(self.object, self.method, self.policy, thresholds, self.experiment)
