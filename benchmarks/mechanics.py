"""`python -m benchmarks.mechanics`: how true the arm stays to its way and how still a held part lies, in an experiment.

Runs one experiment with exact estimates per part and prints the largest distance of the tool from its commanded place
in every motion, and the largest movement of any point of a part between the jaws from lifting to letting go.
"""

from statistics import median

import numpy as np
from numpy.typing import NDArray

import sim.runtime.episode as subject
from cell.arm.ur10 import forward
from cell.interfaces import Contact, Touch
from cell.records import State, Transition
from experiments.setup.experiment import ExperimentSpec, kept_cell, run_experiment
from experiments.setup.thresholds import load_thresholds
from maskval import Pose
from sim.model.robot import JOINTS
from sim.networks.ground_truth import LatestTruth
from sim.runtime.station import SimStation

tool_errors: list[float] = []  # m, one per motion
stations: list["ObservedStation"] = []


class ObservedStation(SimStation):
    """A station that compares the tool with its commanded place before each period."""

    def __init__(self, *arguments: object) -> None:
        super().__init__(*arguments)  # type: ignore[arg-type]
        stations.append(self)
        model = self._world.mj_model
        self._positions = [model.actuator_ctrladr[model.actuator(name).id] for name in JOINTS]

    def _run(self, setpoints: NDArray[np.float64], watch: frozenset[Touch]) -> Contact | None:
        world, errors = self._world, list[float]()
        X_FT, before = world.layout.gripper.X_FT, [world.q]

        def observe() -> None:
            wanted = world.data.ctrl[self._positions]
            tools = [(forward(q) @ X_FT).translation for q in (before[0], wanted)]
            errors.append(float(np.linalg.norm(tools[0] - tools[1])))
            before[0] = world.q

        world.on_step = observe
        contact = super()._run(setpoints, watch)
        world.on_step = None
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
