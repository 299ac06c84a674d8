"""`python -m benchmarks.mechanics`: how true the arm stays to its way and how still a held part lies, in an experiment.

Runs one experiment with exact estimates per part and prints the largest distance of the tool from its commanded place
in every motion, and the largest movement of any point of a part between the jaws from lifting to letting go.
"""

from collections.abc import Iterable, Iterator
from statistics import median

import numpy as np
from numpy.typing import NDArray

import sim.runtime.episode as subject
from cell.interfaces import Contact, Touch
from cell.records import State, Transition
from cell.ur10 import forward
from experiments.setup.experiment import ExperimentSpec, kept_cell, run_experiment
from experiments.setup.thresholds import load_thresholds
from maskval import Pose
from sim.networks.ground_truth import LatestTruth
from sim.runtime.station import SimStation

Setpoint = NDArray[np.float64]  # joint angles, speeds and accelerations, (3, 6)

tool_errors: list[float] = []  # m, one per motion
stations: list["ObservedStation"] = []


class ObservedStation(SimStation):
    """A station that compares the tool with its commanded place before each period."""

    def __init__(self, *arguments: object) -> None:
        super().__init__(*arguments)  # type: ignore[arg-type]
        stations.append(self)

    def _run(self, setpoints: Iterable[Setpoint | None], watch: frozenset[Touch]) -> Contact | None:
        errors: list[float] = []
        X_FT = self._world.layout.gripper.X_FT

        def observed() -> Iterator[Setpoint | None]:
            for setpoint in setpoints:
                if setpoint is not None:
                    wanted = (forward(setpoint[0]) @ X_FT).translation
                    errors.append(float(np.linalg.norm((forward(self.q) @ X_FT).translation - wanted)))
                yield setpoint

        contact = super()._run(observed(), watch)
        if errors:
            tool_errors.append(max(errors))
        return contact


def measure(part: str) -> str:
    """Runs one experiment of a part; its figures as a line."""
    tool_errors.clear()
    spec = ExperimentSpec(part, "none", "oracle", load_thresholds("paper"), "ur-default", 8, 0, 0)
    world = kept_cell(*spec.cell).world
    vertices = world.part_model.part.mesh.vertices
    slips: list[float] = []
    lifted: dict[int, Pose] = {}

    def tell(record: object, latest_truth: LatestTruth) -> None:
        if not isinstance(record, Transition) or record.target not in (State.LIFT, State.RELEASE):
            return
        held = stations[-1].touched_parts()[0]
        X_FO = world.X_WF().inverse() @ world.X_WO(held)
        if record.target is State.LIFT:
            lifted[held] = X_FO
        else:
            moved = X_FO.apply(vertices) - lifted[held].apply(vertices)
            slips.append(float(np.linalg.norm(moved, axis=1).max()))

    result = run_experiment(spec, tell)
    if result.count is None:
        raise RuntimeError(f"the experiment failed: {result.failure}")
    return (
        f"{part}: {result.count.tp} of 8 placed; tool off its way by at most {1000 * max(tool_errors):.2f} mm "
        f"(median of {len(tool_errors)} motions {1000 * median(tool_errors):.2f} mm); held parts moved by at most "
        f"{1000 * max(slips):.2f} mm (median of {len(slips)} transfers {1000 * median(slips):.2f} mm)"
    )


def main() -> None:
    """Prints the figures of both parts."""
    subject.SimStation = ObservedStation  # type: ignore[misc]
    for part in ("antenna", "handle"):
        print(measure(part))


if __name__ == "__main__":
    main()
