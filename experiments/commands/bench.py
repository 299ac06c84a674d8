"""`graspcell bench`: how fast experiments run on this machine, and what takes the time."""

import resource
import statistics
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

from experiments.commands.bench_config import Bench
from experiments.errors import UsageError
from experiments.progress import counted, saying
from experiments.setup.experiment import ExperimentSpec, kept_cell, run_experiment
from experiments.setup.pool import workers
from sim.networks.random_streams import Streams
from sim.runtime.bare_physics import record, replay
from sim.runtime.episode import starting_poses

STAGES = {  # name: (module, class or None, function)
    "physics, with setpoints": ("sim.runtime.world", None, "run_periods"),
    "instance ids": ("sim.runtime.wrist_camera", "WristCamera", "instance_ids"),
    "masks": ("sim.networks.estimators", "NoisyMasks", "detect"),
    "poses": ("sim.networks.estimators", "NoisyPoses", "estimate"),
    "uncertainty": ("cell.perception", "Perception", "uncertainties"),
    "joint moves": ("cell.motion", None, "joint_move"),
    "lines with inverse kinematics": ("cell.motion", None, "line_move"),
    "logs": ("experiments.results.recorder", "Recorder", "__call__"),
}


@dataclass(frozen=True, slots=True)
class Cost:
    """What an experiment took, s: simulated, of process time, and process time of a replay of its commands."""

    simulated: float
    worked: float
    replayed: float


def bench(config: Bench) -> int:
    """Prints the figures; returns the exit code.

    Raises:
        UsageError: an invalid argument, or an experiment that fails.
    """
    groups = config.specs()
    first = next(iter(groups.values()))
    for specs in counted(list(groups.values()), "part", "build and compile"):
        run_experiment(specs[0])  # builds the cell, and compiles what is not cached
    print(f"Process time on one core, medians of {len(first)} experiments of {first[0].parts} parts, {config.method}.")
    for part, specs in groups.items():
        costs = [cost(spec) for spec in counted(specs, "experiment", part)]
        speed = statistics.median(one.simulated / one.worked for one in costs)
        ratio = statistics.median(one.worked / one.replayed for one in costs)
        print(f"\n{part}: {speed:.1f} × real time; {ratio:.2f} × the bare physics of the same commands")
        with saying(f"{part}: time the stages of {len(specs)} experiments"):
            found = shares(specs)
        for stage, share in found.items():
            print(f"    {100 * share:5.1f} %  {stage}")
    print(f"\nmemory of this process {memory(resource.RUSAGE_SELF)} MB")
    if config.jobs > 1:
        with saying(f"time {config.jobs} processes beside one"):
            gain = scaling([spec for specs in groups.values() for spec in specs], config.jobs)
        each = memory(resource.RUSAGE_CHILDREN)
        print(f"{config.jobs} processes do {gain:.2f} × the experiments of one, with {each} MB each")
    return 0


def cost(spec: ExperimentSpec) -> Cost:
    """What the experiment takes, beside a replay right after it."""
    world = kept_cell(*spec.cell).world
    recording = record(world, lambda: run_experiment(spec))
    simulated, worked = duration(spec)
    streams = Streams(spec.seed, spec.experiment, world.part_model.part.name)
    return Cost(simulated, worked, replay(world, starting_poses(world, streams), recording))


def duration(spec: ExperimentSpec) -> tuple[float, float]:
    """Simulated s and process time, s, of one experiment."""
    begin = time.process_time()
    result = run_experiment(spec)
    worked = time.process_time() - begin
    if result.count is None:
        raise UsageError(f"expected experiments that end, got: {result.failure}")
    return result.count.duration, worked


def shares(specs: list[ExperimentSpec]) -> dict[str, float]:
    """The share of each stage in the process time of experiments; what no stage claims is Python around them."""
    with timers() as spent:
        total = sum(duration(spec)[1] for spec in specs)
    found = {stage: spent[stage] / total for stage in STAGES}
    return {**found, "Python around them": 1.0 - sum(found.values())}


@contextmanager
def timers() -> Iterator[dict[str, float]]:
    """Each stage's process time, s, while the context lasts."""
    spent: dict[str, float] = defaultdict(float)
    places = [
        (stage, sys.modules[module] if owner is None else getattr(sys.modules[module], owner), name)
        for stage, (module, owner, name) in STAGES.items()
    ]
    before = [(place, name, getattr(place, name)) for _, place, name in places]
    for stage, place, name in places:
        setattr(place, name, _timed(getattr(place, name), stage, spent))
    try:
        yield spent
    finally:
        for place, name, function in before:
            setattr(place, name, function)


def _timed(function: Callable[..., Any], stage: str, spent: dict[str, float]) -> Callable[..., Any]:
    def wrapper(*arguments: Any, **options: Any) -> Any:
        begin = time.process_time()
        try:
            return function(*arguments, **options)
        finally:
            spent[stage] += time.process_time() - begin

    return wrapper


def scaling(specs: list[ExperimentSpec], jobs: int) -> float:
    """How many times the experiments of one process several do in the same time of the wall clock."""
    load = [replace(spec) for spec in specs for _ in range(jobs)]  # the same for every worker
    with workers(jobs) as run:
        list(run(run_experiment, load))  # builds every worker's cells
        alone, together = [], []
        for _ in range(2):  # in turns: a shared machine is faster now and slower then
            alone.append(_waited(map, specs))
            together.append(_waited(run, load))
    return jobs * min(alone) / min(together)


def _waited(run: Callable[..., Any], specs: list[ExperimentSpec]) -> float:
    begin = time.perf_counter()
    for _ in run(run_experiment, specs):
        pass
    return time.perf_counter() - begin


def memory(whose: int) -> int:
    """The most memory that this process has held, or one of those that have ended, MB."""
    return round(resource.getrusage(whose).ru_maxrss * 1024 / 1e6)
