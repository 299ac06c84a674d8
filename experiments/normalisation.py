"""`python -m experiments.normalisation`: where Ensemble-ADD's scale begins, its least disagreement on a set.

The paper takes the minimum of its test set. Here the set is every picture of experiments with a seed of their own.
"""

import os

from experiments.experiment import ExperimentSpec, run_experiment
from experiments.pool import run_all
from experiments.thresholds import load_thresholds
from maskval import Pose, add
from sim.parts import load_part, part_names

SEED = 1_000_000  # not one that results are made with
EXPERIMENTS = 20


def disagreements(spec: ExperimentSpec) -> list[float]:
    """ADD between both networks' poses for every detection of one experiment, m."""
    vertices = load_part(spec.part).part.mesh.vertices
    return [
        add(_pose(row["X_CO_est"]), _pose(row["X_CO_est_2"]), vertices)
        for row in run_experiment(spec).tables["estimates"]
    ]


def _pose(row: list[float]) -> Pose:
    return Pose.from_quaternion_wxyz(row[3:], row[:3])


def main() -> None:
    """Prints the least disagreement of every part, m."""
    for part in part_names():
        specs = [
            ExperimentSpec(part, "ensemble-add", "noisy", load_thresholds("paper"), "ur-default", 8, SEED, experiment)
            for experiment in range(EXPERIMENTS)
        ]
        values = [value for group in run_all(disagreements, specs, os.cpu_count() or 1) for value in group]
        print(f"{part} = {min(values):.6f}  # of {len(values)} detections")


if __name__ == "__main__":
    main()
