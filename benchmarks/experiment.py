"""`python -m benchmarks.experiment --base FOLDER`: experiments of this tree and of another commit's, in turns.

`git worktree add FOLDER COMMIT` makes the other. Prints process time per simulated second, medians, and their ratio;
the clock of a shared machine says little. `graspcell bench` says where the time goes.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parents[1]


def main() -> None:
    """Runs the experiments and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--base", type=Path, required=True, help="the other tree")
    parser.add_argument("--experiments", type=int, default=5, help="experiments per object")
    parser.add_argument("--belt-speed", type=float, default=0.0, help="m/s")
    parser.add_argument("--work", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.work:
        return work(arguments.belt_speed)
    trees = {"base": arguments.base.resolve(), "this": HERE}
    workers = {name: started(tree, arguments.belt_speed) for name, tree in trees.items()}
    print(f"times real time on one core, medians of {arguments.experiments} experiments")
    print(f"{'object':10}{'base':>10}{'this':>10}{'ratio':>10}")
    for part in ("antenna", "handle"):
        speeds: dict[str, list[float]] = {name: [] for name in trees}
        for experiment in range(-1, arguments.experiments):  # the first, once more, only warms up
            for name, worker in workers.items():
                speed = asked(worker, part, max(0, experiment))
                if experiment >= 0:
                    speeds[name].append(speed)
        base, this = (statistics.median(speeds[name]) for name in trees)
        ratios = [b / a for a, b in zip(speeds["base"], speeds["this"], strict=True)]
        print(f"{part:10}{base:10.1f}{this:10.1f}{statistics.median(ratios):10.2f}", flush=True)
    for worker in workers.values():
        worker.stdin.close()
        worker.wait()
    return None


def started(tree: Path, belt_speed: float) -> Any:
    """A process that runs experiments of a tree."""
    command = [sys.executable, str(Path(__file__).resolve()), "--work", "--base", ".", "--belt-speed", str(belt_speed)]
    environment = {**os.environ, "PYTHONPATH": str(tree), "MUJOCO_GL": "egl"}
    return subprocess.Popen(command, cwd=tree, env=environment, stdin=-1, stdout=-1, text=True)


def asked(worker: Any, part: str, experiment: int) -> float:
    """How many times faster than real time an experiment ran in a worker."""
    worker.stdin.write(json.dumps([part, experiment]) + "\n")
    worker.stdin.flush()
    return float(worker.stdout.readline())


def work(belt_speed: float) -> None:
    """Runs the experiments that come on standard input, of the tree that Python imports from."""
    sys.path[0] = os.environ["PYTHONPATH"]  # instead of this file's folder
    try:
        from experiments.setup.experiment import ExperimentSpec, run_experiment  # noqa: PLC0415
        from experiments.setup.thresholds import load_thresholds  # noqa: PLC0415
        from sim.model.conditions import Conditions  # noqa: PLC0415
    except ImportError:  # as it was up to commit 5640738
        from experiments.experiment import ExperimentSpec, run_experiment  # noqa: PLC0415
        from experiments.thresholds import load_thresholds  # noqa: PLC0415
        from sim.conditions import Conditions  # noqa: PLC0415
    thresholds = load_thresholds("paper")
    for line in sys.stdin:
        part, experiment = json.loads(line)
        conditions = Conditions(belt_speed=belt_speed)
        spec = ExperimentSpec(part, "maskval", "noisy", thresholds, "ur-default", 8, 0, experiment, conditions)
        begin = time.process_time()
        result = run_experiment(spec)
        print(result.count.duration / (time.process_time() - begin), flush=True)


if __name__ == "__main__":
    main()
