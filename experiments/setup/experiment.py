"""One experiment: a belt of parts, one method, one result. No files, no printing: it runs in any process."""

import traceback
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

from cell.arm.limits import PRESETS
from cell.cycle import Cycle, CycleConfig
from cell.errors import CellError
from cell.guards import TIME_LIMIT
from cell.interfaces import Listener
from cell.records import Tally
from cell.setup import EstimatorSetup
from cell.viewpoints import REFINE_DISTANCE
from experiments.errors import UsageError
from experiments.results.first_attempts import FirstAttempts, first_attempts
from experiments.results.recorder import Recorder, Row
from experiments.setup.estimators import choose_estimators
from experiments.setup.methods import Context, make_method
from experiments.setup.policies import make_policy, policy_name
from experiments.setup.thresholds import Thresholds
from maskval import MaskvalError
from sim.errors import GraphicsError, SimError
from sim.instance_ids import PIXEL_CENTER
from sim.model.conditions import Conditions
from sim.networks.estimators import Kind
from sim.networks.ground_truth import LatestTruth
from sim.networks.noise_model import load_noise
from sim.networks.random_streams import Streams
from sim.runtime.episode import Estimators, SimCell, begin_episode, build_cell


@dataclass(frozen=True, slots=True)
class ExperimentSpec:
    """Everything that one experiment's result depends on.

    Attributes:
        part: name or TOML file of the part.
        method: name of the method.
        estimator: noisy, oracle, networks, replay, or `package.module:Class`.
        thresholds: of all methods.
        speed: name of the speed preset.
        parts: how many lie on the belt.
        seed: root seed.
        experiment: number of the experiment.
        conditions: what disturbs the cell.
        maker_meshes: whether the arm is drawn with its maker's meshes; nothing else depends on it.
        policy: a name of `policies.POLICIES`, `package.module:Class`, or None for the method's own.
        recorded: the folder that is replayed.
        networks: the folder of trained networks; None for those that come along.
        time_limit: s of the wall clock that an estimator, the method or the policy has per call.
        noise: other values of parameters of the part's error model, by "section.key".
        refine_distance: m from the estimated part at which it is looked at again.
        fresh_look: whether a part on a moving belt is looked at again before it is grasped.
    """

    part: str
    method: str
    estimator: str
    thresholds: Thresholds
    speed: str
    parts: int
    seed: int
    experiment: int
    conditions: Conditions = field(default_factory=Conditions)
    maker_meshes: bool = False
    policy: str | None = None
    recorded: Path | None = None
    networks: Path | None = None
    time_limit: float = TIME_LIMIT
    noise: tuple[tuple[str, float], ...] = ()
    refine_distance: float = REFINE_DISTANCE
    fresh_look: bool = True

    @property
    def cell(self) -> tuple[str, int, Conditions, bool]:
        """What the cell depends on."""
        return self.part, self.parts, self.conditions, self.maker_meshes


@dataclass(frozen=True, slots=True)
class ExperimentResult:
    """The result of an experiment: its counts, or why there are none and where that was raised, and its logs' rows."""

    spec: ExperimentSpec
    count: Tally | None
    failure: str | None
    tables: dict[str, list[Row]]
    first: FirstAttempts | None = None
    trace: str | None = None


@lru_cache(maxsize=4)  # kept, since compiling takes a second
def kept_cell(part: str, parts: int, conditions: Conditions, maker_meshes: bool, /) -> SimCell:
    """The process's cell for experiments with the same `ExperimentSpec.cell`."""
    return build_cell(part, parts, conditions, maker_meshes)


def run_experiment(
    spec: ExperimentSpec, tell: Callable[[object, LatestTruth], None] | None = None, cell: SimCell | None = None
) -> ExperimentResult:
    """Runs it to its end. A failure of estimators, physics or a policy is a result with a reason, not an exception.

    Args:
        spec: the experiment.
        tell: is told every record as it is made, with the truth about the newest frame.
        cell: what it runs in; the process's own for experiments of this kind by default.

    Raises:
        SimError: the cell cannot be set up, or pictures are asked for without OpenGL.
    """
    # What fails here fails for every experiment, and is not a result of this one.
    cell = cell or kept_cell(*spec.cell)
    part, latest_truth = cell.world.part_model.part, LatestTruth()
    policy = policy_name(spec.policy, spec.method)
    key = {"object": part.name, "method": spec.method, "policy": policy, "experiment": spec.experiment}
    recorder = Recorder(key, part, latest_truth)

    def listen(record: object) -> None:
        recorder(record)
        if tell is not None:
            tell(record, latest_truth)

    count, failure, trace = None, None, None
    try:
        count = make_cycle(spec, cell, latest_truth, listen).run()
    except GraphicsError:
        raise  # whoever looks at pictures meets it in every experiment
    except (CellError, SimError, MaskvalError, UsageError) as error:
        failure, trace = f"{type(error).__name__}: {error}", traceback.format_exc()
    recorder.finish(spec.seed, spec.estimator, count, failure)
    first = None if count is None else first_attempts(recorder.tables)
    return ExperimentResult(spec, count, failure, recorder.tables, first, trace)


def make_cycle(
    spec: ExperimentSpec,
    cell: SimCell,
    latest_truth: LatestTruth,
    listen: Listener,
    estimators: Kind | Estimators | None = None,
) -> Cycle:
    """The cell, set up and reset, with everything that one experiment needs; `estimators` replace the spec's."""
    model, layout = cell.world.part_model, cell.world.layout
    part, streams = model.part, Streams(spec.seed, spec.experiment, model.part.name)
    method = make_method(spec.method, Context(part, spec.thresholds, streams, latest_truth))
    policy = make_policy(spec.policy, method, part, layout, spec.thresholds.refine)
    if estimators is None:
        setup = EstimatorSetup(part, layout.camera, PIXEL_CENTER, spec.seed, spec.experiment)
        estimators = choose_estimators(
            spec.estimator, setup, spec.method, spec.time_limit, recorded=spec.recorded, networks=spec.networks
        )
    noise = load_noise(model.noise).changed(dict(spec.noise))
    episode = begin_episode(cell, streams, latest_truth, estimators, method.uncertainty, noise=noise)
    return Cycle(
        station=episode.station,
        referee=episode.referee,
        perception=replace(episode.perception, time_limit=spec.time_limit),
        policy=policy,
        layout=layout,
        config=CycleConfig(
            parts=spec.parts,
            refine_distance=spec.refine_distance,
            fresh_look=spec.fresh_look,
            speed=PRESETS[spec.speed],
            time_limit=spec.time_limit,
        ),
        listener=listen,
    )
