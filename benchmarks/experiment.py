"""`python -m benchmarks.experiment`: how much faster than real time an experiment runs on a core, and where time goes.

Prints process time (what the core worked) beside wall time (which also waits for others on a shared machine). Each
stage is timed inside of the run; what no stage claims is Python around them.
"""

import argparse
import os
import statistics
import sys
import time
from collections import defaultdict
from collections.abc import Callable
from typing import Any

from experiments.setup.experiment import ExperimentSpec, kept_cell, run_experiment
from experiments.setup.thresholds import load_thresholds

STAGES = {  # name: (module, class or None, function)
    "physics": ("mujoco", None, "mj_step"),
    "instance ids": ("sim.runtime.wrist_camera", "WristCamera", "instance_ids"),
    "masks": ("sim.networks.estimators", "NoisyMasks", "detect"),
    "poses": ("sim.networks.estimators", "NoisyPoses", "estimate"),
    "uncertainty": ("cell.perception", "Perception", "uncertainties"),
    "joint moves": ("cell.motion", None, "joint_move"),
    "lines with inverse kinematics": ("cell.motion", None, "line_move"),
    "logs": ("experiments.results.recorder", "Recorder", "__call__"),
}


def timed(function: Callable[..., Any], stage: str, spent: dict[str, float]) -> Callable[..., Any]:
    """The function, adding its process time to `spent`."""

    def wrapper(*arguments: Any, **options: Any) -> Any:
        begin = time.process_time()
        try:
            return function(*arguments, **options)
        finally:
            spent[stage] += time.process_time() - begin

    return wrapper


def instrument(spent: dict[str, float]) -> None:
    """Puts a timer around every stage."""
    for stage, (module, owner, name) in STAGES.items():
        place = sys.modules[module] if owner is None else getattr(sys.modules[module], owner)
        setattr(place, name, timed(getattr(place, name), stage, spent))


def main() -> None:
    """Runs the experiments and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--experiments", type=int, default=5, help="experiments per object")
    parser.add_argument("--method", default="maskval")
    arguments = parser.parse_args()
    core = min(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {core})
    thresholds = load_thresholds("paper")
    load = os.getloadavg()[0]
    print(f"one core, load {load:.1f} at the start, {arguments.experiments} experiments of 8 parts each, medians")
    specs = {
        part: [
            ExperimentSpec(part, arguments.method, "noisy", thresholds, "ur-default", 8, 0, experiment)
            for experiment in range(arguments.experiments)
        ]
        for part in ("antenna", "handle")
    }
    for group in specs.values():
        run_experiment(group[0])  # compiles kernels and opens the renderer
    bare = {part: [measure(spec) for spec in group] for part, group in specs.items()}
    spent: dict[str, float] = defaultdict(float)
    instrument(spent)
    for part, group in specs.items():
        simulated, worked, waited = (statistics.median(column) for column in zip(*bare[part], strict=True))
        print(
            f"\n{part}: {simulated:.1f} s simulated, {worked:.2f} s of process time "
            f"({simulated / worked:.0f} × real time), {waited:.2f} s on the wall ({simulated / waited:.0f} ×)"
        )
        spent.clear()
        total = sum(measure(spec)[1] for spec in group)
        for stage in STAGES:
            print(f"    {100 * spent[stage] / total:5.1f} %  {stage}")
        print(f"    {100 * (1 - sum(spent.values()) / total):5.1f} %  Python around them")
    kept_cell.cache_clear()


def measure(spec: ExperimentSpec) -> tuple[float, float, float]:
    """Simulated seconds, process time and wall time of one experiment, s."""
    worked, waited = time.process_time(), time.perf_counter()
    result = run_experiment(spec)
    if result.count is None:
        raise RuntimeError(f"the experiment failed: {result.failure}")
    return result.count.duration, time.process_time() - worked, time.perf_counter() - waited


if __name__ == "__main__":
    main()
